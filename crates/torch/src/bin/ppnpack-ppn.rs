//! `ppnpack-ppn`: the ppn service as a process.

use std::process::ExitCode;

use ppnpack_ppn_service::Settings;
use ppnpack_service as run;
use ppnpack_torch::TorchNetwork;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    run::main(Service::Ppn, |process, settings: Settings| {
        let network = Box::new(TorchNetwork::read(&settings)?);
        Ok(Box::new(ppnpack_ppn_service::start(
            process, &settings, network,
        )?))
    })
}
