//! Networks on libtorch, for the programs that are linked with it: `ppnpack-torch` and
//! `ppnpack-ppn`.

mod backend;
mod service;

pub use backend::Torch;
pub use service::TorchNetwork;
