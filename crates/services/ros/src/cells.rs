//! The cells that are there, and their faces.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use ppnpack_ros::Node;
use ppnpack_ros::names::{self, Name};
use ppnpack_service::Shutdown;
use ppnpack_service::alive::{self, Found};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Client;
use ppnpack_view::PlannedScenes;
use ppnpack_wire::keys::{Cell, Service};

use crate::cell::bridge::BridgeFace;
use crate::cell::perception::PerceptionFace;
use crate::cell::planner::PlannerFace;
use crate::error::FaceError;
use crate::frames::Frames;
use crate::requests::Requests;
use crate::settings::Settings;

/// How often it is looked for cells.
const LOOKED_FOR_EVERY: Duration = Duration::from_secs(1);

/// How long the answers to that may take.
const PATIENCE: Duration = Duration::from_millis(500);

/// Cells and containers that have a face at most.
const MOST_CELLS: usize = 1_000;

/// What all cells share.
pub(crate) struct Common {
    pub(crate) process: Process,
    pub(crate) node: Node,
    pub(crate) requests: Requests,
    pub(crate) frames: Arc<Frames>,
    /// That of the service, which may end before the process does.
    pub(crate) shutdown: Shutdown,
    pub(crate) working: Working,
}

/// Each goal that is carried out has it: where all are dropped, so that its channel is closed, none is.
pub(crate) type Working = Arc<SyncSender<Infallible>>;

/// The cells and their faces.
pub(crate) struct Cells {
    common: Common,
    namespace: Name,
    world_from_container: BTreeMap<Cell, Isometry3<f64>>,
    /// Who has which name in ROS: what is asked under one must reach one cell alone.
    names: BTreeMap<Name, Cell>,
    cells: BTreeMap<Cell, CellFace>,
    /// Whether there were more, which is said once.
    is_full: bool,
    scenes: PlannedScenes,
    looked_at: Option<Instant>,
}

/// A cell: what it has of services, each with its topics. It has none where another one has its name.
#[derive(Default)]
struct CellFace {
    bridge: Option<BridgeFace>,
    perception: Option<PerceptionFace>,
    planner: Option<PlannerFace>,
    /// Why it was not passed on when that was last tried, which is said once.
    fault: Option<String>,
}

impl Cells {
    pub(crate) fn new(
        process: &Process,
        node: &Node,
        settings: &Settings,
        shutdown: &Shutdown,
        working: Working,
    ) -> Result<Self, FaceError> {
        let placed = settings.containers.iter().filter_map(|(cell, pose)| {
            // They are checked.
            Some((Cell::new(cell).ok()?, pose.pose().ok()?))
        });
        let session = process.session();
        Ok(Self {
            common: Common {
                requests: Requests::new(Client::new(session), settings.request_limit()),
                frames: Arc::new(Frames::new(node)?),
                process: process.clone(),
                node: node.clone(),
                shutdown: shutdown.clone(),
                working,
            },
            namespace: Name::new(&settings.namespace)?,
            world_from_container: placed.collect(),
            names: BTreeMap::new(),
            cells: BTreeMap::new(),
            is_full: false,
            scenes: PlannedScenes::new(session),
            looked_at: None,
        })
    }

    /// Looks which cells there are, and passes on what is new and read.
    pub(crate) fn advance(&mut self) {
        let now = Instant::now();
        if self.looked_at.is_none_or(|at| now - at >= LOOKED_FOR_EVERY) {
            self.looked_at = Some(now);
            if let Err(error) = self.look(now + PATIENCE) {
                tracing::warn!(%error, "cells are not looked for");
            }
        }
        for (cell, face) in &mut self.cells {
            let fault = face.advance(&self.common, &mut self.scenes).err();
            let fault = fault.map(|error| error.to_string());
            if let Some(error) = &fault
                && face.fault != fault
            {
                tracing::warn!(%cell, error, "a cell is not passed on");
            }
            face.fault = fault;
        }
    }

    /// Gives faces to what is new.
    fn look(&mut self, deadline: Instant) -> Result<(), FaceError> {
        for found in alive::find(self.common.process.session(), deadline)? {
            for cell in &found.cells {
                if let Err(error) = self.meet(&found, cell) {
                    tracing::warn!(%cell, service = %found.service, %error, "no face in ROS");
                }
            }
        }
        Ok(())
    }

    /// A service is there for a cell.
    fn meet(&mut self, found: &Found, cell: &Cell) -> Result<(), FaceError> {
        let is_new = !self.cells.contains_key(cell);
        if is_new && self.cells.len() >= MOST_CELLS {
            if !std::mem::replace(&mut self.is_full, true) {
                tracing::warn!(%cell, most = MOST_CELLS, "not in ROS, nor are further cells: there are too many");
            }
            return Ok(());
        }
        let name = self.namespace.join(&names::part_of(cell.as_str()))?;
        let holder = self
            .names
            .entry(name.clone())
            .or_insert_with(|| cell.clone());
        let face = self.cells.entry(cell.clone()).or_default();
        if holder != cell {
            if is_new {
                tracing::error!(%cell, %holder, %name, "a cell is not in ROS: another one has its name there");
            }
            return Ok(());
        }
        let (common, placed) = (&self.common, &self.world_from_container);
        face.meet(common, found.service, &name, cell, placed.get(cell))
    }
}

impl CellFace {
    /// Has what a service of the cell says and can be asked in ROS.
    fn meet(
        &mut self,
        common: &Common,
        service: Service,
        name: &Name,
        cell: &Cell,
        world_from_container: Option<&Isometry3<f64>>,
    ) -> Result<(), FaceError> {
        // A perception service may be there for all cells, and name none.
        let is_seen = matches!(service, Service::Bridge | Service::Perception);
        if is_seen && self.perception.is_none() {
            self.perception = Some(PerceptionFace::new(common, name, cell)?);
        }
        match service {
            Service::Bridge if self.bridge.is_none() => {
                let pose = world_from_container.copied();
                let pose = pose.unwrap_or_else(Isometry3::identity);
                common.frames.fix_container(cell, &pose)?;
                self.bridge = Some(BridgeFace::new(common, name, cell)?);
            }
            Service::Planner if self.planner.is_none() => {
                self.planner = Some(PlannerFace::new(common, name, cell)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn advance(&mut self, common: &Common, scenes: &mut PlannedScenes) -> Result<(), FaceError> {
        if let Some(bridge) = &mut self.bridge {
            bridge.advance(common)?;
        }
        if let Some(perception) = &mut self.perception {
            perception.advance(common)?;
        }
        if let Some(planner) = &mut self.planner {
            planner.advance(common, scenes)?;
        }
        Ok(())
    }
}
