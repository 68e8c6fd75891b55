//! What the set promises, object by object, and the builders against closed formulas.

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use nalgebra::Point3;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::mass::mass_properties;
use ppnpack_catalogue::mesh::Mesh;

use super::field::{ball, block, cylinder, prism};
use super::outline::{rectangle, spline, triangulate};
use super::solid::Solid;
use super::surfaces::{extrude, lathe, loft, superellipsoid, sweep};
use super::{BUILTIN, OBJECTS, SOURCES, built, builtin, source};

/// The reference container, in metres.
const CONTAINER_M: [f64; 3] = [0.32, 0.32, 0.30];
/// What counts as touching the ground, in metres.
const CONTACT_M: f64 = 0.5e-3;
const MOST_TRIANGLES: usize = 4_000;

/// Directed edges that are not matched by exactly one opposite edge.
fn open_edges(mesh: &Mesh) -> Vec<(u32, u32)> {
    let mut counts: HashMap<(u32, u32), usize> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *counts.entry(edge).or_default() += 1;
        }
    }
    let is_matched = |(a, b)| counts[&(a, b)] == 1 && counts.get(&(b, a)) == Some(&1);
    counts
        .keys()
        .copied()
        .filter(|&edge| !is_matched(edge))
        .collect()
}

/// How many parts that share no vertex the mesh has; unused vertices count as parts.
fn parts(mesh: &Mesh) -> usize {
    let mut parent: Vec<usize> = (0..mesh.vertices.len()).collect();
    fn root(parent: &[usize], mut vertex: usize) -> usize {
        while parent[vertex] != vertex {
            vertex = parent[vertex];
        }
        vertex
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| root(&parent, corner as usize));
        let least = a.min(b).min(c);
        for corner in [a, b, c] {
            parent[corner] = least;
        }
    }
    parent
        .iter()
        .enumerate()
        .filter(|(vertex, parent)| vertex == *parent)
        .count()
}

fn centre_of_mass(mesh: &Mesh) -> Point3<f64> {
    mass_properties(mesh, 1.0).centre_of_mass_m
}

/// The least distance, in metres and over all level directions, by which the support reaches
/// further than the centre of mass; negative where the object would topple.
fn support_margin(mesh: &Mesh) -> f64 {
    let centre = centre_of_mass(mesh);
    (0..360)
        .map(|degrees| {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            mesh.vertices
                .iter()
                .filter(|vertex| vertex.z <= CONTACT_M)
                .map(|vertex| (vertex.x - centre.x) * cos + (vertex.y - centre.y) * sin)
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .fold(f64::INFINITY, f64::min)
}

/// A solid's volume in cubic millimetres, its mesh checked.
fn checked_volume_mm3(solid: Solid) -> f64 {
    let mesh = solid.into_mesh();
    assert_eq!(open_edges(&mesh), []);
    assert_eq!(parts(&mesh), 1);
    mesh.signed_volume_m3() * 1e9
}

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    let error = (value / expected - 1.0).abs();
    assert!(
        error <= tolerance,
        "{value} is not within {tolerance} of {expected}"
    );
}

#[test]
fn every_object_is_one_closed_outward_surface() {
    for object in OBJECTS.iter() {
        assert_eq!(open_edges(&object.mesh), [], "{}", object.name);
        assert_eq!(parts(&object.mesh), 1, "{}", object.name);
        assert!(object.mesh.signed_volume_m3() > 0.0, "{}", object.name);
        assert!(
            object.mesh.triangles.len() <= MOST_TRIANGLES,
            "{}",
            object.name
        );
        for [a, b, c] in object.mesh.corners() {
            assert!(
                (b - a).cross(&(c - a)).norm() > 0.0,
                "{}: a triangle without area",
                object.name
            );
        }
    }
}

#[test]
fn every_object_stands_on_the_ground_in_the_middle_and_fits_the_container() {
    for object in OBJECTS.iter() {
        let bounds = object.mesh.bounds().unwrap();
        for (extent, limit) in bounds.extents_m().iter().zip(CONTAINER_M) {
            assert!(*extent < limit, "{} is {extent} m long", object.name);
        }
        assert_eq!(bounds.lowest.z, 0.0, "{}", object.name);
        let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
        assert!(middle.xy().coords.amax() < 1e-6, "{}", object.name);
    }
}

#[test]
fn every_object_rests_stably_on_a_flat_contact() {
    for object in OBJECTS.iter() {
        let touching = object.mesh.vertices.iter().filter(|v| v.z == 0.0).count();
        assert!(
            touching >= 3,
            "{} touches the ground in {touching} vertices",
            object.name
        );
        let margin = support_margin(&object.mesh);
        assert!(margin > 1e-3, "{} is {margin} m from toppling", object.name);
    }
}

#[test]
fn names_are_unique_snake_case() {
    let names: HashSet<_> = OBJECTS.iter().map(|object| &object.name).collect();
    assert_eq!(names.len(), OBJECTS.len());
    for name in names {
        assert!(
            name.chars().all(|c| c.is_ascii_lowercase() || c == '_'),
            "{name}"
        );
    }
}

#[test]
fn the_set_is_of_the_promised_size_and_order() {
    let set = &**OBJECTS;
    assert_eq!(set.len(), 96);
    let volumes_cm3: Vec<_> = set
        .iter()
        .map(|object| object.mesh.signed_volume_m3() * 1e6)
        .collect();
    assert!(volumes_cm3.is_sorted());
    assert!((3.0..6.0).contains(&volumes_cm3[0]));
    assert!((250.0..400.0).contains(&volumes_cm3[set.len() / 2]));
    assert!((2_000.0..2_700.0).contains(&volumes_cm3[set.len() - 1]));
}

#[test]
fn densities_are_those_of_everyday_goods() {
    for object in OBJECTS.iter() {
        // From a plastic ball to steel tools with plastic handles.
        assert!(
            (50.0..4_000.0).contains(&object.density_kg_m3),
            "{}",
            object.name
        );
        let mass_kg = object.density_kg_m3 * object.mesh.signed_volume_m3();
        assert!((0.005..1.5).contains(&mass_kg), "{}", object.name);
    }
}

#[test]
fn the_set_is_kept_by_all_code_that_makes_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = [&folder, &folder.join("set")].map(|folder| folder.read_dir().unwrap());
    let paths = files
        .into_iter()
        .flatten()
        .map(|entry| entry.unwrap().path());
    let sources = paths.filter(|path| path.is_file() && !path.ends_with("tests.rs"));
    let sources: HashSet<_> = sources.map(|it| fs::read_to_string(it).unwrap()).collect();
    let kept_by = SOURCES.map(str::to_owned);
    assert_eq!(HashSet::from(kept_by), sources);
}

#[test]
fn building_again_gives_the_same_bits_as_does_keeping_them() {
    let folder = tempfile::tempdir().unwrap();
    let cache = CacheDir::At(folder.path().to_owned());
    let kept = [(); 2].map(|()| source(BUILTIN, &cache));
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    assert_eq!(kept, [builtin(), builtin()]);
    assert_eq!(built(), **OBJECTS);
}

#[test]
fn tableware_is_hollow() {
    let hollow = [
        "bowl",
        "salad_bowl",
        "mug",
        "espresso_cup",
        "tumbler",
        "pitcher",
        "flower_pot",
    ];
    let set = &**OBJECTS;
    for name in hollow {
        let object = set.iter().find(|object| object.name == name).unwrap();
        let extents = object.mesh.bounds().unwrap().extents_m();
        let fill = object.mesh.signed_volume_m3() / (extents.x * extents.y * extents.z);
        assert!(fill < 0.25, "{name} fills {fill} of its box");
        // Straight down the middle there is nothing above the lower third.
        let centre = centre_of_mass(&object.mesh);
        let above = object.mesh.corners().filter(|corners| {
            let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
                let (a, b) = (corners[i] - centre, corners[j] - centre);
                a.x * b.y - a.y * b.x
            });
            let covers = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
            covers && corners.iter().any(|corner| corner.z > extents.z / 3.0)
        });
        assert_eq!(above.count(), 0, "{name}");
    }
}

#[test]
fn builders_enclose_the_volumes_of_the_formulas() {
    let l_shape = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    let cylinder = lathe(&[[0.0, 0.0], [5.0, 0.0], [5.0, 8.0], [0.0, 8.0]]);
    let cone = loft(&[[0.0, 10.0, 10.0, 2.0], [9.0, 0.02, 0.02, 2.0]]);
    let quarter_ring: Vec<_> = (0..=40)
        .map(|step| {
            let (sin, cos) = (f64::from(step) / 40.0 * PI / 2.0).sin_cos();
            (Point3::new(50.0 * cos, 50.0 * sin, 0.0), 6.0)
        })
        .collect();
    let ellipsoid = superellipsoid([20.0, 30.0, 40.0], 2.0, 2.0);
    for (solid, volume_mm3, tolerance) in [
        (extrude(&rectangle(3.0, 4.0), 5.0), 60.0, 1e-9),
        (extrude(&l_shape, 2.0), 12.0, 1e-9),
        // Polygons of 32 sides lose up to a hundredth against circles.
        (cylinder, PI * 25.0 * 8.0, 0.01),
        (cone, PI * 25.0 * 9.0 / 3.0, 0.012),
        (sweep(&quarter_ring), PI * 36.0 * 50.0 * PI / 2.0, 0.015),
        (ellipsoid, PI / 6.0 * 24_000.0, 0.03),
    ] {
        assert_close(checked_volume_mm3(solid), volume_mm3, tolerance);
    }
}

#[test]
fn carved_fields_enclose_the_volumes_of_the_formulas() {
    let brick = block([60.0, 50.0, 40.0], 0.0).at(0.0, 0.0, 20.0);
    let wedge = prism(&[[0.0, 0.0], [60.0, 0.0], [0.0, 60.0]], 30.0);
    let pipe = cylinder(30.0, 50.0).without(cylinder(20.0, 60.0));
    for (field, volume_mm3, tolerance) in [
        (
            ball(30.0).at(0.0, 0.0, 40.0),
            4.0 / 3.0 * PI * 27_000.0,
            0.02,
        ),
        // What lies below the ground is cut off.
        (ball(30.0), 2.0 / 3.0 * PI * 27_000.0, 0.02),
        (brick.about_x(0.0), 120_000.0, 0.02),
        (pipe, PI * 500.0 * 50.0, 0.03),
        (wedge, 54_000.0, 0.03),
    ] {
        assert_close(checked_volume_mm3(field.carved(2.0)), volume_mm3, tolerance);
    }
}

#[test]
fn carving_puts_the_underside_on_the_ground() {
    let mesh = cylinder(30.0, 40.0).carved(2.0).into_mesh();
    let on_ground = mesh.vertices.iter().filter(|v| v.z == 0.0);
    let reach = on_ground.map(|v| v.x.hypot(v.y)).fold(0.0, f64::max);
    assert!(
        (reach - 0.03).abs() < 1e-3,
        "the flat underside reaches out {reach} m"
    );
}

#[test]
fn ear_clipping_covers_the_outline_once() {
    let star: Vec<[f64; 2]> = (0..20)
        .map(|corner| {
            let radius = if corner % 2 == 0 { 10.0 } else { 4.0 };
            let (sin, cos) = (f64::from(corner) * PI / 10.0).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect();
    let twice = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let area: f64 = star
        .iter()
        .zip(star.iter().cycle().skip(1))
        .map(|(a, b)| twice(*a, *b))
        .sum();
    let triangles = triangulate(&star);
    assert_eq!(triangles.len(), star.len() - 2);
    let covered: f64 = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|corner| star[corner as usize]);
            twice(a, b) + twice(b, c) + twice(c, a)
        })
        .sum();
    assert_close(covered, area, 1e-12);
}

#[test]
fn splines_pass_through_their_points() {
    let points = [[0.0, 0.0], [5.0, 1.0], [7.0, 6.0], [0.0, 9.0]];
    let curve = spline(&points, 4);
    for (index, point) in points.iter().enumerate() {
        assert_eq!(curve[index * 4], *point);
    }
}

#[test]
fn a_cone_laid_down_lies_along_its_side() {
    let cone = lathe(&[[0.0, 0.0], [20.0, 0.0], [5.0, 100.0], [0.0, 100.0]])
        .laid_down()
        .into_mesh();
    let touching: Vec<_> = cone.vertices.iter().filter(|v| v.z < 1e-5).collect();
    let reach = |sign: f64| touching.iter().map(|v| sign * v.x).fold(f64::MIN, f64::max);
    assert!(touching.len() >= 4);
    assert!(reach(1.0) + reach(-1.0) > 0.095);
}
