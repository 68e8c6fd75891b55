//! A robot that is a program of its own, in any language: it is asked over the wire, again until it
//! answers, and what it says is checked.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_protocol::message;
use ppnpack_service::Shutdown;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{WireError, header};
use serde::{Deserialize, Serialize};

use crate::desk::Reach;
use crate::robot::{Body, CutOff, Ending, Finding, Placement, Robot, RobotError, View};

/// The time limit of a request for work: a program that works longer says so, and is asked again.
const WORK_LIMIT: Duration = Duration::from_secs(1);

/// The time limit of a request to take over.
const TAKE_OVER_LIMIT: Duration = Duration::from_secs(3);

/// The pause before the same is asked again.
const PAUSE: Duration = Duration::from_millis(50);

/// The maximum time without an answer, after which it is not known what the robot did.
const SILENCE: Duration = Duration::from_secs(30);

/// A robot that is a program of its own; the container's size is the cell's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RemoteSettings {
    /// Whether it simulates. A work of which the end was not written down has not happened there.
    pub is_simulated: bool,
}

/// A robot behind the wire.
pub(crate) struct RemoteRobot {
    cell: Cell,
    client: Client,
    settings: RemoteSettings,
    container: ContainerSize,
    /// The start of the program that knows what lies in the container.
    start: Option<String>,
    bodies: Vec<Body>,
}

/// The answer to what is asked until it has ended.
enum Asked<T> {
    Ended(T),
    /// It was surely not begun, and why.
    NotBegun(String),
    /// It is not known what the robot did, and why.
    Unknown(String),
}

impl RemoteRobot {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        container: ContainerSize,
        settings: RemoteSettings,
    ) -> Self {
        Self {
            cell: cell.clone(),
            client: Client::new(process.session()),
            settings,
            container,
            start: None,
            bodies: Vec::new(),
        }
    }

    fn call<R: Request>(&self, request: R, limit: Duration) -> Result<R::Reply, CallError> {
        self.client
            .call(&self.cell, request, Instant::now() + limit)
    }

    /// Has a program that was started anew take over what lies in the container; gives its start.
    fn start(&mut self) -> Result<String, String> {
        if let Some(start) = &self.start {
            return Ok(start.clone());
        }
        let request = v1::TakeOverRequest {
            header: None,
            bodies: self.bodies.iter().map(message::write_body).collect(),
        };
        let reply = self.call(request, TAKE_OVER_LIMIT);
        let reply = reply.map_err(|error| error.to_string())?;
        let start = header::id("start", &reply.start).map_err(|error| error.to_string())?;
        self.account_of(reply.bodies);
        self.start = Some(start.to_owned());
        Ok(start.to_owned())
    }

    /// Takes over the program's account of what lies in the container; says whether it has one.
    fn account_of(&mut self, bodies: Option<v1::Bodies>) -> bool {
        let read = |bodies: v1::Bodies| -> Result<Vec<Body>, WireError> {
            bodies.bodies.iter().map(message::read_body).collect()
        };
        match bodies.map(read).transpose() {
            Ok(None) => false,
            Ok(Some(bodies)) => {
                self.bodies = bodies;
                true
            }
            Err(error) => {
                tracing::warn!(cell = %self.cell, %error, "the robot's account is not believed");
                false
            }
        }
    }

    /// Asks for the same until it has ended, at most once of each start of the program.
    fn ask_until_ended<R: Request, T>(
        &mut self,
        request: impl Fn(String) -> R,
        ended: impl Fn(R::Reply) -> Option<T>,
    ) -> Asked<T> {
        let before = self.bodies.clone();
        let (mut may_have_begun, mut was_anew) = (false, false);
        let mut heard = Instant::now();
        loop {
            let start = match self.start() {
                Ok(start) => start,
                Err(error) => return Asked::NotBegun(format!("the robot's program: {error}")),
            };
            if self.bodies != before {
                let failure = "the robot's program was started anew, and knows of other items";
                return Asked::Unknown(failure.to_owned());
            }
            match self.call(request(start), WORK_LIMIT) {
                Ok(reply) => match ended(reply) {
                    Some(end) => return Asked::Ended(end),
                    None => heard = Instant::now(),
                },
                Err(error) => match error.status() {
                    Some(_) if may_have_begun => {
                        self.start = None;
                        return Asked::Unknown(format!("the robot's program: {error}"));
                    }
                    Some(Status::Stale) if !was_anew => {
                        // It takes over first what lies there.
                        (self.start, was_anew) = (None, true);
                        continue;
                    }
                    Some(_) => return Asked::NotBegun(format!("the robot: {error}")),
                    None if heard.elapsed() > SILENCE => {
                        self.start = None;
                        return Asked::Unknown(format!("the robot's program: {error}"));
                    }
                    None => {}
                },
            }
            may_have_begun = true;
            std::thread::sleep(PAUSE);
        }
    }

    /// Checks an outcome as that of a stranger.
    fn finding(&self, placement: &Placement, outcome: &v1::Outcome) -> Result<Finding, String> {
        let finding =
            message::read_finding(placement, outcome).map_err(|error| error.to_string())?;
        if let Some(found) = &finding.container_from_item {
            Reach::of(self).check_frame(found.isometry())?;
        }
        Ok(finding)
    }

    /// Gives what an end says; keeps account of what lies in the container where the program does
    /// not.
    fn after(&mut self, placement: &Placement, reply: v1::CarryOutReply) -> Finding {
        let outcome = reply.outcome.unwrap_or_default();
        let finding = self.finding(placement, &outcome).unwrap_or_else(|reason| {
            let failure = format!("the robot's program says what cannot be: {reason}");
            Finding::failed(Ending::Unknown, failure)
        });
        let is_told = self.account_of(reply.bodies);
        if let (false, Ending::Placed, Some(container_from_item)) =
            (is_told, finding.ending, finding.container_from_item)
        {
            self.bodies.push(Body {
                item_id: placement.item_id.clone(),
                object: placement.object.clone(),
                container_from_item,
                is_inside: finding.is_inside,
            });
        }
        finding
    }
}

impl Robot for RemoteRobot {
    fn is_simulated(&self) -> bool {
        self.settings.is_simulated
    }

    fn container(&self) -> ContainerSize {
        self.container
    }

    fn objects(&self) -> Option<BTreeMap<String, Bounds>> {
        None
    }

    fn take_over(&mut self, bodies: Vec<Body>) -> Vec<Body> {
        self.bodies = bodies;
        self.start = None;
        if let Err(error) = self.start() {
            tracing::warn!(cell = %self.cell, error, "the robot's program has not taken over yet");
        }
        self.bodies()
    }

    fn place(&mut self, placement: &Placement, cut_off: &Shutdown) -> Result<Finding, CutOff> {
        let request = |start| v1::CarryOutRequest {
            header: None,
            start,
            placement: Some(message::write_placement(placement)),
            is_given_up: cut_off.is_requested(),
        };
        let ended = |reply: v1::CarryOutReply| reply.outcome.is_some().then_some(reply);
        Ok(match self.ask_until_ended(request, ended) {
            Asked::Ended(reply) => self.after(placement, reply),
            Asked::NotBegun(failure) => Finding::failed(Ending::NotPlaced, failure),
            Asked::Unknown(failure) => Finding::failed(Ending::Unknown, failure),
        })
    }

    fn renew(&mut self) -> Result<(), RobotError> {
        let renewal_id = format!("{:032x}", rand::random::<u128>());
        let request = |start| v1::BringEmptyRequest {
            header: None,
            start,
            renewal_id: renewal_id.clone(),
        };
        let ended = |reply: v1::BringEmptyReply| reply.has_ended.then_some(reply.failure);
        match self.ask_until_ended(request, ended) {
            Asked::Ended(failure) if failure.is_empty() => {
                self.bodies.clear();
                Ok(())
            }
            Asked::Ended(why) | Asked::NotBegun(why) | Asked::Unknown(why) => Err(RobotError(why)),
        }
    }

    fn bodies(&self) -> Vec<Body> {
        self.bodies.clone()
    }

    /// The program's cameras publish their clouds themselves.
    fn capture(&mut self) -> Result<Vec<View>, RobotError> {
        Ok(Vec::new())
    }
}
