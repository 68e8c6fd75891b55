//! Simple models, poses and steps.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mass::mass_properties;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::{ConvexPiece, Model};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::LyingSolid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::outcome::PlacedReport;
use ppnpack_physics::settings::CellSettings;

const DENSITY_KG_M3: f64 = 500.0;

/// A solid of this surface and these pieces, even throughout.
fn solid(name: &str, mesh: Mesh, pieces: Vec<Vec<Point3<f64>>>) -> Arc<Model> {
    let pieces = pieces.into_iter();
    Arc::new(Model {
        name: name.to_owned(),
        volume_m3: mesh.signed_volume_m3(),
        pieces: pieces.map(|vertices| ConvexPiece { vertices }).collect(),
        mass: mass_properties(&mesh, DENSITY_KG_M3),
        mesh,
        carries_kg: None,
        resting_poses: Vec::new(),
    })
}

/// A box around the origin.
pub(crate) fn cuboid(sides_m: [f64; 3]) -> Arc<Model> {
    cuboids("box", &[([0.0; 3], sides_m)])
}

/// Boxes, given by centre and sides, that do not overlap; the item frame's origin is as given.
pub(crate) fn cuboids(name: &str, boxes: &[([f64; 3], [f64; 3])]) -> Arc<Model> {
    let (mut mesh, mut pieces) = (Mesh::default(), Vec::new());
    for (centre, sides) in boxes {
        let (centre, half) = (Vector3::from(*centre), Vector3::from(*sides) / 2.0);
        let surface = Mesh::cuboid((centre - half).into(), (centre + half).into());
        mesh.append(&surface);
        pieces.push(surface.vertices);
    }
    solid(name, mesh, pieces)
}

/// A ball around the origin: a hull of 12 * 16 + 2 vertices.
pub(crate) fn ball(radius_m: f64) -> Arc<Model> {
    let mesh = crate::shapes::ball(radius_m, 16, 13);
    let vertices = mesh.vertices.clone();
    solid("ball", mesh, vec![vertices])
}

/// An upright pose.
pub(crate) fn at(x_m: f64, y_m: f64, z_m: f64) -> Isometry3<f64> {
    turned(x_m, y_m, z_m, 0.0)
}

/// A pose turned about the vertical.
pub(crate) fn turned(x_m: f64, y_m: f64, z_m: f64, yaw_rad: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(x_m, y_m, z_m),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad),
    )
}

/// A cell of the reference experiment, changed.
pub(crate) fn cell(change: impl FnOnce(&mut CellSettings)) -> SimulatedCell {
    let mut settings = CellSettings::default();
    change(&mut settings);
    SimulatedCell::new(settings).unwrap()
}

/// A cell of the reference experiment.
pub(crate) fn reference() -> SimulatedCell {
    cell(|_| {})
}

/// A cell with a robot that lays items down.
pub(crate) fn robot() -> SimulatedCell {
    SimulatedCell::new(CellSettings::robot()).unwrap()
}

/// Places a model.
pub(crate) fn put(
    cell: &mut SimulatedCell,
    model: &Arc<Model>,
    pose: Isometry3<f64>,
) -> PlacedReport {
    cell.place(model, &pose).unwrap()
}

/// Solids with where they are.
pub(crate) type Content = [(Arc<Model>, Isometry3<f64>)];

/// What lies in a cell.
pub(crate) fn poses(cell: &SimulatedCell) -> Vec<(Arc<Model>, Isometry3<f64>)> {
    let bodies = cell.contents().into_iter();
    let posed = bodies.map(|body| (body.model, body.container_from_item));
    posed.collect()
}

/// Cells of 1 cm, units of 2 mm, two yaws a right angle apart.
pub(crate) fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(2).unwrap());
    Grid::new(ContainerSize::REFERENCE, resolution.unwrap()).unwrap()
}

/// The item that a box of so many cells and units is; the model's frame is in its middle.
pub(crate) fn boxed(
    arrival: usize,
    model: Arc<Model>,
    [nx, ny]: [usize; 2],
    height: Units,
) -> Candidate {
    // Half a cell is 5 mm, half a unit 1 mm.
    let view = |nx: usize, ny: usize| ViewSurfaces {
        origin_from_corner_m: Vector3::from([
            nx as f64 * 0.005,
            ny as f64 * 0.005,
            f64::from(height) * 0.001,
        ]),
        ..ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny])
    };
    let views = vec![view(nx, ny), view(ny, nx)];
    let item = Item::new("box", views, model.volume_m3).unwrap();
    Candidate::new(arrival, Arc::new(item)).with_model(model)
}

pub(crate) fn solid_box([nx, ny]: [usize; 2], height: Units) -> Arc<Model> {
    let [x_m, y_m] = [nx, ny].map(|cells| cells as f64 * 0.01);
    cuboid([x_m, y_m, f64::from(height) * 0.002])
}

pub(crate) fn block(arrival: usize, cells: [usize; 2], height: Units) -> Candidate {
    boxed(arrival, solid_box(cells, height), cells, height)
}

pub(crate) fn placed(x: usize, y: usize, resting_height: Units) -> RestingPlacement {
    let placement = Placement { yaw: 0, x, y };
    RestingPlacement {
        placement,
        resting_height,
    }
}

pub(crate) fn lying(content: &Content) -> Vec<LyingSolid> {
    let solids = content.iter();
    let solids = solids.map(|(model, pose)| LyingSolid::new(Arc::clone(model), *pose));
    solids.collect()
}

/// A step on the [`grid`], with what is held.
pub(crate) struct Step {
    pub(crate) grid: Grid,
    pub(crate) scene: Scene,
    pub(crate) held: Vec<Candidate>,
}

impl Step {
    /// Of the scene, the check looks at the content alone.
    pub(crate) fn new(content: Vec<LyingSolid>, held: impl Into<Vec<Candidate>>) -> Self {
        let step = Self::unknown(held);
        Self {
            scene: step.scene.with_content(content.into()),
            ..step
        }
    }

    /// Nothing is known of what lies there.
    pub(crate) fn unknown(held: impl Into<Vec<Candidate>>) -> Self {
        let grid = grid();
        Self {
            scene: Scene::from_heightmap(Heightmap::empty(&grid)),
            grid,
            held: held.into(),
        }
    }

    pub(crate) fn input(&self) -> StepInput<'_> {
        StepInput::new(&self.grid, &self.scene, &self.held)
    }
}
