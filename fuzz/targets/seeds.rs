//! Writes valid inputs for the targets to start from into the folder in `PPNPACK_FUZZ_SEEDS`; it
//! fuzzes nothing, but is built as the targets are.
#![no_main]

#[path = "../../crates/wire/tests/support/payload.rs"]
mod payload;

use std::fs;
use std::path::{Path, PathBuf};

use libfuzzer_sys::fuzz_target;
use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::kernel::item::{Item, Underside, ViewSurfaces};
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::convert::{grid, item, pose, scene};
use ppnpack_wire::ros::{PointCloud2, PointField, Stamp, datatype};
use ppnpack_wire::v1;
use prost::Message;

/// The number of kinds of message of the target `requests`; `domain` has fewer.
const KINDS: u8 = 24;

fuzz_target!(init: write_all(), |_data: &[u8]| {});

fn write_all() {
    let folder = PathBuf::from(std::env::var_os("PPNPACK_FUZZ_SEEDS").expect("a folder is named"));
    let write = |target: &str, name: &str, bytes: &[u8]| {
        let folder = folder.join(target);
        fs::create_dir_all(&folder).expect("the folder can be made");
        fs::write(folder.join(name), bytes).expect("the folder can be written to");
    };
    for (name, bytes) in golden() {
        for kind in 0..KINDS {
            let kinded: Vec<u8> = std::iter::once(kind).chain(bytes.iter().copied()).collect();
            write("requests", &format!("{name}-{kind}"), &kinded);
            write("domain", &format!("{name}-{kind}"), &kinded);
        }
    }
    let grid = small_grid();
    let scene = scene(&grid);
    let things = [item(&grid, false), item(&grid, true)];
    let pose = pose::write(&Isometry3::identity());
    let domain: [(u8, &str, Vec<u8>); 4] = [
        (0, "grid", grid::write(&grid).encode_to_vec()),
        (1, "scene", scene::write(&grid, &scene).encode_to_vec()),
        (2, "item", item::write(&things[0]).encode_to_vec()),
        (5, "pose", pose.encode_to_vec()),
    ];
    for (kind, name, bytes) in domain {
        let kinded: Vec<u8> = std::iter::once(kind).chain(bytes).collect();
        write("domain", name, &kinded);
    }
    for heuristic in [
        v1::Heuristic::Sdfm,
        v1::Heuristic::Dbl,
        v1::Heuristic::Hm,
        v1::Heuristic::Mta,
    ] {
        for check in [v1::Check::PhysicalStability, v1::Check::PublishedStability] {
            let request = v1::EvaluateRequest {
                scene: Some(scene::write(&grid, &scene)),
                items: things.iter().map(item::write).collect(),
                objective: Some(v1::Objective {
                    heuristic: heuristic.into(),
                    ..objective()
                }),
                checks: vec![check.into()],
                limit: 4,
                ..v1::EvaluateRequest::default()
            };
            let name = format!("{heuristic:?}-{check:?}");
            write("search", &name, &request.encode_to_vec());
        }
    }
    write("clouds", "plane", &plane().encode_to_vec());
    for (name, bytes) in point_files() {
        write("files", name, &bytes);
    }
    for is_big_endian in [false, true] {
        for is_bigendian in [false, true] {
            let name = format!("{is_big_endian}-{is_bigendian}");
            write("ros", &name, &of_ros(is_big_endian, is_bigendian));
        }
    }
    for key in [
        "ppnpack/v1/cell-1/heightmap",
        "ppnpack/v1/cell-1/rpc/planner/plan",
        "ppnpack/v1/cell-1/rpc/heuristic/evaluate/heuristic-1",
        "ppnpack/v1/_all/alive/planner/planner-1",
    ] {
        write("keys", &key.replace('/', "-"), key.as_bytes());
    }
}

/// The golden encodings: a message's name and number, and its bytes.
fn golden() -> Vec<(String, Vec<u8>)> {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/wire/tests/golden/encodings.txt");
    let text = fs::read_to_string(file).expect("the golden encodings are there");
    let line = |line: &str| {
        let mut words = line.split(' ');
        let name = format!("{}-{}", words.next()?, words.next()?);
        let hex = words.next()?.as_bytes();
        let digits = hex.chunks(2).map(|pair| std::str::from_utf8(pair).ok());
        let bytes = digits.map(|pair| u8::from_str_radix(pair?, 16).ok());
        Some((name, bytes.collect::<Option<Vec<u8>>>()?))
    };
    text.lines().filter_map(line).collect()
}

fn small_grid() -> Grid {
    let yaws = Yaws::half_turn(2).expect("a number of yaws");
    let resolution = Resolution::new(0.01, 0.002, yaws).expect("a resolution");
    let size = ContainerSize::cuboid(0.08, 0.06, 0.1);
    Grid::new(size, resolution).expect("a grid")
}

fn scene(grid: &Grid) -> Scene {
    Scene::from_surface(grid, Surface::empty(grid)).expect("a surface of the grid")
}

fn item(grid: &Grid, has_surfaces: bool) -> Item {
    let samples = grid.resolution().samples_per_cell();
    let view = || ViewSurfaces {
        nx: 2,
        ny: 3,
        top: vec![10; 6],
        bottom: vec![0; 6],
        underside: has_surfaces.then(|| Underside {
            nx: 2 * samples,
            ny: 3 * samples,
            samples_per_cell: samples,
            heights_m: vec![0.0; 6 * samples * samples],
        }),
        origin_from_corner_m: Vector3::new(0.01, 0.015, 0.0),
        centre_of_mass_m: has_surfaces.then(|| Point2::new(0.01, 0.015)),
    };
    Item::new("box", vec![view(), view()], 1e-5).expect("an item")
}

fn objective() -> v1::Objective {
    let settings = ppnpack_packing::ranking::search::SearchSettings::default();
    ppnpack_wire::convert::objective::write(&settings)
}

fn plane() -> v1::PointCloud {
    let points: Vec<Point3<f32>> = (0..100)
        .map(|index| Point3::new(0.03 * (index % 10) as f32, 0.03 * (index / 10) as f32, 0.5))
        .collect();
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let capture = Capture {
        sequence: 1,
        captured_at_ns: 1,
        state_number: 1,
        container_from_sensor: Isometry3::from_parts(Translation3::new(0.0, 0.3, 0.6), down),
    };
    cloud::write(&capture, &points)
}

/// Two points in each form that files have.
fn point_files() -> Vec<(&'static str, Vec<u8>)> {
    let pcd = "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 8 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n\
               POINTS 2\nDATA ";
    let ply = "element vertex 2\nproperty float x\nproperty float y\nproperty double z\nproperty list uchar int seen\n\
               element face 0\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = |format: &str| format!("ply\nformat {format} 1.0\n{ply}");
    // A zero and a copy of it 39 times over: 20 bytes a point.
    let packed = [5, 0, 0, 0, 40, 0, 0, 0, 0, 0, 7 << 5, 30, 0];
    let zeros = [0; 42];
    vec![
        (
            "pcd-ascii",
            format!("{pcd}ascii\n0.1 0.2 0.3 7\nnan -nan 1e-3 7\n").into_bytes(),
        ),
        (
            "pcd-binary",
            [format!("{pcd}binary\n").as_bytes(), &zeros].concat(),
        ),
        (
            "pcd-compressed",
            [format!("{pcd}binary_compressed\n").as_bytes(), &packed].concat(),
        ),
        (
            "ply-ascii",
            (ply("ascii") + "0.1 0.2 0.3 1 7\nnan 0 1e-3 0\n").into_bytes(),
        ),
        (
            "ply-little",
            [ply("binary_little_endian").as_bytes(), &zeros].concat(),
        ),
        (
            "ply-big",
            [ply("binary_big_endian").as_bytes(), &zeros].concat(),
        ),
    ]
}

/// Two padded rows of three points, with a number of each size.
fn of_ros(is_big_endian: bool, is_bigendian: bool) -> Vec<u8> {
    let field = |name, offset, datatype, count| PointField {
        name,
        offset,
        datatype,
        count,
    };
    let message = PointCloud2 {
        stamp: Stamp { sec: 1, nanosec: 2 },
        frame_id: "camera",
        height: 2,
        width: 3,
        fields: vec![
            field("x", 0, datatype::FLOAT32, 1),
            field("y", 4, datatype::FLOAT32, 1),
            field("z", 8, datatype::FLOAT64, 1),
            field("rgb", 16, datatype::UINT32, 1),
            field("r", 16, datatype::UINT8, 1),
            field("ring", 20, datatype::UINT16, 1),
            field("normal", 22, datatype::INT8, 2),
        ],
        is_bigendian,
        point_step: 24,
        row_step: 80,
        data: &[0x3f; 160],
        is_dense: false,
    };
    payload::payload(&message, is_big_endian)
}
