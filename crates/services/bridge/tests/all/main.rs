//! The bridge from outside: one program, as linking what carries messages takes long.
#![cfg(test)]

mod common;
mod expiring;
mod holding;
mod placing;
mod remote;
mod scanning;
