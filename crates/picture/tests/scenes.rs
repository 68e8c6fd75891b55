//! Scenes, sheets and heightmaps: what is in front hides what is behind, equal input gives equal
//! bytes, and odd input gives a picture or an error.
#![cfg(test)]

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_picture::{
    Camera, Colour, HeightField, Image, Item, Scene3d, Size, Tile, TriangleMesh, contact_sheet,
    heightmap, render,
};

const RED: Colour = colour(220, 40, 40);
const BLUE: Colour = colour(40, 40, 220);
const CONTAINER_M: [f64; 3] = [0.32, 0.32, 0.30];

const fn colour(red: u8, green: u8, blue: u8) -> Colour {
    Colour { red, green, blue }
}

/// A cube with an edge of 10 cm on the ground.
fn cube() -> Mesh {
    Mesh::cuboid([0.0; 3], [0.1; 3])
}

fn borrowed(mesh: &Mesh) -> TriangleMesh<'_> {
    TriangleMesh {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
    }
}

fn item(mesh: &Mesh, at_m: [f64; 3], colour: Colour) -> Item<'_> {
    Item {
        mesh: borrowed(mesh),
        world_from_item: Isometry3::translation(at_m[0], at_m[1], at_m[2]),
        colour,
    }
}

fn small() -> Size {
    Size::new(160, 120).unwrap()
}

fn draw(items: Vec<Item<'_>>, container_m: Option<[f64; 3]>) -> Image {
    let scene = Scene3d { items, container_m };
    let highest = Point3::from(CONTAINER_M) + Vector3::new(0.0, 0.0, 0.06);
    let camera = Camera::framing(Point3::origin(), highest);
    render(&scene, &camera, small()).unwrap()
}

/// How many pixels are clearly more red than blue, and the reverse.
fn red_and_blue(image: &Image) -> (usize, usize) {
    let count = |exceeds: fn(i32, i32) -> bool| {
        let pixels = image.pixels().iter();
        let exceeding = pixels.filter(|pixel| exceeds(pixel.red.into(), pixel.blue.into()));
        exceeding.count()
    };
    (
        count(|red, blue| red > blue + 60),
        count(|red, blue| blue > red + 60),
    )
}

#[test]
fn the_nearer_item_hides_the_other() {
    let cube = cube();
    // The usual view is from the side of low x and y, and from above.
    let near = item(&cube, [0.1, 0.1, 0.1], RED);
    let far = item(&cube, [0.13, 0.15, 0.05], BLUE);
    for items in [vec![near, far], vec![far, near]] {
        let (red, blue) = red_and_blue(&draw(items, None));
        assert!(red > 10 * blue.max(1), "{red} red, {blue} blue");
    }
    let (_, alone) = red_and_blue(&draw(vec![far], None));
    assert!(alone > 300, "{alone} blue");
}

#[test]
fn equal_scenes_give_equal_bytes() {
    let cube = cube();
    let first = item(&cube, [0.1, 0.1, 0.0], RED);
    let second = item(&cube, [0.0; 3], BLUE);
    let image = || draw(vec![first, second], Some(CONTAINER_M));
    assert_eq!(image().to_png().unwrap(), image().to_png().unwrap());
}

#[test]
fn items_have_lit_and_dark_sides() {
    let cube = cube();
    let grey = colour(160, 160, 160);
    let image = draw(vec![item(&cube, [0.1, 0.1, 0.0], grey)], None);
    let mut shades = [0; 256];
    for pixel in image.pixels() {
        shades[usize::from(pixel.green)] += 1;
    }
    // The top, two sides and the background; lines are thinner.
    let of_many = shades.iter().filter(|pixels| **pixels > 80).count();
    assert_eq!(of_many, 4);
}

#[test]
fn odd_meshes_are_drawn_without_their_odd_parts() {
    let plain = cube();
    let mut mesh = cube();
    mesh.vertices.push(Point3::new(f64::NAN, 0.0, 0.0));
    mesh.vertices.push(Point3::new(f64::INFINITY, 1e300, 0.0));
    mesh.triangles
        .extend([[0, 1, 8], [9, 1, 0], [0, 0, 1], [0, 1, 4_000_000]]);
    let odd = item(&mesh, [0.1; 3], RED);
    let lost = Item {
        world_from_item: Isometry3::translation(f64::NAN, 0.0, 0.0),
        ..odd
    };
    let expected = draw(vec![item(&plain, [0.1; 3], RED)], Some(CONTAINER_M));
    let found = draw(vec![lost, odd], Some(CONTAINER_M));
    assert_eq!(expected, found);
}

#[test]
fn odd_scenes_and_cameras_give_a_picture() {
    let mesh = cube();
    let cube = item(&mesh, [0.0; 3], RED);
    let nowhere = Camera {
        eye: Point3::origin(),
        target: Point3::origin(),
        field_of_view_rad: f64::NAN,
    };
    let inside = Camera {
        eye: Point3::new(0.05, 0.05, 0.05),
        ..nowhere
    };
    for container_m in [
        None,
        Some(CONTAINER_M),
        Some([f64::NAN, -1.0, 0.0]),
        Some([1e300; 3]),
    ] {
        for items in [vec![], vec![cube]] {
            let scene = Scene3d { items, container_m };
            for camera in [Camera::overlooking(&scene), nowhere, inside] {
                render(&scene, &camera, Size::new(17, 40).unwrap()).unwrap();
            }
        }
    }
}

#[test]
fn oversized_scenes_are_refused() {
    let mut mesh = cube();
    mesh.triangles = vec![[0, 1, 2]; (1 << 22) + 1];
    let scene = Scene3d {
        items: vec![item(&mesh, [0.0; 3], RED)],
        container_m: None,
    };
    let refused = render(&scene, &Camera::overlooking(&scene), small()).unwrap_err();
    assert!(refused.to_string().contains("triangles or vertices"));
}

#[test]
fn sheets_hold_every_tile() {
    let cube = cube();
    let tile = |colour| Tile {
        mesh: borrowed(&cube),
        colour,
        name: "cube",
        detail: "10 × 10 × 10 cm",
    };
    let sheet = contact_sheet("Cubes", &[tile(RED), tile(BLUE), tile(RED)], 80).unwrap();
    let (red, blue) = red_and_blue(&sheet);
    assert!(blue > 500 && red > 3 * blue / 2, "{red} red, {blue} blue");
    assert!(contact_sheet("", &[], 80).is_ok());
    assert!(contact_sheet("", &[], 0).is_err());
    assert!(contact_sheet("", &[], u32::MAX).is_err());
}

#[test]
fn heightmaps_have_x_to_the_right_and_y_up() {
    // Cell (2, 1) of 3 x 2 is the top right one.
    let heights_m = [0.0, 0.0, 0.0, 0.0, 0.0, 0.2];
    let field = HeightField {
        nx: 3,
        ny: 2,
        cell_m: 0.01,
        heights_m: &heights_m,
        scale_top_m: None,
    };
    let image = heightmap("Heights", &field).unwrap();
    let yellow = |x: u32, y: u32| image.colour(x, y) == Some(Colour::of_share(1.0));
    let (width, height) = (720, 480);
    let (left, top) = (84, 64);
    assert!(yellow(left + width - 5, top + 5));
    assert!(!yellow(left + width - 5, top + height - 5) && !yellow(left + 5, top + 5));
    assert_eq!(image, heightmap("Heights", &field).unwrap());
}

#[test]
fn odd_height_fields_give_a_picture_or_an_error() {
    let field = HeightField {
        nx: 1,
        ny: 2,
        cell_m: 0.01,
        heights_m: &[],
        scale_top_m: None,
    };
    let refused = heightmap("", &field).unwrap_err().to_string();
    assert!(refused.contains("needs as many heights"), "{refused}");
    assert!(heightmap("", &HeightField { nx: 0, ..field }).is_err());
    for heights_m in [[f64::NAN, f64::INFINITY], [1e308, -1e308], [0.0, 0.0]] {
        for cell_m in [0.0, f64::NAN, 1e300, -1.0, 1e-300] {
            for scale_top_m in [None, Some(f64::NAN), Some(0.0), Some(1e308)] {
                let odd = HeightField {
                    cell_m,
                    heights_m: &heights_m,
                    scale_top_m,
                    ..field
                };
                assert!(heightmap("Odd", &odd).is_ok());
            }
        }
    }
}
