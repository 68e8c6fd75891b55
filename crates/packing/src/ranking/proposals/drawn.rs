//! Proposals that are drawn at random.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Percent, Proposals, Proposer, all_count, possible_count};
use crate::kernel::grid::Grid;
use crate::kernel::item::Item;
use crate::kernel::placement::Placement;
use crate::kernel::random;
use crate::ranking::step::{Candidate, StageResult, StepInput};

/// Proposes `K` % of `|P|` for each candidate, drawn from its possible placements, every subset
/// equally likely; all of them where they are fewer.
#[derive(Debug, Clone)]
pub struct ProposeRandom {
    share: Percent,
    seed: u64,
    subset: Subset,
    drawn: Vec<Placement>,
}

impl ProposeRandom {
    /// Proposes `share` of the placements, drawn with this seed.
    pub fn new(share: Percent, seed: u64) -> Self {
        Self {
            share,
            seed,
            subset: Subset::default(),
            drawn: Vec::new(),
        }
    }
}

impl Proposer for ProposeRandom {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        for candidate in input.candidates {
            let (grid, item) = (input.grid, &candidate.item);
            let wanted = self.share.of(all_count(grid, item));
            let random = &mut stream(self.seed, input, candidate);
            self.subset.draw(wanted, possible_count(grid, item), random);
            place(grid, item, self.subset.numbers(), &mut self.drawn);
            proposals.push(self.drawn.drain(..));
        }
        Ok(())
    }
}

/// Proposes for each candidate some yaws, and some positions at each, all drawn independently: the
/// fitted baseline [`PUBLISHED_TRIES`](crate::planning::method::ProposalSource::PUBLISHED_TRIES). Where none
/// of them is valid for any candidate, the step has no choice.
#[derive(Debug, Clone)]
pub struct ProposeTries {
    yaws: u8,
    positions: u8,
    seed: u64,
    drawn: Vec<Placement>,
}

impl ProposeTries {
    /// Tries so many yaws with so many positions each, drawn with this seed.
    pub fn new(yaws: u8, positions: u8, seed: u64) -> Self {
        Self {
            yaws,
            positions,
            seed,
            drawn: Vec::new(),
        }
    }

    fn draw(&mut self, grid: &Grid, item: &Item, random: &mut ChaCha8Rng) {
        let views = item.views();
        for _ in 0..self.yaws {
            let yaw = below(views.len(), random);
            let view = yaw.and_then(|yaw| Some((yaw, views.get(yaw)?)));
            let Some((yaw, view)) = view else {
                continue;
            };
            let (nx, ny) = view.corners((grid.nx(), grid.ny()));
            for _ in 0..self.positions {
                // At a yaw at which the item does not fit between the walls, a try is lost.
                let position = below(nx, random).zip(below(ny, random));
                let placement = position.map(|(x, y)| Placement { yaw, x, y });
                self.drawn.extend(placement);
            }
        }
    }
}

impl Proposer for ProposeTries {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        for candidate in input.candidates {
            let random = &mut stream(self.seed, input, candidate);
            self.draw(input.grid, &candidate.item, random);
            proposals.push(self.drawn.drain(..));
        }
        proposals.finish();
        Ok(())
    }
}

/// Makes the generator of a candidate's proposals in a step.
fn stream(seed: u64, input: &StepInput<'_>, candidate: &Candidate) -> ChaCha8Rng {
    let of_step = random::mix(seed, input.step);
    ChaCha8Rng::seed_from_u64(random::mix(of_step, candidate.stream()))
}

/// One of the first `count` numbers; none where there are none.
fn below(count: usize, random: &mut ChaCha8Rng) -> Option<usize> {
    (count > 0).then(|| random.random_range(0..count as u64) as usize)
}

/// Adds the possible placements with these rising numbers in their order by yaw, x and y.
fn place(
    grid: &Grid,
    item: &Item,
    numbers: impl Iterator<Item = usize>,
    placements: &mut Vec<Placement>,
) {
    let mut numbers = numbers.peekable();
    let mut start = 0;
    for (yaw, view) in item.views().iter().enumerate() {
        let (nx, ny) = view.corners((grid.nx(), grid.ny()));
        for x in 0..nx {
            let row = start..start + ny;
            while let Some(number) = numbers.next_if(|number| row.contains(number)) {
                let y = number - row.start;
                placements.push(Placement { yaw, x, y });
            }
            start = row.end;
        }
    }
}

/// A subset of the first whole numbers.
#[derive(Debug, Clone, Default)]
struct Subset {
    words: Vec<u64>,
    count: usize,
}

impl Subset {
    /// Draws `wanted` of the first `count` numbers, or all, every subset equally likely.
    ///
    /// One random number for each that is drawn, or for each that is left out where these are fewer
    /// (Floyd's algorithm: Bentley and Floyd, "A sample of brilliance", 1987).
    fn draw(&mut self, wanted: u64, count: u64, random: &mut ChaCha8Rng) {
        let left_out = count.saturating_sub(wanted);
        let is_inverted = left_out < wanted;
        let drawn = if is_inverted { left_out } else { wanted };
        self.count = count as usize;
        self.words.clear();
        self.words.resize(self.count.div_ceil(64), 0);
        for last in count - drawn..count {
            let any = random.random_range(0..=last);
            if !self.insert(any) {
                self.insert(last);
            }
        }
        if is_inverted {
            self.words.iter_mut().for_each(|word| *word = !*word);
        }
    }

    /// Adds a number; gives whether it was not there yet.
    fn insert(&mut self, number: u64) -> bool {
        let Some(word) = self.words.get_mut((number / 64) as usize) else {
            return false;
        };
        let bit = 1 << (number % 64);
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    fn numbers(&self) -> impl Iterator<Item = usize> {
        let words = self.words.iter().enumerate();
        let numbers = words.flat_map(|(at, word)| ones(*word).map(move |one| at * 64 + one));
        // An inverted subset has bits behind the last number.
        numbers.take_while(|number| *number < self.count)
    }
}

/// The places of the bits of a word that are set, rising.
fn ones(word: u64) -> impl Iterator<Item = usize> {
    let rests = std::iter::successors(Some(word), |rest| Some(rest & rest.wrapping_sub(1)));
    let rests = rests.take_while(|rest| *rest != 0);
    rests.map(|rest| rest.trailing_zeros() as usize)
}
