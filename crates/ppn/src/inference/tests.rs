use std::collections::BTreeSet;

use ppnpack_model::architecture::Architecture;
use ppnpack_model::weights::to_bytes;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::kernel::item::ViewSurfaces;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::files::{all_to_plain, copy_into};
use crate::network::Parameters;

/// A network with random weights and running statistics, as a model.
fn model(architecture: &Architecture, change: impl Fn(&Parameters)) -> Model {
    tch::manual_seed(7);
    let (_, parameters) = Network::new(architecture, tch::Device::Cpu).unwrap();
    change(&parameters);
    let bytes = to_bytes(&all_to_plain(parameters.tensors()).unwrap(), None).unwrap();
    let mut card = Model::shipped().unwrap().card().clone();
    card.architecture = architecture.clone();
    card.weights_blake3 = blake3::hash(&bytes).to_hex().to_string();
    Model::new("a test", &bytes, card).unwrap()
}

fn plain(architecture: &Architecture) -> Model {
    model(architecture, |_| ())
}

/// Items with bumpy surfaces, from a few cells to larger than the container.
fn items(count: u64) -> Vec<Item> {
    let make = |seed| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let views = (0..4).map(|_| {
            let (nx, ny) = (random.random_range(1..36), random.random_range(1..20));
            let mut bottom: Vec<i16> = (0..nx * ny).map(|_| random.random_range(-1..9)).collect();
            bottom[0] = 0;
            let top = bottom
                .iter()
                .map(|bottom| bottom + random.random_range(1..40));
            let top = top.collect();
            ViewSurfaces::of_cells(nx, ny, top, bottom)
        });
        Item::new(&format!("item {seed}"), views.collect(), 1e-4).unwrap()
    };
    (0..count).map(make).collect()
}

fn heightmap(grid: &Grid, seed: u64) -> Heightmap {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let heights = (0..grid.nx() * grid.ny()).map(|_| random.random_range(0..100));
    Heightmap::from_units(grid.nx(), grid.ny(), heights.collect()).unwrap()
}

fn close(a: &[f32], b: &[f32]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-4 * (1.0 + a.abs()), "{a} and {b}");
    }
}

#[test]
fn a_batch_gives_what_single_runs_give_and_caches_change_nothing() {
    // The second admits items that need a larger canvas than others do.
    for grid in [Grid::reference(), grid([0.64, 0.23, 0.3])] {
        a_batch_gives_what_single_runs_give(&grid);
    }
}

fn grid([x_m, y_m, z_m]: [f64; 3]) -> Grid {
    let resolution = Grid::reference().resolution().clone();
    Grid::new(ContainerSize::cuboid(x_m, y_m, z_m), resolution).unwrap()
}

fn a_batch_gives_what_single_runs_give(grid: &Grid) {
    let model = plain(&Architecture::default());
    let (items, scene) = (items(5), heightmap(grid, 1));
    let all: Vec<&Item> = items.iter().collect();
    let mut batched = Inference::new(&model, grid, Device::Cpu).unwrap();
    let together = batched.score(&scene, &all).unwrap();
    let again = batched.score(&scene, &all).unwrap();
    assert_eq!(together.scores, again.scores, "from the cache");
    let cells = together.scores.len() / (4 * items.len());
    for (index, item) in items.iter().enumerate() {
        let mut single = Inference::new(&model, grid, Device::Cpu).unwrap();
        single.score(&heightmap(grid, 2), &[item]).unwrap();
        let alone = single.score(&scene, &[item]).unwrap();
        let range = 4 * index * cells..4 * (index + 1) * cells;
        close(&alone.scores, &together.scores[range.clone()]);
        assert_eq!(alone.fits, together.fits[range]);
    }
}

#[test]
fn folding_changes_nothing() {
    let grid = Grid::reference();
    let shaken = |parameters: &Parameters| {
        for (name, tensor) in parameters.tensors() {
            if name.ends_with("mean") || name.ends_with("variance") || name.ends_with("shift") {
                tch::no_grad(|| drop(tensor.shallow_clone().uniform_(0.5, 1.5)));
            }
        }
    };
    let architecture = Architecture::default();
    let model = model(&architecture, shaken);
    let items = items(3);
    let all: Vec<&Item> = items.iter().collect();
    let scene = heightmap(&grid, 3);
    let mut folded = Inference::new(&model, &grid, Device::Cpu).unwrap();
    let expected = folded.score(&scene, &all).unwrap();
    // The same with normalisation left in place.
    let mut plain = Inference::new(&model, &grid, Device::Cpu).unwrap();
    let (mut unfolded, parameters) = Network::new(&architecture, tch::Device::Cpu).unwrap();
    for (name, tensor) in parameters.tensors() {
        copy_into("a test", name, &model.tensors()[name], tensor).unwrap();
    }
    unfolded.set_training(false);
    plain.network = unfolded;
    let found = plain.score(&scene, &all).unwrap();
    close(&expected.scores, &found.scores);
}

#[test]
fn every_proposal_fits_and_no_placement_is_proposed_twice() {
    let grid = Grid::reference();
    let model = plain(&Architecture::default());
    let (items, scene) = (items(6), heightmap(&grid, 4));
    let all: Vec<&Item> = items.iter().collect();
    let mut inference = Inference::new(&model, &grid, Device::Cpu).unwrap();
    let mut resting = RestingHeights::new(&grid);
    resting.update(&scene, all.iter().copied());
    for percent in [0.02, 5.0, 100.0] {
        let share = Percent::new(percent).unwrap();
        let best = inference.best(&scene, &all, share).unwrap();
        for (item, proposed) in items.iter().zip(best) {
            let mut fitting = BTreeSet::new();
            for (yaw, (map, view)) in resting.of(item).zip(item.views()).enumerate() {
                let limit = grid.rim() - view.height();
                for (x, row) in map.rows().enumerate() {
                    let fits = row
                        .iter()
                        .enumerate()
                        .filter(|(_, height)| **height <= limit);
                    fitting.extend(fits.map(|(y, _)| Placement { yaw, x, y }));
                }
            }
            let wanted = share.of(4 * 32 * 32) as usize;
            assert_eq!(proposed.len(), wanted.min(fitting.len()), "{}", item.name());
            let distinct: BTreeSet<_> = proposed.iter().copied().collect();
            assert_eq!(distinct.len(), proposed.len());
            assert!(distinct.is_subset(&fitting));
        }
    }
}

#[test]
fn ranks_are_in_the_order_of_scores_then_places() {
    let scores = [-3.5, -1e-30, -0.0, 0.0, 1e-40, 2.0, 3e30];
    let ranked: Vec<Ranked> = scores.iter().map(|score| Ranked::new(*score, 9)).collect();
    assert!(ranked.is_sorted_by(|a, b| a < b));
    assert!(Ranked::new(1.0, 4) < Ranked::new(1.0, 5));
    assert_eq!(Ranked::new(-1.0, 123_456).index(), 123_456);
}

#[test]
fn cells_and_placements_are_one_to_one() {
    let grid = Grid::reference();
    let layout = Layout::new(&grid, 16, Symmetry::default());
    let positions = (0..layout.cells()).map(|cell| layout.position_of(cell));
    let distinct: BTreeSet<(usize, usize)> = positions.collect();
    let all = (0..layout.padded.nx).flat_map(|x| (0..layout.padded.ny).map(move |y| (x, y)));
    assert!(distinct.into_iter().eq(all));
    for item in items(4) {
        for view in item.views().iter().filter(|view| layout.admits(view)) {
            let mut seen = BTreeSet::new();
            for x in 0..=grid.nx() - view.nx() {
                for y in 0..=grid.ny() - view.ny() {
                    let cell = layout.cell_of((x, y), view);
                    assert!(cell < layout.cells() && seen.insert(cell));
                    assert_eq!(layout.corner_of(cell, view), Some((x, y)));
                }
            }
            let mut others = (0..layout.cells()).filter(|cell| !seen.contains(cell));
            assert!(others.all(|cell| layout.corner_of(cell, view).is_none()));
        }
    }
}

/// A grid whose sides are no multiples of what a network halves.
fn uneven() -> Grid {
    grid([0.41, 0.23, 0.2])
}

#[test]
fn padding_stands_for_no_placement_and_every_other_cell_for_one() {
    let grid = uneven();
    for symmetry in (0..Symmetry::COUNT).map(Symmetry::of) {
        let layout = Layout::new(&grid, 16, symmetry);
        let inside = layout.inside();
        assert_eq!(inside.len(), layout.cells());
        let cells = inside.iter().filter(|inside| **inside).count();
        assert_eq!(cells, grid.nx() * grid.ny());
        for item in items(4) {
            for view in item.views().iter().filter(|view| layout.admits(view)) {
                for x in 0..=grid.nx() - view.nx() {
                    for y in 0..=grid.ny() - view.ny() {
                        assert!(inside[layout.cell_of((x, y), view)]);
                    }
                }
            }
        }
    }
}

#[test]
fn containers_of_any_size_and_any_number_of_yaws_are_served() {
    let grid = uneven();
    let model = plain(&Architecture::default());
    let items = items(2);
    let all: Vec<&Item> = items.iter().collect();
    let mut inference = Inference::new(&model, &grid, Device::Cpu).unwrap();
    let share = Percent::new(10.0).unwrap();
    for proposed in inference.best(&heightmap(&grid, 5), &all, share).unwrap() {
        assert!(!proposed.is_empty());
    }
}

#[test]
fn weights_of_another_architecture_are_refused() {
    let grid = Grid::reference();
    let open = |card: Architecture, weights: Architecture| {
        let weights = plain(&weights);
        let tensors = to_bytes(weights.tensors(), None).unwrap();
        let mut other = weights.card().clone();
        other.architecture = card;
        let model = Model::new("a test", &tensors, other).unwrap();
        Inference::new(&model, &grid, Device::Cpu)
    };
    let narrow = Architecture {
        widths: vec![4, 4],
        ..Architecture::default()
    };
    let wide = Architecture {
        widths: vec![4, 8],
        ..Architecture::default()
    };
    let without = Architecture {
        resting_heights: false,
        ..narrow.clone()
    };
    for (card, weights, expected) in [
        (narrow.clone(), wide, "but the architecture needs"),
        (
            narrow.clone(),
            without.clone(),
            "the weights have no tensor",
        ),
        (without, narrow, "the architecture has no tensor"),
    ] {
        let error = open(card, weights).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn scores_that_are_no_numbers_are_refused() {
    let grid = Grid::reference();
    let model = plain(&Architecture::default());
    let mut inference = Inference::new(&model, &grid, Device::Cpu).unwrap();
    let (mut broken, parameters) =
        Network::new(&Architecture::default(), tch::Device::Cpu).unwrap();
    broken.set_training(false);
    tch::no_grad(|| {
        let score = &parameters.tensors()["head.score.bias"];
        drop(score.shallow_clone().fill_(f64::NAN));
    });
    inference.network = broken;
    let items = items(1);
    let share = Percent::new(5.0).unwrap();
    let error = inference
        .best(&heightmap(&grid, 6), &[&items[0]], share)
        .unwrap_err();
    assert!(error.to_string().contains("are not finite"), "{error}");
}

#[test]
fn networks_without_a_cuda_device_say_so() {
    if tch::Cuda::is_available() {
        return;
    }
    let model = plain(&Architecture::default());
    let error = Inference::new(&model, &Grid::reference(), Device::Cuda).unwrap_err();
    assert!(error.to_string().contains("no CUDA device"), "{error}");
}
