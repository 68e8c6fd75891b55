//! What is answered where something is not possible.

use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, HeaderName, HeaderValue, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::controls::ControlError;

/// Something that is not possible, and why.
#[derive(Debug)]
pub(super) struct Failure {
    status: StatusCode,
    error: &'static str,
    text: String,
    /// What to ask before it is sent again, confirmed.
    question: Option<&'static str>,
    hint: Option<Hint>,
}

/// What a header says besides.
#[derive(Debug, Clone, Copy)]
enum Hint {
    Authenticate,
    RetryLater,
}

impl Hint {
    fn header(self) -> (HeaderName, HeaderValue) {
        match self {
            Self::Authenticate => (WWW_AUTHENTICATE, HeaderValue::from_static("Bearer")),
            Self::RetryLater => (RETRY_AFTER, HeaderValue::from_static("5")),
        }
    }
}

#[derive(Serialize)]
struct Body<'a> {
    error: &'static str,
    text: &'a str,
    question: Option<&'static str>,
}

impl Failure {
    pub(super) fn new(status: StatusCode, error: &'static str, text: impl Into<String>) -> Self {
        Self {
            status,
            error,
            text: text.into(),
            question: None,
            hint: None,
        }
    }

    pub(super) fn unknown_cell(name: &str) -> Self {
        let text = format!("there is no cell '{name}'");
        Self::new(StatusCode::NOT_FOUND, "unknown_cell", text)
    }

    pub(super) fn invalid(text: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "invalid", text)
    }

    pub(super) fn unanswered(text: impl Into<String>) -> Self {
        Self::new(StatusCode::GATEWAY_TIMEOUT, "unanswered", text)
    }

    pub(super) fn busy(text: impl Into<String>) -> Self {
        Self::new(StatusCode::TOO_MANY_REQUESTS, "busy", text)
    }

    /// A token is missing, or is another one.
    pub(super) fn token() -> Self {
        let text = "the token is missing or wrong";
        Self {
            hint: Some(Hint::Authenticate),
            ..Self::new(StatusCode::UNAUTHORIZED, "token", text)
        }
    }

    /// More pages are connected than may be.
    pub(super) fn too_many_pages() -> Self {
        let text = "too many pages are connected: close one";
        Self {
            hint: Some(Hint::RetryLater),
            ..Self::new(StatusCode::SERVICE_UNAVAILABLE, "too_many", text)
        }
    }

    #[cfg(test)]
    pub(super) fn code(&self) -> &'static str {
        self.error
    }

    /// What was to be done in another thread was not done there.
    pub(super) fn lost() -> Self {
        let text = "the server failed: its log says why";
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "failed", text)
    }
}

impl From<ControlError> for Failure {
    fn from(error: ControlError) -> Self {
        match error {
            ControlError::Invalid(text) => Self::invalid(text),
            ControlError::UnknownCell(name) => Self::unknown_cell(&name),
            ControlError::Unconfirmed(question) => Self {
                question: Some(question),
                ..Self::new(StatusCode::CONFLICT, "unconfirmed", question)
            },
            ControlError::Refused(text) => Self::new(StatusCode::CONFLICT, "refused", text),
            ControlError::Unanswered(text) => Self::unanswered(text),
            ControlError::Busy(text) => Self::busy(text),
        }
    }
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let body = Body {
            error: self.error,
            text: &self.text,
            question: self.question,
        };
        let mut response = (self.status, json(&body)).into_response();
        if let Some((name, value)) = self.hint.map(Hint::header) {
            response.headers_mut().insert(name, value);
        }
        response
    }
}

/// A value as the body of an answer.
pub(super) fn json<T: Serialize>(value: &T) -> impl IntoResponse + use<T> {
    // What is answered has texts as keys alone: it can always be written.
    let text = serde_json::to_string(value).unwrap_or_default();
    ([(CONTENT_TYPE, "application/json")], text)
}
