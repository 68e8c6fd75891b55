//! Batches: steps of a dataset as tensors.

use std::collections::BTreeMap;
use std::sync::Arc;

use ppnpack_dataset::{CandidateRecord, StepRecord};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ItemView};
use ppnpack_packing::kernel::resting::RestingHeights;
use tch::{Device, Kind, TchError, Tensor};

use crate::maps::{Layout, limit, lowest};
use crate::network::{CONTAINER_CHANNELS, RESTING_CHANNELS, VIEW_CHANNELS};
use crate::symmetry::Symmetry;

/// A batch of `S` steps with up to `B` candidates of `R` yaws each, in plain memory; `N = S B`, `L
/// = X Y`.
#[derive(Debug)]
pub(crate) struct Batch {
    steps: i64,
    candidates: i64,
    yaws: i64,
    size: (i64, i64),
    side: i64,
    possible: u64,
    /// `[S]`: the steps' sequences.
    pub(super) sequences: Vec<u32>,
    /// `[S, CONTAINER_CHANNELS, X, Y]`.
    containers: Vec<f32>,
    /// `[U, VIEW_CHANNELS, side, side]`: the views that occur.
    views: Vec<f32>,
    /// `[S B R]`: indices into the views.
    slots: Vec<i64>,
    /// `[S B R, RESTING_CHANNELS, L]`.
    resting: Vec<f32>,
    /// `[L]`: the container's cells; the others are padding.
    inside: Vec<bool>,
    /// `[S B R, L]`: where the view stays below the rim.
    fits: Vec<bool>,
    /// `[S B R, L]`: the optima per yaw.
    optimal: Vec<bool>,
    /// `[S B R, L]`: the optima over all yaws.
    best: Vec<bool>,
    /// `[S B R, L]`: what regression approximates, scaled and cut off; empty where it is not asked
    /// for.
    values: Vec<f32>,
}

/// A batch on a device.
#[derive(Debug)]
pub(crate) struct BatchTensors {
    pub(crate) containers: Tensor,
    pub(crate) views: Tensor,
    pub(crate) slots: Tensor,
    pub(crate) resting: Tensor,
    pub(crate) labels: Labels,
    /// `[S, B R]`.
    pub(crate) shape: (i64, i64),
}

/// Labels that a batch's scores are judged by; the tensors are `[N, R, L]`.
#[derive(Debug)]
pub(crate) struct Labels {
    /// `[1, 1, L]`: the cells that stand for a placement, whether it fits or not.
    pub(crate) inside: Tensor,
    pub(crate) fits: Tensor,
    pub(crate) optimal: Tensor,
    pub(crate) best: Tensor,
    pub(crate) values: Option<Tensor>,
    /// `|P|`: yaws times the container's cells.
    pub(crate) possible: u64,
}

/// Targets that a regression's scores approximate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Regression {
    /// In units of the objective; what is not valid has this target.
    pub(crate) cut_off: f32,
}

impl Regression {
    /// Target of what is not valid or is cut off: near what an untrained network says.
    const CUT_OFF: f32 = 0.0;

    /// Gives the target of a placement whose value exceeds the candidate's least by `above`: from
    /// -1 up to [`Self::CUT_OFF`]. These are scores that a network begins with, so no training goes
    /// into reaching them.
    fn of(self, above: f32) -> f32 {
        above.min(self.cut_off) / self.cut_off - 1.0
    }
}

/// Makes batches; keeps what is the same for all.
#[derive(Debug, Clone)]
pub(crate) struct BatchMaker {
    grid: Grid,
    items: Vec<Arc<Item>>,
    stride: usize,
    /// None where the loss is another.
    regression: Option<Regression>,
    resting: RestingHeights,
}

impl BatchMaker {
    pub(crate) fn new(
        grid: &Grid,
        items: &[Arc<Item>],
        stride: usize,
        regression: Option<Regression>,
    ) -> Self {
        Self {
            grid: grid.clone(),
            items: items.to_vec(),
            stride,
            regression,
            resting: RestingHeights::new(grid),
        }
    }

    /// Makes a batch of these steps, as the symmetry shows them.
    pub(crate) fn make(&mut self, steps: &[&StepRecord], symmetry: Symmetry) -> Batch {
        let layout = Layout::new(&self.grid, self.stride, symmetry);
        let yaws = self.grid.resolution().yaws().count();
        let candidates = steps.iter().map(|step| step.candidates.len()).max();
        let candidates = candidates.unwrap_or(0);
        let first_slots = self.number_objects(steps);
        let (views, side) = layout.write_views(&self.views(&first_slots), self.stride);
        let cells = layout.cells();
        let maps = steps.len() * candidates * yaws;
        let mut batch = Batch {
            steps: steps.len() as i64,
            candidates: candidates as i64,
            yaws: yaws as i64,
            size: (layout.padded.nx as i64, layout.padded.ny as i64),
            side: side as i64,
            possible: (yaws * self.grid.nx() * self.grid.ny()) as u64,
            sequences: steps.iter().map(|step| step.sequence).collect(),
            containers: vec![0.0; steps.len() * CONTAINER_CHANNELS as usize * cells],
            views,
            slots: vec![0; maps],
            resting: vec![0.0; maps * RESTING_CHANNELS as usize * cells],
            inside: layout.inside(),
            fits: vec![false; maps * cells],
            optimal: vec![false; maps * cells],
            best: vec![false; maps * cells],
            values: vec![0.0; self.regression.map_or(0, |_| maps * cells)],
        };
        let containers = batch
            .containers
            .chunks_exact_mut(CONTAINER_CHANNELS as usize * cells);
        for (step, container) in steps.iter().zip(containers) {
            layout.write_container(&step.heightmap, container);
        }
        for (index, step) in steps.iter().enumerate() {
            let first = index * candidates * yaws;
            self.write_step(&layout, &first_slots, step, first, &mut batch);
        }
        batch
    }

    /// Gives the index of the first view of each object that occurs.
    fn number_objects(&self, steps: &[&StepRecord]) -> BTreeMap<usize, usize> {
        let candidates = steps.iter().flat_map(|step| &step.candidates);
        let mut slots: BTreeMap<usize, usize> = candidates
            .map(|candidate| (candidate.object as usize, 0))
            .collect();
        let mut next = 0;
        for (object, slot) in &mut slots {
            *slot = next;
            next += self.items.get(*object).map_or(0, |item| item.views().len());
        }
        slots
    }

    /// Gives the views of the objects that occur, in the order of their slots.
    fn views(&self, first_slots: &BTreeMap<usize, usize>) -> Vec<&ItemView> {
        let objects = first_slots.keys();
        let items = objects.filter_map(|object| self.items.get(*object));
        items.flat_map(|item| item.views()).collect()
    }

    /// Writes a step's candidates from the map with index `first` on.
    fn write_step(
        &mut self,
        layout: &Layout,
        first_slots: &BTreeMap<usize, usize>,
        step: &StepRecord,
        first: usize,
        batch: &mut Batch,
    ) {
        let cells = layout.cells();
        let channels = RESTING_CHANNELS as usize * cells;
        let (nx, ny) = (self.grid.nx(), self.grid.ny());
        let Ok(heightmap) = Heightmap::from_units(nx, ny, step.heightmap.clone()) else {
            return;
        };
        let held = |candidate: &CandidateRecord| self.items.get(candidate.object as usize).cloned();
        let items: Vec<Option<Arc<Item>>> = step.candidates.iter().map(held).collect();
        let present = items.iter().flatten().map(|item| &**item);
        self.resting.update(&heightmap, present);
        let yaws = batch.yaws as usize;
        for (position, (candidate, item)) in step.candidates.iter().zip(items).enumerate() {
            let Some(item) = item else { continue };
            let lowest = lowest(&self.grid, &item, self.resting.of(&item));
            let slot = first_slots.get(&(candidate.object as usize)).copied();
            let slot = slot.unwrap_or(0);
            let views = item.views().iter().zip(self.resting.of(&item));
            for (yaw, (view, heights)) in views.enumerate() {
                let map = first + position * yaws + yaw;
                let range = map * cells..(map + 1) * cells;
                if let Some(entry) = batch.slots.get_mut(map) {
                    *entry = (slot + yaw) as i64;
                }
                if let (Some(resting), Some(fits)) = (
                    batch.resting.get_mut(map * channels..(map + 1) * channels),
                    batch.fits.get_mut(range.clone()),
                ) {
                    let limit = limit(&self.grid, view);
                    layout.write_resting(view, heights, limit, lowest, resting, fits);
                }
                let optima = candidate.yaws.get(yaw);
                let optima = optima.map_or(&[][..], |optima| &optima.placements);
                if let Some(optimal) = batch.optimal.get_mut(range.clone()) {
                    let corners = optima.iter().map(|at| (at.x.into(), at.y.into()));
                    mark(layout, view, corners, optimal);
                }
                if let Some(best) = batch.best.get_mut(range.clone()) {
                    let of_yaw = candidate.best().filter(|placement| placement.yaw == yaw);
                    let corners = of_yaw.map(|placement| (placement.x, placement.y));
                    mark(layout, view, corners, best);
                }
                if let (Some(regression), Some(values), Some(kept)) = (
                    self.regression,
                    batch.values.get_mut(range),
                    candidate.values.as_ref(),
                ) {
                    values.fill(Regression::CUT_OFF);
                    let Some(kept) = kept.yaws().get(yaw) else {
                        continue;
                    };
                    let along_y = kept.size().1.max(1);
                    for (index, above) in kept.all_above_best().enumerate() {
                        let at = layout.cell_of((index / along_y, index % along_y), view);
                        if let Some(entry) = values.get_mut(at) {
                            *entry = regression.of(above);
                        }
                    }
                }
            }
        }
    }
}

fn mark(
    layout: &Layout,
    view: &ItemView,
    corners: impl Iterator<Item = (usize, usize)>,
    out: &mut [bool],
) {
    for corner in corners {
        if let Some(entry) = out.get_mut(layout.cell_of(corner, view)) {
            *entry = true;
        }
    }
}

impl Batch {
    /// Counts the batch's steps.
    pub(crate) fn len(&self) -> usize {
        self.steps as usize
    }

    /// Gives the sequence of a candidate, by its index among all of the batch.
    pub(crate) fn sequence_of(&self, candidate: usize) -> Option<u32> {
        let step = candidate.checked_div(self.candidates as usize)?;
        self.sequences.get(step).copied()
    }

    /// Copies the batch to a device.
    pub(crate) fn to(&self, device: Device) -> Result<BatchTensors, TchError> {
        let (nx, ny) = self.size;
        let maps = self.steps * self.candidates * self.yaws;
        let floats = |values: &[f32], shape: &[i64]| {
            Tensor::f_from_slice(values)?.f_view(shape)?.f_to(device)
        };
        let per_candidate = [self.steps * self.candidates, self.yaws, nx * ny];
        let mask = |values: &[bool]| {
            Tensor::f_from_slice(values)?
                .f_view(per_candidate)?
                .f_to(device)
        };
        let has_values = !self.values.is_empty();
        let values = has_values.then(|| floats(&self.values, &per_candidate));
        Ok(BatchTensors {
            containers: floats(&self.containers, &[self.steps, CONTAINER_CHANNELS, nx, ny])?,
            views: floats(&self.views, &[-1, VIEW_CHANNELS, self.side, self.side])?,
            slots: Tensor::f_from_slice(&self.slots)?.f_to(device)?,
            resting: floats(&self.resting, &[maps, RESTING_CHANNELS, nx * ny])?,
            labels: Labels {
                inside: Tensor::f_from_slice(&self.inside)?
                    .f_view([1, 1, -1])?
                    .f_to(device)?,
                fits: mask(&self.fits)?,
                optimal: mask(&self.optimal)?,
                best: mask(&self.best)?,
                values: values.transpose()?,
                possible: self.possible,
            },
            shape: (self.steps, self.candidates * self.yaws),
        })
    }
}

impl BatchTensors {
    /// Gives the named tensors, to look at a batch that went wrong.
    pub(crate) fn named(&self) -> Result<Vec<(&'static str, Tensor)>, TchError> {
        Ok(vec![
            ("containers", self.containers.shallow_clone()),
            ("views", self.views.shallow_clone()),
            ("slots", self.slots.f_to_kind(Kind::Float)?),
            ("resting", self.resting.shallow_clone()),
            ("fits", self.labels.fits.f_to_kind(Kind::Float)?),
            ("optimal", self.labels.optimal.f_to_kind(Kind::Float)?),
            ("best", self.labels.best.f_to_kind(Kind::Float)?),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regression_approximates_values_above_the_optimum() {
        let regression = Regression { cut_off: 40.0 };
        let of = |above| (regression.of(above) + 1.0) * 40.0;
        assert_eq!(
            [0.0, 12.0, 90.0, f32::INFINITY].map(of),
            [0.0, 12.0, 40.0, 40.0]
        );
    }
}
