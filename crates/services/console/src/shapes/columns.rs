//! The surface of heightmaps, for items of which nothing else is known.

use nalgebra::{Point3, Vector3};
use ppnpack_packing::grid::Units;
use ppnpack_packing::item::ItemView;
use ppnpack_packing::model::mesh::Mesh;

use crate::directory::CellSize;

/// The four cells beside a cell, each with the two corners of the side between, so that the side is seen from outside.
const SIDES: [([isize; 2], [[f64; 2]; 2]); 4] = [
    ([-1, 0], [[0.0, 1.0], [0.0, 0.0]]),
    ([1, 0], [[1.0, 0.0], [1.0, 1.0]]),
    ([0, -1], [[0.0, 0.0], [1.0, 0.0]]),
    ([0, 1], [[1.0, 1.0], [0.0, 1.0]]),
];

/// The surface of an item's columns, in the frame of its heightmaps.
pub(super) fn mesh(view: &ItemView, size: CellSize) -> Mesh {
    let mut columns = Columns {
        view,
        size,
        origin: view.origin_from_corner_m(),
        mesh: Mesh::default(),
    };
    for (x, y, bottom, top) in view.cells() {
        columns.add(x, y, bottom, top);
    }
    columns.mesh
}

struct Columns<'a> {
    view: &'a ItemView,
    size: CellSize,
    /// The frame's origin from the footprint's corner, in metres.
    origin: Vector3<f64>,
    mesh: Mesh,
}

impl Columns<'_> {
    fn add(&mut self, x: usize, y: usize, bottom: Units, top: Units) {
        let (from_x, from_y) = (x as f64, y as f64);
        let corner = |dx: f64, dy: f64, height: Units| ([from_x + dx, from_y + dy], height);
        self.quad([
            corner(0.0, 0.0, top),
            corner(1.0, 0.0, top),
            corner(1.0, 1.0, top),
            corner(0.0, 1.0, top),
        ]);
        self.quad([
            corner(0.0, 0.0, bottom),
            corner(0.0, 1.0, bottom),
            corner(1.0, 1.0, bottom),
            corner(1.0, 0.0, bottom),
        ]);
        for ([beside_x, beside_y], [[ax, ay], [bx, by]]) in SIDES {
            let beside = x
                .checked_add_signed(beside_x)
                .zip(y.checked_add_signed(beside_y));
            if self.surfaces(beside) == Some((bottom, top)) {
                continue;
            }
            self.quad([
                corner(ax, ay, bottom),
                corner(bx, by, bottom),
                corner(bx, by, top),
                corner(ax, ay, top),
            ]);
        }
    }

    /// The lower and upper surface of a cell of the footprint; `None` where there is no such cell.
    fn surfaces(&self, cell: Option<(usize, usize)>) -> Option<(Units, Units)> {
        let (x, y) = cell.filter(|(x, y)| *x < self.view.nx() && *y < self.view.ny())?;
        let index = x * self.view.ny() + y;
        let of = |map: &[Units]| map.get(index).copied();
        of(self.view.bottom()).zip(of(self.view.top()))
    }

    /// Adds a quadrilateral whose corners, in cells and units, wind counter-clockwise seen from outside.
    fn quad(&mut self, corners: [([f64; 2], Units); 4]) {
        // The footprint's limits keep this far below what an index can count.
        let first = self.mesh.vertices.len() as u32;
        for ([x, y], height) in corners {
            let corner = Vector3::new(
                x * self.size.cell_m,
                y * self.size.cell_m,
                f64::from(height) * self.size.height_unit_m,
            );
            self.mesh.vertices.push(Point3::from(corner - self.origin));
        }
        self.mesh
            .triangles
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::item::{ABSENT, Item, ViewSurfaces};

    use super::*;

    const SIZE: CellSize = CellSize {
        cell_m: 0.01,
        height_unit_m: 0.002,
    };

    #[test]
    fn columns_enclose_what_the_heightmaps_do() {
        // A step, a cell with a hollow below, and one without material.
        let (top, bottom) = (vec![4, 2, 4, 0], vec![0, 0, 2, ABSENT]);
        let surfaces = ViewSurfaces::of_cells(2, 2, top, bottom);
        let item = Item::new("ell", vec![surfaces], 0.0).unwrap();
        let mesh = mesh(&item.views()[0], SIZE);
        let voxel_m3 = SIZE.cell_m * SIZE.cell_m * SIZE.height_unit_m;
        let volume_m3 = item.views()[0].voxel_count() as f64 * voxel_m3;
        // Between equal columns there are no sides; between others there are both, which cancel out.
        assert!((mesh.signed_volume_m3() - volume_m3).abs() < 1e-12);
        let bounds = mesh.bounds().unwrap();
        assert!((bounds.extents_m() - Vector3::new(0.02, 0.02, 0.008)).norm() < 1e-12);
    }
}
