//! State of a ranking that is only read while the open list is expanded.

use pulp::{Simd, WithSimd};

use super::open::{Extent, Node};
use super::passes::Placements;
use super::proposed::Proposed;
use super::value::Valuation;
use super::windows::Windows;
use crate::kernel::distance::DistanceLevels;
use crate::kernel::grid::Units;
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::ItemView;
use crate::kernel::lanes::BlockOffsets;
use crate::kernel::objective::Objective;
use crate::kernel::placement::{Placement, RestingPlacement};
use crate::kernel::random;
use crate::kernel::resting::RestingHeights;
use crate::ranking::step::{Candidate, Evaluated, StepInput};

/// State of a ranking: maps of the container, and the views that take part.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) objective: Objective,
    pub(super) seed: u64,
    pub(super) resting: RestingHeights,
    pub(super) proposed: Proposed,
    pub(super) distance: Option<DistanceLevels>,
    pub(super) windows: Option<Windows>,
    pub(super) views: Vec<ViewState>,
    /// Offsets of the views whose resting heights are not computed by rows, by index of the view.
    pub(super) offsets: Vec<BlockOffsets>,
}

/// A view of a candidate that takes part in the current ranking.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewState {
    pub(super) candidate: usize,
    pub(super) yaw: usize,
    /// The terms of the objective that are the same for all of its placements.
    pub(super) constant: f64,
    /// The greatest resting height at which it does not reach too high.
    pub(super) limit: Units,
    pub(super) footprint: usize,
    pub(super) entrance: Entrance,
}

/// Way of a view's placements into the open list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Entrance {
    /// All, as levels: the resting height of every placement is computed.
    All,
    Blocks,
    /// Proposed ones alone, as levels.
    Proposed,
}

impl Prepared {
    #[inline(always)]
    pub(super) fn valuation(&self) -> Valuation<'_> {
        Valuation {
            objective: &self.objective,
            container: &self.resting.container,
            distance: self.distance.as_ref(),
        }
    }

    /// A placement whose value is known.
    pub(super) fn evaluated(&self, best: &Node) -> Option<Evaluated> {
        let state = self.views.get(best.view as usize)?;
        Some(Evaluated {
            candidate: state.candidate,
            resting: resting(best, state),
            value: best.bound,
        })
    }

    /// Lays out a view for the loops over single placements.
    pub(super) fn update_offsets(&mut self, index: usize, view: &ItemView) {
        if self.offsets.len() <= index {
            self.offsets.resize_with(index + 1, BlockOffsets::default);
        }
        if let Some(offsets) = self.offsets.get_mut(index) {
            offsets.update(&self.resting.container, view);
        }
    }
}

/// Recomputes the maps that depend on the container alone.
pub(super) struct UpdateScene<'a> {
    pub(super) prepared: &'a mut Prepared,
    pub(super) heightmap: &'a Heightmap,
}

impl WithSimd for UpdateScene<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Prepared {
            resting,
            distance,
            windows,
            ..
        } = self.prepared;
        if let Some(distance) = distance {
            distance.update(self.heightmap);
        }
        if let Some(windows) = windows {
            windows.update(&resting.container, distance.as_ref());
        }
    }
}

/// A ranking of a step.
#[derive(Clone, Copy)]
pub(super) struct Ranking<'a> {
    pub(super) prepared: &'a Prepared,
    candidates: &'a [Candidate],
    seed: u64,
}

impl<'a> Ranking<'a> {
    pub(super) fn new(prepared: &'a Prepared, input: &StepInput<'a>) -> Self {
        Self {
            prepared,
            candidates: input.candidates,
            seed: random::mix(prepared.seed, input.step),
        }
    }

    #[inline(always)]
    pub(super) fn view(
        &self,
        index: usize,
    ) -> Option<(&'a ViewState, &'a Candidate, &'a ItemView)> {
        let state = self.prepared.views.get(index)?;
        let held = self.candidates.get(state.candidate)?;
        Some((state, held, held.item.views().get(state.yaw)?))
    }

    #[inline(always)]
    pub(super) fn footprint(&self, node: &Node) -> usize {
        let state = self.prepared.views.get(node.view as usize);
        state.map_or(0, |state| state.footprint)
    }

    /// The resting heights of a view that enters as levels.
    #[inline(always)]
    pub(super) fn placements(&self, index: usize) -> Option<Placements<'a>> {
        let (state, held, _) = self.view(index)?;
        match state.entrance {
            Entrance::Blocks => None,
            Entrance::All => {
                let maps = self.prepared.resting.views(held.item.shape());
                maps.get(state.yaw).map(Placements::All)
            }
            Entrance::Proposed => {
                let proposed = self.prepared.proposed.views.get(index);
                proposed.map(Placements::Proposed)
            }
        }
    }

    /// The node with the bound that follows from what is known of it.
    #[inline(always)]
    pub(super) fn bounded(&self, node: Node, state: &ViewState, view: &ItemView) -> Node {
        let objective = &self.prepared.objective;
        let at = (usize::from(node.x), usize::from(node.y));
        let bound = objective.block_bound(view, state.constant, at, node.height, node.distance_sum);
        Node { bound, ..node }
    }

    /// The placement with its value.
    #[inline(always)]
    pub(super) fn valued(&self, node: Node) -> Node {
        // No closure here: it would not be compiled for the processor's features.
        let value = if let Some((state, held, view)) = self.view(node.view as usize) {
            let seed = random::mix(self.seed, held.stream());
            let valuation = self.prepared.valuation();
            valuation.value(view, state.constant, resting(&node, state), seed)
        } else {
            f64::INFINITY
        };
        Node {
            bound: value,
            extent: Extent::Valued,
            ..node
        }
    }
}

#[inline(always)]
fn resting(node: &Node, state: &ViewState) -> RestingPlacement {
    RestingPlacement {
        placement: Placement {
            yaw: state.yaw,
            x: usize::from(node.x),
            y: usize::from(node.y),
        },
        resting_height: node.height,
    }
}
