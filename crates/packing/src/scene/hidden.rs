//! Hidden samples of a surface: what lies there by what is known beside the picture.
//!
//! A sensor bounds what it does not see ([`Surface::has_bounds`]). A hidden sample is as high as
//! known solids, with a margin; seen before, where nothing was placed or moved since, it is as it
//! was. Neither raises a bound. A seen sample may hold less of a solid's edge than a sensor
//! resolves: it is as high as the solid where the picture shows that beside it.

use crate::kernel::grid::Grid;
use crate::kernel::heightmap::{Heightmap, Surface};
use crate::scene::Scene;
use crate::scene::content::{Content, LyingSolid};
use crate::scene::model::mesh::Bounds;
use crate::scene::model::raster::raise_surface;

/// How much higher than a known solid a hidden sample may be, in metres: how well poses are found.
const MARGIN_M: f64 = 0.003;

/// Maximum depth of a seen sample below a solid whose edge it may hold unresolved, in metres.
const LIP_M: f64 = 0.002;

/// Maximum difference of a sample from a solid whose edge may be in the sample beside, in metres.
const EDGE_M: f64 = 0.005;

/// A solid whose origin moved by more than this, in metres, lies elsewhere.
const MOVED_M: f64 = 0.001;

/// A solid that turned by more than this, in radians, lies elsewhere.
const TURNED_RAD: f64 = 0.01;

/// Reach of a solid that moved: what is within this may have been touched, in metres.
const REACH_M: f64 = 0.005;

/// The last picture of a container, with what lay there.
#[derive(Debug, Clone, Default)]
pub struct SceneMemory {
    last: Option<Remembered>,
}

#[derive(Debug, Clone)]
struct Remembered {
    surface: Surface,
    solids: Vec<LyingSolid>,
}

impl SceneMemory {
    /// Forgets the last picture, as when the container was exchanged.
    pub fn clear(&mut self) {
        self.last = None;
    }

    /// Gives the hidden samples of a scene the heights of what is known to lie there. With content
    /// that is unknown or partial only the bounds count. Remembers the result for the next picture.
    pub fn complete(&mut self, grid: &Grid, scene: Scene) -> Scene {
        let known = scene.content().filter(|content| !content.is_partial());
        let (Some(surface), Some(content)) = (scene.surface(), known) else {
            self.clear();
            return scene;
        };
        let solids = content.solids().to_vec();
        let mut surface = surface.clone();
        let mut heightmap = scene.heightmap().clone();
        if surface.has_bounds() {
            let before = self.last.as_ref();
            let before = before.filter(|last| last.surface.has_size_of(&surface));
            let completed = complete(grid, &surface, content, before);
            heightmap = changed(grid, &heightmap, &surface, &completed);
            surface = completed;
        }
        self.last = Some(Remembered {
            surface: surface.clone(),
            solids,
        });
        scene.with_heightmap(heightmap).with_surface(surface)
    }
}

fn complete(
    grid: &Grid,
    surface: &Surface,
    content: &Content,
    before: Option<&Remembered>,
) -> Surface {
    let mut known = Surface::empty(grid);
    for solid in content.solids() {
        raise_surface(&solid.model.mesh, &solid.container_from_item, &mut known);
    }
    let is_same = before.map(|before| before.is_same(surface, content.solids()));
    let (margin_m, lip_m, edge_m) = (MARGIN_M as f32, LIP_M as f32, EDGE_M as f32);
    let mut heights_m = surface.heights_m().to_vec();
    let mut support_m = surface.support_m().to_vec();
    let samples = heights_m.iter_mut().zip(&mut support_m).enumerate();
    for (sample, (height_m, held_m)) in samples {
        let (solid_m, _) = known.at(sample);
        if height_m == held_m {
            if solid_m > *height_m + lip_m && surface.highest_around(sample) >= solid_m - edge_m {
                (*height_m, *held_m) = (solid_m, solid_m);
            }
            continue;
        }
        let remembered = before.zip(is_same.as_ref()).and_then(|(before, is_same)| {
            is_same.get(sample)?.then_some(before.surface.at(sample))
        });
        let (least_m, most_m) = remembered.unwrap_or((solid_m, solid_m + margin_m));
        *height_m = height_m.min(most_m);
        *held_m = least_m.min(*height_m);
    }
    surface.clone().with_heights(heights_m, support_m)
}

/// The cells of changed samples, as high as the highest of their samples now.
fn changed(
    grid: &Grid,
    heightmap: &Heightmap,
    surface: &Surface,
    completed: &Surface,
) -> Heightmap {
    let samples = grid.resolution().samples_per_cell();
    let mut heightmap = heightmap.clone();
    let both = surface.heights_m().iter().zip(completed.heights_m());
    for (sample, (before_m, after_m)) in both.enumerate() {
        let (x, y) = (
            sample / surface.ny() / samples,
            sample % surface.ny() / samples,
        );
        let height = || {
            let within = |cell: usize| cell * samples..(cell + 1) * samples;
            let height_m = completed.highest_in(within(x), within(y));
            grid.resolution().units_above(f64::from(height_m))
        };
        if after_m < before_m {
            heightmap.lower(x, y, height());
        } else if after_m > before_m {
            heightmap.raise(x, y, height());
        }
    }
    heightmap
}

impl Remembered {
    /// Per sample whether nothing that lay or lies around it moved, came or went since.
    fn is_same(&self, surface: &Surface, solids: &[LyingSolid]) -> Vec<bool> {
        let is_in = |solid: &LyingSolid, others: &[LyingSolid]| {
            others.iter().any(|other| is_in_place(solid, other))
        };
        let gone = self.solids.iter().filter(|solid| !is_in(solid, solids));
        let came = solids.iter().filter(|solid| !is_in(solid, &self.solids));
        let mut is_same = vec![true; surface.heights_m().len()];
        for bounds in gone.chain(came).filter_map(bounds) {
            let index = |at_m: f64| (at_m.max(0.0) / surface.pitch_m()) as usize;
            let along = |axis: usize, count: usize| {
                let first = index(bounds.lowest[axis] - REACH_M);
                first..(index(bounds.highest[axis] + REACH_M) + 1).min(count)
            };
            for x in along(0, surface.nx()) {
                for y in along(1, surface.ny()) {
                    if let Some(is_same) = is_same.get_mut(x * surface.ny() + y) {
                        *is_same = false;
                    }
                }
            }
        }
        is_same
    }
}

/// Whether two solids are one that lies where it lay.
pub(crate) fn is_in_place(one: &LyingSolid, other: &LyingSolid) -> bool {
    let (from, to) = (&one.container_from_item, &other.container_from_item);
    one.model.name == other.model.name
        && (from.translation.vector - to.translation.vector).norm() <= MOVED_M
        && from.rotation.angle_to(&to.rotation) <= TURNED_RAD
}

pub(crate) fn bounds(solid: &LyingSolid) -> Option<Bounds> {
    solid
        .model
        .mesh
        .transformed(&solid.container_from_item)
        .bounds()
}
