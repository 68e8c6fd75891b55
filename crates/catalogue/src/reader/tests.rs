use std::path::Path;

use proptest::prelude::*;

use super::*;

/// A unit cube as an OBJ of quadrilaterals.
const CUBE_OBJ: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn parsed(name: &str, bytes: &[u8]) -> Result<Mesh, ObjectError> {
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

/// A cube that lies on its side, as the format has heights along y.
fn cube_glb() -> Vec<u8> {
    let cube = cube();
    let vertices = cube.vertices.iter().flat_map(|at| [at.x, at.z, -at.y]);
    let indices = cube.triangles.iter().flatten();
    let mut data: Vec<u8> = indices
        .flat_map(|index| (*index as u16).to_le_bytes())
        .collect();
    data.extend(vertices.flat_map(|side| (side as f32).to_le_bytes()));
    let json = r#"{"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"children":[1],"scale":[2,2,2]},{"mesh":0,"scale":[0.5,0.5,0.5],"translation":[0,1,0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":1,"NORMAL":9},"indices":0,"material":3}]}],
        "accessors":[{"bufferView":0,"componentType":5123,"count":36,"type":"SCALAR"},
                     {"bufferView":1,"componentType":5126,"count":8,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":96}],
        "buffers":[{"byteLength":168}]}"#;
    let mut bytes = [&b"glTF\x02\0\0\0"[..], &0_u32.to_le_bytes()].concat();
    for (kind, part) in [(b"JSON", json.as_bytes()), (b"BIN\0", &data[..])] {
        bytes.extend((part.len() as u32).to_le_bytes());
        bytes.extend([&kind[..], part].concat());
    }
    bytes
}

/// A cube in two halves of ten units of the file, of which the second is the first moved.
fn cube_3mf() -> Vec<u8> {
    let cube = cube();
    let vertices = cube.vertices.iter();
    let vertices = vertices.map(|at| format!("<vertex x='{}' y='{}' z='{}'/>", at.x, at.y, at.z));
    let triangles = cube.triangles.iter();
    let triangles = triangles.map(|[a, b, c]| format!("<triangle v1='{a}' v2='{b}' v3='{c}' />"));
    let model = format!(
        "<?xml version='1.0'?><model unit='centimeter' xmlns:p='x'><resources><basematerials/>\
         <object id='1'><mesh><vertices>{}</vertices><triangles>{}</triangles></mesh></object>\
         <object id='2'><components><component objectid='1' transform='0 .1 0 -.1 0 0 0 0 .1 2 3 4'/></components>\
         </object></resources><build><item p:path='/3D/3dmodel.model' objectid='2'/></build></model>",
        vertices.collect::<String>(),
        triangles.collect::<String>()
    );
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, content) in [
        ("[Content_Types].xml", "<Types/>"),
        ("3D/3dmodel.model", model.as_str()),
    ] {
        archive.start_file(name, options).unwrap();
        std::io::Write::write_all(&mut archive, content.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
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
        ("cube.glb", cube_glb()),
        ("cube.3mf", cube_3mf()),
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
        let error = parsed(name, cut).unwrap_err().to_string();
        assert!(error.contains("file that can be read: "), "{name}: {error}");
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
        let error = parsed("a.ply", &ply(element)).unwrap_err().to_string();
        assert!(
            error.starts_with("is no PLY file that can be read: "),
            "{element}"
        );
    }
    let mut stl = cube_stl(b"");
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(parsed("a.stl", &stl).is_err());
}

#[test]
fn what_programs_of_the_field_write_is_read() {
    let obj = |from: &str, to: &str| {
        assert!(CUBE_OBJ.contains(from), "{from}");
        CUBE_OBJ.replacen(from, to, 1).into_bytes()
    };
    let before = |head: &[u8], text: &[u8]| [head, text].concat();
    let stl = String::from_utf8(cube_ascii_stl()).unwrap();
    let (binary, solid) = (cube_stl(b"made by a test"), cube_stl(b"solid, yet binary"));
    let ply = String::from_utf8(cube_ply("ascii")).unwrap();
    let ply_of = |from: &str, to: &str| ply.replace(from, to).into_bytes();
    let utf16: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(CUBE_OBJ.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    let cube = cube();
    let flat = ply.split("element face").next().unwrap();
    let strips: Vec<String> = cube
        .triangles
        .iter()
        .map(|[a, b, c]| format!("{a} {b} {c}"))
        .collect();
    let strips = format!(
        "{}element tristrips 1\nproperty list int int vertex_indices\nend_header\n{}\n{} {}\n",
        flat,
        ply.split("end_header\n")
            .nth(1)
            .unwrap()
            .lines()
            .take(8)
            .collect::<Vec<_>>()
            .join("\n"),
        4 * strips.len(),
        strips.join(" -1 ") + " -1"
    );
    let files = [
        (
            "latin-1.obj",
            before(b"# W\xfcrfel\nusemtl Gl\xe4nzend\n", CUBE_OBJ.as_bytes()),
        ),
        (
            "material.obj",
            before(
                b"mtllib none.mtl\nusemtl\nusemtl\tsteel\n",
                CUBE_OBJ.as_bytes(),
            ),
        ),
        (
            "texture.obj",
            before(
                b"vt 0.5\nvt 1 2 3 4\n",
                &obj("f 4 3 2 1", "f 4/1 3/-9 2//7 1/1/99999999999999999999"),
            ),
        ),
        ("comment.obj", obj("f 4 3 2 1", "f 4 3 2 1 # C:\\bottom\\")),
        ("continued.obj", obj("f 4 3 2 1", "f 4 3 \\\r\n 2 \\\n1")),
        ("coloured.obj", obj("v 0 0 0", "v\t0 0 0 0.5 .25 1 1")),
        ("counted-back.obj", obj("f 4 1 5 8", "f -5 -8 -4 -1")),
        ("mac.obj", CUBE_OBJ.replace('\n', "\r").into_bytes()),
        ("utf-16.obj", utf16),
        ("marked.obj", before(b"\xef\xbb\xbf", CUBE_OBJ.as_bytes())),
        (
            "free-form.obj",
            before(b"curv2 1 2\nl 1 2\np 3\nwhatever\n", CUBE_OBJ.as_bytes()),
        ),
        ("bare.stl", stl.replace("solid cube", "solid").into_bytes()),
        ("capitals.stl", stl.to_uppercase().into_bytes()),
        (
            "nan.stl",
            stl.replace("normal 0 0 0", "normal nan -nan(ind) 1.#QNAN")
                .into_bytes(),
        ),
        ("marked.stl", before(b"\xef\xbb\xbf", stl.as_bytes())),
        ("blanks.stl", before(b" \r\n\t", stl.as_bytes())),
        (
            "latin-1.stl",
            before(b"solid W\xfcrfel\nendsolid\n", stl.as_bytes()),
        ),
        ("longer.stl", before(&binary, b"made by a program")),
        ("longer-solid.stl", before(&solid, b"made by a program")),
        (
            "coloured.stl",
            cube_stl(b"solid COLOR=\x10\x20\x30\xff,MATERIAL="),
        ),
        ("bare-points.ply", ply_of(" 1 7\n", " 1. 7\n")),
        ("no-digit.ply", ply_of("\n0 ", "\n.0 ")),
        (
            "latin-1.ply",
            before(
                b"ply\ncomment W\xfcrfel\ncomment\nobj_info \xff",
                &ply.as_bytes()[3..],
            ),
        ),
        ("marked.ply", before(b"\xef\xbb\xbf", &ply_of("\n", "\r\n"))),
        ("strips.ply", strips.into_bytes()),
    ];
    for (name, bytes) in files {
        let mesh = parsed(name, &bytes).unwrap_or_else(|error| panic!("{name} {error}"));
        let (mesh, repairs) = crate::repair::repaired(mesh, LengthUnit::Metres).unwrap();
        assert_eq!((mesh.triangles.len(), repairs), (12, vec![]), "{name}");
        assert!((mesh.signed_volume_m3() - 1.0).abs() < 1e-6, "{name}");
    }
    // Beside the cube's own solid, as of a kit.
    let other = stl.replace("vertex ", "vertex 2").replace("\r", "");
    let kit = parsed("kit.stl", (stl + &other).as_bytes()).unwrap();
    assert_eq!(kit.triangles.len(), 24);
}

#[test]
fn faces_that_are_not_convex_keep_their_notch() {
    let prism = |outline: &[[i32; 2]]| {
        // Coordinates in halves, since objects are at most 5 m long.
        let count = outline.len();
        let mut text = String::new();
        for z in [0, 1] {
            let half = |[x, y]: &[i32; 2]| [*x, *y].map(|side| f64::from(side) / 2.0);
            let vertices = outline.iter().map(half);
            text.extend(vertices.map(|[x, y]| format!("v {x} {y} {z}\n")));
        }
        let face = |corners: Vec<usize>| {
            let corners = corners.iter().map(|corner| format!(" {}", corner + 1));
            format!("f{}\n", corners.collect::<String>())
        };
        text += &face((0..count).rev().collect());
        text += &face((count..2 * count).collect());
        for at in 0..count {
            let next = (at + 1) % count;
            text += &face(vec![at, next, next + count, at + count]);
        }
        let mesh = parsed("prism.obj", text.as_bytes()).unwrap();
        let (mesh, _) = crate::repair::repaired(mesh, LengthUnit::Metres).unwrap();
        let areas = mesh
            .corners()
            .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0);
        [mesh.signed_volume_m3(), areas.sum()].map(|sum: f64| (sum * 1e6).round() / 1e6)
    };
    // An angle, begun where a fan would cover its notch; a channel with corners on straight sides;
    // a star.
    let angle = [[3, 0], [3, 1], [1, 1], [1, 3], [0, 3], [0, 0]];
    assert_eq!(prism(&angle), [1.25, 8.5]);
    let channel = [
        [0, 0],
        [2, 0],
        [4, 0],
        [4, 3],
        [3, 3],
        [3, 2],
        [3, 1],
        [1, 1],
        [1, 3],
        [0, 3],
    ];
    assert_eq!(prism(&channel), [2.0, 13.0]);
    let star = [
        [3, 0],
        [1, 1],
        [0, 3],
        [-1, 1],
        [-3, 0],
        [-1, -1],
        [0, -3],
        [1, -1],
    ];
    assert_eq!(prism(&star)[0], 3.0);
}

#[test]
fn what_is_no_mesh_is_named_with_the_way_out() {
    let refused = [
        ("a.stl", "<!DOCTYPE html><html>", "a web page"),
        (
            "a.glb",
            "version https://git-lfs.github.com/spec/v1\noid sha256:0",
            "git lfs pull",
        ),
        ("a.obj", " \n", "an empty file"),
        ("a.obj", "v 0 0 0\nv 1 0 one\n", "line 2 has 'v 1 0 one'"),
        ("a.obj", "v 0 0 0\nf 0 1 1\n", "line 2 has 'f 0 1 1'"),
        (
            "a.stl",
            "solid\nfacet\nouter loop\nvertex 1 2\n",
            "'vertex 1 2' is no vertex",
        ),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\nx\n",
            "'x' is no vertex",
        ),
        ("a.3mf", "PK", "3MF"),
        ("a.glb", "glTF\x01\0\0\0\x14\0\0\0", "version 1"),
    ];
    for (name, content, reason) in refused {
        let error = parsed(name, content.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    let nan = CUBE_OBJ.replacen("v 1 0 0", "v nan 0 0", 1);
    assert!(
        parsed("nan.obj", nan.as_bytes())
            .unwrap()
            .vertices
            .iter()
            .any(|at| at.x.is_nan())
    );
}

#[test]
fn missing_files_and_other_endings_are_refused() {
    for (path, expected) in [
        ("a.step", "has an ending"),
        ("missing.ply", "cannot be read: "),
    ] {
        let error = read(Path::new(path), LengthUnit::Metres).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    }
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        file in 0_usize..8,
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
