//! How long a cloud of ROS 2 takes to become one of the workspace, beside a plain copy of its
//! payload.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/support/payload.rs"]
mod payload;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::Isometry3;
use ppnpack_wire::ros::{PointCloud2, PointField, Stamp, datatype, to_cloud};

/// A layout: its name, bytes of a point, padding of a row, fields beside x, y, z and whether it is
/// big-endian.
type Layout = (&'static str, u32, u32, &'static [(u32, u8)], bool);

const LAYOUTS: [Layout; 5] = [
    ("x y z", 16, 0, &[], false),
    ("x y z rgb", 32, 0, &[(16, datatype::FLOAT32)], false),
    ("x y z, rows padded", 16, 64, &[], false),
    ("x y z, big-endian", 16, 0, &[], true),
    (
        "x y z ring time, big-endian",
        22,
        0,
        &[(12, datatype::UINT16), (14, datatype::FLOAT64)],
        true,
    ),
];

fn payload(layout: Layout, points: u32) -> Vec<u8> {
    let (_, point_step, padding, others, is_bigendian) = layout;
    let (width, height) = (1000, points / 1000);
    let row_step = width * point_step + padding;
    let field = |name, offset, datatype| PointField {
        name,
        offset,
        datatype,
        count: 1,
    };
    let axes = [("x", 0), ("y", 4), ("z", 8)];
    let axes = axes.map(|(name, offset)| field(name, offset, datatype::FLOAT32));
    let others = others
        .iter()
        .map(|(offset, kind)| field("other", *offset, *kind));
    let data: Vec<u8> = (0..row_step * height).map(|byte| byte as u8).collect();
    let message = PointCloud2 {
        stamp: Stamp::default(),
        frame_id: "camera_depth_optical_frame",
        height,
        width,
        fields: axes.into_iter().chain(others).collect(),
        is_bigendian,
        point_step,
        row_step,
        data: &data,
        is_dense: false,
    };
    payload::payload(&message, false)
}

fn conversion(criterion: &mut Criterion) {
    for points in [300_000, 2_000_000] {
        let mut group = criterion.benchmark_group(format!("{points} points"));
        for layout in LAYOUTS {
            let payload = payload(layout, points);
            group.throughput(Throughput::Bytes(payload.len() as u64));
            group.bench_with_input(
                BenchmarkId::new("read", layout.0),
                &payload,
                |bencher, payload| {
                    bencher.iter(|| {
                        let message = PointCloud2::read(payload).unwrap();
                        to_cloud(&message, 1, &Isometry3::identity()).unwrap()
                    });
                },
            );
            group.bench_with_input(
                BenchmarkId::new("copy", layout.0),
                &payload,
                |bencher, payload| {
                    bencher.iter(|| payload.clone());
                },
            );
        }
    }
}

criterion_group!(benches, conversion);
criterion_main!(benches);
