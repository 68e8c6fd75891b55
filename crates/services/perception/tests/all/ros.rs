//! Clouds of ROS 2 in, heightmaps out, over a real session.
use std::time::Duration;

use crate::payload;
use crate::rig::{PATIENCE, Rig, until};
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_perception_service::{Fate, RosCamera, Settings};
use ppnpack_service::configuration::ServiceSettings;
use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::ros::{PointCloud2, PointField, Stamp, datatype};
use ppnpack_wire::v1;
use zenoh::Wait;
use zenoh::qos::CongestionControl;

/// Where `rmw_zenoh` publishes the clouds of the first camera.
const RMW_KEY: &str = "0/camera/depth/points/sensor_msgs::msg::dds_::PointCloud2_/\
                       RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5";

/// Where the bridge of ROS 2 over DDS publishes those of the second.
const BRIDGE_KEY: &str = "second/depth/points";

/// The camera's height above the floor. It looks straight down, so that its y and z point the other
/// way.
const ABOVE_M: f32 = 0.5;
const ACROSS_M: f32 = 0.32;

fn camera(key: &str, cell: &str) -> RosCamera {
    RosCamera {
        key: key.to_owned(),
        sensor: String::new(),
        is_tray: false,
        cell: cell.to_owned(),
        container_from_sensor: Extrinsics {
            position_m: [0.0, ACROSS_M.into(), ABOVE_M.into()],
            orientation_xyzw: [1.0, 0.0, 0.0, 0.0],
        },
        unit: LengthUnit::Metres,
    }
}

fn settings() -> Settings {
    Settings {
        ros: vec![
            camera("0/camera/depth/points/**", "cell-1"),
            RosCamera {
                unit: LengthUnit::Millimetres,
                ..camera(BRIDGE_KEY, "cell-2")
            },
        ],
        grid: GridSettings::from(&Grid::reference()),
        ..Settings::default()
    }
}

/// How a driver lays its clouds out.
#[derive(Clone, Copy)]
struct Layout {
    is_big_endian: bool,
    is_bigendian: bool,
    point_step: usize,
    padding: usize,
    /// Holes are zeros then.
    is_in_millimetres: bool,
}

const PLAIN: Layout = Layout {
    is_big_endian: false,
    is_bigendian: false,
    point_step: 12,
    padding: 0,
    is_in_millimetres: false,
};

/// The payload of an organised cloud with a point in every sample of the reference grid's surface,
/// or a hole where `height_m` gives nothing; captured in this second.
fn payload(layout: Layout, sec: i32, height_m: impl Fn(usize, usize) -> Option<f32>) -> Vec<u8> {
    let empty = Surface::empty(&Grid::reference());
    let middle_m = |index: usize| ((index as f64 + 0.5) * empty.pitch_m()) as f32;
    let mut data = Vec::new();
    for x in 0..empty.nx() {
        for y in 0..empty.ny() {
            let seen = |height_m| [middle_m(x), ACROSS_M - middle_m(y), ABOVE_M - height_m];
            let (hole, scale) = match layout.is_in_millimetres {
                true => (0.0, 1000.0),
                false => (f32::NAN, 1.0),
            };
            let point = height_m(x, y).map_or([hole; 3], seen);
            let point = point.map(|side_m| side_m * scale);
            let begin = data.len();
            for coordinate in point {
                data.extend(match layout.is_bigendian {
                    true => coordinate.to_be_bytes(),
                    false => coordinate.to_le_bytes(),
                });
            }
            data.resize(begin + layout.point_step, 0xa5);
        }
        data.resize(data.len() + layout.padding, 0x5a);
    }
    let field = |name, offset| PointField {
        name,
        offset,
        datatype: datatype::FLOAT32,
        count: 1,
    };
    let number = |number: usize| u32::try_from(number).unwrap();
    let message = PointCloud2 {
        stamp: Stamp { sec, nanosec: 5 },
        frame_id: "camera_depth_optical_frame",
        height: number(empty.nx()),
        width: number(empty.ny()),
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        is_bigendian: layout.is_bigendian,
        point_step: number(layout.point_step),
        row_step: number(empty.ny() * layout.point_step + layout.padding),
        data: &data,
        is_dense: false,
    };
    payload::payload(&message, layout.is_big_endian)
}

fn flat(sec: i32) -> Vec<u8> {
    payload(PLAIN, sec, |_, _| Some(0.0))
}

/// A perception service with the two cameras. What is published arrives.
fn rig() -> Rig {
    settings().validate().unwrap();
    let rig = Rig::with(&settings(), Stream::Cloud, |_| None);
    for (key, cell) in [(RMW_KEY, "cell-1"), (BRIDGE_KEY, "cell-2")] {
        let cell = Cell::new(cell).unwrap();
        until(&format!("no cloud arrives on {key}"), || {
            rig.publish(key, flat(1));
            rig.ask_for(&cell, 0, Duration::from_millis(200)).ok()
        });
    }
    rig
}

impl Rig {
    /// Publishes as drivers do, and waits where the network is busy.
    fn publish(&self, key: &str, payload: Vec<u8>) {
        let put = self.sensor.session().put(key, payload);
        let put = put.congestion_control(CongestionControl::Block);
        put.wait().unwrap();
    }

    /// The heightmap of the cloud that was captured in this second.
    fn heightmap(&self, cell: &str, sec: i32) -> v1::Heightmap {
        let cell = Cell::new(cell).unwrap();
        let captured_at_ns = i64::from(sec) * 1_000_000_000 + 5;
        until(&format!("no heightmap of second {sec}"), || {
            let heightmap = self.ask_for(&cell, 0, PATIENCE).ok();
            heightmap.filter(|heightmap| heightmap.captured_at_ns == captured_at_ns)
        })
    }

    /// Publishes what is refused, and waits until it was.
    fn publish_refused(&self, key: &str, payload: Vec<u8>) {
        self.meets(Fate::Malformed, || self.publish(key, payload));
    }
}

/// Whole in binary digits, so that the camera's z gives it without rounding; nothing is seen of the
/// cell (10, 20).
fn height_m(x: usize, y: usize) -> Option<f32> {
    let is_dark = (40..44).contains(&x) && (80..84).contains(&y);
    (!is_dark).then(|| ((x * 7 + y * 3) % 200) as f32 / 1024.0)
}

fn expected() -> Scene {
    let grid = Grid::reference();
    let mut surface = Surface::empty(&grid);
    for (x, y) in (0..surface.nx()).flat_map(|x| (0..128).map(move |y| (x, y))) {
        surface.raise(x, y, height_m(x, y).unwrap_or(0.0));
    }
    Scene::from_surface(&grid, surface).unwrap()
}

#[test]
fn clouds_of_every_layout_become_the_heightmap_that_their_surface_gives() {
    let rig = rig();
    let of_points = [
        (false, 12, 0),
        (false, 32, 24),
        (true, 16, 0),
        (true, 21, 7),
    ];
    let layouts = [false, true].into_iter().flat_map(|is_big_endian| {
        of_points.map(|(is_bigendian, point_step, padding)| Layout {
            is_big_endian,
            is_bigendian,
            point_step,
            padding,
            is_in_millimetres: false,
        })
    });
    for (sec, layout) in (2..).zip(layouts) {
        for (key, cell) in [(RMW_KEY, "cell-1"), (BRIDGE_KEY, "cell-2")] {
            let layout = Layout {
                is_in_millimetres: cell == "cell-2",
                ..layout
            };
            rig.publish(key, payload(layout, sec, height_m));
            let heightmap = rig.heightmap(cell, sec);
            let (grid, found) = scene::read(heightmap.scene.as_ref().unwrap()).unwrap();
            assert_eq!(grid, Grid::reference());
            let expected = expected();
            let heights = |scene: &Scene| scene.heightmap().heights().to_vec();
            let pairs = heights(&found).into_iter().zip(heights(&expected));
            let others = pairs.enumerate().filter(|(cell, _)| *cell != 10 * 32 + 20);
            for (cell, (found, expected)) in others {
                assert_eq!(found, expected, "cell {cell}");
            }
            // As high as the lines of sight around leave open.
            let hidden = found.heightmap().get(10, 20).unwrap();
            assert!((70..grid.rim()).contains(&hidden), "{hidden}");
            assert_eq!(heightmap.state_number, 0);
            let quality = heightmap.quality.unwrap();
            let counts = (quality.points_inside, quality.unknown_cells);
            assert_eq!(counts, (128 * 128 - 16, 0));
        }
    }
    assert_eq!(rig.perception.clouds(Fate::Malformed), 0);
    assert_eq!(rig.perception.clouds(Fate::Late), 0);
}

#[test]
fn malformed_clouds_and_other_types_are_refused_and_counted() {
    let rig = rig();
    let half = flat(2).len() / 2;
    for payload in [b"hello".to_vec(), flat(2)[..half].to_vec()] {
        rig.publish_refused(RMW_KEY, payload.clone());
        rig.publish_refused(BRIDGE_KEY, payload);
    }
    // Another type under the same topic, though the payload would do.
    let image = RMW_KEY.replace("PointCloud2_", "Image_");
    rig.publish_refused(&image, flat(2));

    assert_eq!(rig.heightmap("cell-1", 1).captured_at_ns, 1_000_000_005);
    rig.publish(RMW_KEY, flat(3));
    rig.heightmap("cell-1", 3);
}
