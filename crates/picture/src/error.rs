//! Reasons why a picture could not be made.

/// A reason why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// A picture without pixels, or with more than [`MAX_PIXELS`](crate::Size::MAX_PIXELS).
    #[error(
        "a picture of {width} x {height} pixels: it needs at least 1 and at most {limit} pixels"
    )]
    Size {
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
        /// The greatest number of pixels.
        limit: usize,
    },
    /// More geometry than a scene may hold.
    #[error("the scene has more than {limit} triangles or vertices")]
    SceneTooLarge {
        /// The greatest number of triangles, and of vertices.
        limit: usize,
    },
    /// The number of heights is not that of the cells.
    #[error(
        "a height field of {columns} x {rows} cells needs as many heights, but {found} were given"
    )]
    HeightCount {
        /// Cells along x.
        columns: usize,
        /// Cells along y.
        rows: usize,
        /// How many heights were given.
        found: usize,
    },
    /// The PNG encoder failed.
    #[error("encoding the picture as PNG")]
    Png(#[from] png::EncodingError),
}
