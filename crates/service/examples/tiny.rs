//! The smallest service: it answers for heightmaps that it does not have. The tests run it as a
//! process.

use std::process::ExitCode;
use std::time::Instant;

use ppnpack_service::rpc::{Listener, listen};
use ppnpack_service::{Process, Running, ServiceSettings, alive};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{HeightmapRequest, Status};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Settings {
    excuse: String,
}

impl Default for Settings {
    fn default() -> Self {
        let excuse = "there is no camera".to_owned();
        Self { excuse }
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        if self.excuse.is_empty() {
            return Err("excuse: say something".to_owned());
        }
        Ok(())
    }
}

struct Started {
    _listener: Listener,
    _token: alive::Token,
}

impl Running for Started {
    fn finish(self: Box<Self>, _deadline: Instant) -> Result<(), String> {
        Ok(())
    }
}

fn start(process: &Process, settings: Settings) -> anyhow::Result<Box<dyn Running>> {
    let listener = listen::<HeightmapRequest>(process, None, move |incoming| {
        incoming.refuse(Status::Unavailable, settings.excuse.clone());
    })?;
    let token = alive::announce(process, None)?;
    Ok(Box::new(Started {
        _listener: listener,
        _token: token,
    }))
}

fn main() -> ExitCode {
    ppnpack_service::main(Service::Perception, start)
}
