//! Conditions on endpoints and keys where there are certificates, which are of no use beside an
//! open door.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use serde_json::Value;

use super::{ConfigurationError, Mode};

/// Permissions that nobody else may have on a key. Its group may read it, as where a cluster hands
/// it out.
const NOT_OF_A_KEY: u32 = 0o037;

/// Checks the doors of a process, as Zenoh is told of them, from whatever file.
///
/// # Errors
/// [`ConfigurationError::Invalid`] where an endpoint is plain beside certificates, nobody vouches
/// for those of others, whoever has one may do everything, or others may read a key.
pub(super) fn check(mode: Mode, config: &zenoh::Config) -> Result<(), ConfigurationError> {
    let said = |path: &str| -> Value {
        let text = config.get_json(path).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    };
    let tls = |name: &str| said(&format!("transport/link/tls/{name}"));
    let listen = match mode {
        Mode::Client => Vec::new(),
        Mode::Peer | Mode::Router => endpoints(mode, &said("listen/endpoints")),
    };
    let connect = endpoints(mode, &said("connect/endpoints"));
    let files = ["root_ca", "listen", "connect"];
    let has = |name: &&str| !tls(&format!("{name}_certificate")).is_null();
    let has_certificates = files.iter().any(has);
    let is_secure = |endpoint: &String| endpoint.starts_with("tls/");
    for (key, endpoints) in [("zenoh.listen", &listen), ("zenoh.connect", &connect)] {
        if has_certificates && let Some(plain) = endpoints.iter().find(|one| !is_secure(one)) {
            let reason = format!("'{plain}' has no TLS, with certificates it begins with tls/");
            return Err(ConfigurationError::invalid(key, reason));
        }
    }
    let mut all = listen.iter().chain(&connect);
    if all.any(is_secure) && tls("root_ca_certificate").is_null() {
        let reason = "endpoints that begin with tls/ need it, to know the others by";
        return Err(ConfigurationError::invalid("zenoh.tls.root_ca", reason));
    }
    let is_closed = said("access_control/enabled") == true
        && said("access_control/default_permission") == "deny";
    if listen.iter().any(is_secure) && !is_closed {
        let reason = "who listens with a certificate needs access control that is enabled and \
                      denies by default, or whoever has a certificate may do everything: \
                      deploy/secure/make makes it (router/access.json5)";
        return Err(ConfigurationError::invalid("zenoh.file", reason));
    }
    for name in ["listen_private_key", "connect_private_key"] {
        if let Some(path) = tls(name).as_str() {
            check_key(Path::new(path))?;
        }
    }
    Ok(())
}

/// Gives the endpoints of a mode: Zenoh's are one list, or one for each mode.
fn endpoints(mode: Mode, said: &Value) -> Vec<String> {
    let of_mode = serde_json::to_value(mode).unwrap_or_default();
    let of_mode = of_mode.as_str().and_then(|mode| said.get(mode));
    let list = of_mode.unwrap_or(said).as_array();
    let list = list.into_iter().flatten().filter_map(Value::as_str);
    list.map(str::to_owned).collect()
}

fn check_key(path: &Path) -> Result<(), ConfigurationError> {
    let shown = path.display();
    let refused = |reason| ConfigurationError::invalid("zenoh.tls.private_key", reason);
    let metadata = path
        .metadata()
        .map_err(|error| refused(format!("{shown} cannot be read: {error}")))?;
    if metadata.permissions().mode() & NOT_OF_A_KEY == 0 {
        return Ok(());
    }
    let reason = format!("others may read {shown}, or change it: chmod 600 {shown}");
    Err(refused(reason))
}
