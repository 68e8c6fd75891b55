//! Any payload as a cloud of ROS 2: refused, or a cloud of the workspace with as many points.
#![no_main]

#[path = "../../crates/wire/tests/support/payload.rs"]
mod payload;

use libfuzzer_sys::fuzz_target;
use nalgebra::Isometry3;
use ppnpack_wire::convert::cloud;
use ppnpack_wire::ros::{PointCloud2, to_cloud};

fuzz_target!(|data: &[u8]| {
    let Ok(message) = PointCloud2::read(data) else {
        return;
    };
    for is_big_endian in [false, true] {
        let payload = payload::payload(&message, is_big_endian);
        assert_eq!(PointCloud2::read(&payload).as_ref(), Ok(&message));
    }
    let Ok(made) = to_cloud(&message, 1, &Isometry3::identity()) else {
        return;
    };
    let cloud = cloud::read(&made).expect("what is made is possible");
    let points = u64::from(message.width) * u64::from(message.height);
    assert_eq!(cloud.len() as u64, points);
    assert_eq!(cloud.points().count() as u64, points);
});
