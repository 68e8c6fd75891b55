//! `ppnpack-experiments`: the commands of `ppnpack`, and those that make and measure networks and
//! everything else.

use std::process::ExitCode;

use ppnpack_cli::launcher::Launcher;
use ppnpack_experiments::Experiments;

fn main() -> ExitCode {
    ppnpack_cli::main::<Experiments>(&Launcher::default())
}
