//! Packing a sequence, and measuring what each item carries after every placement.

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_packing::checks::check::Evidence;
use ppnpack_packing::checks::loads::Pile;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::refusal::Cause;
use ppnpack_packing::ranking::step::{Candidate, StageError};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{PackingCell, play};
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use serde::{Deserialize, Serialize};

use crate::cases::Case;
use crate::packer::{Packer, unsteady};

/// Minimum load that is kept, in kilograms.
const LEAST_KG: f64 = 1e-4;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Reading {
    pub(super) arrival: usize,
    pub(super) measured_kg: f64,
    pub(super) estimated_kg: f64,
    /// All that rests on it as estimated, wholly or in part.
    pub(super) above_kg: f64,
    /// Force that holds it up beside its weight and load: the error of the measure.
    pub(super) unbalanced_kg: f64,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct State {
    pub(super) is_still: bool,
    pub(super) readings: Vec<Reading>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) number: u32,
    pub(super) objects: Vec<usize>,
    pub(super) items: usize,
    pub(super) placed: usize,
    pub(super) meshes_m3: f64,
    pub(super) unsteady: usize,
    /// Placements that were looked at and refused by their load.
    pub(super) refused: u64,
    pub(super) states: Vec<State>,
}

pub(super) fn pack(packer: &Packer<'_>, case: &Case) -> Outcome<Run> {
    let (mut planner, cell) = packer.bench(case.seed(0))?;
    let grid = &packer.grid;
    let mut cell = MeasuredCell {
        cell,
        pile: Pile::new(grid),
        states: Vec::new(),
    };
    let items = case.sequence.candidates(&packer.catalogue);
    let how = packer.how();
    let episode = play(grid, &mut planner, &mut cell, items, how, &mut ()).or_run()?;
    let refusals = episode.refusals.iter();
    let by_load = refusals.filter(|(refusal, _)| refusal.cause == Cause::Load);
    Ok(Run {
        number: case.number,
        objects: case.sequence.objects.clone(),
        items: episode.metrics.packed.items,
        placed: cell.cell.placed().len(),
        meshes_m3: episode.metrics.packed.meshes_m3,
        unsteady: unsteady(&cell.cell),
        refused: by_load.map(|(_, count)| count).sum(),
        states: cell.states,
    })
}

/// A cell whose loads are measured, and estimated, whenever it was placed into.
struct MeasuredCell {
    cell: SimulatedPackingCell,
    pile: Pile,
    states: Vec<State>,
}

impl MeasuredCell {
    fn read(&mut self, scene: &Scene) {
        let solids = scene.content().map(|content| content.solids());
        self.pile.lay_down(solids.unwrap_or_default());
        let loads = self.cell.cell().loads();
        let contents = self.cell.contents();
        // All three are in the order in which the bodies were placed.
        let readings = contents.iter().zip(&loads).enumerate();
        let readings = readings.map(|(solid, ((arrival, _), load))| Reading {
            arrival: *arrival,
            measured_kg: load.carried_kg,
            estimated_kg: self.pile.carried_kg(solid),
            above_kg: self.pile.above_kg(solid),
            unbalanced_kg: load.unbalanced_kg,
        });
        let is_loaded =
            |reading: &Reading| reading.measured_kg.max(reading.estimated_kg) > LEAST_KG;
        self.states.push(State {
            is_still: self.cell.cell().is_still(),
            readings: readings.filter(is_loaded).collect(),
        });
    }
}

impl PackingCell for MeasuredCell {
    fn scan(&mut self) -> Result<Scene, StageError> {
        let scene = self.cell.scan()?;
        // The first scan is of the empty cell.
        if !self.cell.placed().is_empty() {
            self.read(&scene);
        }
        Ok(scene)
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        evidence: &Evidence,
    ) -> Result<(), StageError> {
        self.cell.place(item, resting, evidence)
    }

    fn is_inside(&self, arrival: usize) -> bool {
        self.cell.is_inside(arrival)
    }
}
