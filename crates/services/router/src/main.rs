//! `ppnpack-router`: the Zenoh router that services and cell controllers connect to, run like any service.
//!
//! Access control is a part of Zenoh's configuration: `zenoh.file` names a file with it.

use std::process::ExitCode;
use std::time::Instant;

use ppnpack_service::configuration::{Endpoints, Mode, ZenohSettings};
use ppnpack_service::{Running, ServiceSettings, alive};
use ppnpack_wire::keys::Service;
use serde::{Deserialize, Serialize};

/// A router has nothing to set but its Zenoh session.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Settings {}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        Ok(())
    }

    fn zenoh() -> ZenohSettings {
        ZenohSettings {
            mode: Mode::Router,
            listen: Endpoints(vec!["tcp/127.0.0.1:7447".to_owned()]),
            ..ZenohSettings::default()
        }
    }
}

/// Zenoh does the work; the token says that it is there.
struct Router {
    _alive: alive::Token,
}

impl Running for Router {
    fn finish(self: Box<Self>, _deadline: Instant) -> Result<(), String> {
        Ok(())
    }
}

fn main() -> ExitCode {
    ppnpack_service::main(Service::Router, |process, _settings: Settings| {
        Ok(Box::new(Router {
            _alive: alive::announce(process, None)?,
        }))
    })
}
