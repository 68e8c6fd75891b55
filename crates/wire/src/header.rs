//! Headers of requests and replies.

use std::time::Duration;

use crate::error::{WireError, needed};
use crate::keys::Instance;
use crate::v1;

/// The longest that a request may take.
pub const MAX_TIME_LIMIT: Duration = Duration::from_secs(600);

/// The longest text for people in a reply, in bytes.
const MAX_TEXT_BYTES: usize = 4096;

/// What a request says of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RequestHeader {
    /// Names the request.
    pub request_id: String,
    /// How long the caller waits.
    pub time_limit: Duration,
    /// The planner that asks; none where another does.
    pub caller: Option<Instance>,
}

impl RequestHeader {
    /// Reads a header.
    ///
    /// # Errors
    /// [`WireError`] where it is missing, or the id, the time limit or the caller is not possible.
    pub fn read(header: Option<&v1::RequestHeader>) -> Result<Self, WireError> {
        let header = needed("header", header)?;
        let time_limit = Duration::from_micros(header.time_limit_us);
        if time_limit.is_zero() || time_limit > MAX_TIME_LIMIT {
            return Err(WireError::invalid(
                "header.time_limit_us",
                format_args!(
                    "{} where 1 to {} is possible",
                    header.time_limit_us,
                    MAX_TIME_LIMIT.as_micros()
                ),
            ));
        }
        let caller = match header.caller.as_str() {
            "" => None,
            caller => {
                let caller = Instance::new(caller);
                Some(caller.map_err(|error| WireError::invalid("header.caller", error))?)
            }
        };
        Ok(Self {
            request_id: id("header.request_id", &header.request_id)?.to_owned(),
            time_limit,
            caller,
        })
    }

    /// The header as a message.
    pub fn to_message(&self) -> v1::RequestHeader {
        let micros = self.time_limit.min(MAX_TIME_LIMIT).as_micros();
        v1::RequestHeader {
            request_id: self.request_id.clone(),
            time_limit_us: u64::try_from(micros).unwrap_or(u64::MAX).max(1),
            caller: self
                .caller
                .as_ref()
                .map_or_else(String::new, Instance::to_string),
        }
    }
}

/// Checks an id that a caller chose.
///
/// # Errors
/// [`WireError::Invalid`] where it is not of 1 to 64 characters of `[A-Za-z0-9_.:-]`.
pub fn id<'a>(field: &'static str, text: &'a str) -> Result<&'a str, WireError> {
    let is_possible =
        |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b':' | b'-');
    if (1..=64).contains(&text.len()) && text.bytes().all(is_possible) {
        Ok(text)
    } else {
        Err(WireError::invalid(
            field,
            "1 to 64 characters of A-Z a-z 0-9 _ . : - are possible",
        ))
    }
}

/// Text for people, cut to what a message may carry.
pub fn text(message: &str) -> String {
    let mut end = message.len().min(MAX_TEXT_BYTES);
    while !message.is_char_boundary(end) {
        end -= 1;
    }
    message.get(..end).unwrap_or("").to_owned()
}

/// The timing of a stage.
pub fn stage(name: &str, duration: Duration) -> v1::StageTiming {
    v1::StageTiming {
        stage: name.to_owned(),
        duration_ns: u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX),
    }
}
