//! The command line of a service.

use std::path::PathBuf;

use clap::{CommandFactory, FromArgMatches, Parser};
use ppnpack_wire::keys::Service;

use crate::configuration::Sources;

/// Runs a service of ppnpack until SIGTERM or SIGINT.
///
/// The configuration comes from the file, then the environment (PPNPACK__ZENOH__CONNECT is zenoh.connect), then --set,
/// each stronger than the one before.
#[derive(Debug, Parser)]
#[command(version)]
pub(super) struct Arguments {
    /// A configuration file (TOML).
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// A value of the configuration, such as zenoh.mode=client.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    instead: Instead,
}

/// What to do instead of running.
#[derive(Debug, clap::Args)]
#[group(multiple = false)]
struct Instead {
    /// Checks the configuration and ends: exit code 0 or 64.
    #[arg(long)]
    validate_config: bool,
    /// Prints the configuration as TOML, secrets as ***, and ends.
    #[arg(long)]
    print_config: bool,
    /// Asks a running process with this configuration, at its admin port, whether it is ready: exit code 0 or 1.
    #[arg(long)]
    healthcheck: bool,
}

/// What to do.
pub(super) enum Action {
    Run,
    Validate,
    Print,
    CheckHealth,
}

impl Arguments {
    /// Reads the command line of this process.
    pub(super) fn read(service: Service) -> Result<Self, clap::Error> {
        let name = format!("ppnpack-{service}");
        let command = Self::command().display_name(name.clone()).bin_name(name);
        let matches = command.try_get_matches()?;
        Self::from_arg_matches(&matches)
    }

    pub(super) fn action(&self) -> Action {
        match self.instead {
            Instead {
                validate_config: true,
                ..
            } => Action::Validate,
            Instead {
                print_config: true, ..
            } => Action::Print,
            Instead {
                healthcheck: true, ..
            } => Action::CheckHealth,
            Instead { .. } => Action::Run,
        }
    }

    pub(super) fn sources(&self, environment: Vec<(String, String)>) -> Sources<'_> {
        Sources {
            file: self.config.as_deref(),
            environment,
            assignments: &self.set,
        }
    }
}
