//! `stack`: a whole stack of real processes on this machine, a router and services that connect to it, measured and tested.
//!
//! The processes are those that lie beside this program: build them first, as `scripts/test` and
//! `scripts/bench-stack` do.

mod bench;
mod cell;
mod clock;
mod disk;
mod faults;
#[cfg(test)]
mod http;
mod latency;
mod mix;
mod packer;
mod process;
mod records;
mod report;
mod soak;
mod stack;
#[cfg(test)]
mod tests;

use clap::Parser;

/// Measures a stack of real processes.
#[derive(Debug, Parser)]
enum Arguments {
    /// Measures plans through the stack: reference setting, simulated cells, the built-in objects
    Bench(bench::Arguments),
    Soak(soak::Arguments),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse() {
        Arguments::Bench(arguments) => bench::run(&arguments),
        Arguments::Soak(arguments) => soak::run(&arguments),
    }
}
