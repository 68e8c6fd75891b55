//! Packing a stream, and what it came to.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_packing::streams::closing::Closing;
use ppnpack_packing::streams::episode::steps_widened;
use ppnpack_packing::streams::orders::{ContainerRules, Orders};
use ppnpack_packing::streams::stream::{Filled, StreamPlay, play_stream};
use ppnpack_physics::packing_cell::SimulatedPackingCell;
use serde::{Deserialize, Serialize};

use super::source::Arrivals;
use crate::packer::{Packer, unsteady};

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) objects: Vec<usize>,
    pub(super) closed: Vec<Container>,
    pub(super) open: Vec<Container>,
    /// Items that fit into no empty container.
    pub(super) unplaceable: usize,
    pub(super) containers_of_orders: Vec<usize>,
    /// Orders of which every item was packed; not those of which some never came.
    pub(super) complete_orders: usize,
    pub(super) orders: usize,
    pub(super) decision_s: Vec<f64>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Container {
    pub(super) items: usize,
    pub(super) placed: usize,
    pub(super) meshes_m3: f64,
    /// Its inner volume.
    pub(super) volume_m3: f64,
    pub(super) unsteady: usize,
    pub(super) steps_widened: usize,
    pub(super) closed_by: Option<String>,
}

pub(super) struct Packing<'a> {
    pub(super) packer: &'a Packer<'a>,
    pub(super) rules: ContainerRules,
    pub(super) how: StreamPlay,
}

impl Packing<'_> {
    pub(super) fn pack(&self, stream: &Arrivals) -> Outcome<Run> {
        let supply = |container: usize| {
            // Each container is another draw of what is random.
            let seed = (u64::from(stream.number) << 32) | container as u64;
            let bench = self.packer.bench(seed);
            bench.map_err(|failure| failure.to_string().into())
        };
        let items = stream.candidates(&self.packer.catalogue);
        let mut orders = Orders::new(
            self.rules.clone(),
            stream.orders.iter().cloned().enumerate(),
        );
        for (order, items) in &stream.expected {
            orders.expect(order, *items);
        }
        let packed = play_stream(&self.packer.grid, supply, items, orders, self.how).or_run()?;
        let all = || packed.closed.iter().chain(&packed.open);
        let steps = all().flat_map(|filled| &filled.steps);
        let mut decision_s: Vec<(u64, f64)> = steps
            .map(|step| (step.step, step.timings.total().as_secs_f64()))
            .collect();
        decision_s.sort_by_key(|(step, _)| *step);
        let (containers_of_orders, complete_orders) = orders_in(stream, all());
        Ok(Run {
            objects: stream.objects.clone(),
            closed: packed.closed.iter().map(Container::of).collect(),
            open: packed.open.iter().map(Container::of).collect(),
            unplaceable: packed.unplaceable.len(),
            containers_of_orders,
            complete_orders,
            orders: stream.expected.len(),
            decision_s: decision_s.into_iter().map(|(_, took_s)| took_s).collect(),
        })
    }
}

/// In how many of these containers each order is, and how many orders are wholly in them.
fn orders_in<'a, C: 'a>(
    stream: &Arrivals,
    containers: impl Iterator<Item = &'a Filled<C>>,
) -> (Vec<usize>, usize) {
    let mut packed: BTreeMap<&Arc<str>, (BTreeSet<usize>, usize)> = BTreeMap::new();
    for filled in containers {
        for step in &filled.steps {
            if let Some(item) = stream.orders.get(step.candidate.arrival) {
                let (containers, items) = packed.entry(&item.order).or_default();
                containers.insert(filled.number);
                *items += 1;
            }
        }
    }
    let is_complete = |(order, items): &&(Arc<str>, usize)| {
        let packed = packed.get(order);
        packed.is_some_and(|(_, of)| of >= items)
    };
    let complete = stream.expected.iter().filter(is_complete).count();
    let containers = packed.values().map(|(containers, _)| containers.len());
    (containers.collect(), complete)
}

impl Container {
    fn of(filled: &Filled<SimulatedPackingCell>) -> Self {
        let packed = filled.packed();
        Self {
            items: packed.items,
            placed: filled.cell.placed().len(),
            meshes_m3: packed.meshes_m3,
            volume_m3: filled.grid.container().volume_m3(),
            unsteady: unsteady(&filled.cell),
            steps_widened: steps_widened(&filled.steps),
            closed_by: filled
                .closing
                .as_ref()
                .map(Closing::rule)
                .map(str::to_owned),
        }
    }
}
