//! Which services there are, how they are, and what they know that no stream has told.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::actor::{Actor, Address, WeakAddress};
use ppnpack_service::alive::{self, Found};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::{ServiceError, Shutdown};
use ppnpack_wire::keys::{Cell, Instance, Service, Stream};
use ppnpack_wire::v1;
use zenoh::Session;

use crate::clock::now_ms;
use crate::directory::Directory;
use crate::follow::{Heightmaps, Newest, Told};
use crate::picture::{FoundService, Health, News};

/// How often it is looked which services there are.
const LOOK: Duration = Duration::from_secs(1);

/// How long the answers to that may take.
const PATIENCE: Duration = Duration::from_millis(500);

/// How long services may take to say how they are.
const HEALTH_PATIENCE: Duration = Duration::from_millis(700);

/// How long a service may take to tell what it knows: a planner plans a step before.
const ASKING_PATIENCE: Duration = Duration::from_secs(2);

/// How often that is asked for: streams may lose messages.
const ASKED_EVERY: Duration = Duration::from_secs(10);

/// Looks for services until it is told to end.
pub(crate) struct Looker {
    pub(crate) session: Session,
    pub(crate) client: Client,
    /// The cells and containers that are followed; none where all are.
    pub(crate) cells: Vec<Cell>,
    pub(crate) follower: WeakAddress<Told>,
    pub(crate) asker: Address<Vec<Found>>,
    pub(crate) shutdown: Shutdown,
}

impl Looker {
    pub(crate) fn run(self) {
        while !self.shutdown.is_requested() {
            let found = self.find().unwrap_or_else(|error| {
                tracing::warn!(%error, "services cannot be looked for");
                Vec::new()
            });
            let told = Told::Found(self.with_health(&found));
            let Some(follower) = self.follower.upgrade() else {
                return;
            };
            if !follower.try_send(told) {
                tracing::debug!("which services there are is told the next time");
            }
            drop(follower);
            // Where it still asks, it is told the next time.
            self.asker.try_send(found);
            if self.shutdown.wait_timeout(LOOK) {
                return;
            }
        }
    }

    /// The services that are there, but for those of other cells alone.
    fn find(&self) -> Result<Vec<Found>, ServiceError> {
        let mut found = alive::find(&self.session, Instant::now() + PATIENCE)?;
        if !self.cells.is_empty() {
            found.retain_mut(|found| {
                let serves_any = found.cells.is_empty();
                found.cells.retain(|cell| self.cells.contains(cell));
                serves_any || !found.cells.is_empty()
            });
        }
        Ok(found)
    }

    fn with_health(&self, found: &[Found]) -> Vec<FoundService> {
        let answers = self
            .client
            .health_of_all(found, Instant::now() + HEALTH_PATIENCE);
        let with_health = found
            .iter()
            .zip(answers)
            .map(|(found, health)| FoundService {
                service: found.service,
                instance: found.instance.clone(),
                cells: found.cells.clone(),
                health: health.map(read).map_err(|error| error.to_string()),
            });
        with_health.collect()
    }
}

fn read(health: v1::HealthReply) -> Health {
    let failing = health.checks.into_iter().filter(|check| !check.is_passing);
    let failing = failing.map(|check| format!("{}: {}", check.name, check.message));
    let versions = health.header.and_then(|header| header.versions);
    Health {
        is_ready: health.is_ready,
        failing: failing.collect(),
        version: versions.unwrap_or_default().software,
        uptime_s: health.uptime_ns as f64 / 1e9,
    }
}

/// Asks services for what they know: as soon as they are found, and then now and again.
pub(crate) struct Asker {
    pub(crate) client: Client,
    pub(crate) directory: Arc<Directory>,
    pub(crate) newest: Newest,
    pub(crate) heightmaps: Heightmaps,
    /// When what was asked last of those that are there.
    pub(crate) asked: BTreeMap<(Service, Instance, Cell), Instant>,
}

impl Actor for Asker {
    type Message = Vec<Found>;

    fn handle(&mut self, found: Vec<Found>) {
        let before = std::mem::take(&mut self.asked);
        for found in found {
            for cell in self.asked_of(&found) {
                let key = (found.service, found.instance.clone(), cell);
                let asked = before.get(&key).copied();
                let is_due = asked.is_none_or(|at| at.elapsed() >= ASKED_EVERY);
                let at = match asked {
                    Some(at) if !is_due => at,
                    _ => {
                        let (service, _, cell) = &key;
                        if let Err(error) = self.ask(*service, cell) {
                            tracing::debug!(%service, %cell, %error, "it tells nothing");
                        }
                        Instant::now()
                    }
                };
                self.asked.insert(key, at);
            }
        }
    }
}

impl Asker {
    /// The cells or containers that a service is asked about.
    fn asked_of(&self, found: &Found) -> Vec<Cell> {
        match found.service {
            Service::Planner => found.cells.clone(),
            Service::Bridge | Service::Perception if !found.cells.is_empty() => found.cells.clone(),
            Service::Bridge | Service::Perception => self.directory.all_containers(),
            _ => Vec::new(),
        }
    }

    fn ask(&self, service: Service, cell: &Cell) -> Result<(), CallError> {
        let deadline = Instant::now() + ASKING_PATIENCE;
        match service {
            Service::Planner => {
                let reply = self
                    .client
                    .call(cell, v1::SessionRequest::default(), deadline)?;
                if let Some(session) = reply.session {
                    let news = News::Session(Box::new(session));
                    self.newest.put((cell.clone(), Stream::Session), news);
                }
            }
            Service::Bridge => {
                let reply = self
                    .client
                    .call(cell, v1::CellStateRequest::default(), deadline)?;
                if let Some(state) = reply.state {
                    let news = News::State(Box::new(state));
                    self.newest.put((cell.clone(), Stream::State), news);
                }
            }
            Service::Perception => {
                let reply = self
                    .client
                    .call(cell, v1::HeightmapRequest::default(), deadline)?;
                if let Some(heightmap) = reply.heightmap {
                    let made_ms = now_ms().saturating_sub(reply.age_ns / 1_000_000);
                    let made = (made_ms, Box::new(heightmap));
                    self.heightmaps.put(cell.clone(), made);
                }
            }
            _ => {}
        }
        Ok(())
    }
}
