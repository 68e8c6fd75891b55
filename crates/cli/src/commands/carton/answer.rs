//! The answer, for programs and people.

use std::time::Duration;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::streams::carton::RuledOut;
use ppnpack_packing::streams::episode::Step;
use ppnpack_perception::extrinsics::Extrinsics;
use serde::Serialize;

use super::attempt::Tried;
use super::search::{Found, Open, Search};
use crate::report::Unplaceable;

/// Which carton an order goes into, and how.
#[derive(Debug, Serialize)]
pub(super) struct Answer {
    order: String,
    /// Number of its items.
    items: usize,
    /// Volume of their meshes.
    items_m3: f64,
    items_kg: f64,
    seed: u64,
    /// The smallest carton that does; none where none does.
    carton: Option<Chosen>,
    /// The smaller ones, by volume.
    refused: Vec<Refused>,
    /// Of these the one that leaves out least, where none does.
    closest: Option<String>,
    took_s: f64,
}

/// A carton as it is described.
#[derive(Debug, Serialize)]
struct Described {
    name: String,
    size_m: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    max_kg: Option<f64>,
    /// Share of its volume that the meshes of all items have.
    fill: f64,
    /// Number of sequences of the items that were tried in it.
    sequences: u32,
}

/// The carton that does, with the plan.
#[derive(Debug, Serialize)]
struct Chosen {
    #[serde(flatten)]
    carton: Described,
    /// The items in the order in which they are placed.
    placements: Vec<Placement>,
}

/// An item, with poses of its own frame in the carton's, whose origin is an inner bottom corner.
#[derive(Debug, Serialize)]
struct Placement {
    /// From 0.
    step: usize,
    /// Number of the item in the order, from 0.
    arrival: usize,
    item: String,
    /// Number of its resting pose; 0 is the offered one.
    pose: usize,
    /// Where it is let go.
    placed: Extrinsics,
    /// Where it lies when all is packed.
    lies: Extrinsics,
}

/// A carton that does not do.
#[derive(Debug, Serialize)]
struct Refused {
    #[serde(flatten)]
    carton: Described,
    kind: Kind,
    /// Why, for people.
    reason: String,
    /// The items that are too large for it, or that the best sequence left out.
    left_out: Vec<Unplaceable>,
    #[serde(skip)]
    left_m3: f64,
}

#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Weight,
    Size,
    Volume,
    Tried,
}

impl Answer {
    pub(super) fn of(
        order: &str,
        search: &Search<'_>,
        cartons: &[Open<'_>],
        found: &[Found],
        took: Duration,
    ) -> Self {
        let items_kg = search.first_poses().filter_map(Candidate::weighs_kg).sum();
        let mut answer = Self {
            order: order.to_owned(),
            items: search.first_poses().count(),
            items_m3: search.all_m3(),
            items_kg,
            seed: search.method.seed,
            carton: None,
            refused: Vec::new(),
            closest: None,
            took_s: took.as_secs_f64(),
        };
        for (open, found) in cartons.iter().zip(found) {
            let described = |sequences| answer.described(open, sequences);
            match found {
                Found::RuledOut(why) => {
                    let refused = Refused::ruled_out(described(0), why, search);
                    answer.refused.push(refused);
                }
                Found::LeavesOut(tried, left) => {
                    let refused = Refused::tried(described(*tried), left, search);
                    answer.refused.push(refused);
                }
                Found::Does(tried, packed) => {
                    answer.carton = Some(Chosen {
                        carton: described(*tried),
                        placements: placements(packed, &open.grid),
                    });
                }
            }
        }
        if answer.carton.is_none() {
            let refused = answer.refused.iter().rev();
            let closest = refused.min_by(|a, b| a.left_m3.total_cmp(&b.left_m3));
            answer.closest = closest.map(|refused| refused.carton.name.clone());
        }
        answer
    }

    fn described(&self, open: &Open<'_>, sequences: u32) -> Described {
        let size = open.carton.size;
        Described {
            name: open.carton.name.clone(),
            size_m: [size.x_m, size.y_m, size.z_m],
            max_kg: open.carton.max_kg,
            fill: self.items_m3 / size.volume_m3(),
            sequences,
        }
    }

    /// Says that no carton does, which came closest and what it leaves out.
    pub(super) fn failure(&self) -> Option<String> {
        let closest = self.closest.as_ref()?;
        let refused = self
            .refused
            .iter()
            .find(|refused| refused.carton.name == *closest)?;
        let order = &self.order;
        Some(format!(
            "no carton takes order {order}; {closest} comes closest: {}",
            refused.reason
        ))
    }
}

impl Refused {
    fn ruled_out(carton: Described, why: &RuledOut, search: &Search<'_>) -> Self {
        let (kind, arrivals) = match why {
            RuledOut::Size { arrivals } => (Kind::Size, &**arrivals),
            RuledOut::Weight { .. } => (Kind::Weight, &[][..]),
            _ => (Kind::Volume, &[][..]),
        };
        let items = search
            .first_poses()
            .filter(|held| arrivals.contains(&held.arrival));
        let left: Vec<Unplaceable> = items
            .map(|held| Unplaceable::new(held, why.to_string()))
            .collect();
        let reason = match left.is_empty() {
            true => why.to_string(),
            false => format!("{}: {why}", names(&left)),
        };
        // Without one that is to blame, all of it is out.
        let left_m3 = match left.is_empty() {
            true => search.all_m3(),
            false => search.volume_m3(&left),
        };
        Self {
            carton,
            kind,
            reason,
            left_out: left,
            left_m3,
        }
    }

    fn tried(carton: Described, left: &[Unplaceable], search: &Search<'_>) -> Self {
        let tried = match carton.sequences {
            1 => "a sequence that was tried leaves".to_owned(),
            more => format!("the best of {more} sequences leaves"),
        };
        Self {
            reason: format!("{tried} out {}", names(left)),
            carton,
            kind: Kind::Tried,
            left_m3: search.volume_m3(left),
            left_out: left.to_vec(),
        }
    }
}

/// Names items, each kind once.
fn names(items: &[Unplaceable]) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for item in items {
        match counts.iter_mut().find(|(name, _)| *name == item.item) {
            Some((_, count)) => *count += 1,
            None => counts.push((&item.item, 1)),
        }
    }
    let told = counts.into_iter().map(|(name, count)| match count {
        1 => name.to_owned(),
        count => format!("{count} {name}"),
    });
    told.collect::<Vec<_>>().join(", ")
}

/// Gives the placements of a plan that was done.
fn placements(tried: &Tried, grid: &Grid) -> Vec<Placement> {
    let contents = tried.cell.contents();
    let placement = |(number, step): (usize, &Step)| {
        let held = &step.candidate;
        let frame = held.item.container_from_item(grid, &step.choice.resting)?;
        let planned = step.evidence.lower(held.lying.own_frame(&frame));
        let (_, lies) = contents
            .iter()
            .find(|(arrival, _)| *arrival == held.arrival)?;
        Some(Placement {
            step: number,
            arrival: held.arrival,
            item: held.item.name().to_string(),
            pose: held.pose,
            placed: Extrinsics::from(&planned),
            lies: Extrinsics::from(&lies.container_from_item),
        })
    };
    tried
        .episode
        .steps
        .iter()
        .enumerate()
        .filter_map(placement)
        .collect()
}
