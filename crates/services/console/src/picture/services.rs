//! Which services there are, and how they are.

use std::collections::BTreeMap;

use ppnpack_wire::keys::{Cell, Instance, Service};
use serde::Serialize;

use super::words;

/// How long a service is remembered that has gone, in milliseconds.
const REMEMBERED_MS: u64 = 600_000;

/// Services that are remembered at most.
const MOST_KEPT: usize = 256;

/// A service as it was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FoundService {
    pub(crate) service: Service,
    pub(crate) instance: Instance,
    /// The cells that it serves; none where it serves any.
    pub(crate) cells: Vec<Cell>,
    /// What it says of itself; or why it says nothing.
    pub(crate) health: Result<Health, String>,
}

/// What a service says of itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Health {
    pub(crate) is_ready: bool,
    /// What does not pass, with what is wrong.
    pub(crate) failing: Vec<String>,
    pub(crate) version: String,
    pub(crate) uptime_s: f64,
}

/// How a service is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Condition {
    Ready,
    NotReady,
    Silent,
    Gone,
}

#[derive(Debug)]
struct Known {
    found: FoundService,
    condition: Condition,
    /// Since when it is in that condition, in milliseconds since 1970.
    since_ms: u64,
}

/// A service as pages show it.
#[derive(Debug, Serialize)]
pub(super) struct ServicePart<'a> {
    service: &'static str,
    instance: &'a str,
    cells: Vec<&'a str>,
    is_alive: bool,
    is_ready: bool,
    failing: Vec<&'a str>,
    version: &'a str,
    uptime_s: f64,
    since_ms: u64,
}

/// The change of a service that somebody wants to hear of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turn {
    /// The cells that it serves; none where it serves any.
    pub(super) cells: Vec<Cell>,
    /// Whether it is there again, or new.
    pub(super) is_back: bool,
    pub(super) text: String,
}

/// The services that are there, and those that were.
#[derive(Debug, Default)]
pub(super) struct Services {
    known: BTreeMap<(Service, Instance), Known>,
}

impl Services {
    /// Takes in which services were found; gives those that went or came back.
    pub(super) fn look(&mut self, now_ms: u64, found: Vec<FoundService>) -> Vec<Turn> {
        let mut turns = Vec::new();
        for (key, known) in &mut self.known {
            let is_found = found
                .iter()
                .any(|found| (&found.service, &found.instance) == (&key.0, &key.1));
            if !is_found {
                turns.extend(known.turn(Condition::Gone, now_ms));
            }
        }
        self.known.retain(|_, known| {
            known.condition != Condition::Gone
                || now_ms.saturating_sub(known.since_ms) < REMEMBERED_MS
        });
        for found in found {
            let key = (found.service, found.instance.clone());
            let condition = match &found.health {
                Ok(health) if health.is_ready => Condition::Ready,
                Ok(_) => Condition::NotReady,
                Err(_) => Condition::Silent,
            };
            if let Some(known) = self.known.get_mut(&key) {
                known.found = found;
                turns.extend(known.turn(condition, now_ms));
            } else if self.known.len() < MOST_KEPT {
                let since_ms = now_ms;
                self.known.insert(
                    key,
                    Known {
                        found,
                        condition,
                        since_ms,
                    },
                );
            }
        }
        turns
    }

    pub(super) fn parts(&self) -> Vec<ServicePart<'_>> {
        self.known.values().map(Known::part).collect()
    }

    /// The cells that planners serve which are there.
    pub(super) fn planned_cells(&self) -> impl Iterator<Item = &Cell> {
        let planners = self.known.values();
        let planners = planners.filter(|known| known.found.service == Service::Planner);
        let there = planners.filter(|known| known.condition != Condition::Gone);
        there.flat_map(|known| &known.found.cells)
    }

    /// What is wrong with the service of a cell, as a sentence; `None` where one that serves the cell is ready.
    pub(super) fn trouble(&self, service: Service, cell: &Cell, now_ms: u64) -> Option<String> {
        let of_service = self
            .known
            .values()
            .filter(|known| known.found.service == service);
        let serving: Vec<&Known> = of_service.filter(|known| known.serves(cell)).collect();
        if serving
            .iter()
            .any(|known| known.condition == Condition::Ready)
        {
            return None;
        }
        let newest = serving.into_iter().max_by_key(|known| known.since_ms);
        let Some(known) = newest else {
            return Some(format!("There is no {service} of {cell}."));
        };
        let passed = words::seconds(known.since_ms, now_ms);
        Some(match known.condition {
            Condition::Gone => format!("The {service} has been away for {passed}."),
            Condition::Silent => format!("The {service} has not answered for {passed}."),
            _ => format!(
                "The {service} has not been ready for {passed}: {}.",
                known.failing().join("; ")
            ),
        })
    }
}

impl Known {
    fn serves(&self, cell: &Cell) -> bool {
        self.found.cells.is_empty() || self.found.cells.contains(cell)
    }

    fn failing(&self) -> Vec<&str> {
        match &self.found.health {
            Ok(health) => health.failing.iter().map(String::as_str).collect(),
            Err(silent) => vec![silent.as_str()],
        }
    }

    /// It is in this condition now; gives what is worth telling of that.
    fn turn(&mut self, condition: Condition, now_ms: u64) -> Option<Turn> {
        let before = std::mem::replace(&mut self.condition, condition);
        if before == condition {
            return None;
        }
        self.since_ms = now_ms;
        let FoundService {
            service, instance, ..
        } = &self.found;
        let text = match condition {
            Condition::Ready => format!("{service} {instance} is ready."),
            Condition::NotReady => {
                format!(
                    "{service} {instance} is not ready: {}.",
                    self.failing().join("; ")
                )
            }
            Condition::Silent => format!("{service} {instance} does not answer."),
            Condition::Gone => format!("{service} {instance} has gone."),
        };
        Some(Turn {
            cells: self.found.cells.clone(),
            is_back: condition == Condition::Ready,
            text,
        })
    }

    fn part(&self) -> ServicePart<'_> {
        let FoundService {
            service,
            instance,
            cells,
            health,
        } = &self.found;
        let health = health.as_ref().ok();
        ServicePart {
            service: service.as_str(),
            instance: instance.as_str(),
            cells: cells.iter().map(Cell::as_str).collect(),
            is_alive: self.condition != Condition::Gone,
            is_ready: self.condition == Condition::Ready,
            failing: match self.condition {
                Condition::Gone => Vec::new(),
                _ => self.failing(),
            },
            version: health.map_or("", |health| health.version.as_str()),
            uptime_s: health.map_or(0.0, |health| health.uptime_s),
            since_ms: self.since_ms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planner(health: Result<bool, &str>) -> FoundService {
        FoundService {
            service: Service::Planner,
            instance: Instance::new("p1").unwrap(),
            cells: vec![Cell::new("c1").unwrap()],
            health: match health {
                Ok(is_ready) => Ok(Health {
                    is_ready,
                    failing: if is_ready {
                        vec![]
                    } else {
                        vec!["store: disk full".to_owned()]
                    },
                    ..Health::default()
                }),
                Err(silent) => Err(silent.to_owned()),
            },
        }
    }

    #[test]
    fn a_service_that_goes_and_comes_back_is_told_of_once_each() {
        let mut services = Services::default();
        let cell = Cell::new("c1").unwrap();
        let trouble =
            |services: &Services, now_ms| services.trouble(Service::Planner, &cell, now_ms);
        assert_eq!(trouble(&services, 0).unwrap(), "There is no planner of c1.");
        assert!(
            services.look(0, vec![planner(Ok(true))]).is_empty(),
            "it is new"
        );
        assert_eq!(trouble(&services, 0), None);
        let gone = services.look(1_000, vec![]);
        assert_eq!(
            (gone[0].is_back, gone[0].text.as_str()),
            (false, "planner p1 has gone.")
        );
        assert!(services.look(2_000, vec![]).is_empty());
        assert_eq!(
            trouble(&services, 13_000).unwrap(),
            "The planner has been away for 12 s."
        );
        assert!(!services.parts()[0].is_alive);
        let back = services.look(14_000, vec![planner(Ok(true))]);
        assert!(back[0].is_back && back.len() == 1);
        assert_eq!(trouble(&services, 14_000), None);
    }

    #[test]
    fn a_service_that_is_silent_or_not_ready_says_why() {
        let mut services = Services::default();
        let cell = Cell::new("c1").unwrap();
        services.look(0, vec![planner(Err("no answer in time"))]);
        let trouble =
            |services: &Services| services.trouble(Service::Planner, &cell, 3_000).unwrap();
        assert_eq!(trouble(&services), "The planner has not answered for 3 s.");
        services.look(1_000, vec![planner(Ok(false))]);
        assert_eq!(
            trouble(&services),
            "The planner has not been ready for 2 s: store: disk full."
        );
        let part = serde_json::to_value(services.parts()).unwrap();
        assert_eq!(part[0]["failing"][0], "store: disk full");
    }

    #[test]
    fn what_has_gone_is_forgotten_in_the_end() {
        let mut services = Services::default();
        services.look(0, vec![planner(Ok(true))]);
        services.look(1, vec![]);
        assert_eq!(services.parts().len(), 1);
        assert_eq!(services.planned_cells().count(), 0);
        services.look(1 + REMEMBERED_MS, vec![]);
        assert!(services.parts().is_empty());
    }
}
