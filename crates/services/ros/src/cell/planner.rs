//! What the planner says of a cell, and what can be asked of it.

use ppnpack_ros::Qos;
use ppnpack_ros::action::ActionServer;
use ppnpack_ros::messages::ppnpack_srvs::{Announce, Begin, Plan, PlanResponse, Report, Withdraw};
use ppnpack_ros::messages::std_srvs::SetBool;
use ppnpack_ros::messages::visualization_msgs::MarkerArray;
use ppnpack_ros::names::Name;
use ppnpack_ros::service::Server;
use ppnpack_service::rpc::CallError;
use ppnpack_service::stream::Subscription;
use ppnpack_view::PlannedScenes;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use super::follow::{self, Followed};
use super::{pack, sessions};
use crate::cells::Common;
use crate::convert::{markers, messages};
use crate::error::FaceError;
use crate::requests::Requests;

/// The planner of a cell in ROS.
pub(crate) struct PlannerFace {
    cell: Cell,
    plan: Followed<v1::PlanningRecord, MarkerArray>,
    _streams: [Subscription; 2],
    _servers: Vec<Server>,
    _pack: ActionServer,
}

impl PlannerFace {
    pub(crate) fn new(common: &Common, name: &Name, cell: &Cell) -> Result<Self, FaceError> {
        let node = &common.node;
        let plan = node.publisher(&name.join("planned_scene")?, Qos::LATCHED)?;
        let decisions = node.publisher(&name.join("decisions")?, Qos::LATCHED)?;
        let told = node.publisher(&name.join("session")?, Qos::LATCHED)?;
        let tell_decision = move |cell: &Cell, decision: &v1::Decision| {
            decisions.publish(&messages::decision(cell, decision))
        };
        Ok(Self {
            cell: cell.clone(),
            plan: Followed::new(cell, Stream::Record, plan),
            _streams: [
                follow::each(common, cell, Stream::Plan, tell_decision)?,
                sessions::follow(common, cell, told)?,
            ],
            _servers: servers(common, name, cell)?,
            _pack: pack::serve(common, &name.join("pack")?, cell)?,
        })
    }

    pub(crate) fn advance(
        &mut self,
        common: &Common,
        scenes: &mut PlannedScenes,
    ) -> Result<(), FaceError> {
        let Some(record) = self.plan.newest(&common.process)? else {
            return Ok(());
        };
        match scenes.draw(&self.cell, &record) {
            Ok(scene) => self.plan.pass_on(Ok(markers::of_scene(&scene))),
            Err(error) => {
                tracing::warn!(cell = %self.cell, error, "a step is not drawn");
                Ok(())
            }
        }
    }
}

fn servers(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Server>, FaceError> {
    let (node, requests) = (&common.node, &common.requests);
    Ok(vec![
        requests.serve::<Begin, _>(node, &name.join("begin")?, cell, |asked| v1::BeginRequest {
            session_id: asked.session_id.clone(),
            is_automatic: asked.is_automatic,
            least_state_number: asked.least_state_number,
            gives_up_pending: asked.gives_up_pending,
            ..v1::BeginRequest::default()
        })?,
        requests.serve::<Announce, _>(node, &name.join("announce")?, cell, |asked| {
            let items = asked.items.iter().map(messages::read_announcement);
            v1::AnnounceRequest {
                items: items.collect(),
                ..v1::AnnounceRequest::default()
            }
        })?,
        requests.serve::<Withdraw, _>(node, &name.join("withdraw")?, cell, |asked| {
            v1::WithdrawRequest {
                item_id: asked.item_id.clone(),
                ..v1::WithdrawRequest::default()
            }
        })?,
        requests.serve::<SetBool, _>(node, &name.join("automatic")?, cell, |asked| {
            v1::AutomaticRequest {
                is_automatic: asked.data,
                ..v1::AutomaticRequest::default()
            }
        })?,
        requests.serve::<Report, _>(node, &name.join("report")?, cell, |asked| {
            v1::ReportRequest {
                decision_id: asked.decision_id.clone(),
                outcome: Some(messages::read_outcome(&asked.decision_id, &asked.outcome)),
                ..v1::ReportRequest::default()
            }
        })?,
        requests.serve_with::<Plan>(node, &name.join("plan")?, cell, |requests, cell, _| {
            plan(requests, cell)
        })?,
    ])
}

fn plan(requests: &Requests, cell: &Cell) -> Result<PlanResponse, CallError> {
    let reply = requests.ask(cell, v1::PlanRequest::default())?;
    let decision = reply.decision.as_ref();
    Ok(PlanResponse {
        success: true,
        message: messages::reasons(&reply.reasons),
        result: messages::number(reply.result),
        decision: decision
            .map(|decision| messages::decision(cell, decision))
            .unwrap_or_default(),
    })
}
