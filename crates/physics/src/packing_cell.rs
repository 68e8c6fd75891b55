//! The simulated cell as the cell of a packing episode.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::check::Evidence;
use ppnpack_packing::episode::PackingCell;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::item::ShapeId;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::plan::{Candidate, StageError};
use serde::{Deserialize, Serialize};

use crate::cell::SimulatedCell;
use crate::error::PhysicsError;
use crate::outcome::{BodyState, PlacedReport};
use crate::settings::CellSettings;

/// What a placement of an episode led to.
#[derive(Debug, Clone)]
pub struct Placed {
    /// The item's place in the sequence of arrivals.
    pub arrival: usize,
    /// What became of it by the end of its settling phase.
    pub report: PlacedReport,
}

/// Which of the content's heights within a cell of the grid is the cell's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Sampling {
    /// The greatest: no item is planned into another.
    #[default]
    #[serde(rename = "exact")]
    Greatest,
    /// That at the cell's middle, as a camera with one pixel per cell gives it.
    #[serde(rename = "camera")]
    Middle,
}

/// A simulated cell that packs the objects of a catalogue.
pub struct SimulatedPackingCell {
    cell: SimulatedCell,
    grid: Grid,
    models: BTreeMap<ShapeId, Arc<Model>>,
    /// By the numbers of their bodies.
    placed: Vec<Placed>,
    sampling: Sampling,
}

impl SimulatedPackingCell {
    /// An empty cell for the objects of a catalogue, scanned on this grid.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where a setting is impossible.
    pub fn new(
        settings: CellSettings,
        grid: &Grid,
        catalogue: &Catalogue,
        sampling: Sampling,
    ) -> Result<Self, PhysicsError> {
        let objects = catalogue.objects.iter();
        Ok(Self {
            cell: SimulatedCell::new(settings)?,
            grid: grid.clone(),
            models: objects
                .map(|object| (object.item.shape(), object.model.clone()))
                .collect(),
            placed: Vec::new(),
            sampling,
        })
    }

    /// What was placed so far, in order.
    pub fn placed(&self) -> &[Placed] {
        &self.placed
    }

    /// What lies in or on the container now, each with its place in the sequence of arrivals.
    pub fn contents(&self) -> Vec<(usize, BodyState)> {
        let bodies = self.cell.contents().into_iter();
        bodies
            .filter_map(|body| Some((self.placed.get(body.id.index())?.arrival, body)))
            .collect()
    }

    /// The simulated cell itself.
    pub fn cell(&self) -> &SimulatedCell {
        &self.cell
    }

    /// What placing the candidate there would lead to; the cell stays as it is.
    ///
    /// # Errors
    /// Where the candidate is not of the cell's catalogue, or its model cannot be simulated.
    pub fn try_place(
        &mut self,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<PlacedReport, StageError> {
        let (model, container_from_item) = self.planned(candidate, resting)?;
        Ok(self.cell.try_place(&model, &container_from_item)?)
    }

    fn planned(
        &self,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<(Arc<Model>, Isometry3<f64>), StageError> {
        let model = self.models.get(&candidate.item.shape());
        let pose = candidate.item.container_from_item(&self.grid, resting);
        model.cloned().zip(pose).ok_or_else(|| {
            let name = candidate.item.name();
            format!("item {name} is not in the catalogue of the simulated cell").into()
        })
    }
}

impl PackingCell for SimulatedPackingCell {
    fn scan(&mut self) -> Result<Scene, StageError> {
        let surface = self.cell.scan_surface(&self.grid)?;
        Ok(match self.sampling {
            Sampling::Greatest => Scene::from_surface(&self.grid, surface)?,
            Sampling::Middle => Scene::from_surface_at_middles(&self.grid, surface)?,
        })
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        _evidence: &Evidence,
    ) -> Result<(), StageError> {
        let (model, container_from_item) = self.planned(item, resting)?;
        let report = self.cell.place(&model, &container_from_item)?;
        self.placed.push(Placed {
            arrival: item.arrival,
            report,
        });
        Ok(())
    }

    fn is_inside(&self, arrival: usize) -> bool {
        self.contents()
            .iter()
            .any(|(placed, body)| *placed == arrival && body.inside)
    }
}
