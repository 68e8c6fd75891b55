//! `ppnpack`: the command line. It hands over to `ppnpack-experiments` and, where a network runs,
//! to `ppnpack-torch`.

use std::process::ExitCode;

use ppnpack_cli::launcher::{Elsewhere, Launcher};

fn main() -> ExitCode {
    ppnpack_cli::main::<Elsewhere>(&Launcher::default())
}
