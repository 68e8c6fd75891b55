//! An episode of the simulated cell: forty household objects released one by one onto one another,
//! each followed by a scan. Planning is not part of what is timed.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot run should say so at once"
)]

use std::sync::Arc;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::Isometry3;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::{Grid, Resolution};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;
use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

const ITEMS: usize = 40;

/// Samples between the positions that are tried.
const STRIDE: usize = 4;

type Release = (Arc<Model>, Isometry3<f64>);

/// The lowest pose on a surface for an item's bounding box, the nearest to the origin among equals.
fn lowest_pose(grid: &Grid, surface: &Surface, model: &Model) -> Option<Isometry3<f64>> {
    let bounds = model.mesh.bounds()?;
    let (extents_m, pitch_m) = (bounds.extents_m(), surface.pitch_m());
    let samples = |length_m: f64| (length_m / pitch_m).ceil() as usize + 1;
    let (width, depth) = (samples(extents_m.x), samples(extents_m.y));
    let highest_m = |first_x: usize, first_y: usize| {
        let rows = surface.heights_m().chunks_exact(surface.ny());
        let covered = rows.skip(first_x).take(width);
        let heights_m = covered.flat_map(|row| row.iter().skip(first_y).take(depth).copied());
        f64::from(heights_m.fold(0.0, f32::max))
    };
    let starts = |count: usize, used: usize| {
        (0..=count.saturating_sub(used))
            .step_by(STRIDE)
            .filter(move |start| start + used <= count)
    };
    let xs = starts(surface.nx(), width);
    let (z_m, x, y) = xs
        .flat_map(|x| starts(surface.ny(), depth).map(move |y| (x, y)))
        .map(|(x, y)| (highest_m(x, y), x, y))
        .filter(|(z_m, ..)| z_m + extents_m.z <= grid.container().z_m)
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    // Half a sample from the walls.
    let corner_m = |index: usize| (index as f64 + 0.5) * pitch_m;
    Some(Isometry3::translation(
        corner_m(x) - bounds.lowest.x,
        corner_m(y) - bounds.lowest.y,
        z_m - bounds.lowest.z,
    ))
}

/// The releases of an episode, planned as it goes.
fn releases(cell: &mut SimulatedCell, grid: &Grid, catalogue: &Catalogue) -> Vec<Release> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut releases = Vec::new();
    for _ in 0..4 * ITEMS {
        let surface = cell.scan_surface(grid).unwrap();
        let model = &catalogue.objects.choose(&mut random).unwrap().model;
        if let Some(pose) = lowest_pose(grid, &surface, model) {
            cell.place(model, &pose).unwrap();
            releases.push((Arc::clone(model), pose));
        }
        if releases.len() == ITEMS {
            break;
        }
    }
    releases
}

fn episode(criterion: &mut Criterion) {
    let grid = Grid::reference();
    let resolution = Resolution::reference();
    let (source, settings) = (ppnpack_household::builtin(), Settings::default());
    let catalogue = Catalogue::load(&source, &settings, &resolution, &|_, _| ()).unwrap();
    let mut cell = SimulatedCell::new(CellSettings::default()).unwrap();
    let releases = releases(&mut cell, &grid, &catalogue);

    let mut group = criterion.benchmark_group("cell");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(20));
    let name = format!("episode of {} items, with scans", releases.len());
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            cell.reset();
            for (model, pose) in &releases {
                cell.place(model, pose).unwrap();
                cell.scan_surface(&grid).unwrap();
            }
        });
    });
    group.bench_function("the same without scans", |bencher| {
        bencher.iter(|| {
            cell.reset();
            for (model, pose) in &releases {
                cell.place(model, pose).unwrap();
            }
        });
    });
    group.bench_function("scan of the full container, nothing cached", |bencher| {
        let bodies = cell.contents().into_iter();
        let poses: Vec<_> = bodies
            .map(|body| (body.model, body.container_from_item))
            .collect();
        bencher.iter_batched_ref(
            || {
                let mut fresh = SimulatedCell::new(CellSettings::default()).unwrap();
                fresh.lay_down(&poses).unwrap();
                fresh
            },
            |fresh| fresh.scan_surface(&grid).unwrap(),
            BatchSize::PerIteration,
        );
    });
    group.bench_function("clone of the full container", |bencher| {
        bencher.iter(|| cell.clone());
    });
    group.finish();
}

criterion_group!(benches, episode);
criterion_main!(benches);
