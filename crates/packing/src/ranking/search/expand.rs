//! The expansion of the open list, compiled for the processor's features.

use std::collections::binary_heap::PeekMut;

use pulp::{Simd, WithSimd};

use super::enter::add;
use super::open::{Extent, Node, OpenList};
use super::prepared::Ranking;
use crate::kernel::clock::Clock;
use crate::kernel::lanes::distance_sum;
use crate::ranking::step::PlacementCounts;

/// Why a ranking does not go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stopped {
    Late,
    /// More is open than may be.
    Full,
}

/// Opens nodes until the least is a placement whose value is known, or none is left.
pub(super) struct Expand<'a> {
    pub(super) ranking: Ranking<'a>,
    pub(super) open: &'a mut OpenList,
    pub(super) counts: &'a mut [PlacementCounts],
    /// Room for what is to enter the list; empty between two nodes.
    pub(super) fresh: &'a mut Vec<Node>,
    pub(super) clock: Clock,
    /// Nodes that may be open at most.
    pub(super) most_open: usize,
}

impl WithSimd for Expand<'_> {
    type Output = Result<(), Stopped>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> Self::Output {
        while let Some(least) = self.open.peek().copied() {
            if self.clock.is_over_before(self.ranking.footprint(&least)) {
                return Err(Stopped::Late);
            }
            if self.open.len() > self.most_open {
                return Err(Stopped::Full);
            }
            match least.extent {
                Extent::Valued => return Ok(()),
                Extent::Block { exponent: 1.. } => self.cut(least),
                Extent::Block { .. } => {
                    let valued = self.ranking.valued(least);
                    self.replace_least(Some(valued));
                }
                Extent::Level => self.evaluate_level(least)?,
            }
        }
        Ok(())
    }
}

impl Expand<'_> {
    /// Cuts the least node, a block, in four; before that its bound is sharpened once.
    #[inline(always)]
    fn cut(&mut self, block: Node) {
        let Ranking { prepared, .. } = self.ranking;
        let (Extent::Block { exponent }, Some((state, _, view))) =
            (block.extent, self.ranking.view(block.view as usize))
        else {
            return;
        };
        let (x, y) = (usize::from(block.x), usize::from(block.y));
        let windows = prepared.windows.as_ref();
        if !block.is_measured
            && let Some(levels) = windows.and_then(|windows| windows.distance(exponent))
        {
            let base = prepared.resting.container.index(x, y);
            let measured = Node {
                distance_sum: distance_sum(levels, base, view, block.height),
                is_measured: true,
                ..block
            };
            // The heap moves it back to where its new bound belongs.
            if let Some(mut least) = self.open.peek_mut() {
                *least = self.ranking.bounded(measured, state, view);
            }
            return;
        }
        let finer = exponent - 1;
        let side = 1 << finer;
        let of = Node {
            extent: Extent::Block { exponent: finer },
            ..block
        };
        let corners = [(x, y), (x, y + side), (x + side, y), (x + side, y + side)];
        add(self.ranking, of, corners, self.fresh);
        if finer == 0
            && let Some(counts) = self.counts.get_mut(state.candidate)
        {
            counts.fitting += self.fresh.len() as u64;
        }
        // A part is hardly ever far from where the whole was, so one of them takes its place.
        let part = self.fresh.pop();
        self.replace_least(part);
        self.open.extend(self.fresh.drain(..));
    }

    /// Puts another node in the place of the least, or none.
    #[inline(always)]
    fn replace_least(&mut self, by: Option<Node>) {
        match (by, self.open.peek_mut()) {
            (Some(node), Some(mut least)) => *least = node,
            (None, Some(least)) => {
                PeekMut::pop(least);
            }
            (_, None) => {}
        }
    }

    /// Evaluates the least node, a level.
    #[inline(always)]
    fn evaluate_level(&mut self, level: Node) -> Result<(), Stopped> {
        self.collect(level);
        if self.open.len() + self.fresh.len() > self.most_open {
            return Err(Stopped::Full);
        }
        let ranking = self.ranking;
        for node in &mut *self.fresh {
            if self.clock.is_over_before(ranking.footprint(node)) {
                return Err(Stopped::Late);
            }
            *node = ranking.valued(*node);
        }
        self.open.extend(self.fresh.drain(..));
        Ok(())
    }

    /// Takes the placements of the least node, a level; the view's next level takes its place.
    #[inline(always)]
    fn collect(&mut self, level: Node) {
        let index = level.view as usize;
        let mut next = None;
        if let Some((state, _, view)) = self.ranking.view(index)
            && let Some(placements) = self.ranking.placements(index)
        {
            let height = placements.collect(level, self.fresh);
            if height <= state.limit {
                let level = Node { height, ..level };
                next = Some(self.ranking.bounded(level, state, view));
            }
        }
        self.replace_least(next);
    }
}
