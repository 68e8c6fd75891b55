//! Why a request has no good answer.

use ppnpack_wire::keys::{Method, Service};
use ppnpack_wire::v1::Status;
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError};
use prost::{Message, Name};

/// Why a request has no good answer.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// Nobody answered: none is there, or it died. The request may have been carried out.
    #[error("no {service} answered {method}; is one running?")]
    NoAnswer {
        /// The service that was asked.
        service: Service,
        /// The method that was called.
        method: Method,
    },
    /// It was refused.
    #[error("{}: {message}", status.as_str_name())]
    Refused {
        /// The reason.
        status: Status,
        /// The reason in words.
        message: String,
        /// The whole reply.
        reply: Refusal,
    },
    /// The answer is no reply to this request.
    #[error("the answer is malformed: {0}")]
    Malformed(#[from] WireError),
    /// There was no answer in time. The request may have been carried out.
    #[error("no answer in time")]
    TimedOut,
    /// Zenoh refused to send the request.
    #[error("the request cannot be sent: {0}")]
    Zenoh(String),
}

impl CallError {
    /// Gives the status of a refusal.
    pub fn status(&self) -> Option<Status> {
        match self {
            Self::Refused { status, .. } => Some(*status),
            _ => None,
        }
    }

    pub(super) fn outcome(&self) -> &'static str {
        match self {
            Self::NoAnswer { .. } => "no_answer",
            Self::Refused { .. } => "refused",
            Self::Malformed(_) => "malformed",
            Self::TimedOut => "timed_out",
            Self::Zenoh(_) => "failed",
        }
    }
}

/// The reply of a refusal, which may say more than its status, such as which items are missing.
#[derive(Debug, Clone)]
pub struct Refusal(pub(super) Vec<u8>);

impl Refusal {
    /// Decodes the reply.
    ///
    /// # Errors
    /// [`WireError`] where it is another one.
    pub fn decode<M: Message + Name + Default>(&self) -> Result<M, WireError> {
        ppnpack_wire::decode(&self.0, MAX_MESSAGE_BYTES)
    }
}
