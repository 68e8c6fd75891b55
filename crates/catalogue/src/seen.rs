//! Solids of items of which no more is known than their heightmaps, such as what was seen of an
//! unknown item.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_packing::kernel::grid::{Resolution, Units};
use ppnpack_packing::kernel::item::{Item, ItemView, ShapeId};

use crate::convex::{MAX_PIECES, piece};
use crate::hull::hull;
use crate::mass::{DEFAULT_DENSITY_KG_M3, mass_properties};
use crate::mesh::{Bounds, Mesh};
use crate::object::{MassProperties, Model};

/// The most columns along a side: more cells are taken together.
const MOST_COLUMNS: usize = 128;

/// Columns become several pieces where the air in their hull is more than this share of the hull of
/// all.
const AIR_SHARE: f64 = 0.05;

/// Coordinates beyond this are taken for a mistake, in metres.
const MOST_M: f64 = 10.0;

/// The least share of its columns that an item fills.
const LEAST_FILLED_SHARE: f64 = 0.01;

/// The most solids that are kept.
const MOST_KEPT: usize = 256;

/// Solids of what was seen of items, made once per shape.
#[derive(Debug, Default)]
pub struct SeenSolids(HashMap<ShapeId, Option<Arc<Model>>>);

impl SeenSolids {
    /// The [`solid`] of an item on the grid that it was made for; `None` where it has none.
    pub fn of(&mut self, item: &Item, resolution: &Resolution) -> Option<Arc<Model>> {
        if let Some(known) = self.0.get(&item.shape()) {
            return known.clone();
        }
        if self.0.len() >= MOST_KEPT {
            self.0.clear();
        }
        let made = solid(item, resolution).map(Arc::new);
        self.0.insert(item.shape(), made.clone());
        made
    }
}

/// The solid of an item's heightmaps at the first yaw of a resolution, in the frame that
/// [`Item::container_from_item`] poses: full from the lower to the upper surface of each cell.
///
/// It has the mass of the item's mesh at [`DEFAULT_DENSITY_KG_M3`], or of all columns where the
/// mesh's volume is not known, and no resting poses. `None` where it is too thin for a solid or too
/// far from its own frame. Deterministic.
pub fn solid(item: &Item, resolution: &Resolution) -> Option<Model> {
    let view = item.views().first()?;
    let yaw_rad = *resolution.yaws().radians().first()?;
    let item_from_corner = item_from_corner(view, yaw_rad);
    let columns = columns(view, resolution);
    let mesh = mesh(&columns).transformed(&item_from_corner);
    let is_near = |vertex: &Point3<f64>| vertex.iter().all(|value| value.abs() <= MOST_M);
    if !mesh.vertices.iter().all(is_near) {
        return None;
    }
    let hulls = hulls(columns).into_iter();
    let pieces: Vec<_> = hulls
        .map(|hull| piece(hull.transformed(&item_from_corner)))
        .collect();
    if pieces.is_empty() {
        return None;
    }
    let columns_m3 = mesh.signed_volume_m3();
    let volume_m3 = match item.mesh_volume_m3() {
        known_m3 if known_m3 > 0.0 => known_m3.clamp(LEAST_FILLED_SHARE * columns_m3, columns_m3),
        _ => columns_m3,
    };
    let density_kg_m3 = DEFAULT_DENSITY_KG_M3 * volume_m3 / columns_m3;
    let mass = mass_properties(&mesh, density_kg_m3);
    Some(Model {
        name: item.name().to_string(),
        volume_m3,
        pieces,
        mass: balanced(mass, view, resolution, &item_from_corner),
        mesh,
        carries_kg: None,
        resting_poses: Vec::new(),
    })
}

/// The frame of the footprint's corner at the lowest point, as the item has it at a yaw, in its
/// own.
fn item_from_corner(view: &ItemView, yaw_rad: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -yaw_rad);
    let corner_m = turn * -view.origin_from_corner_m();
    Isometry3::from_parts(Translation3::from(corner_m), turn)
}

/// The mass properties with the item's own centre of mass over the footprint, where that is above
/// it.
fn balanced(
    mut mass: MassProperties,
    view: &ItemView,
    resolution: &Resolution,
    item_from_corner: &Isometry3<f64>,
) -> MassProperties {
    let cell_m = resolution.cell_m();
    let centre = view.centre_of_mass_m(cell_m);
    let is_within = |at_m: f64, cells: usize| (0.0..=cells as f64 * cell_m).contains(&at_m);
    if is_within(centre.x, view.nx()) && is_within(centre.y, view.ny()) {
        let centre = item_from_corner * Point3::new(centre.x, centre.y, 0.0);
        mass.centre_of_mass_m.x = centre.x;
        mass.centre_of_mass_m.y = centre.y;
    }
    mass
}

/// A cell with material, or a block of cells of which some have.
#[derive(Debug, Clone, Copy)]
struct Column {
    /// Its place among the columns.
    x: usize,
    y: usize,
    /// In metres from the footprint's corner at the lowest point.
    bounds: Bounds,
}

/// The columns of a view, by x, then y.
fn columns(view: &ItemView, resolution: &Resolution) -> Vec<Column> {
    let cells = view.nx().max(view.ny()).div_ceil(MOST_COLUMNS).max(1);
    let mut spans: BTreeMap<(usize, usize), (Units, Units)> = BTreeMap::new();
    for (x, y, bottom, top) in view.cells() {
        let span = spans.entry((x / cells, y / cells)).or_insert((bottom, top));
        *span = (span.0.min(bottom), span.1.max(top));
    }
    let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
    let corner = |x: usize, y: usize, height: Units| {
        let x_m = (x * cells).min(view.nx()) as f64 * cell_m;
        let y_m = (y * cells).min(view.ny()) as f64 * cell_m;
        Point3::new(x_m, y_m, f64::from(height) * unit_m)
    };
    let columns = spans.into_iter().map(|((x, y), (bottom, top))| {
        let bounds = Bounds {
            lowest: corner(x, y, bottom),
            highest: corner(x + 1, y + 1, top),
        };
        Column { x, y, bounds }
    });
    columns.collect()
}

fn volume_m3(columns: &[Column]) -> f64 {
    let volumes_m3 = columns
        .iter()
        .map(|column| column.bounds.extents_m().product());
    volumes_m3.sum()
}

/// The surface of the columns: a box for each run of equal ones along y.
fn mesh(columns: &[Column]) -> Mesh {
    let span = |Column { x, bounds, .. }: &Column| (*x, bounds.lowest.z, bounds.highest.z);
    let is_run = |one: &Column, next: &Column| one.y + 1 == next.y && span(one) == span(next);
    let mut mesh = Mesh::default();
    for run in columns.chunk_by(is_run) {
        if let (Some(first), Some(last)) = (run.first(), run.last()) {
            let run = Bounds {
                lowest: first.bounds.lowest,
                highest: last.bounds.highest,
            };
            mesh.append(&run.mesh());
        }
    }
    mesh
}

/// The hulls of at most [`MAX_PIECES`] parts of the columns, cut where they hold most air; none
/// where the columns have no volume.
fn hulls(columns: Vec<Column>) -> Vec<Mesh> {
    let Some(whole) = Part::new(columns) else {
        return Vec::new();
    };
    let spared_m3 = AIR_SHARE * whole.hull.signed_volume_m3();
    let mut parts = vec![whole];
    while parts.len() < MAX_PIECES {
        parts.sort_by(|a, b| a.air_m3.total_cmp(&b.air_m3));
        let airy = parts.last().filter(|part| part.air_m3 > spared_m3);
        let Some(halves) = airy.and_then(Part::halves) else {
            break;
        };
        parts.pop();
        parts.extend(halves);
    }
    parts.into_iter().map(|part| part.hull).collect()
}

/// Columns that become a convex piece.
struct Part {
    columns: Vec<Column>,
    hull: Mesh,
    /// Space that the hull holds beside the columns, in cubic metres.
    air_m3: f64,
}

impl Part {
    fn new(columns: Vec<Column>) -> Option<Self> {
        let hull = hull(&outline(&columns))?;
        let air_m3 = hull.signed_volume_m3() - volume_m3(&columns);
        Some(Self {
            columns,
            hull,
            air_m3,
        })
    }

    /// Gives what the best cut along a side leaves, where it can be cut.
    fn halves(&self) -> Option<[Self; 2]> {
        let axes: [Axis; 2] = [|column: &Column| column.x, |column: &Column| column.y];
        let cuts = axes
            .into_iter()
            .filter_map(|axis| Some((axis, best_cut(&self.columns, axis)?)));
        let (axis, cut) = cuts.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
        let columns = self.columns.iter().copied();
        let (before, behind): (Vec<Column>, Vec<Column>) =
            columns.partition(|column| axis(column) < cut.first_behind);
        Some([Self::new(before)?, Self::new(behind)?])
    }
}

/// A column's place along x or y.
type Axis = fn(&Column) -> usize;

/// The columns of one place along an axis.
struct Layer {
    place: usize,
    bounds: Bounds,
    columns_m3: f64,
}

/// A cut between layers.
struct Cut {
    /// The place of the first columns behind it.
    first_behind: usize,
    /// Space that the boxes around the columns before and behind it hold beside them.
    cost: f64,
}

/// The cut of least cost; `None` where all columns have one place.
fn best_cut(columns: &[Column], axis: Axis) -> Option<Cut> {
    let mut layers: BTreeMap<usize, Layer> = BTreeMap::new();
    for column in columns {
        let place = axis(column);
        let layer = layers.entry(place).or_insert(Layer {
            place,
            bounds: column.bounds,
            columns_m3: 0.0,
        });
        layer.bounds = around(&layer.bounds, &column.bounds);
        layer.columns_m3 += column.bounds.extents_m().product();
    }
    let layers: Vec<Layer> = layers.into_values().collect();
    let cuts = (1..layers.len()).filter_map(|middle| {
        let (before, behind) = layers.split_at(middle);
        Some(Cut {
            first_behind: behind.first()?.place,
            cost: cost(before) + cost(behind),
        })
    });
    cuts.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The air in the box around layers, to the power of 3/4. Of cuts that leave as much air in all,
/// the best so leaves it on one side: the wall of a bowl is cut off whole.
fn cost(layers: &[Layer]) -> f64 {
    let bounds = layers.iter().map(|layer| layer.bounds);
    let whole = bounds.reduce(|one, other| around(&one, &other));
    let box_m3 = whole.map_or(0.0, |whole| whole.extents_m().product());
    let columns_m3: f64 = layers.iter().map(|layer| layer.columns_m3).sum();
    // Square roots are the same everywhere, powers need not be.
    let root = (box_m3 - columns_m3).max(0.0).sqrt();
    root * root.sqrt()
}

fn around(one: &Bounds, other: &Bounds) -> Bounds {
    Bounds {
        lowest: one.lowest.inf(&other.lowest),
        highest: one.highest.sup(&other.highest),
    }
}

/// Points of the columns among which all corners of their hull are: of each row along y those on
/// its outline.
fn outline(columns: &[Column]) -> Vec<Point3<f64>> {
    let mut points = Vec::new();
    for row in columns.chunk_by(|one, next| one.x == next.x) {
        let Some(Column { bounds, .. }) = row.first() else {
            continue;
        };
        let sides_m = [bounds.lowest.x, bounds.highest.x];
        let upper = upper_hull(ends(row, |bounds| bounds.highest.z));
        let lower = upper_hull(ends(row, |bounds| -bounds.lowest.z));
        let lower = lower.into_iter().map(|at| Vector2::new(at.x, -at.y));
        for at in upper.into_iter().chain(lower) {
            points.extend(sides_m.map(|x_m| Point3::new(x_m, at.x, at.y)));
        }
    }
    points
}

/// Ends of a row's columns along y, each with a height of the column.
fn ends(row: &[Column], height_m: fn(&Bounds) -> f64) -> impl Iterator<Item = Vector2<f64>> {
    row.iter().flat_map(move |Column { bounds, .. }| {
        let ends_m = [bounds.lowest.y, bounds.highest.y];
        ends_m.map(|y_m| Vector2::new(y_m, height_m(bounds)))
    })
}

/// Keeps, of points by ascending x, those on the upper side of their hull.
fn upper_hull(points: impl Iterator<Item = Vector2<f64>>) -> Vec<Vector2<f64>> {
    let mut hull: Vec<Vector2<f64>> = Vec::new();
    for point in points {
        while let [.., before, last] = hull.as_slice()
            && (last - before).perp(&(point - before)) >= 0.0
        {
            hull.pop();
        }
        hull.push(point);
    }
    hull
}

#[cfg(test)]
mod tests;
