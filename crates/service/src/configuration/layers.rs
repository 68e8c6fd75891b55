//! One configuration from several sources, each value with its origin.

use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

use figment::value::{Dict, Map, Value};
use figment::{Figment, Metadata, Profile, Provider};
use serde::de::DeserializeOwned;

use super::{ConfigurationError, Sources, ZenohSettings};

/// Prefix of environment variables that belong to the configuration.
pub const ENVIRONMENT_PREFIX: &str = "PPNPACK__";

/// Last parts of the keys of secrets.
const SECRETS: [&str; 2] = ["token", "password"];

struct Layer {
    origin: String,
    values: Dict,
}

impl Provider for Layer {
    fn metadata(&self) -> Metadata {
        // Keys are shown as they are, whatever the origin.
        Metadata::named(self.origin.clone()).interpolater(|_, keys| keys.join("."))
    }

    fn data(&self) -> Result<Map<Profile, Dict>, figment::Error> {
        Ok(Map::from([(Profile::Default, self.values.clone())]))
    }
}

/// Reads one configuration from all sources, on top of the service's own way to reach Zenoh.
pub(super) fn extract<T: DeserializeOwned>(
    sources: &Sources<'_>,
    zenoh: &ZenohSettings,
) -> Result<T, ConfigurationError> {
    let zenoh = Value::serialize(zenoh).map_err(|error| refused(&error))?;
    let mut figment = Figment::from(Layer {
        origin: "the service's defaults".to_owned(),
        values: Dict::from([("zenoh".to_owned(), zenoh)]),
    });
    if let Some(path) = sources.file {
        figment = figment.merge(file(path)?);
    }
    for (name, value) in &sources.environment {
        if let Some(rest) = name.strip_prefix(ENVIRONMENT_PREFIX) {
            let key = rest.to_lowercase().replace("__", ".");
            figment = figment.merge(layer(format!("environment variable {name}"), &key, value)?);
        }
    }
    for assignment in sources.assignments {
        let (key, value) = assignment
            .split_once('=')
            .filter(|(key, _)| !key.trim().is_empty())
            .ok_or_else(|| ConfigurationError::Refused {
                reason: format!("'{assignment}' is no KEY=VALUE, such as zenoh.mode=client"),
                origin: "option --set".to_owned(),
            })?;
        let key = key.trim();
        if SECRETS.contains(&key.rsplit('.').next().unwrap_or_default()) {
            let reason =
                "everybody on the machine sees what a program is started with: say it in a file";
            return Err(ConfigurationError::invalid(key, reason));
        }
        figment = figment.merge(layer(format!("option --set {key}"), key, value.trim())?);
    }
    figment.extract().map_err(|mut error| {
        error.path.extend(rest_of_path::<T>(&figment, &error));
        let origin = figment.find_metadata(&error.path.join("."));
        error.metadata = origin.cloned().or(error.metadata.take());
        refused(&error)
    })
}

/// Gives the keys that lead from the place where an error was noticed to its cause, the value
/// without which it does not come. Settings whose keys stand among those of others are read as a
/// whole.
fn rest_of_path<T: DeserializeOwned>(figment: &Figment, error: &figment::Error) -> Vec<String> {
    let mut rest = Vec::new();
    let Ok(mut all) = figment.extract::<Dict>() else {
        return rest;
    };
    loop {
        let path: Vec<&String> = error.path.iter().chain(&rest).collect();
        let keys = dict_at(&mut all, &path).map(|dict| dict.keys().cloned().collect());
        let is_cause = |key: &String| {
            let mut others = all.clone();
            dict_at(&mut others, &path).and_then(|dict| dict.remove(key));
            match Value::from(others).deserialize::<T>() {
                Ok(_) => true,
                Err(other) => other.kind != error.kind && !other.missing(),
            }
        };
        match Vec::into_iter(keys.unwrap_or_default()).find(is_cause) {
            Some(key) => rest.push(key),
            None => return rest,
        }
    }
}

fn dict_at<'a>(dict: &'a mut Dict, path: &[&String]) -> Option<&'a mut Dict> {
    path.iter()
        .try_fold(dict, |dict, key| match dict.get_mut(*key) {
            Some(Value::Dict(_, inner)) => Some(inner),
            _ => None,
        })
}

fn file(path: &Path) -> Result<Layer, ConfigurationError> {
    let unreadable = |reason: String| ConfigurationError::Unreadable {
        path: path.to_owned(),
        reason,
    };
    let not_toml = |error: &dyn Display| {
        let error = error.to_string();
        unreadable(format!("it is not TOML: {}", error.trim_end()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
    let table = toml::Table::from_str(&text).map_err(|error| not_toml(&error))?;
    let values = Value::serialize(table).map_err(|error| not_toml(&error))?;
    Ok(Layer {
        origin: path.display().to_string(),
        values: values.into_dict().unwrap_or_default(),
    })
}

fn layer(origin: String, key: &str, text: &str) -> Result<Layer, ConfigurationError> {
    let value = Value::serialize(value_of(text)).map_err(|error| refused(&error))?;
    let values = figment::util::nest(key, value).into_dict();
    let values = values.unwrap_or_default();
    Ok(Layer { origin, values })
}

/// Reads a value of TOML; any other text stands for itself.
fn value_of(text: &str) -> toml::Value {
    let table = format!("value = {text}").parse::<toml::Table>();
    let table = table.ok().filter(|table| table.len() == 1);
    let value = table.and_then(|mut table| table.remove("value"));
    let value = value.filter(|value| !value.is_datetime());
    value.unwrap_or_else(|| toml::Value::String(text.to_owned()))
}

fn refused(error: &figment::Error) -> ConfigurationError {
    let key = error.path.join(".");
    let separator = if key.is_empty() { "" } else { ": " };
    let metadata = error.metadata.as_ref();
    let origin = metadata.map_or("the configuration as a whole", |metadata| &metadata.name);
    ConfigurationError::Refused {
        reason: format!("{key}{separator}{}", error.kind),
        origin: origin.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_toml_or_text() {
        assert_eq!(value_of("true"), true.into());
        assert_eq!(value_of("12"), 12.into());
        assert_eq!(value_of("\"12\""), "12".into());
        for text in ["tcp/127.0.0.1:7447", "1979-05-27", "1\nother = 2", ""] {
            assert_eq!(value_of(text), text.into());
        }
        assert!(value_of("[\"a\", \"b\"]").is_array());
    }
}
