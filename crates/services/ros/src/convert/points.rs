//! Heightmaps as points.

use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{WireError, v1};

use super::messages;
use crate::rmw::messages::{Header, PointCloud2, PointField, Time};

/// The type of numbers of 32 bits, as `sensor_msgs/PointField` numbers it.
const FLOAT32: u8 = 7;

/// Bytes of a point with three coordinates.
const POINT_BYTES: u32 = 12;

/// Gives the middles of the cells of a heightmap at their heights, in the frame of the container. What was not seen has none.
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
        datatype: FLOAT32,
        count: 1,
    };
    let row_step = u32::try_from(data.len()).unwrap_or(u32::MAX);
    Ok(PointCloud2 {
        header: Header {
            stamp: Time::from_ns(message.captured_at_ns),
            frame_id: messages::container_frame(cell.as_str()),
        },
        height: 1,
        width: row_step / POINT_BYTES,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step,
        data,
        is_dense: true,
    })
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::grid::Grid;
    use ppnpack_packing::heightmap::{Heightmap, Scene};

    use super::*;

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
        let first: Vec<f32> = points.data[..12]
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
