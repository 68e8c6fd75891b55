//! Settings in files.

use serde::de::DeserializeOwned;

/// Maximum size of a file, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Reads the settings in a file, JSON where its name ends so and TOML otherwise: a parser for
/// options that name one.
///
/// # Errors
/// Its fault, in one line, with the place in the file.
pub(crate) fn settings<T: DeserializeOwned>(path: &str) -> Result<T, String> {
    let length = std::fs::metadata(path)
        .map_err(|error| error.to_string())?
        .len();
    if length > MAX_BYTES {
        return Err(format!(
            "{path} has {length} bytes: no settings are longer than {MAX_BYTES}"
        ));
    }
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    if path.ends_with(".json") {
        return serde_json::from_str(&text).map_err(|error| error.to_string());
    }
    toml::from_str(&text).map_err(|error| {
        let place = error.to_string();
        let place = place.lines().next().unwrap_or_default();
        format!("{place}: {}", error.message().replace('\n', " "))
    })
}
