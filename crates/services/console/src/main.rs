//! `ppnpack-console`: the operator's page as a process.

use std::process::ExitCode;

use ppnpack_console::Settings;
use ppnpack_service as run;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    run::main(Service::Console, |process, settings: Settings| {
        Ok(Box::new(ppnpack_console::start(process, &settings)?))
    })
}
