//! The way to reach Zenoh: `[zenoh]`.

use std::fmt::Display;
use std::path::PathBuf;

use ppnpack_numbers::settings;
use ppnpack_wire::MAX_CLOUD_BYTES;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};
use x509_parser::pem::Pem;

use super::{ConfigurationError, Secret, check, secure};

const DEFAULT_ROUTER: &str = "tcp/127.0.0.1:7447";

/// Maximum size of a message beside its content: its key and the like.
const MESSAGE_OVERHEAD_BYTES: usize = 1 << 20;

/// A cloud of a million points as drivers of ROS write them, with colour: 32 bytes a point.
const USUAL_CLOUD_BYTES: usize = 32 << 20;

/// The key here, the path in Zenoh's configuration, the value there.
type Entry = (String, String, Value);

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
                let parts = parts.filter(|part| !part.is_empty());
                parts.map(str::to_owned).collect()
            }
            Given::Many(list) => list,
        }))
    }
}

settings! {
    /// The way to reach Zenoh. Multicast scouting is always off: it fails silently in containers.
    pub struct ZenohSettings {
        /// The part of this process.
        pub mode: Mode = Mode::default(),
        /// Endpoints that it connects to; for a client `tcp/127.0.0.1:7447` where they are not
        /// given.
        pub connect: Option<Endpoints> = None,
        /// Endpoints that it listens on.
        pub listen: Endpoints = Endpoints::default(),
        /// Prefix of all keys on the network, so that several stacks can share it.
        pub namespace: Option<String> = None,
        /// Certificates, for endpoints that begin with `tls/`.
        pub tls: TlsSettings = TlsSettings::default(),
        /// The name with which this process connects.
        pub user: Option<String> = None,
        /// The password that goes with it.
        pub password: Option<Secret> = None,
        /// A file with lines `user:password`: those who may connect to this process.
        pub users_file: Option<PathBuf> = None,
        /// Maximum size of a message, in bytes: a larger one does not arrive.
        // A router may have to keep as much for each priority of all who connect: larger clouds
        // have to be asked for.
        pub max_message_bytes: usize = USUAL_CLOUD_BYTES + MESSAGE_OVERHEAD_BYTES,
        /// Maximum number of others that are connected to this process.
        pub max_sessions: usize = 256,
        /// Time of silence after which another counts as gone, in seconds.
        pub lease_s: f64 = 3.0,
        /// A Zenoh configuration (JSON5) to begin with, such as one with access control. The
        /// settings here are stronger.
        pub file: Option<PathBuf> = None,
    }
}

settings! {
    /// Certificates and keys, as PEM files.
    pub struct TlsSettings {
        /// The authority that signs the certificates of others.
        pub root_ca: Option<PathBuf> = None,
        /// This process's certificate. Where it is given, others need one too (mutual TLS).
        pub certificate: Option<PathBuf> = None,
        /// The key that goes with it.
        pub private_key: Option<PathBuf> = None,
        /// Whether a certificate must be for the name that was connected to.
        pub verify_name: bool = true,
    }
}

impl ZenohSettings {
    /// Makes room for the largest clouds: for clients of their own router, or a router of this
    /// machine.
    #[must_use]
    pub fn with_largest_clouds(self) -> Self {
        Self {
            max_message_bytes: MAX_CLOUD_BYTES + MESSAGE_OVERHEAD_BYTES,
            ..self
        }
    }

    pub(super) fn fill_in(&mut self) {
        let is_client = self.mode == Mode::Client;
        let default = is_client.then(|| DEFAULT_ROUTER.to_owned());
        self.connect
            .get_or_insert(Endpoints(Vec::from_iter(default)));
    }

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
        check("zenoh.lease_s", self.lease_s, 0.1..=600.0)?;
        if self.user.is_some() != self.password.is_some() {
            let reason = "user and password go together";
            return Err(ConfigurationError::invalid("zenoh.user", reason));
        }
        for (key, path) in [
            ("zenoh.tls.root_ca", &self.tls.root_ca),
            ("zenoh.tls.certificate", &self.tls.certificate),
            ("zenoh.tls.private_key", &self.tls.private_key),
            ("zenoh.users_file", &self.users_file),
            ("zenoh.file", &self.file),
        ] {
            if let Some(path) = path
                && let Err(error) = std::fs::File::open(path)
            {
                let reason = format!("{} cannot be read: {error}", path.display());
                return Err(ConfigurationError::invalid(key, reason));
            }
        }
        self.tls.ends()?;
        secure::check(self.mode, &self.to_zenoh()?)
    }

    /// Makes Zenoh's configuration.
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
            if !value.is_null() {
                let inserted = config.insert_json5(&path, &value.to_string());
                inserted.map_err(|error| ConfigurationError::invalid(key, error))?;
            }
        }
        Ok(config)
    }

    /// Gives the entries for Zenoh's configuration; null is none.
    fn entries(&self) -> impl Iterator<Item = Entry> {
        let lease_ms = (self.lease_s * 1000.0) as u64;
        // Zenoh listens on all interfaces where it is told nothing.
        let is_said = |list: &[String]| self.file.is_none() || !list.is_empty();
        let endpoints = |list: &[String]| json!(is_said(list).then_some(list));
        let (connect, listen) = (endpoints(self.connect()), endpoints(&self.listen.0));
        let max_size = "transport/link/rx/max_message_size";
        let max_sessions = "transport/unicast/max_sessions";
        let own = [
            ("mode", "mode", json!(self.mode)),
            ("max_message_bytes", max_size, json!(self.max_message_bytes)),
            ("max_sessions", max_sessions, json!(self.max_sessions)),
            ("lease_s", "transport/link/tx/lease", json!(lease_ms)),
            ("connect", "connect/endpoints", connect),
            ("listen", "listen/endpoints", listen),
            ("namespace", "namespace", json!(self.namespace)),
            ("user", "transport/auth/usrpwd", self.users()),
        ];
        let own = own.map(|(key, path, value)| (format!("zenoh.{key}"), path.to_owned(), value));
        let fixed = fixed_entries(self.mode).into_iter();
        let fixed = fixed.map(|(path, value)| ("zenoh".to_owned(), path.to_owned(), value));
        own.into_iter().chain(self.tls.entries()).chain(fixed)
    }

    fn users(&self) -> Value {
        if self.user.is_none() && self.users_file.is_none() {
            return Value::Null;
        }
        json!({
            "user": self.user,
            "password": self.password.as_ref().map(Secret::reveal),
            "dictionary_file": self.users_file,
        })
    }
}

impl TlsSettings {
    /// Gives the end of the first certificate of each file to end, in seconds since 1970, with the
    /// name of the setting.
    ///
    /// # Errors
    /// [`ConfigurationError::Invalid`] where a file has no certificate.
    pub(crate) fn ends(&self) -> Result<Vec<(&'static str, i64)>, ConfigurationError> {
        let own = self.certificate.as_ref().map(|path| ("certificate", path));
        let authority = self.root_ca.as_ref().map(|path| ("root_ca", path));
        let given = own.into_iter().chain(authority);
        let ends = given.map(|(name, path)| {
            let refused = |reason: &dyn Display| {
                let reason = format!("{} is no certificate: {reason}", path.display());
                ConfigurationError::invalid(format!("zenoh.tls.{name}"), reason)
            };
            let text = std::fs::read(path).map_err(|error| refused(&error))?;
            let ends = Pem::iter_from_buffer(&text).map(|pem| {
                let pem = pem.map_err(|error| refused(&error))?;
                let certificate = pem.parse_x509().map_err(|error| refused(&error))?;
                Ok(certificate.validity().not_after.timestamp())
            });
            let ends: Vec<i64> = ends.collect::<Result<_, _>>()?;
            let first = ends.into_iter().min();
            Ok((name, first.ok_or_else(|| refused(&"it is empty"))?))
        });
        ends.collect()
    }

    fn entries(&self) -> impl Iterator<Item = Entry> {
        let is_mutual = self.certificate.as_ref().map(|_| true);
        let (certificate, private_key) = (&self.certificate, &self.private_key);
        let verifies = self.verify_name;
        let entries = [
            ("root_ca", "root_ca_certificate", json!(self.root_ca)),
            ("certificate", "listen_certificate", json!(certificate)),
            ("certificate", "connect_certificate", json!(certificate)),
            ("certificate", "enable_mtls", json!(is_mutual)),
            // Who could not connect any more does not stay connected either.
            ("certificate", "close_link_on_expiration", json!(is_mutual)),
            ("private_key", "listen_private_key", json!(private_key)),
            ("private_key", "connect_private_key", json!(private_key)),
            ("verify_name", "verify_name_on_connect", json!(verifies)),
        ];
        entries.into_iter().map(|(key, path, value)| {
            let path = format!("transport/link/tls/{path}");
            (format!("zenoh.tls.{key}"), path, value)
        })
    }
}

/// Gives the entries that are the same for every process: paths with their values.
fn fixed_entries(mode: Mode) -> [(&'static str, Value); 7] {
    let retry =
        json!({"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2.0});
    // Without multicast, a router has nothing to wait for when it starts.
    let scouting_delay = (mode == Mode::Router).then_some(0);
    // A router asks itself where it listens, and who is connected.
    let tells = (mode == Mode::Router).then_some(true);
    // A reader that does not read is cut off after so long; until then it holds up who writes to
    // it.
    let block_us = json!(2_000_000);
    let block = "transport/link/tx/queue/congestion_control/block/wait_before_close";
    [
        ("scouting/multicast/enabled", json!(false)),
        // A connection that is lost is back within about a second of the other's return, not four.
        ("connect/retry", retry),
        ("transport/unicast/open_timeout", json!(2000)),
        (block, block_us),
        // Maximum number of batches of 64 KiB that wait on a link, and the most that Zenoh allows.
        // A record or a cloud takes several: with Zenoh's two it is dropped where the machine is
        // busy for a few milliseconds.
        ("transport/link/tx/queue/size/data", json!(16)),
        ("scouting/delay", json!(scouting_delay)),
        ("adminspace/enabled", json!(tells)),
    ]
}
