//! The cells that are there, and what is in ROS of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use ppnpack_service::alive;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Service};

use crate::convert;
use crate::error::RosError;
use crate::face::{Common, Face};
use crate::requests::Requests;
use crate::rmw::keys::{Name, Qos};
use crate::rmw::messages::{TfMessage, TransformStamped};
use crate::rmw::{Node, Publisher};
use crate::settings::Settings;

/// How long the answers to who is there may take.
const PATIENCE: Duration = Duration::from_millis(500);

/// Cells and containers that have a face at most.
const MOST_CELLS: usize = 1_000;

/// The cells and their faces.
pub(crate) struct Cells {
    common: Common,
    namespace: Name,
    world_from_container: BTreeMap<Cell, Isometry3<f64>>,
    /// Where containers are: whoever comes later is told of all.
    fixed: Publisher<TfMessage>,
    fixed_frames: BTreeMap<Cell, TransformStamped>,
    /// Who has which name in ROS: what is asked under one must reach one cell alone.
    names: BTreeMap<Name, Cell>,
    /// A cell has none where another one has its name.
    faces: BTreeMap<Cell, Face>,
    /// Whether there were more, which is said once.
    is_full: bool,
}

impl Cells {
    pub(crate) fn new(
        process: &Process,
        node: Node,
        settings: &Settings,
    ) -> Result<Self, RosError> {
        let placed = settings.containers.iter().filter_map(|(cell, pose)| {
            // They are checked.
            Some((Cell::new(cell).ok()?, pose.pose().ok()?))
        });
        let client = Client::new(process.session());
        Ok(Self {
            namespace: Name::new(&settings.namespace)?,
            world_from_container: placed.collect(),
            fixed: node.publisher(&Name::ROOT.join("tf_static"), Qos::Latched)?,
            fixed_frames: BTreeMap::new(),
            names: BTreeMap::new(),
            faces: BTreeMap::new(),
            is_full: false,
            common: Common {
                requests: Requests::new(client, settings.request_limit()),
                moving: Arc::new(node.publisher(&Name::ROOT.join("tf"), Qos::Frames)?),
                process: process.clone(),
                node,
            },
        })
    }

    /// Looks which cells there are, and has in ROS what is new.
    pub(crate) fn look(&mut self) {
        let session = self.common.process.session();
        let found = match alive::find(session, Instant::now() + PATIENCE) {
            Ok(found) => found,
            Err(error) => return tracing::warn!(%error, "cells are not looked for"),
        };
        for found in found {
            for cell in &found.cells {
                if let Err(error) = self.meet(found.service, cell) {
                    tracing::warn!(%cell, service = %found.service, %error, "not in ROS");
                }
            }
        }
    }

    /// Has what a service of a cell says and can be asked in ROS.
    fn meet(&mut self, service: Service, cell: &Cell) -> Result<(), RosError> {
        let is_new = !self.faces.contains_key(cell);
        if is_new && self.faces.len() >= MOST_CELLS {
            if !std::mem::replace(&mut self.is_full, true) {
                tracing::warn!(%cell, most = MOST_CELLS, "not in ROS, nor are further cells: there are too many");
            }
            return Ok(());
        }
        let name = self.namespace.join(cell.as_str());
        let holder = self
            .names
            .entry(name.clone())
            .or_insert_with(|| cell.clone());
        let face = self.faces.entry(cell.clone()).or_default();
        if holder != cell {
            if is_new {
                tracing::error!(%cell, %holder, %name, "a cell is not in ROS: another one has its name there");
            }
            return Ok(());
        }
        if service == Service::Bridge && face.bridge.is_none() {
            let placed = self.world_from_container.get(cell).copied();
            let pose = convert::pose_of(&placed.unwrap_or_default());
            let frame = convert::container_frame(cell.as_str());
            let fixed = convert::frame("world", frame, &pose);
            self.fixed_frames.insert(cell.clone(), fixed);
            let transforms = self.fixed_frames.values().cloned().collect();
            self.fixed.publish(&TfMessage { transforms })?;
        }
        face.meet(&self.common, service, &name, cell)
    }
}
