//! The services, and their health.

use std::collections::BTreeMap;

use ppnpack_service::alive::Found;
use ppnpack_service::survey;
use ppnpack_wire::keys::{Cell, Instance, Service};
use ppnpack_wire::v1;
use serde_json::{Value, json};

use super::words;

/// How long a service that has gone is remembered, in milliseconds.
const REMEMBERED_MS: u64 = 600_000;

const MOST_KEPT: usize = 256;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Condition {
    Ready,
    NotReady,
    Silent,
    Gone,
}

#[derive(Debug)]
struct Known {
    found: Found,
    health: v1::HealthReply,
    condition: Condition,
    /// The time since which it is in that condition, in milliseconds since 1970.
    since_ms: u64,
}

/// A change of a service that is worth telling.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turn {
    /// The cells that it serves; none where it serves any.
    pub(super) cells: Vec<Cell>,
    /// Whether it is there again, or new.
    pub(super) is_back: bool,
    pub(super) text: String,
}

#[derive(Debug, Default)]
pub(super) struct Services {
    known: BTreeMap<(Service, Instance), Known>,
}

impl Services {
    /// Takes in the services that were found; gives those that went or came back.
    pub(super) fn look(&mut self, now_ms: u64, found: Vec<(Found, v1::HealthReply)>) -> Vec<Turn> {
        let mut turns = Vec::new();
        for ((service, instance), known) in &mut self.known {
            let mut all = found.iter().map(|(found, _)| found);
            if !all.any(|found| (&found.service, &found.instance) == (service, instance)) {
                turns.extend(known.turn(Condition::Gone, now_ms));
            }
        }
        self.known.retain(|_, known| {
            known.condition != Condition::Gone
                || now_ms.saturating_sub(known.since_ms) < REMEMBERED_MS
        });
        for (found, health) in found {
            let key = (found.service, found.instance.clone());
            let condition = match health.is_ready {
                true => Condition::Ready,
                false if survey::is_silent(&health) => Condition::Silent,
                false => Condition::NotReady,
            };
            if let Some(known) = self.known.get_mut(&key) {
                (known.found, known.health) = (found, health);
                turns.extend(known.turn(condition, now_ms));
            } else if self.known.len() < MOST_KEPT {
                let known = Known {
                    found,
                    health,
                    condition,
                    since_ms: now_ms,
                };
                self.known.insert(key, known);
            }
        }
        turns
    }

    pub(super) fn parts(&self) -> Vec<Value> {
        self.known.values().map(Known::part).collect()
    }

    /// Gives the cells of all planners that are there.
    pub(super) fn planned_cells(&self) -> impl Iterator<Item = &Cell> {
        let planners = self.known.values();
        let planners = planners.filter(|known| known.found.service == Service::Planner);
        let there = planners.filter(|known| known.condition != Condition::Gone);
        there.flat_map(|known| &known.found.cells)
    }

    /// Says what is wrong with a service of a cell; `None` where one that serves the cell is ready.
    pub(super) fn trouble(&self, service: Service, cell: &Cell, now_ms: u64) -> Option<String> {
        let known = self.known.values();
        let of_service = known.filter(|known| known.found.service == service);
        let serving: Vec<&Known> = of_service.filter(|known| known.serves(cell)).collect();
        let is_ready = |known: &&Known| known.condition == Condition::Ready;
        if serving.iter().any(is_ready) {
            return None;
        }
        let newest = serving.into_iter().max_by_key(|known| known.since_ms);
        let Some(known) = newest else {
            return Some(format!("There is no {service} of {cell}."));
        };
        let passed = words::seconds(known.since_ms, now_ms);
        let failing = known.failing().join("; ");
        Some(match known.condition {
            Condition::Gone => format!("The {service} has been away for {passed}."),
            Condition::Silent => format!("The {service} has not answered for {passed}."),
            _ => format!("The {service} has not been ready for {passed}: {failing}."),
        })
    }
}

impl Known {
    fn serves(&self, cell: &Cell) -> bool {
        self.found.cells.is_empty() || self.found.cells.contains(cell)
    }

    /// Gives the checks that do not pass, with their faults; of a silent one, the fault alone.
    fn failing(&self) -> Vec<String> {
        let failing = self.health.checks.iter().filter(|check| !check.is_passing);
        let told = failing.map(|check| match survey::is_silent(&self.health) {
            true => check.message.clone(),
            false => format!("{}: {}", check.name, check.message),
        });
        told.collect()
    }

    /// Notes the condition; gives its change, where it has one.
    fn turn(&mut self, condition: Condition, now_ms: u64) -> Option<Turn> {
        let before = std::mem::replace(&mut self.condition, condition);
        if before == condition {
            return None;
        }
        self.since_ms = now_ms;
        let name = format!("{} {}", self.found.service, self.found.instance);
        let failing = self.failing().join("; ");
        let text = match condition {
            Condition::Ready => format!("{name} is ready."),
            Condition::NotReady => format!("{name} is not ready: {failing}."),
            Condition::Silent => format!("{name} does not answer."),
            Condition::Gone => format!("{name} has gone."),
        };
        Some(Turn {
            cells: self.found.cells.clone(),
            is_back: condition == Condition::Ready,
            text,
        })
    }

    fn part(&self) -> Value {
        let is_alive = self.condition != Condition::Gone;
        let header = self.health.header.as_ref();
        let versions = header.and_then(|header| header.versions.as_ref());
        let cells: Vec<&str> = self.found.cells.iter().map(Cell::as_str).collect();
        json!({
            "service": self.found.service.as_str(),
            "instance": self.found.instance.as_str(),
            "cells": cells,
            "is_alive": is_alive,
            "is_ready": self.condition == Condition::Ready,
            "failing": if is_alive { self.failing() } else { Vec::new() },
            "version": versions.map_or("", |versions| versions.software.as_str()),
            "uptime_s": self.health.uptime_ns as f64 / 1e9,
            "since_ms": self.since_ms,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{cell, found};
    use super::*;

    /// A planner with this health: ready, or with a check that fails.
    fn planner(failing: Option<(&str, &str)>) -> (Found, v1::HealthReply) {
        let checks = failing.map(|(name, message)| v1::HealthCheck {
            name: name.to_owned(),
            is_passing: false,
            message: message.to_owned(),
        });
        let health = v1::HealthReply {
            is_ready: failing.is_none(),
            checks: checks.into_iter().collect(),
            ..v1::HealthReply::default()
        };
        (found(Service::Planner, &["c1"]), health)
    }

    #[test]
    fn a_service_that_goes_and_comes_back_is_told_of_once_each() {
        let mut services = Services::default();
        let cell = cell("c1");
        let trouble =
            |services: &Services, now_ms| services.trouble(Service::Planner, &cell, now_ms);
        assert_eq!(trouble(&services, 0).unwrap(), "There is no planner of c1.");
        assert!(
            services.look(0, vec![planner(None)]).is_empty(),
            "it is new"
        );
        assert_eq!(trouble(&services, 0), None);
        let gone = services.look(1_000, vec![]);
        assert!(!gone[0].is_back);
        assert_eq!(gone[0].text, "planner p1 has gone.");
        assert!(services.look(2_000, vec![]).is_empty());
        let away = trouble(&services, 13_000).unwrap();
        assert_eq!(away, "The planner has been away for 12 s.");
        assert_eq!(services.parts()[0]["is_alive"], false);
        let back = services.look(14_000, vec![planner(None)]);
        assert!(back[0].is_back && back.len() == 1);
        assert_eq!(trouble(&services, 14_000), None);
    }

    #[test]
    fn a_service_that_is_silent_or_not_ready_says_why() {
        let mut services = Services::default();
        let cell = cell("c1");
        services.look(0, vec![planner(Some(("answer", "no answer in time")))]);
        let trouble =
            |services: &Services| services.trouble(Service::Planner, &cell, 3_000).unwrap();
        assert_eq!(trouble(&services), "The planner has not answered for 3 s.");
        services.look(1_000, vec![planner(Some(("store", "disk full")))]);
        let failing = "The planner has not been ready for 2 s: store: disk full.";
        assert_eq!(trouble(&services), failing);
        assert_eq!(services.parts()[0]["failing"][0], "store: disk full");
    }

    #[test]
    fn what_has_gone_is_forgotten_in_the_end() {
        let mut services = Services::default();
        services.look(0, vec![planner(None)]);
        services.look(1, vec![]);
        assert_eq!(services.parts().len(), 1);
        assert_eq!(services.planned_cells().count(), 0);
        services.look(1 + REMEMBERED_MS, vec![]);
        assert!(services.parts().is_empty());
    }
}
