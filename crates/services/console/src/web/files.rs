//! The files of the page.

use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::IntoResponse;

use super::failure::Failure;
use crate::page::{self, File, INDEX};

pub(super) async fn index() -> Result<impl IntoResponse, Failure> {
    serve(page::file(INDEX))
}

pub(super) async fn named(Path(name): Path<String>) -> Result<impl IntoResponse, Failure> {
    serve(page::file(&name))
}

pub(super) async fn missing() -> Failure {
    Failure::new(StatusCode::NOT_FOUND, "not_found", "there is no such page")
}

pub(super) async fn other_method() -> Failure {
    let text = "this is asked for by another method";
    Failure::new(StatusCode::METHOD_NOT_ALLOWED, "other_method", text)
}

fn serve(file: Option<&'static File>) -> Result<impl IntoResponse, Failure> {
    let missing = || Failure::new(StatusCode::NOT_FOUND, "not_found", "there is no such file");
    let file = file.ok_or_else(missing)?;
    let headers = [(CONTENT_TYPE, file.kind), (CACHE_CONTROL, "no-cache")];
    Ok((headers, file.content))
}
