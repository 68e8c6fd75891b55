//! Looking ahead: how full the container would get after each of a step's options.
//!
//! Each option is followed to the end of the container by roll-outs: the greedy method packs what waits and then items drawn
//! at random from those that may arrive, on a coarser grid and without physics. All options meet the same futures (common
//! random numbers), so that their differences scatter less than their ends. The option that the objective prefers is left
//! only where another one fills more by a margin of standard errors: with few futures, the best of several means is often the
//! luckiest.

use std::sync::Arc;
use std::time::Instant;

use ppnpack_numbers::{SettingError, within};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::candidate::Candidate;
use crate::chooser::Chooser;
use crate::coarse::{CoarseGrid, CoarseItems};
use crate::episode::{IdealCell, Play, play};
use crate::heightmap::{Heightmap, Scene};
use crate::item::{Item, ItemError};
use crate::plan::Planner;
use crate::random;
use crate::step::{Evaluated, StageError, StageResult, StepInput};

/// The most items of a future.
const LONGEST_FUTURE: usize = 1_000;

/// How a step looks ahead, where the items of the buffer compete together. By default it does not: in a cell with physics nothing
/// was found to be gained by it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LookAheadSettings {
    /// How many futures each option is followed through; with 0 nothing is looked ahead.
    pub futures: usize,
    /// By how many standard errors of the mean difference an option must fill more than that of least value.
    pub significance: f64,
}

impl Default for LookAheadSettings {
    fn default() -> Self {
        Self {
            futures: 0,
            significance: 1.5,
        }
    }
}

impl LookAheadSettings {
    /// Whether a step looks ahead.
    pub fn is_on(&self) -> bool {
        self.futures > 0
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not.
    pub fn validate(&self) -> Result<(), SettingError> {
        let futures = within("between 0 and 1000", 0.0..=1e3);
        futures("the number of futures", self.futures as f64)?;
        let errors = within("between 0 and 100 standard errors", 0.0..=100.0);
        errors("the look-ahead's significance", self.significance)
    }
}

/// Chooses by roll-outs. What it chooses is the same with any number of threads.
pub struct LookAhead {
    settings: LookAheadSettings,
    seed: u64,
    grids: CoarseGrid,
    items: CoarseItems,
    /// What may arrive, on the coarse grid.
    mix: Vec<Arc<Item>>,
    /// One for each thread.
    players: Vec<Planner>,
    pool: Option<Arc<rayon::ThreadPool>>,
}

/// An option, as it was taken.
struct Start {
    scene: Scene,
    /// The items that wait then.
    waiting: Vec<Candidate>,
    volume_m3: f64,
}

impl LookAhead {
    /// A look-ahead over the items of `mix`, all equally likely; `player` makes the planners of the coarse grid.
    ///
    /// # Errors
    /// [`ItemError`] where an item has no place on the coarse grid; what `player` answers.
    pub fn new<E: From<ItemError>>(
        settings: LookAheadSettings,
        seed: u64,
        grids: CoarseGrid,
        mix: &[Arc<Item>],
        pool: Option<Arc<rayon::ThreadPool>>,
        player: impl Fn(&CoarseGrid) -> Result<Planner, E>,
    ) -> Result<Self, E> {
        let mut items = CoarseItems::default();
        let mix = mix.iter().map(|item| items.of(&grids, item));
        let mix = mix.collect::<Result<Vec<_>, _>>()?;
        let threads = pool.as_ref().map_or(1, |pool| pool.current_num_threads());
        let players = (0..threads).map(|_| player(&grids));
        Ok(Self {
            settings,
            seed,
            mix,
            items,
            players: players.collect::<Result<_, _>>()?,
            grids,
            pool,
        })
    }

    /// The coarse grid's scene and buffer after an option.
    fn start(&mut self, input: &StepInput<'_>, option: &Evaluated) -> Result<Start, StageError> {
        let lost = || StageError::from("an option is of no candidate of the step");
        let taken = input.candidates.get(option.candidate).ok_or_else(lost)?;
        let at = option.resting.placement;
        let view = taken.item.views().get(at.yaw).ok_or_else(lost)?;
        let mut heightmap = input.scene.heightmap().clone();
        heightmap.place(view, &option.resting);
        let mut waiting: Vec<Candidate> = Vec::new();
        for held in input.candidates {
            let is_other_pose = waiting
                .last()
                .is_some_and(|last| last.arrival == held.arrival);
            if held.arrival != taken.arrival && !is_other_pose {
                let item = self.items.of(&self.grids, &held.item)?;
                waiting.push(Candidate::new(held.arrival, item));
            }
        }
        Ok(Start {
            scene: Scene::from_heightmap(self.grids.pool(&heightmap)),
            waiting,
            volume_m3: taken.item.mesh_volume_m3(),
        })
    }

    /// What arrives in each of the futures: enough to fill the container.
    fn futures(&self, input: &StepInput<'_>) -> Vec<Vec<Candidate>> {
        let free_m3 = free_m3(input, input.scene.heightmap());
        let first = input.candidates.iter().map(|held| held.arrival + 1).max();
        let of_step = random::mix(self.seed, input.step);
        let futures = 0..self.settings.futures as u64;
        let draw = |future: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(random::mix(of_step, future));
            let mut drawn_m3 = 0.0;
            let arrivals = first.unwrap_or(0)..;
            let mut arriving = Vec::new();
            for arrival in arrivals.take(LONGEST_FUTURE) {
                let Some(item) = self.mix.get(random.random_range(0..self.mix.len())) else {
                    break;
                };
                drawn_m3 += item.mesh_volume_m3();
                arriving.push(Candidate::new(arrival, Arc::clone(item)));
                if drawn_m3 > free_m3 {
                    break;
                }
            }
            arriving
        };
        futures.map(draw).collect()
    }

    /// The volume that is packed in the end by each start, in each of the futures.
    fn play_all(
        &mut self,
        input: &StepInput<'_>,
        starts: &[Start],
        futures: &[Vec<Candidate>],
    ) -> StageResult<Vec<Vec<f64>>> {
        let (grids, count) = (&self.grids, self.players.len());
        let play_some = |(first, player): (usize, &mut Planner)| {
            let futures = futures.iter().enumerate().skip(first).step_by(count);
            let ends = futures.map(|(index, future)| {
                let ends = starts.iter().map(|start| {
                    let end = end_m3(grids, player, start, future, input.deadline);
                    Ok(start.volume_m3 + end?)
                });
                Ok((index, ends.collect::<StageResult<Vec<f64>>>()?))
            });
            ends.collect::<StageResult<Vec<_>>>()
        };
        let players = &mut self.players;
        let ends: Vec<StageResult<Vec<_>>> = match &self.pool {
            Some(pool) => {
                let players = players.par_iter_mut().enumerate();
                pool.install(|| players.map(play_some).collect())
            }
            None => players.iter_mut().enumerate().map(play_some).collect(),
        };
        let mut ends: Vec<_> = ends.into_iter().collect::<StageResult<Vec<_>>>()?.concat();
        ends.sort_unstable_by_key(|(index, _)| *index);
        Ok(ends.into_iter().map(|(_, ends)| ends).collect())
    }
}

impl Chooser for LookAhead {
    fn choose(&mut self, input: &StepInput<'_>, options: &[Evaluated]) -> StageResult<usize> {
        if options.len() < 2 || self.mix.is_empty() {
            return Ok(0);
        }
        let starts = options.iter().map(|option| self.start(input, option));
        let starts = starts.collect::<StageResult<Vec<_>>>()?;
        let futures = self.futures(input);
        let ends = self.play_all(input, &starts, &futures)?;
        Ok(preferred(&ends, self.settings.significance))
    }
}

/// The volume above the content, in cubic metres.
fn free_m3(input: &StepInput<'_>, heightmap: &Heightmap) -> f64 {
    let resolution = input.grid.resolution();
    let rim = input.grid.rim();
    let free = heightmap
        .heights()
        .iter()
        .map(|height| f64::from(rim - rim.min(*height)));
    free.sum::<f64>() * resolution.cell_m().powi(2) * resolution.height_unit_m()
}

/// The volume that a future packs in addition, in cubic metres.
fn end_m3(
    grids: &CoarseGrid,
    player: &mut Planner,
    start: &Start,
    future: &[Candidate],
    deadline: Option<Instant>,
) -> StageResult<f64> {
    if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
        return Err("the time limit passed".into());
    }
    let mut cell = IdealCell::holding(grids.coarse(), start.scene.clone());
    let how = Play::with_buffer(start.waiting.len() + 1);
    let sequence = start.waiting.iter().chain(future).cloned().collect();
    let episode = play(grids.coarse(), player, &mut cell, sequence, how, &mut ())?;
    Ok(episode.metrics.packed.meshes_m3)
}

/// The option that fills most of those that fill more than the first by a margin of standard errors; else the first. `ends`
/// has a row for each future, and in it the end of each option.
fn preferred(ends: &[Vec<f64>], significance: f64) -> usize {
    let options = ends.first().map_or(0, Vec::len);
    let mut best = (0, 0.0);
    for option in 1..options {
        let gains = ends
            .iter()
            .filter_map(|ends| Some(ends.get(option)? - ends.first()?));
        let gains: Vec<f64> = gains.collect();
        let count = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let squares: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
        let error = (squares / (count - 1.0).max(1.0) / count).sqrt();
        if mean > significance * error && mean > best.1 {
            best = (option, mean);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_option_is_left_only_where_another_is_better_by_the_margin() {
        // The second option is better by 2 on average, with a standard error of 1.
        let ends = [vec![10.0, 11.0], vec![10.0, 13.0]];
        assert_eq!(preferred(&ends, 1.9), 1);
        assert_eq!(preferred(&ends, 2.0), 0);
        // Among those that are better by the margin, the best.
        let ends = [vec![10.0, 11.0, 12.0, 40.0], vec![10.0, 11.1, 12.1, -15.0]];
        assert_eq!(preferred(&ends, 1.5), 2);
        // Without a margin chance decides.
        assert_eq!(preferred(&ends, 0.0), 3);
    }

    #[test]
    fn what_is_equal_or_unknown_is_not_preferred() {
        assert_eq!(preferred(&[vec![1.0, 1.0], vec![2.0, 2.0]], 0.0), 0);
        assert_eq!(preferred(&[], 1.5), 0);
        assert_eq!(preferred(&[vec![1.0]], 1.5), 0);
    }

    #[test]
    fn impossible_settings_are_named() {
        let settings = LookAheadSettings {
            significance: f64::NAN,
            ..LookAheadSettings::default()
        };
        let refused = settings.validate().unwrap_err().to_string();
        assert!(refused.contains("significance"), "{refused}");
        assert!(!LookAheadSettings::default().is_on());
    }
}
