//! Rasterising the household set, and making the items of a whole catalogue from it.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot run should say so at once"
)]

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::Isometry3;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_catalogue::raster::raise_surface;
use ppnpack_catalogue::views;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::Surface;

fn raster(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("raster");
    group.sample_size(20);
    let reference = Resolution::reference();
    let catalogue = Catalogue::load(
        &ppnpack_household::builtin(),
        &Settings::default(),
        &reference,
        &|_, _| {},
    )
    .unwrap();
    let largest = catalogue.objects.iter().max_by(|a, b| {
        a.model
            .mesh
            .triangles
            .len()
            .cmp(&b.model.mesh.triangles.len())
    });
    let model = largest.unwrap().model.clone();
    let pose = Isometry3::translation(0.16, 0.16, 0.0);
    for (cell_m, yaws, name) in [(0.01, 4, "1 cm, 4 yaws"), (0.0025, 16, "2.5 mm, 16 yaws")] {
        let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap()).unwrap();
        let grid = Grid::new(ContainerSize::REFERENCE, resolution.clone()).unwrap();
        let triangles = model.mesh.triangles.len();
        let label = format!("surface of {}, {triangles} triangles", model.name);
        group.bench_function(BenchmarkId::new(label, name), |bencher| {
            bencher.iter_batched_ref(
                || Surface::empty(&grid),
                |surface| raise_surface(&model.mesh, &pose, surface),
                BatchSize::SmallInput,
            );
        });
        group.bench_function(BenchmarkId::new("views of one item", name), |bencher| {
            bencher.iter(|| views::item(&model, &resolution).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, raster);
criterion_main!(benches);
