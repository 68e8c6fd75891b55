//! What services share, from outside: one program, as linking what carries messages takes long.
#![cfg(test)]

mod configuration;
mod process;
mod rpc;
mod stream;
mod trace;
