//! Clouds and heightmaps as points.

use ppnpack_ros::cdr::Bytes;
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::sensor_msgs::{PointCloud2, PointField};
use ppnpack_ros::messages::std_msgs::Header;
use ppnpack_wire::convert::cloud::Cloud;
use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, NumericType};
use ppnpack_wire::{WireError, ros};

use crate::frames;

/// Bytes of a point with three coordinates.
const POINT_BYTES: u32 = 12;

/// A cloud with all of its fields, in the frame of its sensor.
pub(crate) fn cloud(cell: &Cell, cloud: &Cloud<'_>) -> PointCloud2 {
    let message = cloud.message();
    let fields = message.fields.iter().map(|field| PointField {
        name: field.name.clone(),
        offset: field.offset,
        datatype: datatype(field.r#type()),
        count: 1,
    });
    let width = u32::try_from(cloud.len()).unwrap_or(u32::MAX);
    PointCloud2 {
        header: Header {
            stamp: Time::from_ns(cloud.captured_at_ns()),
            frame_id: frames::sensor(cell, &message.sensor),
        },
        height: 1,
        width,
        fields: fields.collect(),
        is_bigendian: false,
        point_step: message.point_stride,
        row_step: message.point_stride.saturating_mul(width),
        data: Bytes(message.data.clone()),
        // Holes are points that are not finite.
        is_dense: false,
    }
}

/// The middles of the cells of a heightmap at their heights, in the frame of the container. What was not seen has none.
///
/// # Errors
/// [`WireError`] where the heightmap is not possible.
pub(crate) fn heightmap(cell: &Cell, message: &v1::Heightmap) -> Result<PointCloud2, WireError> {
    let (grid, scene) = scene::read_required("heightmap.scene", message.scene.as_ref())?;
    let cell_m = grid.resolution().cell_m();
    let unit_m = grid.resolution().height_unit_m();
    let middle_m = |index: usize| ((index as f64 + 0.5) * cell_m) as f32;
    let mut data = Vec::with_capacity(grid.nx() * grid.ny() * POINT_BYTES as usize);
    for (x, y) in (0..grid.nx()).flat_map(|x| (0..grid.ny()).map(move |y| (x, y))) {
        let height = scene.heightmap().get(x, y);
        let Some(height) = height.filter(|height| *height <= grid.rim()) else {
            continue;
        };
        let height_m = (f64::from(height) * unit_m) as f32;
        for coordinate in [middle_m(x), middle_m(y), height_m] {
            data.extend_from_slice(&coordinate.to_le_bytes());
        }
    }
    let field = |name: &str, offset: u32| PointField {
        name: name.to_owned(),
        offset,
        datatype: PointField::FLOAT32,
        count: 1,
    };
    let row_step = u32::try_from(data.len()).unwrap_or(u32::MAX);
    Ok(PointCloud2 {
        header: Header {
            stamp: Time::from_ns(message.captured_at_ns),
            frame_id: frames::container(cell.as_str()),
        },
        height: 1,
        width: row_step / POINT_BYTES,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step,
        data: Bytes(data),
        is_dense: true,
    })
}

/// The type of a field, as ROS numbers it.
fn datatype(of: NumericType) -> u8 {
    match of {
        // A checked cloud has none of these.
        NumericType::Unspecified | NumericType::Uint8 => ros::datatype::UINT8,
        NumericType::Int8 => ros::datatype::INT8,
        NumericType::Uint16 => ros::datatype::UINT16,
        NumericType::Int16 => ros::datatype::INT16,
        NumericType::Uint32 => ros::datatype::UINT32,
        NumericType::Int32 => ros::datatype::INT32,
        NumericType::Float32 => ros::datatype::FLOAT32,
        NumericType::Float64 => ros::datatype::FLOAT64,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};
    use ppnpack_packing::grid::Grid;
    use ppnpack_packing::heightmap::{Heightmap, Scene};
    use ppnpack_ros::cdr as encoding;
    use ppnpack_wire::convert::cloud::{self as clouds, Capture};

    use super::*;

    #[test]
    fn a_cloud_that_goes_to_ros_and_back_is_the_same() {
        let cell = Cell::new("cell-1").unwrap();
        let capture = Capture {
            sequence: 3,
            captured_at_ns: 5_000_000_007,
            state_number: 0,
            container_from_sensor: Isometry3::translation(0.1, 0.2, 0.9),
        };
        let points = [Point3::new(0.0, 0.5, 1.0), Point3::new(f32::NAN, 0.0, 0.0)];
        let message = clouds::write(&capture, &points);
        let there = cloud(&cell, &clouds::read(&message).unwrap());
        assert_eq!((there.width, there.row_step), (2, 24));
        assert_eq!(there.header.frame_id, "cell-1/sensor");
        let payload = encoding::encode(&there).unwrap();
        let read = ros::PointCloud2::read(&payload).unwrap();
        let back = ros::to_cloud(&read, 3, &capture.container_from_sensor).unwrap();
        assert_eq!(back, message);
    }

    #[test]
    fn a_heightmap_has_a_point_for_each_cell_that_was_seen() {
        let cell = Cell::new("cell-1").unwrap();
        let grid = Grid::reference();
        let mut heights = vec![0; grid.nx() * grid.ny()];
        heights[0] = grid.rim() + 1;
        heights[1] = 10;
        let heightmap_of = Heightmap::from_units(grid.nx(), grid.ny(), heights).unwrap();
        let message = v1::Heightmap {
            scene: Some(scene::write(&grid, &Scene::from_heightmap(heightmap_of))),
            ..v1::Heightmap::default()
        };
        let points = heightmap(&cell, &message).unwrap();
        assert_eq!(points.width as usize, grid.nx() * grid.ny() - 1);
        let first: Vec<f32> = points.data.0[..12]
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
            .collect();
        let resolution = grid.resolution();
        let expected = [
            0.5 * resolution.cell_m(),
            1.5 * resolution.cell_m(),
            10.0 * resolution.height_unit_m(),
        ];
        for (found, expected) in first.iter().zip(expected) {
            assert!((f64::from(*found) - expected).abs() < 1e-6, "{first:?}");
        }
    }
}
