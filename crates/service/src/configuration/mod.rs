//! The configuration of a process: from a file, the environment and the command line, each stronger
//! than the last.
//!
//! ```toml
//! instance = "planner-1"              # of the service; unlike any other's
//! shutdown_grace_s = 5.0
//!
//! [zenoh]
//! mode = "client"                     # client, peer or router
//! connect = ["tcp/127.0.0.1:7447"]
//!
//! [admin]
//! listen = "127.0.0.1:9100"           # port 0: one of the system's choice; "off": none
//!
//! [log]
//! format = "json"                     # json or human
//! filter = "info,zenoh=warn"
//!
//! [telemetry]
//! otlp = "http://127.0.0.1:4318/v1/traces"
//!
//! [service]                           # what the service itself defines
//! ```
//!
//! In the environment, `PPNPACK__ZENOH__CONNECT` is `zenoh.connect`. On the command line it is
//! `--set zenoh.connect=...`. Values there are TOML, and text where they are none. Text that looks
//! like a number needs quotes of its own.

mod layers;
mod observability;
mod secret;
mod secure;
mod zenoh;

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

pub use ppnpack_numbers::settings;
use ppnpack_wire::keys::{Cell, Instance, Service};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use self::zenoh::{Endpoints, Mode, TlsSettings, ZenohSettings};
pub use layers::ENVIRONMENT_PREFIX;
pub use observability::{AdminListen, AdminSettings, LogFormat, LogSettings, TelemetrySettings};
pub use secret::Secret;

/// Checks that a setting lies within its limits.
///
/// # Errors
/// Names the setting, its value and the limits.
pub fn in_range<T: PartialOrd + Display + Copy>(
    name: &str,
    value: T,
    limits: RangeInclusive<T>,
) -> Result<(), String> {
    if limits.contains(&value) {
        return Ok(());
    }
    let (least, most) = limits.into_inner();
    let possible = format_args!("{least} to {most} is possible");
    Err(format!("{name} is {value} where {possible}"))
}

/// Reads the names of cells, and of their containers, in the setting `cells`.
///
/// # Errors
/// Names the first that is no cell's name.
pub fn cells(names: &[String]) -> Result<Vec<Cell>, String> {
    let cells = names.iter().map(|name| Cell::new(name));
    let cells: Result<_, _> = cells.collect();
    cells.map_err(|error| format!("cells: {error}"))
}

/// The settings of a service itself: the section `[service]`. Its types refuse unknown keys
/// (`#[serde(deny_unknown_fields)]`) and have a default for each.
pub trait ServiceSettings: Serialize + DeserializeOwned + Default {
    /// Checks what types cannot.
    ///
    /// # Errors
    /// The key of an impossible value, and the possible ones.
    fn validate(&self) -> Result<(), String>;

    /// Prepares the service's files after a backup of them was put back: what was done since then
    /// is not known. Gives a report in words.
    ///
    /// # Errors
    /// The reason in words, as where the service keeps no files, or cannot read or write them.
    fn after_restore(&self) -> Result<String, String> {
        Err("this service keeps nothing that could be restored".to_owned())
    }

    /// Gives the settings of Zenoh where the configuration has none.
    fn zenoh() -> ZenohSettings {
        ZenohSettings::default()
    }
}

/// The reason for which a configuration was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigurationError {
    /// The file cannot be read, or is not TOML.
    #[error("the configuration {} cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The reason, with the place.
        reason: String,
    },
    /// A key is not known, or has a value of another kind; or an option is no assignment.
    #[error("{reason} (from {origin})")]
    Refused {
        /// The key and the fault.
        reason: String,
        /// The file, the environment variable or the option.
        origin: String,
    },
    /// A value is not possible.
    #[error("{key}: {reason}")]
    Invalid {
        /// The key.
        key: String,
        /// The fault, and the possible values.
        reason: String,
    },
}

impl ConfigurationError {
    fn invalid(key: impl Into<String>, reason: impl Display) -> Self {
        let (key, reason) = (key.into(), reason.to_string());
        Self::Invalid { key, reason }
    }
}

fn check(
    key: &'static str,
    value: f64,
    limits: RangeInclusive<f64>,
) -> Result<(), ConfigurationError> {
    in_range("it", value, limits).map_err(|reason| ConfigurationError::invalid(key, reason))
}

/// The sources of a configuration.
#[derive(Debug, Default)]
pub struct Sources<'a> {
    /// The file, if there is one.
    pub file: Option<&'a Path>,
    /// Environment variables; those without the [`ENVIRONMENT_PREFIX`] are left alone.
    pub environment: Vec<(String, String)>,
    /// Assignments `key=value` of the command line.
    pub assignments: &'a [String],
}

/// The whole configuration of a process.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(
    default,
    deny_unknown_fields,
    bound(deserialize = "S: ServiceSettings")
)]
pub struct Configuration<S> {
    /// The name of this process among those of its service; by default the service's and "-1".
    pub instance: String,
    /// Maximum time after SIGTERM for the work in flight, in seconds.
    pub shutdown_grace_s: f64,
    /// The way to reach Zenoh.
    pub zenoh: ZenohSettings,
    /// The admin port.
    pub admin: AdminSettings,
    /// Logs.
    pub log: LogSettings,
    /// Traces.
    pub telemetry: TelemetrySettings,
    /// The service's own.
    pub service: S,
}

impl<S: ServiceSettings> Default for Configuration<S> {
    fn default() -> Self {
        Self {
            instance: String::new(),
            shutdown_grace_s: 5.0,
            zenoh: S::zenoh(),
            admin: AdminSettings::default(),
            log: LogSettings::default(),
            telemetry: TelemetrySettings::default(),
            service: S::default(),
        }
    }
}

impl<S: ServiceSettings> Configuration<S> {
    /// Reads and checks a configuration, and fills in the values that depend on others.
    ///
    /// # Errors
    /// [`ConfigurationError`]
    pub fn load(service: Service, sources: &Sources<'_>) -> Result<Self, ConfigurationError> {
        let mut configuration: Self = layers::extract(sources, &S::zenoh())?;
        if configuration.instance.is_empty() {
            configuration.instance = format!("{service}-1");
        }
        configuration.zenoh.fill_in();
        configuration.validate()?;
        Ok(configuration)
    }

    fn validate(&self) -> Result<(), ConfigurationError> {
        self.instance()?;
        check("shutdown_grace_s", self.shutdown_grace_s, 0.0..=3600.0)?;
        self.zenoh.validate()?;
        drop(self.log.to_filter()?);
        self.telemetry.validate()?;
        self.service
            .validate()
            .map_err(|reason| ConfigurationError::invalid("service", reason))
    }

    /// Reads the name of this process.
    ///
    /// # Errors
    /// [`ConfigurationError::Invalid`] where it is none.
    pub fn instance(&self) -> Result<Instance, ConfigurationError> {
        Instance::new(&self.instance)
            .map_err(|error| ConfigurationError::invalid("instance", error))
    }

    /// Gives the maximum time for the work in flight at the end.
    pub fn shutdown_grace(&self) -> Duration {
        Duration::try_from_secs_f64(self.shutdown_grace_s).unwrap_or_default()
    }

    /// Writes the configuration as TOML; secrets are `***`.
    ///
    /// # Errors
    /// Fails where the service has settings that TOML cannot express.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Gives the first 16 hexadecimal digits of the BLAKE3 hash of all but the instance's name, so
    /// that replicas have the same.
    pub fn hash(&self) -> String {
        let mut table = toml::Table::try_from(self).unwrap_or_default();
        table.remove("instance");
        let text = toml::to_string(&table).unwrap_or_default();
        let hash = blake3::hash(text.as_bytes()).to_hex();
        hash.chars().take(16).collect()
    }
}
