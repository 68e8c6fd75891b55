//! What is seen of the objects of the set makes solids that stand where the objects do.

#![allow(clippy::unwrap_used, reason = "a panic is a failing test")]

use ppnpack_catalogue::catalogue::NamedMesh;
use ppnpack_catalogue::convex::{MAX_PIECE_VERTICES, MAX_PIECES};
use ppnpack_catalogue::mass::mass_properties;
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::{seen, views};
use ppnpack_packing::grid::{Resolution, Units, Yaws};
use ppnpack_packing::item::ItemView;

/// An object whose pieces nobody needs.
fn model(object: &NamedMesh) -> Model {
    Model {
        name: object.name.clone(),
        mesh: object.mesh.clone(),
        volume_m3: object.mesh.signed_volume_m3(),
        pieces: Vec::new(),
        mass: mass_properties(&object.mesh, object.density_kg_m3),
        carries_kg: None,
        resting_poses: Vec::new(),
    }
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
fn what_is_seen_of_an_object_is_a_solid_of_the_same_columns_and_place() {
    for (cell_m, unit_m) in [(0.01, 0.002), (0.004, 0.001)] {
        let yaws = Yaws::half_turn(1).unwrap();
        let resolution = Resolution::new(cell_m, unit_m, yaws).unwrap();
        for object in ppnpack_household::OBJECTS.iter() {
            let (known, name) = (model(object), &object.name);
            let item = views::item(&known, &resolution).unwrap();
            let solid = seen::solid(&item, &resolution).unwrap();
            let again = views::item(&solid, &resolution).unwrap();
            let views = [&again, &item].map(|item| item.views().first().unwrap());
            let [again, view] = views.map(from_first);
            assert_eq!(again, view, "{name} at {cell_m} m");

            let (box_of_solid, box_of_object) = (solid.mesh.bounds(), known.mesh.bounds());
            let (of_solid, of_object) = (box_of_solid.unwrap(), box_of_object.unwrap());
            for apart in [
                of_solid.lowest - of_object.lowest,
                of_solid.highest - of_object.highest,
            ] {
                assert!(apart.xy().amax() < cell_m + 1e-6, "{name}: {apart}");
                assert!(apart.z.abs() < unit_m + 1e-6, "{name}: {apart}");
            }
            let centres = solid.mass.centre_of_mass_m - known.mass.centre_of_mass_m;
            assert!(centres.xy().norm() < 1e-9, "{name}: {centres}");

            assert!((1..=MAX_PIECES).contains(&solid.pieces.len()), "{name}");
            let vertices = || solid.pieces.iter().map(|piece| &piece.vertices);
            assert!(vertices().all(|vertices| vertices.len() <= MAX_PIECE_VERTICES));
            let vertices: Vec<_> = vertices().flatten().copied().collect();
            let of_pieces = Bounds::of(&vertices).unwrap();
            assert!((of_pieces.lowest - of_solid.lowest).norm() < 1e-5, "{name}");
            assert!(
                (of_pieces.highest - of_solid.highest).norm() < 1e-5,
                "{name}"
            );
        }
    }
}
