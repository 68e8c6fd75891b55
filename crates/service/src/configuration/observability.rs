//! The settings of the admin port, logs and traces.

use std::net::{Ipv4Addr, SocketAddr};

use ppnpack_numbers::settings;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use tracing_subscriber::EnvFilter;

use super::{ConfigurationError, check};

/// The admin port: `[admin]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AdminSettings {
    /// The address that it listens on.
    pub listen: AdminListen,
}

/// The address of the admin port, such as `"127.0.0.1:9100"`, or `"off"`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AdminListen {
    /// No admin port.
    Off,
    /// This address; at port 0 the system chooses one.
    At(SocketAddr),
}

impl Default for AdminListen {
    fn default() -> Self {
        Self::At(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)))
    }
}

impl Serialize for AdminListen {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Off => serializer.serialize_str("off"),
            Self::At(address) => serializer.collect_str(address),
        }
    }
}

impl<'de> Deserialize<'de> for AdminListen {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text == "off" {
            return Ok(Self::Off);
        }
        text.parse().map(Self::At).map_err(|_| {
            let wanted = "address and port such as 127.0.0.1:9100, nor \"off\"";
            serde::de::Error::custom(format_args!("'{text}' is no {wanted}"))
        })
    }
}

settings! {
    /// Logs: `[log]`.
    pub struct LogSettings {
        /// For people or for programs.
        pub format: LogFormat = LogFormat::Human,
        /// The events that are written, as directives of `tracing-subscriber`: `info`, or
        /// `info,ppnpack_planner=debug`.
        pub filter: String = "info,zenoh=warn".to_owned(),
    }
}

/// The format of a line of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// One JSON object a line.
    Json,
    /// For people.
    Human,
}

impl LogSettings {
    pub(crate) fn to_filter(&self) -> Result<EnvFilter, ConfigurationError> {
        EnvFilter::try_new(&self.filter)
            .map_err(|error| ConfigurationError::invalid("log.filter", error))
    }
}

settings! {
    /// Traces: `[telemetry]`.
    pub struct TelemetrySettings {
        /// The collector that spans are sent to as OTLP over HTTP, such as
        /// `http://127.0.0.1:4318/v1/traces`, if any.
        pub otlp: Option<String> = None,
        /// The share of traces that are recorded, of those that begin here.
        pub sampled_share: f64 = 1.0,
    }
}

impl TelemetrySettings {
    pub(super) fn validate(&self) -> Result<(), ConfigurationError> {
        if let Some(endpoint) = &self.otlp
            && !endpoint.starts_with("http://")
        {
            let reason = format!(
                "'{endpoint}' is no address such as http://127.0.0.1:4318/v1/traces; a collector \
                 at hand takes it on from there"
            );
            return Err(ConfigurationError::invalid("telemetry.otlp", reason));
        }
        check("telemetry.sampled_share", self.sampled_share, 0.0..=1.0)
    }
}
