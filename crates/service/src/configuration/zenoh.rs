//! How Zenoh is reached: `[zenoh]`.

use std::path::PathBuf;

use ppnpack_wire::MAX_CLOUD_BYTES;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use super::{ConfigurationError, Secret};

/// Where clients look for a router if nothing else is said.
const DEFAULT_ROUTER: &str = "tcp/127.0.0.1:7447";

/// Zenoh's part in a network.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Connects to one router (or peer) and reaches everything through it.
    #[default]
    Client,
    /// Connects to others and is connected to.
    Peer,
    /// Passes messages on between others.
    Router,
}

/// Zenoh endpoints such as `tcp/127.0.0.1:7447`: a list, or text with commas.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Endpoints(pub Vec<String>);

impl<'de> Deserialize<'de> for Endpoints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "endpoints are a list, such as [\"tcp/127.0.0.1:7447\"]"
        )]
        enum Given {
            One(String),
            Many(Vec<String>),
        }
        Ok(Self(match Given::deserialize(deserializer)? {
            Given::One(text) => {
                let parts = text.split(',').map(str::trim);
                parts
                    .filter(|part| !part.is_empty())
                    .map(str::to_owned)
                    .collect()
            }
            Given::Many(list) => list,
        }))
    }
}

/// How Zenoh is reached. Multicast scouting is always off: it fails silently in containers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ZenohSettings {
    /// The part of this process.
    pub mode: Mode,
    /// Endpoints that it connects to; for a client `tcp/127.0.0.1:7447` where they are not given.
    pub connect: Option<Endpoints>,
    /// Endpoints that it listens on.
    pub listen: Endpoints,
    /// What all keys begin with on the network, so that several stacks can share it.
    pub namespace: Option<String>,
    /// Certificates, for endpoints that begin with `tls/`.
    pub tls: TlsSettings,
    /// The name with which this process connects.
    pub user: Option<String>,
    /// The password that goes with it.
    pub password: Option<Secret>,
    /// A file with lines `user:password`: those who may connect to this process.
    pub users_file: Option<PathBuf>,
    /// The largest message that is received, in bytes.
    pub max_message_bytes: usize,
    /// The most others that may be connected to this process.
    pub max_sessions: usize,
    /// After how long of silence another counts as gone, in seconds.
    pub lease_s: f64,
    /// A Zenoh configuration (JSON5) to begin with, such as one with access control. What is said here is stronger.
    pub file: Option<PathBuf>,
}

/// Certificates and keys, as PEM files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TlsSettings {
    /// Who signs the certificates of others.
    pub root_ca: Option<PathBuf>,
    /// This process's certificate. Where it is given, others need one too (mutual TLS).
    pub certificate: Option<PathBuf>,
    /// The key that goes with it.
    pub private_key: Option<PathBuf>,
    /// Whether a certificate must be for the name that was connected to.
    pub verify_name: bool,
}

impl Default for TlsSettings {
    fn default() -> Self {
        Self {
            root_ca: None,
            certificate: None,
            private_key: None,
            verify_name: true,
        }
    }
}

impl Default for ZenohSettings {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            connect: None,
            listen: Endpoints::default(),
            namespace: None,
            tls: TlsSettings::default(),
            user: None,
            password: None,
            users_file: None,
            // A cloud with its key and the like.
            max_message_bytes: MAX_CLOUD_BYTES + (1 << 20),
            max_sessions: 256,
            lease_s: 3.0,
            file: None,
        }
    }
}

impl ZenohSettings {
    /// Fills in what depends on the mode.
    pub(super) fn fill_in(&mut self) {
        let mode = self.mode;
        self.connect.get_or_insert_with(|| match mode {
            Mode::Client => Endpoints(vec![DEFAULT_ROUTER.to_owned()]),
            Mode::Peer | Mode::Router => Endpoints::default(),
        });
    }

    /// What it connects to.
    pub(crate) fn connect(&self) -> &[String] {
        self.connect.as_ref().map_or(&[], |endpoints| &endpoints.0)
    }

    pub(super) fn validate(&self) -> Result<(), ConfigurationError> {
        if self.mode == Mode::Client && self.connect().is_empty() {
            let reason = format!("a client needs one to connect to, such as {DEFAULT_ROUTER}");
            return Err(ConfigurationError::invalid("zenoh.connect", reason));
        }
        if self.mode == Mode::Router && self.listen.0.is_empty() && self.file.is_none() {
            let reason = "a router needs one to listen on, such as tcp/0.0.0.0:7447";
            return Err(ConfigurationError::invalid("zenoh.listen", reason));
        }
        if !(0.1..=600.0).contains(&self.lease_s) {
            return Err(ConfigurationError::invalid(
                "zenoh.lease_s",
                "0.1 to 600 is possible",
            ));
        }
        if self.user.is_some() != self.password.is_some() {
            return Err(ConfigurationError::invalid(
                "zenoh.user",
                "user and password go together",
            ));
        }
        for (key, path) in self.files() {
            if let Some(path) = path
                && let Err(error) = std::fs::File::open(path)
            {
                let reason = format!("{} cannot be read: {error}", path.display());
                return Err(ConfigurationError::invalid(key, reason));
            }
        }
        self.to_zenoh().map(drop)
    }

    fn files(&self) -> [(&'static str, Option<&PathBuf>); 5] {
        [
            ("zenoh.tls.root_ca", self.tls.root_ca.as_ref()),
            ("zenoh.tls.certificate", self.tls.certificate.as_ref()),
            ("zenoh.tls.private_key", self.tls.private_key.as_ref()),
            ("zenoh.users_file", self.users_file.as_ref()),
            ("zenoh.file", self.file.as_ref()),
        ]
    }

    /// As Zenoh wants it.
    ///
    /// # Errors
    /// [`ConfigurationError::Invalid`] where Zenoh does not take a value.
    pub fn to_zenoh(&self) -> Result<zenoh::Config, ConfigurationError> {
        let mut config = match &self.file {
            Some(path) => zenoh::Config::from_file(path)
                .map_err(|error| ConfigurationError::invalid("zenoh.file", error))?,
            None => zenoh::Config::default(),
        };
        for (key, path, value) in self.entries() {
            config
                .insert_json5(path, &value.to_string())
                .map_err(|error| ConfigurationError::invalid(key, error))?;
        }
        Ok(config)
    }

    /// The key here, the path in Zenoh's configuration, the value there.
    fn entries(&self) -> Vec<(&'static str, &'static str, Value)> {
        let mut entries = vec![
            ("zenoh.mode", "mode", json!(self.mode)),
            (
                "zenoh.max_message_bytes",
                "transport/link/rx/max_message_size",
                json!(self.max_message_bytes),
            ),
            (
                "zenoh.max_sessions",
                "transport/unicast/max_sessions",
                json!(self.max_sessions),
            ),
            (
                "zenoh.lease_s",
                "transport/link/tx/lease",
                json!(milliseconds(self.lease_s)),
            ),
        ];
        entries.extend(self.endpoint_entries());
        entries.extend(self.optional_entries());
        entries.extend(fixed_entries(self.mode));
        entries
    }

    fn endpoint_entries(&self) -> impl Iterator<Item = (&'static str, &'static str, Value)> {
        let lists = [
            ("zenoh.connect", "connect/endpoints", self.connect()),
            ("zenoh.listen", "listen/endpoints", &self.listen.0),
        ];
        // Zenoh listens on all interfaces where it is told nothing.
        let is_said = |list: &[String]| self.file.is_none() || !list.is_empty();
        lists
            .into_iter()
            .filter(move |(_, _, list)| is_said(list))
            .map(|(key, path, list)| (key, path, json!(list)))
    }

    fn optional_entries(&self) -> Vec<(&'static str, &'static str, Value)> {
        let tls = &self.tls;
        let mut entries = Vec::new();
        if let Some(namespace) = &self.namespace {
            entries.push(("zenoh.namespace", "namespace", json!(namespace)));
        }
        if let Some(root_ca) = &tls.root_ca {
            let path = "transport/link/tls/root_ca_certificate";
            entries.push(("zenoh.tls.root_ca", path, json!(root_ca)));
        }
        if let Some(certificate) = &tls.certificate {
            for path in [
                "transport/link/tls/listen_certificate",
                "transport/link/tls/connect_certificate",
            ] {
                entries.push(("zenoh.tls.certificate", path, json!(certificate)));
            }
            entries.push((
                "zenoh.tls.certificate",
                "transport/link/tls/enable_mtls",
                json!(true),
            ));
        }
        if let Some(key) = &tls.private_key {
            for path in [
                "transport/link/tls/listen_private_key",
                "transport/link/tls/connect_private_key",
            ] {
                entries.push(("zenoh.tls.private_key", path, json!(key)));
            }
        }
        let path = "transport/link/tls/verify_name_on_connect";
        entries.push(("zenoh.tls.verify_name", path, json!(tls.verify_name)));
        let users = json!({
            "user": self.user,
            "password": self.password.as_ref().map(Secret::reveal),
            "dictionary_file": self.users_file,
        });
        if self.user.is_some() || self.users_file.is_some() {
            entries.push(("zenoh.user", "transport/auth/usrpwd", users));
        }
        entries
    }
}

/// What is the same for every process.
fn fixed_entries(mode: Mode) -> Vec<(&'static str, &'static str, Value)> {
    let retry =
        json!({"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2.0});
    let mut entries = vec![
        ("zenoh", "scouting/multicast/enabled", json!(false)),
        // A connection that is lost is back within about a second of the other's return, not four.
        ("zenoh", "connect/retry", retry),
        ("zenoh", "transport/unicast/open_timeout", json!(2000)),
        // A reader that does not read is cut off after so long; until then it holds up who writes to it.
        (
            "zenoh",
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            json!(2_000_000),
        ),
    ];
    if mode == Mode::Router {
        // Without multicast, a router has nothing to wait for when it starts.
        entries.push(("zenoh", "scouting/delay", json!(0)));
    }
    entries
}

fn milliseconds(seconds: f64) -> u64 {
    (seconds * 1000.0) as u64
}
