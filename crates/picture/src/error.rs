//! Reasons why a picture could not be made.

/// A reason why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// What is to be drawn is impossible, or too much: a sentence for people.
    #[error("{0}")]
    Impossible(String),
    /// The PNG encoder failed.
    #[error("encoding the picture as PNG")]
    Png(#[from] png::EncodingError),
}
