//! The local evaluator: a best-first search that computes an objective only where it may matter.
//!
//! One open list holds what is left of a ranking, the least bound first. Placements enter it as
//! levels, one per view and resting height, or, in the bounded search, as blocks of `2^e`
//! placements a side. A level is opened by evaluating its placements, a block by cutting it in
//! four, down to single ones. A value is final once it is below every bound left. So expensive
//! terms are computed near the best alone, and the order, ties included, is that of a full sort.
//!
//! Only blocks come down to single placements in the list. Where resting heights are known,
//! entering each singly was measured to take 10 to 50 % longer a step than passes over them do.

mod enter;
mod expand;
pub(crate) mod limits;
mod open;
mod passes;
mod prepared;
mod proposed;
pub(crate) mod value;
mod windows;

use ppnpack_numbers::settings;
use pulp::Arch;

use crate::kernel::clock::Clock;
use crate::kernel::distance::DistanceLevels;
use crate::kernel::grid::{Grid, MAX_UNITS, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::ItemView;
use crate::kernel::lanes::BlockOffsets;
use crate::kernel::objective::{Heuristic, Objective, Order, SettingError, Weights};
use crate::kernel::resting::RestingHeights;
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::{CandidateProposals, Proposals, possible_count_below_rim};
use crate::ranking::step::{Evaluated, PlacementCounts, Shortfall, StageResult, StepInput};
use enter::Enter;
use expand::{Expand, Stopped};
pub use limits::TooMuchMemory;
use limits::{CUT, container_bytes, nodes_bytes, view_bytes};
use open::{Extent, Node, OpenList};
use prepared::{Entrance, Prepared, Ranking, UpdateScene, ViewState};
use proposed::{Lower, Proposed};
use windows::Windows;

/// About how many blocks a view enters with, single placements where there are no blocks.
const LARGEST_BLOCKS: usize = 64;

/// Evaluates a heuristic over proposals on this machine.
#[derive(Debug)]
pub struct Search {
    grid: Grid,
    /// How far above the rim items may reach.
    above_rim: Units,
    arch: Arch,
    prepared: Prepared,
    counts: Vec<PlacementCounts>,
    open: OpenList,
    fresh: Vec<Node>,
    /// The most memory that it may take.
    limit_bytes: usize,
    /// Bytes of it that the ranking took before anything was opened.
    entered_bytes: usize,
    shortfall: Shortfall,
}

settings! {
    /// Settings of a search. The defaults are the paper's: SDFM, the items of the buffer together.
    pub struct SearchSettings {
        /// Objective.
        pub heuristic: Heuristic = Heuristic::Sdfm,
        /// Whether the items of the buffer compete together, with the objective's balance term.
        pub order: Order = Order::Balance,
        /// The weights of the objective's terms.
        pub weights: Weights = Weights::default(),
        /// Drives [`Heuristic::Random`].
        pub seed: u64 = 0,
        /// Reach of an item above the rim where it is placed, in metres: it may sink when tried.
        pub above_rim_m: f64 = 0.0,
    }
}

impl Search {
    /// A search on one thread.
    pub fn new(grid: &Grid, settings: &SearchSettings) -> Result<Self, SettingError> {
        settings.weights.validate()?;
        let balanced = settings.order == Order::Balance;
        let needs_distance = settings.heuristic == Heuristic::Sdfm;
        Ok(Self {
            grid: grid.clone(),
            above_rim: above_rim(grid, settings.above_rim_m),
            arch: Arch::new(),
            prepared: Prepared {
                objective: Objective::new(grid, settings.heuristic, &settings.weights, balanced),
                seed: settings.seed,
                resting: RestingHeights::new(grid),
                distance: needs_distance.then(|| DistanceLevels::new(grid)),
                proposed: Proposed::new(grid),
                windows: None,
                views: Vec::new(),
                offsets: Vec::new(),
            },
            counts: Vec::new(),
            open: OpenList::new(),
            fresh: Vec::new(),
            limit_bytes: usize::MAX,
            entered_bytes: 0,
            shortfall: Shortfall::default(),
        })
    }

    /// About how many bytes a bounded search on a grid takes before anything is ranked.
    pub fn least_bytes(grid: &Grid, heuristic: Heuristic) -> usize {
        container_bytes(grid, heuristic, Windows::exponents(grid))
    }

    /// Fails with [`TooMuchMemory`], in place of taking more memory than about this many bytes.
    #[must_use]
    pub fn within_bytes(mut self, limit_bytes: usize) -> Self {
        self.limit_bytes = limit_bytes;
        self
    }

    fn entered_bytes(
        &self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> usize {
        let of_candidate = |candidate: &usize| {
            let held = input.candidates.get(*candidate)?;
            let is_some = matches!(proposals.of(*candidate), CandidateProposals::Some(_));
            let is_whole = !is_some && self.prepared.windows.is_none();
            let views = held.item.views().iter();
            let bytes = views.map(|view| view_bytes(&self.grid, view, is_whole));
            Some(bytes.sum::<usize>())
        };
        self.container_bytes() + group.iter().filter_map(of_candidate).sum::<usize>()
    }

    fn container_bytes(&self) -> usize {
        let windows = self.prepared.windows.as_ref();
        let windows = windows.map_or(0, |windows| usize::from(windows.largest_exponent));
        container_bytes(&self.grid, self.prepared.objective.heuristic, windows)
    }

    /// How many nodes may be open beside what a ranking took before.
    fn most_open(&self) -> usize {
        self.limit_bytes.saturating_sub(self.entered_bytes) / nodes_bytes(1)
    }

    /// Looks only where a bound does not rule out the best, for candidates of which all placements
    /// are proposed. The ranking is the same, bit for bit, but [`PlacementCounts::fitting`] counts
    /// what was looked at. SDFM, DBL and HM have such bounds; with others this changes nothing.
    ///
    /// It pays on fine grids; it runs on one thread.
    #[must_use]
    pub fn bounded(mut self) -> Self {
        self.prepared.windows = Windows::new(&self.grid, self.prepared.objective.heuristic);
        self
    }

    fn update_scene(&mut self, input: &StepInput<'_>) {
        let heightmap = input.scene.heightmap();
        let walled = self.walled(heightmap);
        let heightmap = walled.as_ref().unwrap_or(heightmap);
        let prepared = &mut self.prepared;
        let buffer = input.candidates.iter().map(|held| &*held.item);
        if prepared.resting.update(heightmap, buffer) {
            self.arch.dispatch(UpdateScene {
                prepared,
                heightmap,
            });
        }
    }

    /// The heightmap with what reaches the rim, such as blocked or unseen cells, as high as items
    /// may reach, so that nothing comes to lie over it; `None` where it is that already.
    fn walled(&self, heightmap: &Heightmap) -> Option<Heightmap> {
        let rim = self.grid.rim();
        if self.above_rim == 0 || heightmap.max() < rim {
            return None;
        }
        let mut walled = heightmap.clone();
        for x in 0..heightmap.nx() {
            for (y, height) in heightmap.row(x).iter().enumerate() {
                if *height >= rim {
                    walled.raise(x, y, rim + self.above_rim);
                }
            }
        }
        Some(walled)
    }

    /// The greatest resting height of a view; below 0 where it is taller than the container.
    fn highest(&self, view: &ItemView) -> Units {
        let rim = self.grid.rim();
        match view.height() {
            height if height > rim => -1,
            height => (rim - height + self.above_rim).min(rim - 1),
        }
    }

    /// Enters the placements of a candidate that do not reach too high, or says what stopped it.
    fn enter(
        &mut self,
        input: &StepInput<'_>,
        candidate: usize,
        proposals: &Proposals,
        most_open: usize,
    ) -> Result<(), Stopped> {
        let Some(held) = input.candidates.get(candidate) else {
            return Ok(());
        };
        let mut clock = Clock::new(input.deadline);
        let item = &*held.item;
        let entrance = match (proposals.of(candidate), &self.prepared.windows) {
            (CandidateProposals::Some(placements), _) => {
                let first = self.prepared.views.len();
                self.prepared.proposed.take(first, item, placements);
                Entrance::Proposed
            }
            (_, Some(_)) => Entrance::Blocks,
            (_, None) => {
                let resting = &mut self.prepared.resting;
                resting.prepare(item, input.deadline);
                Entrance::All
            }
        };
        let mut counts = PlacementCounts {
            possible: possible_count_below_rim(&self.grid, item),
            ..PlacementCounts::default()
        };
        for (yaw, view) in item.views().iter().enumerate() {
            if clock.is_over_before(LARGEST_BLOCKS * view.nx() * view.ny()) {
                return Err(Stopped::Late);
            }
            let index = self.prepared.views.len();
            self.prepared.views.push(ViewState {
                candidate,
                yaw,
                constant: self.prepared.objective.constant(view),
                limit: self.highest(view),
                footprint: view.nx() * view.ny(),
                entrance,
            });
            if entrance != Entrance::All {
                self.prepared.update_offsets(index, view);
            }
            if entrance == Entrance::Proposed {
                self.lower(index, view);
            }
            let (proposed, fitting) = self.arch.dispatch(Enter {
                ranking: Ranking::new(&self.prepared, input),
                fresh: &mut self.fresh,
                index,
            });
            counts.proposed += proposed;
            counts.fitting += fitting;
            if self.fresh.len() > most_open {
                return Err(Stopped::Full);
            }
        }
        if let Some(entry) = self.counts.get_mut(candidate) {
            *entry = counts;
        }
        Ok(())
    }

    fn stop(&mut self, stopped: Stopped) -> StageResult {
        // Memory of its own is given back: it may be all that there is.
        self.open = OpenList::new();
        self.fresh = Vec::new();
        match stopped {
            Stopped::Late => {
                self.shortfall.cut(CUT.to_owned());
                Ok(())
            }
            Stopped::Full => Err(self.too_much().into()),
        }
    }

    fn too_much(&self) -> TooMuchMemory {
        TooMuchMemory {
            limit_bytes: self.limit_bytes,
        }
    }

    fn lower(&mut self, index: usize, view: &ItemView) {
        let Prepared {
            resting,
            proposed,
            offsets,
            ..
        } = &mut self.prepared;
        if let (Some(proposed), Some(offsets)) = (proposed.views.get_mut(index), offsets.get(index))
        {
            self.arch.dispatch(Lower {
                container: &resting.container,
                view,
                proposed,
                offsets,
            });
        }
    }
}

/// A length above the rim, in units.
fn above_rim(grid: &Grid, above_rim_m: f64) -> Units {
    let units = (above_rim_m / grid.resolution().height_unit_m()).round();
    units.clamp(0.0, f64::from(MAX_UNITS - grid.rim())) as Units
}

impl Evaluator for Search {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> StageResult {
        self.prepared.views.clear();
        self.open.clear();
        self.fresh.clear();
        self.shortfall.clear();
        self.counts.clear();
        self.counts
            .resize(input.candidates.len(), PlacementCounts::default());
        self.entered_bytes = self.entered_bytes(input, group, proposals);
        if self.entered_bytes > self.limit_bytes {
            return Err(self.too_much().into());
        }
        self.update_scene(input);
        let most_open = self.most_open();
        // In the order of the candidates, as equal values come in the order of the views.
        for candidate in (0..input.candidates.len()).filter(|held| group.contains(held)) {
            if let Err(stopped) = self.enter(input, candidate, proposals, most_open) {
                return self.stop(stopped);
            }
        }
        // Together, which is sooner than one by one.
        self.open.extend(self.fresh.drain(..));
        Ok(())
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> StageResult<Option<Evaluated>> {
        let least = self.open.peek();
        // More often than not the next value is known already.
        if least.is_some_and(|least| least.extent != Extent::Valued) {
            let most_open = self.most_open();
            let expanded = self.arch.dispatch(Expand {
                ranking: Ranking::new(&self.prepared, input),
                open: &mut self.open,
                counts: &mut self.counts,
                fresh: &mut self.fresh,
                clock: Clock::new(input.deadline),
                most_open,
            });
            if let Err(stopped) = expanded {
                return self.stop(stopped).map(|()| None);
            }
        }
        let best = self.open.pop();
        Ok(best.and_then(|best| self.prepared.evaluated(&best)))
    }

    fn leave_out(&mut self, candidate: usize) {
        let views = &self.prepared.views;
        let is_of = |node: &Node| {
            let view = views.get(node.view as usize);
            view.is_some_and(|view| view.candidate == candidate)
        };
        self.open.retain(|node| !is_of(node));
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.counts.get(candidate).copied().unwrap_or_default()
    }

    fn held_bytes(&self) -> usize {
        let offsets = self.prepared.offsets.iter().map(BlockOffsets::bytes);
        self.container_bytes()
            + self.prepared.resting.held_bytes()
            + offsets.sum::<usize>()
            + nodes_bytes(self.open.capacity() + self.fresh.capacity())
    }

    fn shortfall(&self) -> Option<&Shortfall> {
        Some(&self.shortfall)
    }
}
