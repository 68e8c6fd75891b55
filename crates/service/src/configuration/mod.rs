//! The configuration of a process: from a file, the environment and the command line, each stronger than the last.
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
//! In the environment, `PPNPACK__ZENOH__CONNECT` is `zenoh.connect`; on the command line `--set zenoh.connect=...`.
//! Values there are TOML; what is none is text. Text that looks like a number needs quotes of its own.

mod layers;
mod observability;
mod secret;
mod secure;
mod zenoh;

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

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
/// What the setting is, and what is possible.
pub fn in_range<T: PartialOrd + Display + Copy>(
    name: &str,
    value: T,
    limits: RangeInclusive<T>,
) -> Result<(), String> {
    if limits.contains(&value) {
        return Ok(());
    }
    let (least, most) = limits.into_inner();
    Err(format!(
        "{name} is {value} where {least} to {most} is possible"
    ))
}

/// Reads the names of cells, and of their containers, in the setting `cells`.
///
/// # Errors
/// Which name is none.
pub fn cells(names: &[String]) -> Result<Vec<Cell>, String> {
    let cells = names.iter().map(|name| Cell::new(name));
    let cells: Result<_, _> = cells.collect();
    cells.map_err(|error| format!("cells: {error}"))
}

/// What a service itself has to configure: the section `[service]`. Its types refuse unknown keys
/// (`#[serde(deny_unknown_fields)]`) and have a default for each.
pub trait ServiceSettings: Serialize + DeserializeOwned + Default {
    /// Checks what types cannot; the text says which key is wrong, and what would be right.
    ///
    /// # Errors
    /// Where a value is not possible.
    fn validate(&self) -> Result<(), String>;

    /// Prepares what the service keeps on disk after a backup of it was put back: what was done since then is not known. Gives what
    /// was done, for people.
    ///
    /// # Errors
    /// Where it keeps nothing, or that cannot be read or written.
    fn after_restore(&self) -> Result<String, String> {
        Err("this service keeps nothing that could be restored".to_owned())
    }

    /// How Zenoh is reached where the configuration does not say it.
    fn zenoh() -> ZenohSettings {
        ZenohSettings::default()
    }
}

/// Why a configuration was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigurationError {
    /// The file cannot be read.
    #[error("the configuration {} cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{} is not TOML: {reason}", path.display())]
    NotToml {
        /// The file.
        path: PathBuf,
        /// What the parser says, with the place.
        reason: String,
    },
    /// `--set` was given something else than an assignment.
    #[error("'{0}' is no setting: give KEY=VALUE, such as zenoh.mode=client")]
    Assignment(String),
    /// A key is not known, or has a value of another kind.
    #[error("{reason} (from {origin})")]
    Refused {
        /// The key and what is wrong.
        reason: String,
        /// The file, the environment variable or the option.
        origin: String,
    },
    /// A value is not possible.
    #[error("{key}: {reason}")]
    Invalid {
        /// The key.
        key: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
}

impl ConfigurationError {
    fn invalid(key: impl Into<String>, reason: impl Display) -> Self {
        let (key, reason) = (key.into(), reason.to_string());
        Self::Invalid { key, reason }
    }
}

/// Checks that the value of a key lies within its limits.
fn check(
    key: &'static str,
    value: f64,
    limits: RangeInclusive<f64>,
) -> Result<(), ConfigurationError> {
    if limits.contains(&value) {
        return Ok(());
    }
    let (least, most) = limits.into_inner();
    let reason = format_args!("{least} to {most} is possible");
    Err(ConfigurationError::invalid(key, reason))
}

/// Where configurations come from.
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
    /// The name of this process among those of its service; the service and "-1" where it is not given.
    pub instance: String,
    /// How long what is in flight may take after SIGTERM, in seconds.
    pub shutdown_grace_s: f64,
    /// How Zenoh is reached.
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
    /// Reads and checks a configuration, and fills in what depends on other values.
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

    /// The name of this process.
    ///
    /// # Errors
    /// [`ConfigurationError::Invalid`] where it is none.
    pub fn instance(&self) -> Result<Instance, ConfigurationError> {
        Instance::new(&self.instance)
            .map_err(|error| ConfigurationError::invalid("instance", error))
    }

    /// How long what is in flight may take at the end.
    pub fn shutdown_grace(&self) -> Duration {
        Duration::try_from_secs_f64(self.shutdown_grace_s).unwrap_or_default()
    }

    /// The configuration as TOML; secrets are `***`.
    ///
    /// # Errors
    /// Where the service has settings that TOML cannot express.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The first 16 hexadecimal digits of the BLAKE3 hash of all but the instance's name: replicas have the same.
    pub fn hash(&self) -> String {
        let mut table = toml::Table::try_from(self).unwrap_or_default();
        table.remove("instance");
        let text = toml::to_string(&table).unwrap_or_default();
        let hash = blake3::hash(text.as_bytes()).to_hex();
        hash.chars().take(16).collect()
    }
}
