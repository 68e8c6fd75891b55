//! Simple models and poses for the tests and benches of the simulated cell.
#![allow(dead_code, reason = "each test file uses some of it")]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::object::{ConvexPiece, MassProperties, Model};
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::content::LyingSolid;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::placement::{Placement, RestingPlacement};

const DENSITY_KG_M3: f64 = 500.0;

/// A box around the origin.
pub(crate) fn cuboid(sides_m: [f64; 3]) -> Arc<Model> {
    cuboids("box", &[([0.0; 3], sides_m)])
}

/// Boxes, given by centre and sides, that do not overlap; the item frame's origin is as given.
pub(crate) fn cuboids(name: &str, boxes: &[([f64; 3], [f64; 3])]) -> Arc<Model> {
    let mut mesh = Mesh::default();
    let mut pieces = Vec::new();
    let mut volume_m3 = 0.0;
    let mut moment = Vector3::zeros();
    for (centre, sides) in boxes {
        let (centre, sides) = (Vector3::from(*centre), Vector3::from(*sides));
        let around = Bounds {
            lowest: Point3::from(centre - sides / 2.0),
            highest: Point3::from(centre + sides / 2.0),
        };
        let surface = around.mesh();
        mesh.append(&surface);
        pieces.push(ConvexPiece {
            vertices: surface.vertices,
        });
        let volume = sides.product();
        volume_m3 += volume;
        moment += centre * volume;
    }
    let centre_of_mass = moment / volume_m3;
    let mut inertia_kg_m2 = Matrix3::zeros();
    for (centre, sides) in boxes {
        let (centre, sides) = (Vector3::from(*centre), Vector3::from(*sides));
        let mass_kg = DENSITY_KG_M3 * sides.product();
        let squares = sides.component_mul(&sides);
        let own = Vector3::new(
            squares.y + squares.z,
            squares.x + squares.z,
            squares.x + squares.y,
        );
        let arm = centre - centre_of_mass;
        inertia_kg_m2 += Matrix3::from_diagonal(&(own * mass_kg / 12.0));
        inertia_kg_m2 +=
            mass_kg * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose());
    }
    Arc::new(Model {
        name: name.to_owned(),
        mesh,
        volume_m3,
        pieces,
        mass: MassProperties {
            mass_kg: DENSITY_KG_M3 * volume_m3,
            centre_of_mass_m: Point3::from(centre_of_mass),
            inertia_kg_m2,
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    })
}

/// A ball around the origin: a hull of 12 * 16 + 2 vertices.
pub(crate) fn ball(radius_m: f64) -> Arc<Model> {
    let (rings, around) = (12_u32, 16_u32);
    let mut vertices = vec![Point3::new(0.0, 0.0, -radius_m)];
    for ring in 1..=rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings + 1);
        for step in 0..around {
            let azimuth = std::f64::consts::TAU * f64::from(step) / f64::from(around);
            let (sin, cos) = azimuth.sin_cos();
            let flat = Vector3::new(cos * polar.sin(), sin * polar.sin(), -polar.cos());
            vertices.push(Point3::from(flat * radius_m));
        }
    }
    vertices.push(Point3::new(0.0, 0.0, radius_m));
    let at = |ring: u32, step: u32| 1 + (ring - 1) * around + step % around;
    let top = rings * around + 1;
    let mut triangles = Vec::new();
    for step in 0..around {
        triangles.push([0, at(1, step + 1), at(1, step)]);
        triangles.push([top, at(rings, step), at(rings, step + 1)]);
        for ring in 1..rings {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    let mesh = Mesh {
        vertices: vertices.clone(),
        triangles,
    };
    let volume_m3 = mesh.signed_volume_m3();
    let mass_kg = DENSITY_KG_M3 * volume_m3;
    Arc::new(Model {
        name: "ball".to_owned(),
        mesh,
        volume_m3,
        pieces: vec![ConvexPiece { vertices }],
        mass: MassProperties {
            mass_kg,
            centre_of_mass_m: Point3::origin(),
            inertia_kg_m2: Matrix3::identity() * 0.4 * mass_kg * radius_m * radius_m,
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    })
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

/// What lies in a container: solids and where they are.
pub(crate) type Content = [(Arc<Model>, Isometry3<f64>)];

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
    let view = |nx: usize, ny: usize| ViewSurfaces {
        // Half a cell is 5 mm, half a unit 1 mm.
        origin_from_corner_m: Vector3::new(
            nx as f64 * 0.005,
            ny as f64 * 0.005,
            f64::from(height) * 0.001,
        ),
        ..ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny])
    };
    let views = vec![view(nx, ny), view(ny, nx)];
    let item = Item::new("box", views, model.volume_m3).unwrap();
    Candidate::new(arrival, Arc::new(item)).with_model(model)
}

pub(crate) fn solid_box([nx, ny]: [usize; 2], height: Units) -> Arc<Model> {
    cuboid([
        nx as f64 * 0.01,
        ny as f64 * 0.01,
        f64::from(height) * 0.002,
    ])
}

pub(crate) fn block(arrival: usize, cells: [usize; 2], height: Units) -> Candidate {
    boxed(arrival, solid_box(cells, height), cells, height)
}

pub(crate) fn placed(x: usize, y: usize, resting_height: Units) -> RestingPlacement {
    RestingPlacement {
        placement: Placement { yaw: 0, x, y },
        resting_height,
    }
}

pub(crate) fn lying(content: &Content) -> Vec<LyingSolid> {
    let solids = content
        .iter()
        .map(|(model, pose)| LyingSolid::new(Arc::clone(model), *pose));
    solids.collect()
}

/// A scene of which the check looks at the content alone.
pub(crate) fn scene(grid: &Grid, content: &Content) -> Scene {
    Scene::from_heightmap(Heightmap::empty(grid)).with_content(lying(content).into())
}
