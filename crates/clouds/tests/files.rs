//! Point cloud files: what is written comes back, and what is malformed is refused with a reason.
#![cfg(test)]

use nalgebra::Point3;
use ppnpack_clouds::{Cloud, CloudError, FormatError, MAX_POINTS, parse, read, to_pcd};
use proptest::prelude::*;

/// How points may stand in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Layout {
    PcdAscii,
    PcdBinary,
    PcdCompressed,
    PlyAscii,
    PlyLittle,
    PlyBig,
}

const LAYOUTS: [Layout; 6] = [
    Layout::PcdAscii,
    Layout::PcdBinary,
    Layout::PcdCompressed,
    Layout::PlyAscii,
    Layout::PlyLittle,
    Layout::PlyBig,
];

/// A file as another program might write it: colours before and after the coordinates, of which `z`
/// may be a double.
fn file(layout: Layout, cloud: &Cloud, has_doubles: bool) -> Vec<u8> {
    let (width, height) = (cloud.width(), cloud.height());
    let count = cloud.points_m().len();
    let (size, kind) = [(4, "float"), (8, "double")][usize::from(has_doubles)];
    let pcd = |data: &str| {
        format!(
            "# made by hand\nVERSION .7\nFIELDS rgb x y _ z\nSIZE 4 4 4 1 {size}\nTYPE U F F U F\nCOUNT 1 1 1 3 1\n\
             WIDTH {width}\nHEIGHT {height}\nPOINTS {count}\nDATA {data}\n"
        )
    };
    let ply = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment by hand\nelement camera 1\nproperty list uchar int view\n\
             element vertex {count}\nproperty float x\nproperty uchar red\nproperty float y\nproperty {kind} z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let big = layout == Layout::PlyBig;
    let float = |value: f32| match big {
        true => value.to_be_bytes(),
        false => value.to_le_bytes(),
    };
    let last = |value: f32| -> Vec<u8> {
        match (has_doubles, big) {
            (false, _) => float(value).to_vec(),
            (true, false) => f64::from(value).to_le_bytes().to_vec(),
            (true, true) => f64::from(value).to_be_bytes().to_vec(),
        }
    };
    let points = || cloud.points_m().iter();
    match layout {
        Layout::PcdAscii => {
            let line = |p: &Point3<f32>| format!("4711 {} {} 0 0 0 {}\n", p.x, p.y, p.z);
            (pcd("ascii") + &points().map(line).collect::<String>()).into_bytes()
        }
        Layout::PcdBinary => {
            let mut file = pcd("binary").into_bytes();
            for p in points() {
                file.extend([7; 4]);
                file.extend([float(p.x), float(p.y)].concat());
                file.extend([9; 3]);
                file.extend(last(p.z));
            }
            file
        }
        Layout::PcdCompressed => {
            let mut columns = vec![7; 4 * count];
            columns.extend(points().flat_map(|p| float(p.x)));
            columns.extend(points().flat_map(|p| float(p.y)));
            columns.extend(vec![9; 3 * count]);
            columns.extend(points().flat_map(|p| last(p.z)));
            let packed = packed(&columns);
            let mut file = pcd("binary_compressed").into_bytes();
            file.extend((packed.len() as u32).to_le_bytes());
            file.extend((columns.len() as u32).to_le_bytes());
            file.extend(packed);
            file
        }
        Layout::PlyAscii => {
            let line = |p: &Point3<f32>| format!("{} 255 {} {}\n", p.x, p.y, p.z);
            (ply("ascii") + "2 1 2\n" + &points().map(line).collect::<String>() + "3 0 0 0\n")
                .into_bytes()
        }
        Layout::PlyLittle | Layout::PlyBig => {
            let format = ["binary_little_endian", "binary_big_endian"][usize::from(big)];
            let mut file = ply(format).into_bytes();
            file.extend([1, 0, 0, 0, 0]);
            for p in points() {
                file.extend(float(p.x));
                file.push(255);
                file.extend(float(p.y));
                file.extend(last(p.z));
            }
            file.push(0);
            file
        }
    }
}

/// LZF: runs of equal bytes become copies, all else plain bytes.
fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    for run in bytes.chunk_by(|a, b| a == b) {
        for piece in run.chunks(200) {
            packed.extend([0, piece[0]]);
            match piece.len() - 1 {
                0 => {}
                more @ 1..=2 => packed.extend(piece[..more].iter().flat_map(|byte| [0, *byte])),
                more @ 3..=8 => packed.extend([((more - 2) << 5) as u8, 0]),
                more => packed.extend([7 << 5, (more - 9) as u8, 0]),
            }
        }
    }
    packed
}

fn any_cloud() -> impl Strategy<Value = Cloud> {
    let side = prop_oneof![9 => -10.0..10.0_f32, 1 => Just(f32::NAN)];
    let point = proptest::array::uniform3(side).prop_map(Point3::from);
    (1..8_usize, 0..8_usize).prop_flat_map(move |(width, height)| {
        proptest::collection::vec(point.clone(), width * height)
            .prop_map(move |points_m| Cloud::organised(width, points_m).unwrap())
    })
}

#[test]
fn points_at_the_lens_are_holes_and_units_are_converted() {
    let points = vec![Point3::new(-0.0, 0.0, 0.0), Point3::new(0.0, 500.0, 1250.0)];
    let cloud = Cloud::unorganised(points).unwrap().in_units_of(0.001);
    let measured: Vec<_> = cloud.measured_m().collect();
    assert_eq!(measured, [Point3::new(0.0, 0.5, 1.25)]);
    assert_eq!(cloud.points_m().len(), 2);
}

#[test]
fn comments_of_any_bytes_are_passed_over() {
    let pcd: &[u8] = b"# caf\xe9 \x00\xff\nVERSION 0.7\n# \xfe\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n1 2 3\n";
    let ply: &[u8] =
        b"ply\nformat ascii 1.0\ncomment caf\xe9 \x00\xff\nobj_info \xfe\nelement vertex 1\n\
        property float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
    for file in [pcd, ply] {
        assert_eq!(parse(file).unwrap().points_m(), [[1.0, 2.0, 3.0].into()]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_comes_back(cloud in any_cloud()) {
        prop_assert_eq!(parse(&to_pcd(&cloud)).unwrap(), cloud);
    }

    #[test]
    fn files_of_other_programs_are_read(cloud in any_cloud(), has_doubles: bool) {
        for layout in LAYOUTS {
            let read = parse(&file(layout, &cloud, has_doubles));
            // PLY has no rows.
            let is_ply = matches!(layout, Layout::PlyAscii | Layout::PlyLittle | Layout::PlyBig);
            let in_one_row = Cloud::unorganised(cloud.points_m().to_vec()).unwrap();
            let expected = if is_ply { &in_one_row } else { &cloud };
            prop_assert_eq!(&read.unwrap(), expected, "{:?}", layout);
        }
    }

    #[test]
    fn truncated_files_are_refused(
        cloud in any_cloud(),
        layout in proptest::sample::select(&LAYOUTS[..]),
        share in 0.0..1.0_f64,
    ) {
        prop_assume!(!cloud.points_m().is_empty());
        let whole = file(layout, &cloud, false);
        // What follows the last vertex is not needed, and a line's end neither; a shorter last
        // number is one too.
        let tail = match layout {
            Layout::PcdAscii => 40,
            Layout::PlyAscii => 50,
            Layout::PlyLittle | Layout::PlyBig => 1,
            _ => 0,
        };
        let length = ((whole.len() - tail) as f64 * share) as usize;
        let refused = parse(&whole[..length]);
        prop_assert!(refused.is_err(), "{:?} cut to {} of {}", layout, length, whole.len());
    }

    #[test]
    fn damaged_files_do_no_harm(
        cloud in any_cloud(),
        layout in proptest::sample::select(&LAYOUTS[..]),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut content = file(layout, &cloud, false);
        for (place, byte) in damage {
            let place = place.index(content.len());
            content[place] = byte;
        }
        if let Ok(cloud) = parse(&content) {
            prop_assert!(cloud.points_m().len() <= content.len());
        }
    }

    #[test]
    fn anything_may_follow_a_header(
        tail in proptest::collection::vec(any::<u8>(), 0..200),
        layout in proptest::sample::select(&LAYOUTS[..]),
    ) {
        let empty = Cloud::default();
        let text = String::from_utf8_lossy(&file(layout, &empty, false)).into_owned();
        let text = text.replace("WIDTH 0", "WIDTH 4").replace("HEIGHT 0", "HEIGHT 1");
        let text = text.replace("POINTS 0", "POINTS 4").replace("vertex 0", "vertex 4");
        let mut content = text.into_bytes();
        content.extend(tail);
        if let Ok(cloud) = parse(&content) {
            prop_assert_eq!(cloud.points_m().len(), 4);
        }
    }
}

/// The reason for which a text is refused.
fn refused(text: &str) -> String {
    let error = parse(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.len() < 400, "{error}");
    error
}

const PCD: &str = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n0 0 0\n";

#[test]
fn hostile_headers_are_refused_before_memory_is_taken() {
    assert!(parse(PCD.as_bytes()).is_ok());
    let changed = |from: &str, to: &str| {
        assert!(PCD.contains(from));
        refused(&PCD.replace(from, to))
    };
    let many = (MAX_POINTS + 1).to_string();
    assert!(changed("WIDTH 1", &format!("WIDTH {many}")).contains("at most"));
    assert!(changed("WIDTH 1", "WIDTH 99999999999999999999999").contains("WIDTH"));
    assert!(changed("HEIGHT 1", &format!("HEIGHT {}", u64::MAX / 3)).contains("at most"));
    let wide = changed("WIDTH 1\nHEIGHT 1\nPOINTS 1", "WIDTH 60000000");
    assert!(wide.contains("announces 60000000 points"), "{wide}");
    assert!(changed("POINTS 1", "POINTS 2").contains("WIDTH times HEIGHT"));
    assert!(changed("FIELDS x y z", "FIELDS x y y").contains("two fields 'y'"));
    assert!(changed("FIELDS x y z", "FIELDS x y w").contains("lacks"));
    assert!(changed("FIELDS x y z", "FIELDS x y z w").contains("SIZE"));
    assert!(changed("TYPE F F F", "TYPE F F I").contains("'z'"));
    assert!(changed("TYPE F F F", "TYPE F F Q").contains("'Q'"));
    assert!(changed("SIZE 4 4 4", "SIZE 4 4 3").contains("'3'"));
    assert!(changed("WIDTH 1", "COUNT 1 1 4000000000\nWIDTH 1").contains("COUNT"));
    assert!(changed("WIDTH 1", "COUNT 1 1 2\nWIDTH 1").contains("'z'"));
    assert!(changed("DATA ascii", "DATA octal").contains("octal"));
    assert!(changed("DATA ascii", "DATUM ascii").contains("DATUM"));
    assert!(changed("DATA ascii\n0 0 0\n", "").contains("no line DATA"));
    assert!(changed("0 0 0\n", "0.0 0.0\n").contains("'0.0 0.0'"));
    assert!(changed("0 0 0\n", "0 0 one\n").contains("one"));
    assert!(changed("0 0 0\n", "0 0 0 0\n").contains("3 numbers"));
    let packed = |lengths: &str| {
        let body = format!("binary_compressed\n{lengths}abcd");
        changed("ascii\n0 0 0", &body)
    };
    // Not what is announced.
    assert!(packed("\x04\0\0\0\x7f\0\0\0").contains("12 bytes"));
    assert!(packed("\x7f\0\0\0\x0c\0\0\0").contains("announces 127 packed bytes"));
    assert!(packed("\x04\0\0\0\x0c\0\0\0").contains("damaged"));

    let ply = |count: &str, kind: &str| {
        refused(&format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty {kind} x\nproperty float y\n\
             property float z\nend_header\n"
        ))
    };
    assert!(ply(&many, "float").contains("at most"));
    assert!(ply("60000000", "float").contains("60000000 elements"));
    assert!(ply("18446744073709551615", "float").contains("at most"));
    assert!(ply("1", "int").contains("'x'"));
    assert!(ply("1", "list uchar float").contains("'x'"));
    assert!(refused("ply\nformat ascii 1.0\nelement face 0\nend_header\n").contains("vertex"));
    assert!(refused("ply\n").contains("PLY"));
    assert!(refused(&format!("ply\n{}", "x ".repeat(10_000))).contains("PLY"));
}

#[test]
fn headers_of_older_versions_are_read() {
    let older = "# .PCD v.5\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\n1 2 3\n-nan nan NaN\n";
    let cloud = parse(older.as_bytes()).unwrap();
    assert_eq!(cloud.points_m()[0], Point3::new(1.0, 2.0, 3.0));
    assert!(cloud.points_m()[1].iter().all(|side| side.is_nan()));
    assert_eq!(cloud.measured_m().count(), 1);
    let windows = PCD.replace('\n', "\r\n");
    assert_eq!(parse(windows.as_bytes()).unwrap().points_m().len(), 1);
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.pcd");
    let error = read(&path).unwrap_err();
    assert!(matches!(error, CloudError::Read(..)));
    assert!(error.to_string().contains("scan.pcd"));
    std::fs::write(&path, "solid cube").unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.contains("scan.pcd") && error.contains("PCD"),
        "{error}"
    );
    let other = folder.path().join("scan.stl");
    std::fs::write(&other, "solid cube").unwrap();
    let error = read(&other).unwrap_err();
    let is_unknown = matches!(error, CloudError::Format(_, FormatError::Unknown));
    assert!(is_unknown, "{error}");
    let misnamed = folder.path().join("scan.xyz");
    std::fs::write(&misnamed, PCD).unwrap();
    let points = read(&misnamed).unwrap().points_m().len();
    assert_eq!(points, 1, "content decides");
}

#[test]
fn rows_are_whole() {
    let point = Point3::new(0.0, 0.0, 0.0);
    assert!(Cloud::organised(2, vec![point; 3]).is_err());
    assert!(Cloud::organised(0, vec![point]).is_err());
    let cloud = Cloud::organised(2, vec![point; 6]).unwrap();
    assert_eq!((cloud.width(), cloud.height()), (2, 3));
    let hole = Cloud::unorganised(vec![Point3::new(0.0, f32::INFINITY, 0.0)]).unwrap();
    assert!(hole.points_m()[0].iter().all(|side| side.is_nan()));
}
