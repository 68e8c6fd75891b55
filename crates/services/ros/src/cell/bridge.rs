//! What the bridge says of a container, and what can be asked of it.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_ros::messages::builtin_interfaces::Time;
use ppnpack_ros::messages::ppnpack_srvs::{Changed, Hold};
use ppnpack_ros::messages::std_srvs::Trigger;
use ppnpack_ros::messages::visualization_msgs::MarkerArray;
use ppnpack_ros::names::Name;
use ppnpack_ros::service::Server;
use ppnpack_ros::{Qos, RosError};
use ppnpack_service::stream::Subscription;
use ppnpack_wire::convert::pose;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{debug, v1};

use super::follow::{self, Followed};
use crate::cells::Common;
use crate::convert::{markers, messages};
use crate::error::FaceError;
use crate::frames::{self, Frames};

/// The bridge of a container in ROS.
pub(crate) struct BridgeFace {
    cell: Cell,
    scene: Followed<v1::CellState, MarkerArray>,
    _streams: [Subscription; 2],
    _servers: Vec<Server>,
}

impl BridgeFace {
    pub(crate) fn new(common: &Common, name: &Name, cell: &Cell) -> Result<Self, FaceError> {
        let node = &common.node;
        let scene = node.publisher(&name.join("scene")?, Qos::LATCHED)?;
        let states = node.publisher(&name.join("state")?, Qos::LATCHED)?;
        let outcomes = node.publisher(&name.join("outcomes")?, Qos::EVENTS)?;
        let frames = Arc::clone(&common.frames);
        let tell_state = move |cell: &Cell, state: &v1::CellState| {
            states.publish(&messages::state(cell, state))?;
            tell_items(&frames, cell, state)
        };
        let tell_outcome = move |cell: &Cell, outcome: &v1::Outcome| {
            outcomes.publish(&messages::outcome(cell, outcome))
        };
        Ok(Self {
            cell: cell.clone(),
            scene: Followed::new(cell, Stream::State, scene),
            _streams: [
                follow::each(common, cell, Stream::State, tell_state)?,
                follow::each(common, cell, Stream::Outcome, tell_outcome)?,
            ],
            _servers: servers(common, name, cell)?,
        })
    }

    pub(crate) fn advance(&mut self, common: &Common) -> Result<(), FaceError> {
        let Some(state) = self.scene.newest(&common.process)? else {
            return Ok(());
        };
        let scene = debug::state(&self.cell, 0, &state);
        self.scene.pass_on(Ok(markers::of_scene(&scene)))
    }
}

/// Says where the items of a container are.
fn tell_items(frames: &Frames, cell: &Cell, state: &v1::CellState) -> Result<(), RosError> {
    let items = state.bodies.iter().filter_map(|body| {
        let at = pose::read_required("pose", body.container_from_item.as_ref());
        let at: Isometry3<f64> = at.ok()?;
        Some((frames::item(cell, &body.item_id), at))
    });
    frames.tell(cell, &Time::now(), items)
}

fn servers(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Server>, FaceError> {
    let (node, requests) = (&common.node, &common.requests);
    // However many wait for something else, a cell can be held.
    let holds = requests.apart();
    Ok(vec![
        holds.serve::<Hold, _>(node, &name.join("hold")?, cell, |asked| v1::HoldRequest {
            reason: asked.reason.clone(),
            is_aborting: asked.is_aborting,
            ..v1::HoldRequest::default()
        })?,
        requests.serve::<Trigger, _>(node, &name.join("resume")?, cell, |_| {
            v1::ResumeRequest::default()
        })?,
        requests.serve::<Trigger, _>(node, &name.join("renew")?, cell, |_| {
            v1::RenewRequest::default()
        })?,
        requests.serve::<Changed, _>(node, &name.join("changed")?, cell, |asked| {
            v1::ChangedRequest {
                removed_item_ids: asked.removed_item_ids.clone(),
                ..v1::ChangedRequest::default()
            }
        })?,
    ])
}
