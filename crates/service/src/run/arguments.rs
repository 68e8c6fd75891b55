//! The command line of a service.

use std::path::PathBuf;

use clap::{CommandFactory, FromArgMatches, Parser};
use ppnpack_wire::keys::Service;

/// Runs a service of ppnpack until SIGTERM or SIGINT.
///
/// The configuration comes from the file, then the environment (PPNPACK__ZENOH__CONNECT is
/// zenoh.connect), then --set, each stronger than the one before.
#[derive(Debug, Parser)]
#[command(version)]
pub(super) struct Arguments {
    /// A configuration file (TOML).
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// A value of the configuration, such as zenoh.mode=client.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// Checks the configuration and ends: exit code 0 or 64.
    #[arg(long, group = "instead")]
    pub(super) validate_config: bool,
    /// Prints the configuration as TOML, secrets as ***, and ends.
    #[arg(long, group = "instead")]
    pub(super) print_config: bool,
    /// Prepares what is on disk after a backup of it was put back, while the service does not run,
    /// and ends: exit code 0 or 1.
    #[arg(long, group = "instead")]
    pub(super) after_restore: bool,
}

impl Arguments {
    /// Reads the command line of this process.
    pub(super) fn read(service: Service) -> Result<Self, clap::Error> {
        let name = format!("ppnpack-{service}");
        let command = Self::command().display_name(name.clone()).bin_name(name);
        let matches = command.try_get_matches()?;
        Self::from_arg_matches(&matches)
    }
}
