//! `ppnpack-perception`: the perception service as a process.

use std::process::ExitCode;

use ppnpack_perception_service::Settings;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    ppnpack_service::main(Service::Perception, |process, settings: Settings| {
        Ok(Box::new(ppnpack_perception_service::start(
            process, &settings,
        )?))
    })
}
