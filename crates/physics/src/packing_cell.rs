//! The simulated cell as the cell of a packing episode.

use std::collections::BTreeMap;
use std::iter::once;
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::{CatalogueObject, Model};
use ppnpack_numbers::gaussian;
use ppnpack_packing::checks::check::Evidence;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::ShapeId;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::step::{Candidate, StageError};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::{Content, LyingSolid};
use ppnpack_packing::streams::episode::PackingCell;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::cell::SimulatedCell;
use crate::error::PhysicsError;
use crate::moves::{LastPoses, Moves};
use crate::outcome::{BodyState, PlacedReport};
use crate::settings::CellSettings;
use crate::view::{CameraSettings, CameraView};

/// The outcome of a placement of an episode.
#[derive(Debug, Clone)]
pub struct Placed {
    /// The item's place in the sequence of arrivals.
    pub arrival: usize,
    /// The report at the end of its settling phase.
    pub report: PlacedReport,
    /// All that moved by then, itself among it.
    pub moves: Moves,
}

/// The choice of a grid cell's height among the content's heights within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Sampling {
    /// The greatest: no item is planned into another.
    #[default]
    #[serde(rename = "exact")]
    Greatest,
    /// The one at the cell's middle, as a camera with one pixel per cell gives it.
    #[serde(rename = "camera")]
    Middle,
}

/// A simulated cell that packs the objects of a catalogue. Its content is posed by the items' own
/// frames, in whichever of their resting poses they were placed.
pub struct SimulatedPackingCell {
    cell: SimulatedCell,
    /// Bodies that lay there from the start.
    preloaded: usize,
    grid: Grid,
    /// Models of objects, by their shapes in all of their poses.
    models: BTreeMap<ShapeId, Arc<Model>>,
    /// Placements, by the numbers of their bodies.
    placed: Vec<Placed>,
    last_poses: LastPoses,
    sampling: Sampling,
    /// Cameras that see the cell in place of an exact scan.
    view: Option<CameraView>,
    pose_error: PoseError,
    random: ChaCha8Rng,
}

/// Standard deviations of the poses in which the content is known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseError {
    /// Deviation of the position, per axis, in metres.
    pub position_m: f64,
    /// Deviation of the rotation, per axis, in radians.
    pub rotation_rad: f64,
}

impl PoseError {
    /// Draws a pose as it is known.
    pub fn disturb(self, pose: &Isometry3<f64>, random: &mut ChaCha8Rng) -> Isometry3<f64> {
        if self == Self::default() {
            return *pose;
        }
        let mut normal = || gaussian(random.random(), random.random());
        let mut vector = |deviation: f64| Vector3::from_fn(|_, _| deviation * normal());
        let moved = Translation3::from(pose.translation.vector + vector(self.position_m));
        let turned = UnitQuaternion::from_scaled_axis(vector(self.rotation_rad));
        Isometry3::from_parts(moved, turned * pose.rotation)
    }
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
            random: ChaCha8Rng::seed_from_u64(settings.seed),
            pose_error: PoseError::default(),
            cell: SimulatedCell::new(settings)?,
            preloaded: 0,
            grid: grid.clone(),
            models: objects.flat_map(by_shape).collect(),
            placed: Vec::new(),
            last_poses: LastPoses::default(),
            sampling,
            view: None,
        })
    }

    /// Has cameras see the cell in place of an exact scan.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where a setting is impossible.
    pub fn with_cameras(mut self, settings: &CameraSettings) -> Result<Self, PhysicsError> {
        self.view = Some(CameraView::new(settings, &self.grid)?);
        Ok(self)
    }

    /// Makes its scenes know the poses of its content only so well.
    #[must_use]
    pub fn with_pose_error(mut self, pose_error: PoseError) -> Self {
        self.pose_error = pose_error;
        self
    }

    /// Lays bodies down, in place of all that is there: the container is not empty at the start.
    ///
    /// # Errors
    /// As [`SimulatedCell::lay_down`].
    pub fn lay_down(
        &mut self,
        bodies: &[(Arc<Model>, Isometry3<f64>)],
    ) -> Result<(), PhysicsError> {
        self.cell.lay_down(bodies)?;
        self.placed.clear();
        self.preloaded = bodies.len();
        Ok(())
    }

    /// Gives the placements so far, in order.
    pub fn placed(&self) -> &[Placed] {
        &self.placed
    }

    /// Gives what was placed and lies in or on the container now, each with its place in the
    /// sequence of arrivals.
    pub fn contents(&self) -> Vec<(usize, BodyState)> {
        let bodies = self.cell.contents().into_iter();
        let placed = bodies.filter_map(|body| {
            let placed = body.id.index().checked_sub(self.preloaded)?;
            Some((self.placed.get(placed)?.arrival, body))
        });
        placed.collect()
    }

    /// Gives what lay there from the start and still does.
    pub fn preloaded(&self) -> impl Iterator<Item = BodyState> {
        let bodies = self.cell.contents().into_iter();
        bodies.take_while(|body| body.id.index() < self.preloaded)
    }

    /// Gives the simulated cell itself.
    pub fn cell(&self) -> &SimulatedCell {
        &self.cell
    }

    /// Gives the model that is placed, as far as it is known, and the pose of its frame.
    fn planned(
        &self,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<(Arc<Model>, Isometry3<f64>), StageError> {
        let frame = candidate.item.container_from_item(&self.grid, resting);
        let planned = match self.models.get(&candidate.item.shape()) {
            Some(own) => frame.map(|frame| (Arc::clone(own), candidate.lying.own_frame(&frame))),
            None => candidate.model.clone().zip(frame),
        };
        planned.ok_or_else(|| {
            let name = candidate.item.name();
            format!("item {name} is not in the catalogue of the simulated cell").into()
        })
    }
}

/// Gives the model of an object, by the shapes of all of its poses.
fn by_shape(object: &CatalogueObject) -> impl Iterator<Item = (ShapeId, Arc<Model>)> {
    let further = object.poses.iter().map(|posed| posed.item.shape());
    let shapes = once(object.item.shape()).chain(further);
    shapes.map(move |shape| (shape, Arc::clone(&object.model)))
}

impl PackingCell for SimulatedPackingCell {
    fn scan(&mut self) -> Result<Scene, StageError> {
        let known = self.cell.contents().into_iter().map(|body| {
            let pose = &body.container_from_item;
            let pose = self.pose_error.disturb(pose, &mut self.random);
            LyingSolid::new(body.model, pose)
        });
        let known: Content = known.collect();
        let (cell, grid) = (&mut self.cell, &self.grid);
        if let Some(view) = &mut self.view {
            return Ok(view.scene(cell, known)?);
        }
        let scene = match self.sampling {
            Sampling::Greatest => cell.scan(grid)?,
            Sampling::Middle => Scene::from_surface_at_middles(grid, cell.scan_surface(grid)?)?,
        };
        Ok(scene.with_content(known))
    }

    fn place(
        &mut self,
        item: &Candidate,
        resting: &RestingPlacement,
        evidence: &Evidence,
    ) -> Result<(), StageError> {
        let (model, pose) = self.planned(item, resting)?;
        let report = self.cell.place(&model, &evidence.lower(pose))?;
        self.placed.push(Placed {
            arrival: item.arrival,
            report,
            moves: Moves::default(),
        });
        let contents = self.contents().into_iter();
        let poses = contents.map(|(arrival, body)| (arrival, body.container_from_item));
        let moves = self.last_poses.changed(poses);
        if let Some(placed) = self.placed.last_mut() {
            placed.moves = moves;
        }
        Ok(())
    }

    fn is_inside(&self, arrival: usize) -> bool {
        let contents = self.contents();
        let mut contents = contents.iter();
        contents.any(|(placed, body)| *placed == arrival && body.inside)
    }
}
