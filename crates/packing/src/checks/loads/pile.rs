//! The content of a container as a pile: who rests on whom, and what each item carries.

use std::sync::Arc;

use nalgebra::Point2;

use super::contacts::{Gap, shares};
use super::sides::Sides;
use super::stack::{Shares, Stack};
use crate::kernel::grid::{ABSENT, Grid, Resolution};
use crate::kernel::item::ItemView;
use crate::kernel::placement::Placement;
use crate::scene::content::LyingSolid;
use crate::scene::model::raster::Raster;

/// Maximum reach of a surface above the underside of what rests on it, in metres: squares know
/// their extremes alone, and simulated bodies are not quite where they touch.
const OVERLAP_M: f32 = 0.005;

/// Content of a container as a pile, with the load of each item.
#[derive(Debug)]
pub struct Pile {
    resolution: Resolution,
    raster: Raster,
    /// The upper surface of all together in metres, and whose it is; row-major.
    ground: Vec<(f32, Option<usize>)>,
    /// Sides of the solids, in the order of the content; kept from one content to the next.
    sides: Vec<Arc<Sides>>,
    stack: Stack,
}

impl Pile {
    /// An empty container.
    pub fn new(grid: &Grid) -> Self {
        let resolution = grid.resolution().clone();
        let samples = resolution.samples_per_cell();
        let raster = Raster {
            origin: Point2::origin(),
            pitch_m: resolution.surface_pitch_m(),
            nx: grid.nx() * samples,
            ny: grid.ny() * samples,
        };
        Self {
            resolution,
            raster,
            ground: vec![(0.0, None); raster.nx * raster.ny],
            sides: Vec::new(),
            stack: Stack::default(),
        }
    }

    /// Takes over what lies in the container, in place of what lay there.
    pub fn lay_down(&mut self, solids: &[LyingSolid]) {
        let before = std::mem::take(&mut self.sides);
        let sides = solids.iter().map(|solid| {
            let known = before.iter().find(|sides| sides.is_of(solid));
            known.map_or_else(|| Arc::new(Sides::new(solid, &self.raster)), Arc::clone)
        });
        self.sides = sides.collect();
        self.ground.fill((0.0, None));
        for (index, sides) in self.sides.iter().enumerate() {
            for (x, y, heights) in sides.squares() {
                if let Some(ground) = self.ground.get_mut(x * self.raster.ny + y)
                    && heights.highest_m > ground.0
                {
                    *ground = (heights.highest_m, Some(index));
                }
            }
        }
        let masses_kg: Vec<f64> = solids.iter().map(|solid| solid.burden.mass_kg).collect();
        let sides = self.sides.iter().enumerate();
        let shares = sides.map(|(index, own)| self.shares_of(index, own));
        self.stack = Stack::new(&masses_kg, shares.collect());
    }

    /// Gives the estimated load of a solid, in kilograms.
    pub fn carried_kg(&self, solid: usize) -> f64 {
        self.stack.carried_kg.get(solid).copied().unwrap_or(0.0)
    }

    /// The mass of all that rests on a solid, wholly or in part, in kilograms.
    pub fn above_kg(&self, solid: usize) -> f64 {
        self.stack.above_kg.get(solid).copied().unwrap_or(0.0)
    }

    /// Gives the load in kilograms that an item, resting at a placement, adds to each solid.
    pub fn added_kg(&self, view: &ItemView, placement: &Placement, mass_kg: f64) -> Vec<f64> {
        let centre = view.placed_centre_of_mass_m(placement, self.resolution.cell_m());
        let shares = shares(&self.gaps_below_view(view, placement), &centre);
        self.stack.added_kg(mass_kg, &shares)
    }

    fn middle(&self, x: usize, y: usize) -> Point2<f64> {
        Point2::new(x as f64 + 0.5, y as f64 + 0.5) * self.raster.pitch_m
    }

    fn ground(&self, x: usize, y: usize) -> Option<(f32, Option<usize>)> {
        let index = (y < self.raster.ny).then_some(x * self.raster.ny + y)?;
        self.ground.get(index).copied()
    }

    fn shares_of(&self, index: usize, own: &Sides) -> Shares {
        let others = self.sides.iter().enumerate();
        let others = others.filter(|(other, sides)| *other != index && sides.may_meet(own));
        let others: Vec<(usize, &Arc<Sides>)> = others.collect();
        let gaps = own.squares().map(|(x, y, own)| {
            // The highest surface that is not above the underside.
            let mut below = (0.0, None);
            for (other, sides) in &others {
                if let Some(heights) = sides.at(x, y)
                    && heights.highest_m > below.0
                    && heights.highest_m <= own.lowest_m + OVERLAP_M
                {
                    below = (heights.highest_m, Some(*other));
                }
            }
            Gap {
                gap_m: own.lowest_m - below.0,
                at: self.middle(x, y),
                on: below.1,
            }
        });
        shares(&gaps.collect::<Vec<_>>(), &own.centre_of_mass)
    }

    /// Gives the gaps below an item: by the fine samples of its view where it has them, else by
    /// cells.
    fn gaps_below_view(&self, view: &ItemView, placement: &Placement) -> Vec<Gap> {
        let samples = self.resolution.samples_per_cell();
        let fine = view.underside();
        let fine = fine.filter(|fine| fine.samples_per_cell == samples);
        let lowest_m = |x: usize, y: usize| match fine {
            Some(fine) => fine.heights_m.get(x * fine.ny + y).copied(),
            None => {
                let bottom = view.bottom().get(x / samples * view.ny() + y / samples);
                let bottom = bottom.filter(|bottom| **bottom != ABSENT);
                bottom.map(|bottom| f32::from(*bottom) * self.resolution.height_unit_m() as f32)
            }
        };
        let (first_x, first_y) = (placement.x * samples, placement.y * samples);
        let mut gaps = Vec::new();
        for x in 0..view.nx() * samples {
            for y in 0..view.ny() * samples {
                let lowest_m = lowest_m(x, y).filter(|lowest_m| lowest_m.is_finite());
                let ground = self.ground(first_x + x, first_y + y);
                if let Some((lowest_m, (ground_m, on))) = lowest_m.zip(ground) {
                    gaps.push(Gap {
                        gap_m: lowest_m - ground_m,
                        at: self.middle(first_x + x, first_y + y),
                        on,
                    });
                }
            }
        }
        gaps
    }
}
