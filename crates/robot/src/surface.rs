//! An item's upper surface, finely sampled, as a suction cup sees it.

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::raster::{Raster, rasterise};
use ppnpack_packing::kernel::grid::{ABSENT, Resolution};
use ppnpack_packing::kernel::item::Item;

/// Maximum of samples along one side.
const MAX_SAMPLES: f64 = 1024.0;

/// The upper surface of an item as it lies, seen from above.
///
/// Row-major: sample `(x, y)` is at `x * ny + y` and covers the square `[x, x + 1) x [y, y + 1)`
/// pitches from the corner. Each height is the greatest within its square, from the item's lowest
/// point, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct UpperSurface {
    nx: usize,
    ny: usize,
    pitch_m: f64,
    /// Heights; not a number where there is no material.
    heights_m: Vec<f64>,
    /// The greatest distance from a square's border inwards at which its material may end, in
    /// metres.
    pub(crate) edge_m: f64,
    /// The point at which the centre of mass's vertical axis meets the footprint, in metres from
    /// the surface's corner.
    pub(crate) centre_of_mass_m: Point2<f64>,
    /// The surface's frame, at the corner and the item's lowest point, in the item's.
    pub(crate) item_from_surface: Isometry3<f64>,
}

impl UpperSurface {
    /// Samples the surface of a model at a pitch, in metres. `None` for a model without a vertex.
    ///
    /// The pitch is made coarser for a model that would have more than 1024 samples along a side.
    pub fn of_model(model: &Model, pitch_m: f64) -> Option<Self> {
        let bounds = model.mesh.bounds()?;
        let extents_m = bounds.extents_m();
        let pitch_m = pitch_m.max(extents_m.x.max(extents_m.y) / MAX_SAMPLES);
        let samples = |length_m: f64| (length_m / pitch_m).ceil().max(1.0) as usize;
        let (nx, ny) = (samples(extents_m.x), samples(extents_m.y));
        let raster = Raster {
            origin: bounds.lowest.xy(),
            pitch_m,
            nx,
            ny,
        };
        let mut heights_m = vec![f64::NAN; nx * ny];
        for triangle in model.mesh.corners() {
            rasterise(&triangle, &raster, |x, y, _, highest| {
                if let Some(height) = heights_m.get_mut(x * ny + y) {
                    *height = height.max(highest - bounds.lowest.z);
                }
            });
        }
        Some(Self {
            nx,
            ny,
            pitch_m,
            heights_m,
            edge_m: pitch_m,
            centre_of_mass_m: Point2::from((model.mass.centre_of_mass_m - bounds.lowest).xy()),
            item_from_surface: Translation3::from(bounds.lowest.coords).into(),
        })
    }

    /// Gives the surface that an item's heightmap at its first yaw shows: as coarse as the
    /// resolution's cells and units, so the cup may overhang an edge by up to a cell. `None` for an
    /// item without a yaw.
    pub fn of_item(item: &Item, resolution: &Resolution) -> Option<Self> {
        let view = item.views().first()?;
        let yaw_rad = resolution.yaws().radians().first()?;
        let columns = view.top().iter().zip(view.bottom());
        let heights_m = columns.map(|(top, bottom)| match *bottom {
            ABSENT => f64::NAN,
            _ => f64::from(*top) * resolution.height_unit_m(),
        });
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -yaw_rad);
        let to_item = Translation3::from(-view.origin_from_corner_m());
        Some(Self {
            nx: view.nx(),
            ny: view.ny(),
            pitch_m: resolution.cell_m(),
            heights_m: heights_m.collect(),
            // A cell's worth would leave no small item to hold; a heightmap tells no better.
            edge_m: 0.0,
            centre_of_mass_m: view.centre_of_mass_m(resolution.cell_m()),
            item_from_surface: turn * to_item,
        })
    }

    /// Gives the middles of the squares with material.
    pub(crate) fn middles_m(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        let known = self.heights_m.iter().enumerate();
        let known = known.filter(|(_, height_m)| !height_m.is_nan());
        known.map(|(index, _)| self.middle_m((index / self.ny) as f64, (index % self.ny) as f64))
    }

    fn middle_m(&self, x: f64, y: f64) -> Point2<f64> {
        Point2::new(x + 0.5, y + 0.5) * self.pitch_m
    }

    /// Gives the squares that a disc touches: the middle's offset from the disc's, and the height;
    /// `None` where there is no material, or beside the surface.
    pub(crate) fn around(
        &self,
        middle_m: Point2<f64>,
        radius_m: f64,
    ) -> impl Iterator<Item = (Vector2<f64>, Option<f64>)> + '_ {
        let range = move |at: f64| {
            let first = ((at - radius_m) / self.pitch_m).floor() as i64;
            let last = ((at + radius_m) / self.pitch_m).floor() as i64;
            first..=last
        };
        let squares = range(middle_m.x).flat_map(move |x| range(middle_m.y).map(move |y| (x, y)));
        let half_m = 0.5 * self.pitch_m;
        squares.filter_map(move |(x, y)| {
            let offset = self.middle_m(x as f64, y as f64) - middle_m;
            let nearest = offset.abs().add_scalar(-half_m).sup(&Vector2::zeros());
            (nearest.norm() < radius_m).then(|| {
                let inside = usize::try_from(x).ok().zip(usize::try_from(y).ok());
                let inside = inside.filter(|(x, y)| *x < self.nx && *y < self.ny);
                let height = inside.and_then(|(x, y)| self.heights_m.get(x * self.ny + y));
                (offset, height.copied().filter(|height| !height.is_nan()))
            })
        })
    }
}
