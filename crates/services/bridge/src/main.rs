//! `ppnpack-bridge`: the bridge service as a process, with simulated cells.

use std::process::ExitCode;

use ppnpack_bridge::Settings;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    ppnpack_service::main(Service::Bridge, |process, settings: Settings| {
        let catalogue = settings.load_catalogue()?;
        Ok(Box::new(ppnpack_bridge::start(
            process, &settings, &catalogue,
        )?))
    })
}
