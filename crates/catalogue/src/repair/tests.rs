use nalgebra::Point3;
use proptest::prelude::*;

use super::*;
use crate::shapes::{ball, cube, tube};

fn repaired_m(mesh: Mesh) -> Result<(Mesh, Vec<Repair>), ObjectError> {
    repaired(mesh, LengthUnit::Metres)
}

fn inside_out(mut mesh: Mesh) -> Mesh {
    let triangles = mesh.triangles.iter_mut();
    triangles.for_each(|corners| corners.swap(0, 1));
    mesh
}

#[test]
fn a_sound_mesh_stays_as_it_is() {
    let mesh = ball(0.05, 12, 9);
    assert_eq!(repaired_m(mesh.clone()), Ok((mesh, vec![])));
}

#[test]
fn loose_triangles_are_welded() {
    let corners: Vec<_> = cube(0.1).corners().flatten().collect();
    let triangles = (0..12).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    let mut loose = Mesh {
        vertices: corners,
        triangles,
    };
    let (mesh, repairs) = repaired_m(loose.clone()).unwrap();
    assert_eq!(
        (mesh.vertices.len(), repairs),
        (8, vec![Repair::Welded(28)])
    );
    // As a file of few digits has them.
    for (index, vertex) in loose.vertices.iter_mut().enumerate() {
        vertex.x += 1e-8 * index as f64;
    }
    let (mesh, _) = repaired_m(loose).unwrap();
    assert_eq!(mesh.vertices.len(), 8);
}

#[test]
fn inside_out_meshes_are_turned() {
    let (mesh, repairs) = repaired_m(inside_out(cube(0.1))).unwrap();
    assert!((mesh.signed_volume_m3() - 0.001).abs() < 1e-12);
    assert_eq!(repairs, vec![Repair::Turned(12)]);
}

#[test]
fn a_cavity_stays_a_cavity_and_a_neighbour_is_turned() {
    let mut hollow = cube(0.1);
    hollow.append(&inside_out(cube(0.05)));
    let (hollow, repairs) = repaired_m(hollow).unwrap();
    assert!(repairs.is_empty());
    assert!((hollow.signed_volume_m3() - 0.000_875).abs() < 1e-12);
    let mut both = cube(0.1);
    both.append(&inside_out(Mesh::cuboid(
        [0.2, 0.0, 0.0],
        [0.25, 0.05, 0.05],
    )));
    let (both, _) = repaired_m(both).unwrap();
    assert!((both.signed_volume_m3() - 0.001_125).abs() < 1e-12);
}

#[test]
fn blocks_against_each_other_keep_their_volume_wherever_they_are() {
    for at in [-3.0, 0.0, 3.0] {
        let mut both = Mesh::cuboid([at, 0.0, 0.0], [at + 0.25, 0.25, 0.25]);
        // Its mirror image has the other diagonal on the side that they share.
        let mut other = Mesh::cuboid([at + 0.25, 0.0, 0.0], [at + 0.5, 0.25, 0.25]);
        let vertices = other.vertices.iter_mut();
        vertices.for_each(|vertex| vertex.y = 0.25 - vertex.y);
        both.append(&inside_out(other));
        let (both, repairs) = repaired_m(both).unwrap();
        assert_eq!(repairs, vec![Repair::Welded(4)]);
        assert!((both.signed_volume_m3() - 0.031_25).abs() < 1e-12);
    }
}

#[test]
fn a_part_in_the_opening_of_another_is_no_cavity() {
    // Mirrored, so that it winds inwards; its box lies within that of the ring.
    let mut ring = tube(0.1, 0.06, 0.05, 24);
    let ring_m3 = ring.signed_volume_m3();
    let part = Mesh::cuboid([-0.02, -0.02, 0.01], [0.02, 0.02, 0.03]);
    let part_m3 = part.signed_volume_m3();
    ring.append(&inside_out(part));
    let (both, repairs) = repaired_m(ring).unwrap();
    assert!((both.signed_volume_m3() - ring_m3 - part_m3).abs() < 1e-12);
    assert_eq!(repairs, vec![Repair::Turned(12)]);
}

#[test]
fn a_shell_inside_another_counts_its_space_once() {
    let mut shells = cube(0.1);
    shells.append(&cube(0.05));
    assert_eq!(
        repaired_m(shells),
        Ok((
            cube(0.1),
            vec![Repair::UnusedVertices(8), Repair::Nested(1)]
        ))
    );
    // A ball in a hollow is a ball in a hollow.
    let mut hollow = cube(0.1);
    hollow.append(&inside_out(cube(0.08)));
    hollow.append(&cube(0.05));
    assert_eq!(repaired_m(hollow.clone()), Ok((hollow.clone(), vec![])));
    let (turned, _) = repaired_m(inside_out(hollow.clone())).unwrap();
    assert!((turned.signed_volume_m3() - hollow.signed_volume_m3()).abs() < 1e-12);
}

#[test]
fn a_side_with_vertices_of_others_on_it_is_cut_there() {
    let mut mesh = cube(0.1);
    let [a, b, c] = mesh.triangles[0];
    let at = |share: f64| {
        let [a, b] = [a, b].map(|corner| mesh.vertices[corner as usize].coords);
        Point3::from(a + (b - a) * share)
    };
    let stops = [at(0.3), at(0.8)];
    mesh.vertices.extend(stops);
    mesh.triangles[0] = [a, 8, c];
    mesh.triangles.extend([[8, 9, c], [9, b, c]]);
    let (closed, repairs) = repaired_m(mesh).unwrap();
    assert_eq!(closed.triangles.len(), 16);
    assert!((closed.signed_volume_m3() - 0.001).abs() < 1e-12);
    assert_eq!(repairs, vec![Repair::Cut(1)]);
}

#[test]
fn triangles_that_add_nothing_go() {
    let mut mesh = cube(0.1);
    mesh.triangles.push(mesh.triangles[3]);
    mesh.triangles.push([0, 0, 5]);
    mesh.triangles.extend([[0, 1, 7], [1, 0, 7]]);
    mesh.vertices.push(Point3::new(9.0, 9.0, 9.0));
    let (fixed, repairs) = repaired_m(mesh).unwrap();
    assert_eq!(fixed, cube(0.1));
    assert_eq!(
        repairs,
        vec![
            Repair::UnusedVertices(1),
            Repair::Degenerate(1),
            Repair::Duplicate(3)
        ]
    );
}

#[test]
fn a_sliver_that_closes_a_crack_stays() {
    let mut mesh = cube(0.1);
    // Splits one of the two triangles at an edge, so that a flat one is needed between the halves
    // and the other.
    let [a, b, c] = mesh.triangles[0];
    let half = nalgebra::center(&mesh.vertices[a as usize], &mesh.vertices[b as usize]);
    let middle = mesh.vertices.len() as u32;
    mesh.vertices.push(half);
    mesh.triangles[0] = [a, middle, c];
    mesh.triangles.extend([[middle, b, c], [a, b, middle]]);
    let (fixed, _) = repaired_m(mesh.clone()).unwrap();
    assert_eq!(fixed, mesh);
}

#[test]
fn small_flat_holes_are_closed_and_large_ones_are_not() {
    let mut mesh = ball(0.05, 24, 24);
    mesh.triangles.retain(|corners| !corners.contains(&0));
    let (closed, repairs) = repaired_m(mesh).unwrap();
    assert!(repairs.contains(&Repair::Capped(1)));
    assert!(closed.signed_volume_m3() > 0.0);
    let mut open_box = cube(0.1);
    open_box.triangles.truncate(10);
    let refused = repaired_m(open_box).unwrap_err().to_string();
    assert!(refused.starts_with("is not closed: 4 edges"), "{refused}");
}

#[test]
fn what_is_no_solid_is_refused() {
    let mut nan = cube(0.1);
    nan.vertices[3].y = f64::NAN;
    let mut missing = cube(0.1);
    missing.triangles[2] = [0, 1, 8];
    for (mesh, expected) in [
        (Mesh::default(), "has no triangles"),
        (nan, "has a vertex (number 3) that is not finite"),
        (
            missing,
            "has a triangle (number 2) that names vertex 8 of 8",
        ),
        (Mesh::cuboid([0.0; 3], [0.1, 0.1, 1e-6]), "has no thickness"),
    ] {
        let refused = repaired_m(mesh).unwrap_err().to_string();
        assert!(refused.starts_with(expected), "{refused}");
    }
}

#[test]
fn unlikely_sizes_name_the_likely_unit() {
    let (metres, millimetres) = (LengthUnit::Metres, LengthUnit::Millimetres);
    for (mesh, unit, expected) in [
        (cube(100.0), metres, "likely drawn in mm;"),
        (cube(0.0002), millimetres, "likely drawn in m;"),
        (cube(1e9), metres, "give the unit in which it is drawn"),
    ] {
        let refused = repaired(mesh, unit).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
}

proptest! {
    #[test]
    fn turned_triangles_are_turned_back(
        turned in prop::collection::vec(any::<prop::sample::Index>(), 0..40),
    ) {
        let sound = ball(0.05, 12, 9);
        let mut mesh = sound.clone();
        for index in turned {
            let index = index.index(mesh.triangles.len());
            mesh.triangles[index].swap(1, 2);
        }
        let (fixed, _) = repaired_m(mesh).unwrap();
        prop_assert!((fixed.signed_volume_m3() - sound.signed_volume_m3()).abs() < 1e-12);
    }

    #[test]
    fn any_soup_is_a_solid_or_refused(
        corners in prop::collection::vec(prop::array::uniform3(0_u32..9), 1..40),
        points in prop::collection::vec(prop::array::uniform3(-0.1..0.1_f64), 9),
    ) {
        let vertices = points.into_iter().map(Point3::from).collect();
        if let Ok((mesh, _)) = repaired_m(Mesh { vertices, triangles: corners }) {
            prop_assert!(mesh.signed_volume_m3() > 0.0);
            prop_assert_eq!(orientation::open_edges(&mesh), 0);
        }
    }
}
