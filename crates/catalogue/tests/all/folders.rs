//! Folders of mesh files, good and bad.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Isometry3;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, CatalogueError, Settings, Source};
use ppnpack_catalogue::report::inspect;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::Resolution;

/// A box of 30 x 50 x 20 units of length.
const BOX: &str = "\
v 0 0 0\nv 30 0 0\nv 30 50 0\nv 0 50 0\nv 0 0 20\nv 30 0 20\nv 30 50 20\nv 0 50 20\n\
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::write(directory.path().join(name), content).unwrap();
    }
    directory
}

fn settings() -> Settings {
    Settings {
        unit: LengthUnit::Millimetres,
        cache: CacheDir::Nowhere,
        ..Settings::default()
    }
}

fn load(path: &Path) -> Result<Catalogue, CatalogueError> {
    load_with(path, &settings())
}

fn load_with(path: &Path, settings: &Settings) -> Result<Catalogue, CatalogueError> {
    let source = Source::Folder(path.to_owned());
    Catalogue::load(&source, settings, &Resolution::reference(), &|_, _| ())
}

fn names(catalogue: &Catalogue) -> Vec<&str> {
    let objects = catalogue.objects.iter();
    objects.map(|object| object.model.name.as_str()).collect()
}

#[test]
fn files_come_in_the_order_of_their_names() {
    let directory = folder(&[("b.obj", BOX), ("a.OBJ", BOX), ("readme.txt", "no mesh")]);
    let catalogue = load(directory.path()).unwrap();
    assert_eq!(names(&catalogue), ["a", "b"]);
    assert_eq!(catalogue.find("b").map(|(index, _)| index), Some(1));
    assert!(catalogue.find("c").is_none());
    let view = &catalogue.get(0).unwrap().item.views()[0];
    assert_eq!((view.nx(), view.ny(), view.height()), (3, 5, 10));
}

#[test]
fn the_table_gives_order_names_units_and_masses() {
    let table = "file,licence,index,name,unit,mass_kg,carries_kg\n\
                 box.obj,MIT,1,large,cm,,\nbox.obj,MIT,0,small,,0.25,1.5\n";
    let files = [
        ("box.obj", BOX),
        ("objects.csv", table),
        ("unlisted.obj", ""),
    ];
    let directory = folder(&files);
    let catalogue = load(directory.path()).unwrap();
    assert_eq!(names(&catalogue), ["small", "large"]);
    let models = catalogue.models();
    assert!((models[0].mass.mass_kg - 0.25).abs() < 1e-12);
    assert!((models[1].volume_m3 - 0.03).abs() < 1e-9);
    assert!((models[1].mass.mass_kg - 12.0).abs() < 1e-6);
    let carry_kg: Vec<_> = models.iter().map(|model| model.carries_kg).collect();
    assert_eq!(carry_kg, [Some(1.5), None]);
}

#[test]
fn tables_of_spreadsheets_are_read() {
    let tables = [
        "\u{feff}File,Mass_kg,note\r\nbox.obj,0.25,\r\n,,\r\n\r\n",
        "file;mass_kg;note\nbox.obj;0,25;a, b\n;;\n",
        "file\tnote\tmass_kg\nbox.obj\t\t0,25\n",
    ];
    for table in tables {
        let directory = folder(&[("box.obj", BOX), ("objects.csv", table)]);
        let models = load(directory.path()).unwrap().models();
        assert_eq!(models.len(), 1, "{table}");
        assert!((models[0].mass.mass_kg - 0.25).abs() < 1e-12, "{table}");
    }
}

#[test]
fn files_that_cannot_be_used_are_left_out_where_that_is_wished() {
    let wished = Settings {
        skip_unusable: true,
        ..settings()
    };
    let directory = folder(&[("a.obj", "f"), ("b.obj", BOX), ("c.stl", "<html>")]);
    assert!(load(directory.path()).is_err());
    let catalogue = load_with(directory.path(), &wished).unwrap();
    assert_eq!(names(&catalogue), ["b"]);
    let all_bad = folder(&[("a.obj", "v")]);
    assert!(load_with(all_bad.path(), &wished).is_err());
}

#[test]
fn mistakes_in_the_table_name_their_line() {
    let table = |lines: &str| {
        let directory = folder(&[("a.obj", BOX), ("b.obj", BOX), ("objects.csv", lines)]);
        load(directory.path()).unwrap_err().to_string()
    };
    let wrong = [
        (
            "index,name,file\n0,a,a.obj\n0,b,b.obj\n",
            "objects.csv:3: the index 0",
        ),
        (
            "index,name,file\n0,a,a.obj\n2,b,b.obj\n",
            "objects.csv:3: no line has the index 1",
        ),
        (
            "index,name,file\n0,a,c.obj\n",
            "objects.csv:2: the file 'c.obj' is not there",
        ),
        (
            "index,name,file,unit\n0,a,a.obj,ell\n",
            "objects.csv:2: 'ell' is no unit",
        ),
        (
            "file,mass_kg\na.obj,1\nb.obj,-1\n",
            "objects.csv:3: the mass of -1 kg",
        ),
        (
            "file,carries_kg\na.obj,0\nb.obj,-1\n",
            "objects.csv:3: carries_kg is -1",
        ),
        ("index,name\n0,a\n", "the column 'file' is needed"),
        (
            "file,mass\na.obj,1\n",
            "objects.csv:1: the column 'mass' is not read: call it 'mass_kg'",
        ),
        ("file,inde\na.obj,0\n", "call it 'index'"),
        ("index,file\nx,a.obj\n", "objects.csv:2: "),
        ("index,file\n0,a.obj,too,many\n", "objects.csv:2: "),
        (
            "name,file\na,a.obj\na,b.obj\n",
            "the name 'a' stands for both",
        ),
    ];
    for (lines, expected) in wrong {
        let error = table(lines);
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn folders_without_objects_are_refused() {
    let directory = folder(&[("readme.txt", "")]);
    let missing = directory.path().join("missing");
    let twice = folder(&[("a.obj", BOX), ("a.stl", "")]);
    for (path, expected) in [
        (directory.path(), "holds no .ply"),
        (&missing, "is no folder"),
        (twice.path(), "the name 'a' stands for both"),
    ] {
        let refused = load(path).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
}

#[test]
fn all_bad_files_are_named_and_the_good_ones_reported() {
    let open = BOX.replace("f 4 3 2 1\n", "");
    let files = [
        ("a.obj", BOX),
        ("b.stl", "solid"),
        ("c.obj", open.as_str()),
        ("d.ply", "ply\n"),
    ];
    let directory = folder(&files);
    let text = load(directory.path()).unwrap_err().to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    for (line, expected) in
        lines
            .iter()
            .zip(["b.stl is", "c.obj is not closed: 4 edges", "d.ply is"])
    {
        assert!(line.contains(expected), "{text}");
    }
    let source = Source::Folder(directory.path().to_owned());
    let reports = inspect(&source, &settings()).unwrap();
    assert_eq!(reports.len(), 4);
    let model = &reports[0].outcome.as_ref().unwrap().model;
    assert_eq!(model.mesh.triangles.len(), 12);
    assert_eq!((model.pieces.len(), model.resting_poses.len()), (1, 6));
    assert!((model.mesh.bounds().unwrap().extents_m().y - 0.05).abs() < 1e-9);
    assert!(reports[1..].iter().all(|report| report.outcome.is_err()));
}

#[test]
fn progress_counts_to_the_total() {
    let directory = folder(&[("a.obj", BOX), ("b.obj", BOX), ("c.obj", BOX)]);
    let most = AtomicUsize::new(0);
    let source = Source::Folder(directory.path().to_owned());
    let count = |done: usize, total: usize| {
        assert_eq!(total, 3);
        most.fetch_max(done, Ordering::Relaxed);
    };
    Catalogue::load(&source, &settings(), &Resolution::reference(), &count).unwrap();
    assert_eq!(most.into_inner(), 3);
}

#[test]
fn the_hash_tells_catalogues_apart() {
    let hash = |content: &str| {
        load(folder(&[("a.obj", content)]).path())
            .unwrap()
            .content_hash()
    };
    assert_eq!(hash(BOX), hash(BOX));
    assert_ne!(hash(BOX), hash(&BOX.replace("20", "21")));
}

#[test]
fn an_object_may_be_packed_in_further_poses() {
    let directory = folder(&[("a.obj", BOX)]);
    let with_poses = |poses: usize| {
        let settings = Settings {
            poses,
            ..settings()
        };
        load_with(directory.path(), &settings).unwrap()
    };
    let (one, three) = (with_poses(1), with_poses(3));
    assert_eq!(
        one.content_hash(),
        load(directory.path()).unwrap().content_hash()
    );
    assert_ne!(one.content_hash(), three.content_hash());
    assert_eq!(one.objects[0].candidates(7).len(), 1);
    assert_eq!(with_poses(2).objects[0].candidates(7).len(), 2);

    let object = &three.objects[0];
    let candidates = object.candidates(7);
    let heights = [10, 15, 25];
    assert_eq!(candidates.len(), heights.len());
    for (pose, (candidate, height)) in candidates.iter().zip(heights).enumerate() {
        assert_eq!((candidate.arrival, candidate.pose), (7, pose));
        assert_eq!(candidate.item.views()[0].height(), height);
        assert_eq!(&**candidate.item.name(), "a");
        let turned = candidate.model.as_ref().unwrap();
        let own_frame = candidate.lying.own_frame(&Isometry3::identity());
        let vertices = object.model.mesh.vertices.iter();
        for (own, turned) in vertices.zip(&turned.mesh.vertices) {
            assert!((own_frame * own - turned).norm() < 1e-12);
        }
    }
}

#[test]
fn two_loads_at_once_share_a_cache() {
    let directory = folder(&[("a.obj", BOX), ("b.obj", BOX)]);
    let cached = || Settings {
        cache: CacheDir::At(directory.path().join("cache")),
        ..settings()
    };
    let hash = || {
        let catalogue = load_with(directory.path(), &cached());
        catalogue.unwrap().content_hash()
    };
    let hashes: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(hash)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    assert!(hashes.windows(2).all(|pair| pair[0] == pair[1]));
    // Both files hold the same mesh.
    let kept = fs::read_dir(directory.path().join("cache")).unwrap();
    assert_eq!(kept.count(), 1);
    assert_eq!(hash(), hashes[0]);
}
