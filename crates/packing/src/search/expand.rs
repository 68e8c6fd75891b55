//! The expansion of the open list, compiled for the processor's features.

use std::collections::binary_heap::PeekMut;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::enter::add;
use super::open::{Extent, Node, OpenList};
use super::prepared::{Ranking, resting};
use crate::kernel::distance_sum;
use crate::step::{Evaluated, PlacementCounts};

/// Placements evaluated together where there is a pool of threads.
const PARALLEL_BATCH: usize = 1024;

/// Opens nodes until a placement comes up whose value is below every bound left; gives that.
pub(super) struct Expand<'a> {
    pub(super) ranking: Ranking<'a>,
    pub(super) open: &'a mut OpenList,
    pub(super) counts: &'a mut [PlacementCounts],
    /// Room for the placements that are evaluated together.
    pub(super) fresh: &'a mut Vec<Node>,
    pub(super) arch: Arch,
    pub(super) pool: Option<&'a rayon::ThreadPool>,
}

impl WithSimd for Expand<'_> {
    type Output = Option<Evaluated>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> Self::Output {
        loop {
            let least = *self.open.peek()?;
            match least.extent {
                Extent::Valued => {
                    self.open.pop();
                    let state = self.ranking.prepared.views.get(least.view as usize)?;
                    return Some(Evaluated {
                        candidate: state.candidate,
                        resting: resting(&least, state),
                        value: least.bound,
                    });
                }
                Extent::Block { exponent: 1.. } => self.cut(least),
                Extent::Block { .. } => {
                    if let Some(mut placement) = self.open.peek_mut() {
                        *placement = self.ranking.valued(least);
                    }
                }
                Extent::Level => self.evaluate_levels(),
            }
        }
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
        self.open.pop();
        let finer = exponent - 1;
        let side = 1 << finer;
        let of = Node {
            extent: Extent::Block { exponent: finer },
            ..block
        };
        let corners = [(x, y), (x, y + side), (x + side, y), (x + side, y + side)];
        let added = add(self.ranking, self.open, of, corners);
        if finer == 0
            && let Some(counts) = self.counts.get_mut(state.candidate)
        {
            counts.fitting += added;
        }
    }

    /// Evaluates the placements of the least node, a level; with a pool those of the next levels too, so that there is
    /// work for it.
    #[inline(always)]
    fn evaluate_levels(&mut self) {
        let batch = if self.pool.is_some() {
            PARALLEL_BATCH
        } else {
            1
        };
        while self.fresh.len() < batch
            && let Some(least) = self.open.peek().copied()
            && least.extent == Extent::Level
        {
            self.collect(least);
        }
        let ranking = self.ranking;
        match self.pool {
            Some(pool) if self.fresh.len() > PARALLEL_BATCH / 4 => {
                let share = self.fresh.len().div_ceil(2 * pool.current_num_threads());
                let chunks = self.fresh.par_chunks_mut(share.max(1));
                let arch = self.arch;
                pool.install(|| {
                    chunks.for_each(|chunk| arch.dispatch(Evaluate { ranking, chunk }));
                });
            }
            _ => {
                for node in &mut *self.fresh {
                    *node = ranking.valued(*node);
                }
            }
        }
        self.open.extend(self.fresh.drain(..));
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
        match (next, self.open.peek_mut()) {
            (Some(next), Some(mut least)) => *least = next,
            (None, Some(least)) => {
                PeekMut::pop(least);
            }
            (_, None) => {}
        }
    }
}

/// Computes the values of some placements.
struct Evaluate<'a> {
    ranking: Ranking<'a>,
    chunk: &'a mut [Node],
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for node in self.chunk {
            *node = self.ranking.valued(*node);
        }
    }
}
