//! What viewers see.
#![cfg(test)]

mod planned;
mod viewing;
