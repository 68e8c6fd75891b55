//! Why a request is not carried out.

use std::error::Error;

use ppnpack_packing::planning::plan::PlanError;
use ppnpack_packing::ranking::search::TooMuchMemory;
use ppnpack_wire::WireError;
use ppnpack_wire::v1::Status;

use crate::store::StoreError;
use ppnpack_protocol::session::SessionError;

/// Why a request is not carried out.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub(crate) status: Status,
    pub(crate) message: String,
}

impl Refusal {
    pub(crate) fn new(status: Status, message: impl std::fmt::Display) -> Self {
        Self {
            status,
            message: message.to_string(),
        }
    }

    /// Refuses, as the request asks for what is not possible.
    pub(crate) fn invalid(message: impl std::fmt::Display) -> Self {
        Self::new(Status::Invalid, message)
    }

    /// Refuses, as something that is needed is not there now.
    pub(crate) fn unavailable(message: impl std::fmt::Display) -> Self {
        Self::new(Status::Unavailable, message)
    }
}

impl From<SessionError> for Refusal {
    fn from(error: SessionError) -> Self {
        let status = match error {
            SessionError::UnknownItem(_)
            | SessionError::UnknownOrder(_)
            | SessionError::UnknownDecision(_)
            | SessionError::UnknownContainer(_) => Status::NotFound,
            SessionError::NoKind | SessionError::Full => Status::Invalid,
            SessionError::Failed(_) => Status::Stale,
            _ => Status::Conflict,
        };
        Self::new(status, error)
    }
}

impl From<StoreError> for Refusal {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::TooManyShapes { .. } => Self::invalid(error),
            error => Self::unavailable(error),
        }
    }
}

impl From<PlanError> for Refusal {
    fn from(error: PlanError) -> Self {
        if is_too_much(&error) {
            return Self::invalid(format_args!("{error}; or set search_mib of the cell"));
        }
        Self::new(Status::Failed, error)
    }
}

/// Says whether a plan would need as much memory again if it was asked for again.
fn is_too_much(error: &PlanError) -> bool {
    let mut cause = Some(error as &(dyn Error + 'static));
    while let Some(error) = cause {
        if error.is::<TooMuchMemory>() {
            return true;
        }
        cause = error.source();
    }
    false
}

impl From<WireError> for Refusal {
    fn from(error: WireError) -> Self {
        Self::invalid(error)
    }
}
