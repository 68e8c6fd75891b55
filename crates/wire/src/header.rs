//! Headers of requests and replies.

use std::time::Duration;

use crate::error::{WireError, needed};
use crate::keys::{Cell, Instance};
use crate::limits::checked;
use crate::v1;

/// Maximum time limit of a request.
pub const MAX_TIME_LIMIT: Duration = Duration::from_secs(600);

/// Maximum size of a text for people in a reply, in bytes.
const MAX_TEXT_BYTES: usize = 4096;

/// The header of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RequestHeader {
    /// The name of the request, its idempotency key.
    pub request_id: String,
    /// The time for which the caller waits.
    pub time_limit: Duration,
    /// The planner that asks; none where another does.
    pub caller: Option<Instance>,
    /// The packing session that it is meant for; none where it is for any.
    pub session_id: Option<String>,
    /// The cell that it is for; none where it does not say so.
    pub cell: Option<Cell>,
}

impl RequestHeader {
    /// Reads a header.
    ///
    /// # Errors
    /// [`WireError`] where it is missing, or the id, the time limit, the caller, the session or the
    /// cell is not possible.
    pub fn read(header: Option<&v1::RequestHeader>) -> Result<Self, WireError> {
        let header = needed("header", header)?;
        let time_limit = Duration::from_micros(header.time_limit_us);
        let is_possible = !time_limit.is_zero() && time_limit <= MAX_TIME_LIMIT;
        let range = format_args!("1 to {} is possible", MAX_TIME_LIMIT.as_micros());
        let field = "header.time_limit_us";
        checked(field, header.time_limit_us, is_possible, range)?;
        let caller = (!header.caller.is_empty()).then(|| Instance::new(&header.caller));
        let caller = caller.transpose();
        let session_id = Some(&header.session_id).filter(|session_id| !session_id.is_empty());
        let session_id = session_id.map(|text| id("header.session_id", text));
        let cell = (!header.cell.is_empty()).then(|| Cell::new(&header.cell));
        let cell = cell.transpose();
        Ok(Self {
            caller: caller.map_err(|error| WireError::invalid("header.caller", error))?,
            session_id: session_id.transpose()?.map(str::to_owned),
            cell: cell.map_err(|error| WireError::invalid("header.cell", error))?,
            request_id: id("header.request_id", &header.request_id)?.to_owned(),
            time_limit,
        })
    }

    /// Writes the header as a message.
    pub fn to_message(&self) -> v1::RequestHeader {
        let micros = self.time_limit.min(MAX_TIME_LIMIT).as_micros();
        let caller = self.caller.as_ref();
        v1::RequestHeader {
            request_id: self.request_id.clone(),
            time_limit_us: u64::try_from(micros).unwrap_or(u64::MAX).max(1),
            caller: caller.map_or_else(String::new, Instance::to_string),
            session_id: self.session_id.clone().unwrap_or_default(),
            cell: self.cell.as_ref().map_or_else(String::new, Cell::to_string),
        }
    }
}

/// Checks an id that a caller chose.
///
/// # Errors
/// [`WireError::Invalid`] where it is not of 1 to 64 characters of `[A-Za-z0-9_.:-]`.
pub fn id<'a>(field: &'static str, text: &'a str) -> Result<&'a str, WireError> {
    let is_possible = |byte: u8| byte.is_ascii_alphanumeric() || b"_.:-".contains(&byte);
    if (1..=64).contains(&text.len()) && text.bytes().all(is_possible) {
        return Ok(text);
    }
    let reason = "1 to 64 characters of A-Z a-z 0-9 _ . : - are possible";
    Err(WireError::invalid(field, reason))
}

/// Cuts a text for people to the maximum of a message.
pub fn text(message: &str) -> String {
    let end = message.floor_char_boundary(MAX_TEXT_BYTES);
    message.get(..end).unwrap_or("").to_owned()
}

/// Makes the timing of a stage.
pub fn stage(name: &str, duration: Duration) -> v1::StageTiming {
    v1::StageTiming {
        stage: name.to_owned(),
        duration_ns: u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX),
    }
}
