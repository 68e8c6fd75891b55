//! Point cloud files.
//!
//! [`read`] takes PCD (ascii, binary, binary_compressed) and PLY (ascii, binary of either byte
//! order) by what they contain; [`to_pcd`] gives the bytes of a binary PCD. Only `x`, `y` and `z`
//! are read, as numbers of 4 or 8 bytes with a fraction; they are metres in the frame that the file
//! was written in, which is taken to be the sensor's. A file's own viewpoint is not applied.
//!
//! Files come from anywhere: what is malformed is refused with the reason, and memory is taken for
//! what a file has, never for what it announces.
//!
//! ```
//! use ppnpack_clouds::{Cloud, parse, to_pcd};
//!
//! let file = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
//!     end_header\n0.1 0.2 0.3\n";
//! let cloud = parse(file)?;
//! assert_eq!(cloud.points_m(), [[0.1, 0.2, 0.3].into()]);
//! assert_eq!(parse(&to_pcd(&cloud))?, cloud);
//! # Ok::<(), ppnpack_clouds::FormatError>(())
//! ```

mod cloud;
mod error;
mod files;
mod pcd;
mod ply;
pub mod ply_rows;
pub mod text;

pub use cloud::{Cloud, CloudShapeError, MAX_POINTS};
pub use error::{CloudError, FormatError};
pub use files::{MAX_FILE_BYTES, parse, read};
pub use pcd::to_pcd;
