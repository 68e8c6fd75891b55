//! The golden vectors of the published heuristics: 40 single-object evaluations on the reference grid.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::fs::File;
use std::path::PathBuf;

use nalgebra::Vector3;
use ndarray::{Array0, Array2};
use ndarray_npy::NpzReader;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Heightmap;
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::{Heuristic, Weights};
use ppnpack_packing::oracle;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::stability::PublishedStability;
use ppnpack_packing::survey::survey;

struct Case {
    name: String,
    heightmap: Heightmap,
    item: Item,
    drop: Array2<i16>,
    stable: Array2<u8>,
    values: Vec<(Heuristic, Array2<f32>)>,
    distance: Array2<f32>,
}

fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/golden"
    ));
    if !folder.is_dir() {
        eprintln!("skipped: no golden vectors at {}", folder.display());
        return None;
    }
    Some(folder)
}

fn read(path: &PathBuf) -> Case {
    let mut npz = NpzReader::new(File::open(path).unwrap()).unwrap();
    let container: Array2<i16> = npz.by_name("container").unwrap();
    let top: Array2<i16> = npz.by_name("object_top").unwrap();
    let bottom: Array2<i16> = npz.by_name("object_bottom").unwrap();
    let height: Array0<i16> = npz.by_name("object_height").unwrap();
    let (nx, ny) = top.dim();
    let item = Item::new(
        "golden",
        vec![ViewSurfaces {
            nx,
            ny,
            top: top.into_iter().collect(),
            bottom: bottom.into_iter().collect(),
            underside: None,
            origin_from_corner_m: Vector3::zeros(),
            centre_of_mass_m: None,
        }],
        0.0,
    )
    .unwrap();
    assert_eq!(item.views()[0].height(), height.into_scalar());
    let mut map = |name: &str| {
        npz.by_name::<ndarray::OwnedRepr<f32>, ndarray::Ix2>(name)
            .unwrap()
    };
    Case {
        name: path.file_name().unwrap().to_string_lossy().into_owned(),
        heightmap: Heightmap::from_units(32, 32, container.into_iter().collect()).unwrap(),
        item,
        values: vec![
            (Heuristic::Sdfm, map("sdf")),
            (Heuristic::Dbl, map("dbl")),
            (Heuristic::Hm, map("hm")),
        ],
        distance: map("sdf_distance"),
        drop: npz.by_name("drop").unwrap(),
        stable: npz.by_name("stable").unwrap(),
    }
}

#[test]
fn all_golden_cases_are_met() {
    let Some(folder) = folder() else { return };
    let grid = Grid::reference();
    let weights = Weights::default();
    let mut paths: Vec<PathBuf> = folder
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    assert_eq!(paths.len(), 40);
    let mut compared = 0;
    for case in paths.iter().map(read) {
        let view = &case.item.views()[0];
        for (heuristic, expected) in &case.values {
            let surveyed = survey(&grid, &case.heightmap, view, *heuristic, &weights).unwrap();
            assert_eq!(surveyed.len(), expected.len(), "{}", case.name);
            for found in surveyed {
                let at = (found.x, found.y);
                let place = format!("{} {heuristic:?} at {at:?}", case.name);
                let placement = Placement {
                    yaw: 0,
                    x: found.x,
                    y: found.y,
                };
                let height = found.resting_height;
                if case.drop[at] < 0 {
                    // The vectors refuse a top that exactly reaches the rim; the engine accepts it.
                    let top = height + view.height();
                    assert!(top >= grid.rim(), "{place}: resting height {height}");
                    continue;
                }
                compared += 1;
                assert_eq!(height, case.drop[at], "{place}: resting height");
                let expected = f64::from(expected[at]);
                // The vectors are stored as f32, whose steps exceed the tolerance for the largest values.
                let error = (f64::from(found.value as f32) - expected).abs();
                assert!(
                    error <= 1e-3,
                    "{place}: {} instead of {expected}",
                    found.value
                );
                if *heuristic != Heuristic::Sdfm {
                    continue;
                }
                let resting = RestingPlacement {
                    placement,
                    resting_height: height,
                };
                let depth = PublishedStability::default().depth_cells(
                    &grid,
                    &case.heightmap,
                    view,
                    &resting,
                );
                if (depth - 0.5).abs() > 1e-6 {
                    assert_eq!(
                        found.is_stable,
                        case.stable[at] == 1,
                        "{place}: depth {depth}"
                    );
                }
            }
        }
        // The oracle is far slower, so it is compared on a thinned set of placements.
        for (index, expected) in case.distance.indexed_iter().step_by(29) {
            let placement = Placement {
                yaw: 0,
                x: index.0,
                y: index.1,
            };
            let height = case.drop[index];
            if height < 0 {
                continue;
            }
            let found =
                2.5 * oracle::mean_distance(&grid, &case.heightmap, view, placement, height);
            let error = (found - f64::from(*expected)).abs();
            assert!(
                error <= 1e-3,
                "{} at {index:?}: {found} instead of {expected}",
                case.name
            );
            assert_eq!(
                oracle::resting_height(&case.heightmap, view, placement),
                Some(height)
            );
        }
    }
    assert!(compared > 10_000, "only {compared} placements compared");
}
