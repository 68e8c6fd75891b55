use std::path::Path;

use proptest::prelude::*;

use super::*;

/// A unit cube as an OBJ of quadrilaterals.
const CUBE_OBJ: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn parsed(name: &str, bytes: &[u8]) -> Result<Mesh, ReadError> {
    parse(Path::new(name), bytes, LengthUnit::Metres)
}

fn cube() -> Mesh {
    parsed("cube.obj", CUBE_OBJ.as_bytes()).unwrap()
}

fn cube_ply(encoding: &str) -> Vec<u8> {
    let cube = cube();
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 8\nproperty float x\nproperty float y\n\
         property double z\nproperty uchar red\nelement face 12\n\
         property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for vertex in &cube.vertices {
        if encoding == "ascii" {
            bytes.extend(format!("{} {} {} 7\n", vertex.x, vertex.y, vertex.z).bytes());
        } else {
            bytes.extend((vertex.x as f32).to_le_bytes());
            bytes.extend((vertex.y as f32).to_le_bytes());
            bytes.extend(vertex.z.to_le_bytes());
            bytes.push(7);
        }
    }
    for [a, b, c] in &cube.triangles {
        if encoding == "ascii" {
            bytes.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            bytes.push(3);
            bytes.extend([a, b, c].iter().flat_map(|index| index.to_le_bytes()));
        }
    }
    bytes
}

fn cube_stl(comment: &[u8]) -> Vec<u8> {
    let mut bytes = comment.to_vec();
    bytes.resize(80, b' ');
    let cube = cube();
    bytes.extend((cube.triangles.len() as u32).to_le_bytes());
    for corners in cube.corners() {
        bytes.extend([0_u8; 12]);
        for coordinate in corners.iter().flat_map(|corner| corner.iter().copied()) {
            bytes.extend((coordinate as f32).to_le_bytes());
        }
        bytes.extend([0_u8; 2]);
    }
    bytes
}

fn cube_ascii_stl() -> Vec<u8> {
    let mut text = String::from("solid cube\n");
    for corners in cube().corners() {
        let vertices = corners.map(|at| format!("vertex {} {} {}\n", at.x, at.y, at.z));
        let vertices = vertices.concat();
        text += &format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n");
    }
    text.push_str("endsolid cube\n");
    text.into_bytes()
}

/// Every format with a whole file of it.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("cube.obj", CUBE_OBJ.as_bytes().to_vec()),
        ("ascii.ply", cube_ply("ascii")),
        ("binary.PLY", cube_ply("binary_little_endian")),
        ("binary.stl", cube_stl(b"made by a test")),
        ("solid.stl", cube_stl(b"solid, yet binary")),
        ("ascii.stl", cube_ascii_stl()),
    ]
}

#[test]
fn every_format_gives_the_same_cube() {
    for (name, bytes) in files() {
        let mesh = parse(Path::new(name), &bytes, LengthUnit::Millimetres).unwrap();
        assert_eq!(
            (mesh.vertices.len(), mesh.triangles.len()),
            (8, 12),
            "{name}"
        );
        assert!((mesh.signed_volume_m3() - 1e-9).abs() < 1e-18, "{name}");
    }
}

#[test]
fn a_cut_file_is_refused() {
    for (name, bytes) in files() {
        if name == "cube.obj" {
            continue; // Any line of it may be the last.
        }
        let cut = &bytes[..bytes.len() * 3 / 4];
        let error = parsed(name, cut).unwrap_err();
        assert!(matches!(error, ReadError::Format { .. }), "{name}: {error}");
    }
}

#[test]
fn counts_that_the_file_cannot_hold_are_refused_without_reading() {
    let ply = |element: &str| {
        format!("ply\nformat binary_little_endian 1.0\n{element}\nend_header\n").into_bytes()
    };
    for element in [
        "element vertex 4000000000\nproperty float x",
        "element vertex 18446744073709551615\nproperty double x",
        "element nothing 4000000000",
    ] {
        let read = parsed("a.ply", &ply(element));
        assert!(matches!(read, Err(ReadError::Format { .. })), "{element}");
    }
    let mut stl = cube_stl(b"");
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(parsed("a.stl", &stl).is_err());
}

#[test]
fn missing_files_and_other_endings_are_refused() {
    assert!(matches!(
        read(Path::new("a.step"), LengthUnit::Metres),
        Err(ReadError::Extension)
    ));
    assert!(matches!(
        read(Path::new("missing.ply"), LengthUnit::Metres),
        Err(ReadError::Io(_))
    ));
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        file in 0_usize..6,
        cut in 0.0..=1.0_f64,
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
    ) {
        let (name, mut bytes) = files().swap_remove(file);
        for (index, byte) in damage {
            let index = index.index(bytes.len());
            bytes[index] = byte;
        }
        bytes.truncate((bytes.len() as f64 * cut) as usize);
        // Whether it reads is of no matter here.
        drop(parsed(name, &bytes));
    }
}
