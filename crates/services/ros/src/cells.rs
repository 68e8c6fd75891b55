//! The cells that are there, and their faces in ROS.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_perception::extrinsics::Extrinsics;
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

/// How long it is waited for answers of the cells.
const PATIENCE: Duration = Duration::from_millis(500);

const MOST_CELLS: usize = 1_000;

pub(crate) struct Cells {
    common: Common,
    namespace: Name,
    world_from_container: BTreeMap<String, Extrinsics>,
    /// The frames of containers: whoever comes later is told of all.
    fixed: Publisher<TfMessage>,
    fixed_frames: BTreeMap<Cell, TransformStamped>,
    /// The cell of each name in ROS: a request under one must reach one cell alone.
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
        let client = Client::new(process.session());
        Ok(Self {
            namespace: Name::new(&settings.namespace)?,
            world_from_container: settings.containers.clone(),
            fixed: node.publisher(&Name::ROOT.join("tf_static"), Qos::Latched)?,
            fixed_frames: BTreeMap::new(),
            names: BTreeMap::new(),
            faces: BTreeMap::new(),
            is_full: false,
            common: Common {
                requests: Requests::new(client, Duration::from_secs_f64(settings.request_limit_s)),
                moving: Arc::new(node.publisher(&Name::ROOT.join("tf"), Qos::Frames)?),
                process: process.clone(),
                node,
            },
        })
    }

    /// Looks for cells, and puts new ones into ROS.
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

    /// Puts a service of a cell into ROS.
    fn meet(&mut self, service: Service, cell: &Cell) -> Result<(), RosError> {
        let is_new = !self.faces.contains_key(cell);
        if is_new && self.faces.len() >= MOST_CELLS {
            if !std::mem::replace(&mut self.is_full, true) {
                tracing::warn!(%cell, most = MOST_CELLS, "not in ROS, nor are further cells: there are too many");
            }
            return Ok(());
        }
        let name = self.namespace.join(cell.as_str());
        let holder = self.names.entry(name.clone());
        let holder = holder.or_insert_with(|| cell.clone());
        let face = self.faces.entry(cell.clone()).or_default();
        if holder != cell {
            if is_new {
                tracing::error!(%cell, %holder, %name, "a cell is not in ROS: another one has its name there");
            }
            return Ok(());
        }
        if service == Service::Bridge && face.bridge.is_none() {
            let placed = self.world_from_container.get(cell.as_str());
            let placed = placed.and_then(|placed| placed.pose().ok());
            let pose = convert::pose_of(&placed.unwrap_or_default());
            let frame = convert::container_frame(cell);
            let fixed = convert::frame("world", frame, &pose);
            self.fixed_frames.insert(cell.clone(), fixed);
            let transforms = self.fixed_frames.values().cloned().collect();
            self.fixed.publish(&TfMessage { transforms })?;
        }
        face.meet(&self.common, service, &name, cell)
    }
}
