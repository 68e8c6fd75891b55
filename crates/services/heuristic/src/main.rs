//! `ppnpack-heuristic`: the heuristic service as a process.

use std::process::ExitCode;

use ppnpack_heuristic::Settings;
use ppnpack_service as run;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    run::main(Service::Heuristic, |process, settings: Settings| {
        Ok(Box::new(ppnpack_heuristic::start(process, &settings)?))
    })
}
