//! Heightmaps and surfaces, which placements are planned on, from what a sensor above a container
//! sees.
//!
//! A [`Mapper`](mapper::Mapper) sorts the points of a cloud into the samples of a grid's fine
//! surface. What no point was seen of is at most as high as the lines of sight leave open; where
//! none passes it counts as higher than the rim.
//!
//! A scene may be doubtful ([`doubts`]): little of it was seen, the container is not where it
//! should be, something reaches into it, or moves. Nothing is to be planned on it then.
//! [`calibration`] finds where the container stands.
//!
//! The crate is pure and synchronous; it knows neither the wire nor any sensor.
//!
//! A block in the paper's container, seen by a sensor that stands in the container's frame:
//!
//! ```
//! use nalgebra::{Isometry3, Point3};
//! use ppnpack_packing::kernel::grid::Grid;
//! use ppnpack_perception::mapper::Mapper;
//! use ppnpack_perception::settings::MapperSettings;
//!
//! // A point every 2 mm; the block is just under 10 cm high.
//! let middle = |number: u16| 0.002 * (f32::from(number) + 0.5);
//! let is_block = |x_m: f32, y_m: f32| x_m < 0.12 && y_m < 0.08;
//! let cloud = (0..160_u16).flat_map(|row| (0..160).map(move |column| (middle(row), middle(column))));
//! let cloud = cloud.map(|(x_m, y_m)| Point3::new(x_m, y_m, if is_block(x_m, y_m) { 0.099 } else { 0.0 }));
//!
//! let grid = Grid::reference();
//! let mut mapper = Mapper::new(&grid, MapperSettings::default())?;
//! let mapped = mapper.map(cloud, &Isometry3::identity())?;
//! let heightmap = mapped.scene.heightmap();
//! // Cells are 1 cm wide, heights count in units of 2 mm.
//! assert_eq!((heightmap.get(11, 7), heightmap.get(12, 7)), (Some(50), Some(0)));
//! assert!(mapped.doubts.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibration;
pub mod doubts;
pub mod extrinsics;
mod holes;
mod layers;
pub mod mapper;
mod raster;
pub mod settings;
mod sight;
pub mod still;
mod walls;
