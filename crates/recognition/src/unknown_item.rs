//! Items that are packed without being known.

use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::kernel::grid::{ABSENT, MAX_CELLS, MAX_UNITS, Resolution, Units};
use ppnpack_packing::kernel::item::{Item, ItemError, ViewSurfaces};
use ppnpack_packing::kernel::rectangle::least_rectangle_rad;

use crate::segmentation::Cluster;

/// An item made of what was seen of it. Its upper surface is the seen one; as nothing is known of
/// its lower side, there is material from every seen place down to the support.
#[derive(Debug)]
pub struct UnknownItem {
    /// The item, with a view per yaw.
    pub item: Item,
    /// The item frame in the world: on the support, under the middle of the seen points, along
    /// their least rectangle.
    pub world_from_item: Isometry3<f64>,
}

/// Why a cluster makes no item.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnknownItemError {
    /// It has no point that is finite.
    #[error("nothing is seen of the item")]
    NoPoints,
    /// It has more cells or units than the engine represents, by its extents in metres.
    #[error("an item of {:.2} x {:.2} x {:.2} m is too large for the grid", .0.x, .0.y, .0.z)]
    TooLarge(Vector3<f64>),
    /// Its surfaces make no item.
    #[error(transparent)]
    Item(#[from] ItemError),
}

/// Makes an item of a cluster, at each yaw of a resolution.
///
/// # Errors
/// [`UnknownItemError`] where there is no point, or the item is too large.
pub fn unknown_item(
    name: &str,
    cluster: &Cluster,
    resolution: &Resolution,
) -> Result<UnknownItem, UnknownItemError> {
    let is_sound = |point: &&Point3<f64>| point.iter().all(|value| value.is_finite());
    let points: Vec<Point3<f64>> = cluster.points_m.iter().filter(is_sound).copied().collect();
    let bounds = Bounds::of(&points).ok_or(UnknownItemError::NoPoints)?;
    let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
    let yaw_rad = least_rectangle_rad(points.iter().map(Point3::xy)).unwrap_or(0.0);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let support_from_item = Translation3::new(middle.x, middle.y, 0.0) * turn;
    let item_from_support = support_from_item.inverse();
    let centred = points.iter().map(|point| item_from_support * point);
    let centred: Vec<Point3<f64>> = centred.collect();
    let views = resolution.yaws().radians().iter();
    let views = views.map(|yaw_rad| view(&centred, *yaw_rad, resolution));
    let views = views.collect::<Result<Vec<_>, _>>()?;
    // The volume of all columns at the first yaw.
    let tops = views.first().into_iter().flat_map(|view| &view.top);
    let units: f64 = tops.map(|top| f64::from(*top)).sum();
    let volume_m3 = units * resolution.height_unit_m() * resolution.cell_m().powi(2);
    Ok(UnknownItem {
        item: Item::new(name, views, volume_m3)?,
        world_from_item: cluster.world_from_support * support_from_item,
    })
}

/// Gives the surfaces at one yaw.
fn view(
    points: &[Point3<f64>],
    yaw_rad: f64,
    resolution: &Resolution,
) -> Result<ViewSurfaces, UnknownItemError> {
    let (sin, cos) = yaw_rad.sin_cos();
    let turned = points.iter().map(|point| {
        let x = cos * point.x - sin * point.y;
        let y = sin * point.x + cos * point.y;
        Point3::new(x, y, point.z)
    });
    let turned: Vec<Point3<f64>> = turned.collect();
    let Bounds { lowest, highest } = Bounds::of(&turned).ok_or(UnknownItemError::NoPoints)?;
    let extents_m = Vector3::new(highest.x - lowest.x, highest.y - lowest.y, highest.z);
    let cell_m = resolution.cell_m();
    let limit_m = MAX_CELLS as f64 * cell_m;
    let is_large = extents_m.x > limit_m || extents_m.y > limit_m;
    if is_large || extents_m.z > f64::from(MAX_UNITS) * resolution.height_unit_m() {
        return Err(UnknownItemError::TooLarge(extents_m));
    }
    let cells = |width_m: f64| ((width_m / cell_m).ceil() as usize).clamp(1, MAX_CELLS);
    let (nx, ny) = (cells(extents_m.x), cells(extents_m.y));
    let mut heights_m = vec![f64::NEG_INFINITY; nx * ny];
    for point in &turned {
        let offset = (point.xy() - lowest.xy()) / cell_m;
        let (x, y) = (offset.x as usize, offset.y as usize);
        let (x, y) = (x.min(nx - 1), y.min(ny - 1));
        if let Some(height_m) = heights_m.get_mut(x * ny + y) {
            *height_m = height_m.max(point.z);
        }
    }
    close_gaps(&mut heights_m, nx, ny);
    let column = |height_m: &f64| -> (Units, Units) {
        match height_m.is_finite() {
            true => (resolution.units_above(*height_m).max(1), 0),
            false => (0, ABSENT),
        }
    };
    let (top, bottom) = heights_m.iter().map(column).unzip();
    Ok(ViewSurfaces {
        origin_from_corner_m: Vector3::new(-lowest.x, -lowest.y, 0.0),
        centre_of_mass_m: centre(&heights_m, ny, cell_m),
        ..ViewSurfaces::of_cells(nx, ny, top, bottom)
    })
}

/// Gives cells without a point between two covered ones the height of their highest neighbour: the
/// sensor missed them.
fn close_gaps(heights_m: &mut [f64], nx: usize, ny: usize) {
    let seen = heights_m.to_vec();
    let at = |x: usize, y: usize| {
        let height_m = (x < nx && y < ny).then(|| seen.get(x * ny + y));
        height_m.flatten().copied().unwrap_or(f64::NEG_INFINITY)
    };
    for (index, height_m) in heights_m.iter_mut().enumerate() {
        let (x, y) = (index / ny, index % ny);
        let (before, after) = (at(x.wrapping_sub(1), y), at(x + 1, y));
        let (left, right) = (at(x, y.wrapping_sub(1)), at(x, y + 1));
        let is_between = before.min(after).is_finite() || left.min(right).is_finite();
        if is_between && !height_m.is_finite() {
            *height_m = before.max(after).max(left).max(right);
        }
    }
}

/// Gives the centre of the columns, from the corner.
fn centre(heights_m: &[f64], ny: usize, cell_m: f64) -> Option<Point2<f64>> {
    let mut moment = Vector2::zeros();
    let mut total_m = 0.0;
    let columns = heights_m.iter().enumerate();
    for (index, height_m) in columns.filter(|(_, height)| height.is_finite()) {
        let middle = Vector2::new((index / ny) as f64 + 0.5, (index % ny) as f64 + 0.5);
        moment += middle * *height_m;
        total_m += height_m;
    }
    (total_m > 0.0).then(|| Point2::from(moment * (cell_m / total_m)))
}
