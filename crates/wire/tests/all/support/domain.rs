//! Random values of the domain.

use nalgebra::{Isometry3, Point2, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::checks::motion::{Cycle, JointPoint, Leg, LegKind};
use ppnpack_packing::kernel::grid::{
    ABSENT, ContainerSize, Grid, MAX_UNITS, Resolution, Units, Yaws,
};
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
use ppnpack_packing::kernel::item::{Item, Underside, ViewSurfaces};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::scene::Scene;
use proptest::prelude::*;

/// Lengths with all bits of their mantissa in use.
fn lengths_m() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.01), Just(0.0025), 0.001_f64..0.05]
}

pub(crate) fn grids() -> impl Strategy<Value = Grid> {
    let yaws = proptest::collection::vec(-10.0_f64..10.0, 1..9);
    let sides = (1.0_f64..12.0, 1.0_f64..12.0, 1.0_f64..300.0);
    let shapes = prop_oneof![Just((0.0, 0.0)), (0.0..0.4_f64, 0.0..0.9_f64)];
    let numbers = (lengths_m(), lengths_m(), yaws, sides, shapes);
    numbers.prop_map(|(cell_m, unit_m, yaws, (x, y, z), (setback, radius))| {
        let yaws = Yaws::from_radians(yaws).unwrap();
        let resolution = Resolution::new(cell_m, unit_m, yaws).unwrap();
        let size = ContainerSize::cuboid(x * cell_m, y * cell_m, z * unit_m);
        let side_m = size.x_m.min(size.y_m);
        let draft_rad = (setback * side_m / size.z_m).atan().min(0.7);
        let leaning = ContainerSize { draft_rad, ..size };
        let container = ContainerSize {
            corner_radius_m: radius * (0.5 * side_m - leaning.setback_m(0.0)),
            ..leaning
        };
        Grid::new(container, resolution).unwrap()
    })
}

/// Scenes whose heightmap and surface have nothing to do with each other.
pub(crate) fn scenes() -> impl Strategy<Value = (Grid, Scene)> {
    grids().prop_flat_map(|grid| {
        let (nx, ny) = (grid.nx(), grid.ny());
        let heights = proptest::collection::vec(0..=MAX_UNITS, nx * ny);
        let empty = Surface::empty(&grid);
        let (sx, sy, pitch_m) = (empty.nx(), empty.ny(), empty.pitch_m());
        let heights_m = proptest::collection::vec(any_height_m(), sx * sy);
        let seen = proptest::collection::vec(any::<bool>(), sx * sy);
        let surface = (heights_m, seen).prop_map(move |(heights_m, seen)| {
            let held = heights_m.iter().zip(&seen);
            let held = held.map(|(height_m, seen)| if *seen { *height_m } else { 0.0 });
            let held = held.collect();
            let surface = Surface::from_metres(sx, sy, pitch_m, heights_m).unwrap();
            surface.with_support(held).unwrap()
        });
        let surface = proptest::option::of(surface);
        (Just(grid), heights, surface).prop_map(|(grid, heights, surface)| {
            let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights).unwrap();
            let scene = Scene::new(&grid, heightmap, surface).unwrap();
            (grid, scene)
        })
    })
}

fn any_height_m() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0),
        Just(f32::MAX),
        Just(f32::MIN_POSITIVE),
        0.0_f32..1.0
    ]
}

fn vectors() -> impl Strategy<Value = Vector3<f64>> {
    (-2.0_f64..2.0, -2.0_f64..2.0, -2.0_f64..2.0).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

fn views() -> impl Strategy<Value = ViewSurfaces> {
    let cell = (0_i16..6, 1_i16..20, 0_u8..5);
    let sizes = (1_usize..7, 1_usize..7, 1_usize..4);
    sizes.prop_flat_map(move |(nx, ny, samples)| {
        let cells = proptest::collection::vec(cell.clone(), nx * ny);
        let below = prop_oneof![Just(f32::INFINITY), -0.001_f32..0.5];
        let below = proptest::collection::vec(below, nx * ny * samples * samples);
        let underside = below.prop_map(move |heights_m| Underside {
            nx: nx * samples,
            ny: ny * samples,
            samples_per_cell: samples,
            heights_m,
        });
        let underside = proptest::option::of(underside);
        let centre = proptest::option::of((0.0_f64..0.1, 0.0_f64..0.1));
        (cells, underside, vectors(), centre).prop_map(move |(cells, underside, origin, centre)| {
            let (top, bottom) = surfaces(&cells);
            ViewSurfaces {
                nx,
                ny,
                top,
                bottom,
                underside,
                origin_from_corner_m: origin,
                centre_of_mass_m: centre.map(|(x, y)| Point2::new(x, y)),
            }
        })
    })
}

/// Upper and lower surfaces with holes, the first cell at the bottom.
fn surfaces(cells: &[(i16, i16, u8)]) -> (Vec<Units>, Vec<Units>) {
    let cell = |(index, (low, thickness, kind)): (usize, &(i16, i16, u8))| match (index, kind) {
        (0, _) => (*thickness, 0),
        (_, 0) => (0, ABSENT),
        _ => (low + thickness, *low),
    };
    cells.iter().enumerate().map(cell).unzip()
}

pub(crate) fn items() -> impl Strategy<Value = Item> {
    let views = proptest::collection::vec(views(), 1..5);
    (".{1,60}", views, 0.0_f64..0.01)
        .prop_map(|(name, views, volume_m3)| Item::new(&name, views, volume_m3).unwrap())
}

pub(crate) fn placements() -> impl Strategy<Value = Placement> {
    (0_usize..360, 0_usize..2048, 0_usize..2048).prop_map(|(yaw, x, y)| Placement { yaw, x, y })
}

pub(crate) fn resting_placements() -> impl Strategy<Value = RestingPlacement> {
    (placements(), 0..=MAX_UNITS).prop_map(|(placement, resting_height)| RestingPlacement {
        placement,
        resting_height,
    })
}

pub(crate) fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    let rotation = (-1.0_f64..1.0, -1.0_f64..1.0, -1.0_f64..1.0, 0.1_f64..1.0);
    (vectors(), rotation).prop_map(|(position, (x, y, z, w))| {
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(position), rotation)
    })
}

pub(crate) fn points() -> impl Strategy<Value = Vec<Point3<f32>>> {
    let coordinate = || prop_oneof![Just(f32::NAN), any::<f32>(), -1.0_f32..1.0];
    let point = (coordinate(), coordinate(), coordinate());
    proptest::collection::vec(point.prop_map(|(x, y, z)| Point3::new(x, y, z)), 0..40)
}

/// A cycle of two legs.
pub(crate) fn cycle() -> Cycle {
    let leg = |kind, times_s: &[f64]| Leg {
        kind,
        points: times_s
            .iter()
            .map(|time_s| JointPoint {
                time_s: *time_s,
                position_rad: [0.1, -0.2, *time_s, 3.0, -6.0, 12.5],
            })
            .collect(),
    };
    Cycle {
        arm: "an arm".to_owned(),
        cycle_s: 2.5,
        container_from_item_at_pick: Isometry3::translation(0.1, -0.35, 0.02),
        grasp_yaw_rad: 0.75,
        grip_s: 0.2,
        release_s: 0.15,
        legs: vec![
            leg(LegKind::Descend, &[0.0, 0.01, 0.02]),
            leg(LegKind::Lift, &[0.0]),
        ],
    }
}
