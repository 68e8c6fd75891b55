use ppnpack_packing::kernel::grid::{ABSENT, ContainerSize, Grid, Yaws};
use ppnpack_packing::kernel::item::ViewSurfaces;
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use proptest::prelude::*;

use super::*;
use crate::object::ConvexPiece;
use crate::views;

/// An item of `nx` x `ny` cells with a single view.
fn item(nx: usize, ny: usize, top: Vec<Units>, bottom: Vec<Units>) -> Item {
    let surfaces = ViewSurfaces::of_cells(nx, ny, top, bottom);
    Item::new("seen", vec![surfaces], 0.0).unwrap()
}

fn seen(item: &Item) -> Model {
    solid(item, &Resolution::reference()).unwrap()
}

fn pieces_m3(model: &Model) -> f64 {
    let volume_m3 = |piece: &ConvexPiece| hull(&piece.vertices).unwrap().signed_volume_m3();
    model.pieces.iter().map(volume_m3).sum()
}

/// The columns of a view, seen from the first of them along x and along y.
fn from_first(view: &ItemView) -> Vec<(usize, usize, Units, Units)> {
    let first_x = view.cells().map(|cell| cell.0).min().unwrap();
    let first_y = view.cells().map(|cell| cell.1).min().unwrap();
    let cells = view.cells();
    cells
        .map(|(x, y, bottom, top)| (x - first_x, y - first_y, bottom, top))
        .collect()
}

#[test]
fn a_box_is_one_piece_of_the_usual_density() {
    let model = seen(&item(6, 4, vec![20; 24], vec![0; 24]));
    assert_eq!((model.pieces.len(), model.pieces[0].vertices.len()), (1, 8));
    assert!((model.volume_m3 - 0.06 * 0.04 * 0.04).abs() < 1e-12);
    assert!((model.mass.mass_kg - DEFAULT_DENSITY_KG_M3 * model.volume_m3).abs() < 1e-9);
    let centre = model.mass.centre_of_mass_m - Point3::new(0.03, 0.02, 0.02);
    assert!(centre.norm() < 1e-9, "{centre}");
}

#[test]
fn a_known_volume_makes_it_lighter() {
    let surfaces = ViewSurfaces::of_cells(2, 2, vec![10; 4], vec![0; 4]);
    let mass_kg = |volume_m3| {
        let item = Item::new("seen", vec![surfaces.clone()], volume_m3).unwrap();
        seen(&item).mass.mass_kg
    };
    let full_m3 = 0.02 * 0.02 * 0.02;
    assert!((mass_kg(full_m3 / 4.0) - mass_kg(0.0) / 4.0).abs() < 1e-12);
    // A volume that is no part of the columns is none of the item's.
    assert_eq!(mass_kg(1.0), mass_kg(0.0));
    assert!((mass_kg(1e-300) - mass_kg(0.0) * LEAST_FILLED_SHARE).abs() < 1e-12);
}

#[test]
fn a_step_is_two_pieces_without_air() {
    let model = seen(&item(4, 1, vec![10, 10, 30, 30], vec![0; 4]));
    assert_eq!(model.pieces.len(), 2);
    assert!((pieces_m3(&model) - model.volume_m3).abs() < 1e-12);
}

#[test]
fn a_bowl_stays_hollow() {
    let is_wall = |index: usize| [0, 11].contains(&(index / 12)) || [0, 11].contains(&(index % 12));
    let top = (0..144).map(|index| if is_wall(index) { 40 } else { 5 });
    let model = seen(&item(12, 12, top.collect(), vec![0; 144]));
    assert!((2..=MAX_PIECES).contains(&model.pieces.len()));
    let full_m3 = 0.12 * 0.12 * 0.08;
    assert!(pieces_m3(&model) < 0.5 * full_m3);
}

#[test]
fn it_stands_on_its_cells_whatever_its_frame_and_the_first_yaw() {
    for yaw_rad in [0.0, 0.3] {
        let yaws = Yaws::from_radians(vec![yaw_rad]).unwrap();
        let resolution = Resolution::new(0.01, 0.002, yaws).unwrap();
        let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
        let surfaces = ViewSurfaces {
            origin_from_corner_m: Vector3::new(0.013, -0.02, 0.004),
            ..ViewSurfaces::of_cells(3, 5, vec![25; 15], vec![0; 15])
        };
        let item = Item::new("seen", vec![surfaces], 0.0).unwrap();
        let model = solid(&item, grid.resolution()).unwrap();
        let resting = RestingPlacement {
            placement: Placement { yaw: 0, x: 7, y: 2 },
            resting_height: 10,
        };
        let pose = item.container_from_item(&grid, &resting).unwrap();
        let posed = |points: &[Point3<f64>]| {
            let posed: Vec<_> = points.iter().map(|point| pose * point).collect();
            Bounds::of(&posed).unwrap()
        };
        for bounds in [
            posed(&model.mesh.vertices),
            posed(&model.pieces[0].vertices),
        ] {
            assert!((bounds.lowest - Point3::new(0.07, 0.02, 0.02)).norm() < 1e-9);
            assert!((bounds.highest - Point3::new(0.10, 0.07, 0.07)).norm() < 1e-9);
        }
        let centre = pose * model.mass.centre_of_mass_m;
        assert!((centre - Point3::new(0.085, 0.045, 0.045)).norm() < 1e-9);
    }
}

#[test]
fn a_known_centre_of_mass_is_kept_where_it_is_above_the_footprint() {
    let centre_x_m = |x_m: f64| {
        let surfaces = ViewSurfaces {
            centre_of_mass_m: Some(nalgebra::Point2::new(x_m, 0.02)),
            ..ViewSurfaces::of_cells(4, 4, vec![10; 16], vec![0; 16])
        };
        let item = Item::new("seen", vec![surfaces], 0.0).unwrap();
        seen(&item).mass.centre_of_mass_m.x
    };
    assert!((centre_x_m(0.03) - 0.03).abs() < 1e-12);
    for wrong_m in [-0.01, 7.0, f64::NAN] {
        assert!((centre_x_m(wrong_m) - 0.02).abs() < 1e-9);
    }
}

#[test]
fn what_is_far_from_its_frame_has_no_solid() {
    for origin_m in [1e6, f64::NAN, f64::INFINITY] {
        let surfaces = ViewSurfaces {
            origin_from_corner_m: Vector3::new(origin_m, 0.0, 0.0),
            ..ViewSurfaces::of_cells(1, 1, vec![1], vec![0])
        };
        let item = Item::new("far", vec![surfaces], 0.0).unwrap();
        assert_eq!(solid(&item, &Resolution::reference()), None);
    }
}

#[test]
fn many_cells_are_taken_together_within_the_footprint() {
    let (nx, ny) = (2 * MOST_COLUMNS + 1, 3);
    let resolution = Resolution::new(0.001, 0.002, Yaws::half_turn(1).unwrap()).unwrap();
    let item = item(nx, ny, vec![10; nx * ny], vec![0; nx * ny]);
    let model = solid(&item, &resolution).unwrap();
    let extents_m = model.mesh.bounds().unwrap().extents_m();
    assert!((extents_m - Vector3::new(0.257, 0.003, 0.02)).norm() < 1e-9);
    assert!(columns(&item.views()[0], &resolution).len() <= MOST_COLUMNS);
}

#[test]
fn a_shape_is_made_once() {
    let mut solids = SeenSolids::default();
    let item = item(2, 2, vec![10; 4], vec![0; 4]);
    let first = solids.of(&item, &Resolution::reference()).unwrap();
    let again = solids.of(&item, &Resolution::reference()).unwrap();
    assert!(Arc::ptr_eq(&first, &again));
    for _ in 0..MOST_KEPT {
        let other = Item::new(
            "other",
            vec![ViewSurfaces::of_cells(1, 1, vec![5], vec![0])],
            0.0,
        );
        solids.of(&other.unwrap(), &Resolution::reference());
    }
    assert!(solids.0.len() <= MOST_KEPT);
}

/// Items with holes and an uneven underside.
fn items() -> impl Strategy<Value = Item> {
    let sides = (1_usize..9, 1_usize..9);
    sides.prop_flat_map(|(nx, ny)| {
        let cell = (0_i16..8, 1_i16..30, 0_u8..5);
        proptest::collection::vec(cell, nx * ny).prop_map(move |cells| {
            let is_absent = |index: usize| index > 0 && cells[index].2 == 0;
            let present = (0..cells.len()).filter(|index| !is_absent(*index));
            let lowest = present.map(|index| cells[index].0).min().unwrap();
            let spans = cells
                .iter()
                .enumerate()
                .map(|(index, (low, thickness, _))| {
                    if is_absent(index) {
                        (0, ABSENT)
                    } else {
                        (low - lowest + thickness, low - lowest)
                    }
                });
            let (top, bottom) = spans.unzip();
            item(nx, ny, top, bottom)
        })
    })
}

proptest! {
    #[test]
    fn its_columns_are_those_that_were_seen(item in items()) {
        let model = seen(&item);
        let again = views::item(&model, &Resolution::reference()).unwrap();
        prop_assert_eq!(from_first(&again.views()[0]), from_first(&item.views()[0]));
        prop_assert_eq!(&model, &seen(&item));
    }

    #[test]
    fn its_pieces_are_few_and_hold_all_columns(item in items()) {
        let model = seen(&item);
        prop_assert!((1..=MAX_PIECES).contains(&model.pieces.len()));
        let vertices = model.pieces.iter().flat_map(|piece| &piece.vertices);
        let around_pieces = Bounds::of(&vertices.copied().collect::<Vec<_>>()).unwrap();
        let around_mesh = model.mesh.bounds().unwrap();
        prop_assert!((around_pieces.lowest - around_mesh.lowest).norm() < 1e-5);
        prop_assert!((around_pieces.highest - around_mesh.highest).norm() < 1e-5);
        prop_assert!((model.mass.mass_kg - DEFAULT_DENSITY_KG_M3 * model.volume_m3).abs() < 1e-9);
        let whole_m3 = hull(&model.mesh.vertices).unwrap().signed_volume_m3();
        // Simplified pieces may lose some of a millimetre.
        prop_assert!(pieces_m3(&model) < 1.001 * whole_m3);
        prop_assert!(pieces_m3(&model) > 0.9 * model.volume_m3);
    }
}
