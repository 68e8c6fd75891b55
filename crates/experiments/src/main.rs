//! `ppnpack-experiments`: the commands of `ppnpack`, and those that make networks and measure.

use std::process::ExitCode;

use ppnpack_cli::launcher::Launcher;
use ppnpack_experiments::Experiments;

fn main() -> ExitCode {
    ppnpack_cli::main::<Experiments>(&Launcher::default())
}
