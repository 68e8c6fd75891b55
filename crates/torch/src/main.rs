//! `ppnpack-torch`: the commands of `ppnpack` and of `ppnpack-experiments`, with the network.
//!
//! Those do not link libtorch, so they run where there is none; they hand over to this program
//! where a network is wanted.

use std::process::ExitCode;

use ppnpack_experiments::Experiments;
use ppnpack_torch::Torch;

fn main() -> ExitCode {
    ppnpack_cli::main::<Experiments>(&Torch)
}
