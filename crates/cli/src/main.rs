//! `ppnpack`: the command line. Networks run in `ppnpack-torch`, to which it hands over.

use std::process::ExitCode;

use ppnpack_cli::launcher::Launcher;

fn main() -> ExitCode {
    ppnpack_cli::main(&Launcher::default())
}
