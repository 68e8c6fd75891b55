//! `ppnpack-torch`: the same commands as `ppnpack`, with the network.
//!
//! `ppnpack` itself does not link libtorch, so it runs where there is none; it hands over to this program where a
//! network is wanted.

use std::process::ExitCode;

use ppnpack_torch::Torch;

fn main() -> ExitCode {
    ppnpack_cli::main(&Torch)
}
