//! Answers to requests that fail.

use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, HeaderName, HeaderValue, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};

use crate::controls::ControlError;

#[derive(Debug)]
pub(super) struct Failure {
    status: StatusCode,
    error: &'static str,
    text: String,
    /// The question before it is sent again, confirmed.
    question: Option<&'static str>,
    header: Option<(HeaderName, &'static str)>,
}

impl Failure {
    pub(super) fn new(status: StatusCode, error: &'static str, text: impl Into<String>) -> Self {
        Self {
            status,
            error,
            text: text.into(),
            question: None,
            header: None,
        }
    }

    pub(super) fn forbidden(error: &'static str, text: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, error, text)
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

    pub(super) fn token() -> Self {
        let text = "the token is missing or wrong";
        Self {
            header: Some((WWW_AUTHENTICATE, "Bearer")),
            ..Self::new(StatusCode::UNAUTHORIZED, "token", text)
        }
    }

    pub(super) fn is_of_token(&self) -> bool {
        self.status == StatusCode::UNAUTHORIZED
    }

    pub(super) fn too_many_pages() -> Self {
        let text = "too many pages are connected: close one";
        Self {
            header: Some((RETRY_AFTER, "5")),
            ..Self::new(StatusCode::SERVICE_UNAVAILABLE, "too_many", text)
        }
    }

    #[cfg(test)]
    pub(super) fn code(&self) -> &'static str {
        self.error
    }

    /// Says that a thread did not do its work.
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
        }
    }
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let body = json!({
            "error": self.error,
            "text": self.text,
            "question": self.question,
        });
        let mut response = (self.status, json(&body)).into_response();
        if let Some((name, value)) = self.header {
            let value = HeaderValue::from_static(value);
            response.headers_mut().insert(name, value);
        }
        response
    }
}

/// Writes a value as the body of an answer.
pub(super) fn json(value: &Value) -> impl IntoResponse + use<> {
    ([(CONTENT_TYPE, "application/json")], value.to_string())
}
