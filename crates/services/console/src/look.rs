//! The services: which ones there are, their health, and their answers where streams told nothing.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::actor::{Actor, Address};
use ppnpack_service::alive::Found;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::{ServiceError, Shutdown, survey};
use ppnpack_wire::keys::{Cell, Instance, Service, Stream};
use ppnpack_wire::v1;
use zenoh::Session;

use crate::directory::Directory;
use crate::follow::{Heightmaps, Newest};
use crate::now_ms;
use crate::picture::News;

const LOOK: Duration = Duration::from_secs(1);

/// How long they may take to tell their health, half of it to be found.
const PATIENCE: Duration = Duration::from_millis(1_200);

/// How long a service may take to tell what it knows: a planner plans a step before.
const ASKING_PATIENCE: Duration = Duration::from_secs(2);

/// How often a service is asked: streams may lose messages.
const ASKED_EVERY: Duration = Duration::from_secs(10);

/// The thread that looks for services until it is told to end.
pub(crate) struct HealthPoller {
    pub(crate) session: Session,
    /// The cells and containers that are followed; none where all are.
    pub(crate) cells: Vec<Cell>,
    pub(crate) directory: Arc<Directory>,
    pub(crate) asker: Address<Vec<Found>>,
    pub(crate) shutdown: Shutdown,
}

impl HealthPoller {
    pub(crate) fn run(self) {
        while !self.shutdown.is_requested() {
            let services = self.find().unwrap_or_else(|error| {
                tracing::warn!(%error, "services cannot be looked for");
                Vec::new()
            });
            let found = services.iter().map(|(found, _)| found.clone()).collect();
            self.directory
                .change(|picture| picture.look(now_ms(), services));
            // Where it still asks, it is told the next time.
            self.asker.try_send(found);
            if self.shutdown.wait_timeout(LOOK) {
                return;
            }
        }
    }

    /// Finds the services that are there, but for those of other cells alone.
    fn find(&self) -> Result<Vec<(Found, v1::HealthReply)>, ServiceError> {
        let mut services = survey::instances(&self.session, PATIENCE)?;
        if !self.cells.is_empty() {
            services.retain_mut(|(found, _)| {
                let serves_any = found.cells.is_empty();
                found.cells.retain(|cell| self.cells.contains(cell));
                serves_any || !found.cells.is_empty()
            });
        }
        Ok(services)
    }
}

/// The actor that asks services for what they know: as soon as they are found, and then again and
/// again.
pub(crate) struct StatePoller {
    pub(crate) client: Client,
    pub(crate) directory: Arc<Directory>,
    pub(crate) newest: Newest,
    pub(crate) heightmaps: Heightmaps,
    /// The time of the last question to each of those that are there.
    pub(crate) asked: BTreeMap<(Service, Instance, Cell), Instant>,
}

impl Actor for StatePoller {
    type Message = Vec<Found>;

    fn handle(&mut self, found: Vec<Found>) {
        let before = std::mem::take(&mut self.asked);
        for found in found {
            for cell in self.asked_of(&found) {
                let key = (found.service, found.instance.clone(), cell);
                let asked = before.get(&key).copied();
                let asked = asked.filter(|at| at.elapsed() < ASKED_EVERY);
                let at = asked.unwrap_or_else(|| {
                    let (service, _, cell) = &key;
                    if let Err(error) = self.ask(*service, cell) {
                        tracing::debug!(%service, %cell, %error, "it tells nothing");
                    }
                    Instant::now()
                });
                self.asked.insert(key, at);
            }
        }
    }
}

impl StatePoller {
    /// Gives the cells or containers that a service is asked about.
    fn asked_of(&self, found: &Found) -> Vec<Cell> {
        match found.service {
            Service::Planner => found.cells.clone(),
            Service::Bridge | Service::Perception if !found.cells.is_empty() => found.cells.clone(),
            Service::Bridge | Service::Perception => self.directory.all_containers(),
            _ => Vec::new(),
        }
    }

    fn ask(&self, service: Service, cell: &Cell) -> Result<(), CallError> {
        let (client, deadline) = (&self.client, Instant::now() + ASKING_PATIENCE);
        match service {
            Service::Planner => {
                let reply = client.call(cell, v1::SessionRequest::default(), deadline)?;
                if let Some(session) = reply.session {
                    let news = News::Session(Box::new(session));
                    self.newest.put((cell.clone(), Stream::Session), news);
                }
            }
            Service::Bridge => {
                let reply = client.call(cell, v1::CellStateRequest::default(), deadline)?;
                if let Some(state) = reply.state {
                    let news = News::State(Box::new(state));
                    self.newest.put((cell.clone(), Stream::State), news);
                }
            }
            Service::Perception => {
                let reply = client.call(cell, v1::HeightmapRequest::default(), deadline)?;
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
