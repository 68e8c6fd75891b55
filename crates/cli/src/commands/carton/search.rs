//! The search for the smallest carton: several at once, each by one sequence after another.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::anyhow;
use indicatif::ProgressBar;
use ppnpack_catalogue::cartons::Carton;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::streams::carton::{RuledOut, Sequences, ruled_out};

use super::attempt::{Bench, Tried};
use crate::failure::{OrRun, Outcome};
use crate::options::Simulated;
use crate::progress;
use crate::report::Unplaceable;

/// Greatest share of the items' volume that the first sequence may leave out: of a carton in which
/// it leaves out more, no other is tried.
const HOPELESS_SHARE: f64 = 0.3;

/// A carton that may be chosen, on its grid.
pub(super) struct Open<'a> {
    pub(super) carton: &'a Carton,
    pub(super) grid: Grid,
    pub(super) simulated: Simulated,
}

/// What was found out of a carton.
pub(super) enum Found {
    /// Nothing was tried in it.
    RuledOut(RuledOut),
    /// In none of so many sequences are all items in it; the least left out.
    LeavesOut(u32, Vec<Unplaceable>),
    /// All items lie in it by the last of so many sequences.
    Does(u32, Box<Tried>),
}

/// The search for an order's carton.
pub(super) struct Search<'a> {
    pub(super) catalogue: &'a Catalogue,
    pub(super) method: &'a Method,
    /// The items of the order, each in all of its poses.
    pub(super) items: &'a [Candidate],
    /// The most sequences that are tried in a carton.
    pub(super) sequences: u32,
}

impl Search<'_> {
    /// Gives what was found out of each carton, from the smallest on, up to the first that does.
    pub(super) fn smallest(&self, cartons: &[Open<'_>]) -> Outcome<Vec<Found>> {
        let mut found: BTreeMap<usize, Found> = BTreeMap::new();
        let mut open = Vec::new();
        for (number, carton) in cartons.iter().enumerate() {
            match ruled_out(&carton.grid, self.items, carton.carton.max_kg) {
                Some(why) => drop(found.insert(number, Found::RuledOut(why))),
                None => open.push((number, carton)),
            }
        }
        for (number, tried) in self.try_all(&open)? {
            found.insert(number, tried?);
        }
        let does = |found: &Found| matches!(found, Found::Does(..));
        let mut found: Vec<Found> = found.into_values().collect();
        if let Some(first) = found.iter().position(does) {
            found.truncate(first + 1);
        }
        Ok(found)
    }

    /// Tries cartons on all cores, the smallest first, until one does and all smaller ones do not.
    fn try_all(&self, open: &[(usize, &Open<'_>)]) -> Outcome<BTreeMap<usize, Outcome<Found>>> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = cores.clamp(1, open.len().max(1));
        let bar = progress::bar("Trying", open.len() as u64 * u64::from(self.sequences));
        let (next, ends_at) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
        let found: Mutex<BTreeMap<usize, Outcome<Found>>> = Mutex::new(BTreeMap::new());
        let work = || {
            while let Some((number, carton)) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                let is_over = || ends_at.load(Ordering::Relaxed) < *number;
                if is_over() {
                    break;
                }
                let tried = self.carton(carton, cores / workers, &is_over, &bar);
                if matches!(tried, Ok(Some(Found::Does(..))) | Err(_)) {
                    ends_at.fetch_min(*number, Ordering::Relaxed);
                }
                if let (Ok(mut found), Some(tried)) = (found.lock(), tried.transpose()) {
                    found.insert(*number, tried);
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(work);
            }
        });
        bar.finish_and_clear();
        let broken = |_| anyhow!("a try of a carton panicked");
        found.into_inner().map_err(broken).or_run()
    }

    /// Tries sequences in a carton until one does; `None` where it is over before.
    fn carton(
        &self,
        open: &Open<'_>,
        threads: usize,
        is_over: &dyn Fn() -> bool,
        bar: &ProgressBar,
    ) -> Outcome<Option<Found>> {
        let bench = Bench {
            catalogue: self.catalogue,
            method: self.method,
            grid: &open.grid,
            simulated: &open.simulated,
            threads,
        };
        let mut sequences = Sequences::new(self.items, self.method.seed);
        let mut least: Option<Vec<Unplaceable>> = None;
        let mut tried = 0;
        while tried < self.sequences {
            let Some(attempt) = bench.attempt(sequences.next_sequence(), tried == 0, is_over)?
            else {
                return Ok(None);
            };
            tried += 1;
            bar.inc(1);
            if attempt.left_out.is_empty() {
                return Ok(Some(Found::Does(tried, Box::new(attempt))));
            }
            sequences.left_out(&attempt.failed);
            let left_m3 = |left: &[Unplaceable]| self.volume_m3(left);
            if least
                .as_ref()
                .is_none_or(|least| left_m3(&attempt.left_out) < left_m3(least))
            {
                least = Some(attempt.left_out);
            }
            let left_m3 = least.as_deref().map_or(0.0, left_m3);
            if left_m3 > HOPELESS_SHARE * self.all_m3() {
                break;
            }
        }
        bar.inc(u64::from(self.sequences - tried));
        Ok(Some(Found::LeavesOut(tried, least.unwrap_or_default())))
    }

    /// Gives the volume of these items, in cubic metres.
    pub(super) fn volume_m3(&self, left: &[Unplaceable]) -> f64 {
        let is_left = |held: &&Candidate| left.iter().any(|item| item.arrival == held.arrival);
        let items = self.first_poses().filter(is_left);
        items.map(|held| held.item.mesh_volume_m3()).sum()
    }

    /// Gives the volume of all items, in cubic metres.
    pub(super) fn all_m3(&self) -> f64 {
        let items = self.first_poses();
        items.map(|held| held.item.mesh_volume_m3()).sum()
    }

    /// The items in their first poses.
    pub(super) fn first_poses(&self) -> impl Iterator<Item = &Candidate> {
        let items = self.items.chunk_by(|a, b| a.arrival == b.arrival);
        items.filter_map(<[Candidate]>::first)
    }
}
