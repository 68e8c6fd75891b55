//! Connections of the commands to a running stack.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use clap::Args;
use ppnpack_service::configuration::{Endpoints, ZenohSettings};

use crate::failure::{OrInput, Outcome};

/// Default endpoint of a stack: Zenoh's own port.
const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

/// The environment variable that names another default.
const ENDPOINT_VARIABLE: &str = "PPNPACK_ENDPOINT";

/// Gives the endpoint at which `ppnpack up` listens, and the other commands connect, if no option
/// says otherwise.
pub(crate) fn default_endpoint() -> String {
    std::env::var(ENDPOINT_VARIABLE).unwrap_or_else(|_| DEFAULT_ENDPOINT.to_owned())
}

/// Opens a session with the stack at an endpoint; `file` is a Zenoh configuration to begin with.
pub(crate) fn open(endpoint: &str, file: Option<&Path>) -> Outcome<zenoh::Session> {
    use zenoh::Wait;
    let settings = ZenohSettings {
        connect: Some(Endpoints(vec![endpoint.to_owned()])),
        file: file.map(Path::to_owned),
        ..ZenohSettings::default().with_largest_clouds()
    };
    let config = settings.to_zenoh().or_input()?;
    Ok(zenoh::open(config).wait().map_err(|error| {
        anyhow!("{endpoint} cannot be reached: {error}; `ppnpack up` starts a stack there")
    })?)
}

/// A running stack.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Connection")]
pub(crate) struct ConnectOptions {
    /// The Zenoh endpoint of a router, or of `ppnpack up`; the environment's PPNPACK_ENDPOINT is
    /// another default
    #[arg(long, value_name = "ENDPOINT", default_value_t = default_endpoint())]
    connect: String,

    /// A Zenoh configuration (JSON5) to begin with, such as one with certificates
    #[arg(long, value_name = "FILE")]
    zenoh_config: Option<PathBuf>,

    /// How long to wait for answers, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0)]
    wait: f64,
}

impl ConnectOptions {
    /// Opens a session with the stack.
    pub(crate) fn open(&self) -> Outcome<zenoh::Session> {
        open(&self.connect, self.zenoh_config.as_deref())
    }

    /// Gives the time at which to stop waiting.
    pub(crate) fn deadline(&self) -> Outcome<Instant> {
        let wait = Duration::try_from_secs_f64(self.wait).or_input()?;
        Ok(Instant::now() + wait)
    }
}
