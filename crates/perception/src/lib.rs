//! What a sensor above a container sees, as the heightmap and the surface that placements are planned on.
//!
//! A [`Mapper`](mapper::Mapper) sorts the points of a cloud into the samples of a grid's fine surface. What no point was
//! seen of is unknown, and counts as higher than the rim: nothing is ever placed there.
//!
//! A scene may be doubtful ([`doubts`]): little of it was seen, the container is not where it should be, something
//! reaches into it, or something moves. Nothing is to be planned on it then. Where the container stands before the
//! sensor is found by [`calibration`].
//!
//! The crate is pure and synchronous; it knows neither the wire nor any sensor.

pub mod calibration;
pub mod doubts;
pub mod extrinsics;
mod holes;
mod layers;
mod limits;
pub mod mapper;
pub mod settings;
pub mod still;
