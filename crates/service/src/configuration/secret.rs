//! Text that is shown to nobody.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

const HIDDEN: &str = "***";

/// Text that is shown to nobody: not in logs, not by `--print-config`.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl Secret {
    /// Gives the text itself.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl From<String> for Secret {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(HIDDEN)
    }
}

impl Serialize for Secret {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(HIDDEN)
    }
}

impl<'de> Deserialize<'de> for Secret {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // The error of an untagged enum does not show the value.
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a secret is text: put it in quotes")]
        enum Given {
            Text(String),
            Number(i64),
        }
        Ok(match Given::deserialize(deserializer)? {
            Given::Text(text) => Self(text),
            Given::Number(number) => Self(number.to_string()),
        })
    }
}
