//! The methods that are compared, and how one plays an instance.

use std::time::Instant;

use clap::ValueEnum;
use ppnpack_cli::failure::Outcome;
use ppnpack_packing::kernel::objective::Heuristic;
use serde::{Deserialize, Serialize};

use super::bin::Bin;
use super::engine::Engine;
use super::look_ahead::LookAhead;
use super::rules::Setting;
use super::snug::Snug;
use super::source::{Boxes, Instance};
use super::surface::{Placed, Sides};

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Method {
    /// The engine's deepest bottom-left
    Dbl,
    /// The engine's heightmap minimisation
    Hm,
    /// The engine's signed-distance-field minimisation
    Sdfm,
    /// The engine's maximum touching area
    Mta,
    /// Little space lost below the box, much touched at its sides, its top level with its
    /// neighbours
    Snug,
    /// Roll-outs of the policy through common futures from the known distribution
    LookAhead,
}

/// Chooses the placement of an arriving box among those that the bin accepts; futures are drawn.
pub(super) type Player = Box<dyn FnMut(&Bin, Sides, &mut Boxes) -> Outcome<Option<Placed>>>;

impl Method {
    pub(super) fn player(self, setting: Setting, rollouts: usize) -> Outcome<Player> {
        let policy = Snug::new(setting);
        let heuristic = match self {
            Self::Dbl => Heuristic::Dbl,
            Self::Hm => Heuristic::Hm,
            Self::Sdfm => Heuristic::Sdfm,
            Self::Mta => Heuristic::Mta,
            Self::Snug => {
                return Ok(Box::new(move |bin, arriving, _| {
                    Ok(policy.best(bin, arriving))
                }));
            }
            Self::LookAhead => {
                let look_ahead = LookAhead { policy, rollouts };
                return Ok(Box::new(move |bin, arriving, futures| {
                    Ok(look_ahead.choose(bin, arriving, futures))
                }));
            }
        };
        let mut engine = Engine::new(setting, heuristic)?;
        Ok(Box::new(move |bin, arriving, _| {
            engine.choose(bin, arriving)
        }))
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) placed: Vec<Placed>,
    /// The time of each decision that placed a box, in seconds.
    pub(super) decision_s: Vec<f64>,
}

pub(super) fn play(player: &mut Player, setting: Setting, instance: &Instance) -> Outcome<Run> {
    let mut bin = Bin::empty(setting);
    let mut futures = instance.futures();
    let mut run = Run {
        placed: Vec::new(),
        decision_s: Vec::new(),
    };
    for arriving in instance.boxes() {
        let started = Instant::now();
        let choice = player(&bin, arriving, &mut futures)?;
        let took_s = started.elapsed().as_secs_f64();
        let Some(placed) = choice else {
            break;
        };
        run.decision_s.push(took_s);
        run.placed.push(placed);
        bin.place(&placed);
    }
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::super::surface::SIDE;
    use super::*;

    #[derive(Default)]
    struct Voxels(std::collections::HashSet<(u8, u8, u8)>);

    impl Voxels {
        fn of(placed: &Placed) -> impl Iterator<Item = (u8, u8, u8)> {
            let (z, top) = (placed.z, placed.top());
            placed
                .cells()
                .flat_map(move |(x, y)| (z..top).map(move |z| (x, y, z)))
        }

        /// Whether a box is inside, on free cells only, and nothing is above it in its way down.
        fn is_free_from_above(&self, placed: &Placed) -> bool {
            let is_inside = |(x, y, z): (u8, u8, u8)| x.max(y).max(z) < SIDE;
            let mut way = placed
                .cells()
                .flat_map(|(x, y)| (placed.z..SIDE).map(move |z| (x, y, z)));
            Self::of(placed).all(is_inside) && way.all(|cell| !self.0.contains(&cell))
        }

        /// Whether it lies on the floor or on something.
        fn is_borne(&self, placed: &Placed) -> bool {
            let mut cells = placed.cells();
            placed.z == 0 || cells.any(|(x, y)| self.0.contains(&(x, y, placed.z - 1)))
        }
    }

    fn ways(voxels: &Voxels, setting: Setting, arriving: Sides) -> Vec<Placed> {
        let Sides { x, y, z } = arriving;
        let upright = [(x, y, z), (y, x, z)];
        let lying = [(x, z, y), (z, x, y), (y, z, x), (z, y, x)];
        let lying = lying.into_iter().filter(|_| setting == Setting::Free);
        let turns = upright.into_iter().chain(lying);
        let mut ways = Vec::new();
        for sides in turns.map(|(x, y, z)| Sides { x, y, z }) {
            for x in 0..=SIDE - sides.x {
                for y in 0..=SIDE - sides.y {
                    let rests = (0..=SIDE - sides.z).map(|z| Placed { sides, x, y, z });
                    let free = rests.filter(|placed| voxels.is_free_from_above(placed));
                    ways.extend(free.filter(|placed| voxels.is_borne(placed)));
                }
            }
        }
        ways
    }

    #[test]
    fn boxes_never_overlap_and_the_episode_ends_where_nothing_fits() {
        for setting in [Setting::Stable, Setting::Free] {
            for method in Method::value_variants() {
                let instance = Instance {
                    seed: 11,
                    number: 2,
                };
                let mut player = method.player(setting, 16).unwrap();
                let run = play(&mut player, setting, &instance).unwrap();
                let mut voxels = Voxels::default();
                let mut bin = Bin::empty(setting);
                for (placed, arriving) in run.placed.iter().zip(instance.boxes()) {
                    let mut sides = [placed.sides, arriving].map(|Sides { x, y, z }| [x, y, z]);
                    sides.iter_mut().for_each(|sides| sides.sort_unstable());
                    assert_eq!(sides[0], sides[1]);
                    assert!(ways(&voxels, setting, arriving).contains(placed));
                    assert!(bin.accepts(placed));
                    voxels.0.extend(Voxels::of(placed));
                    bin.place(placed);
                }
                assert!(!run.placed.is_empty());
                assert_eq!(voxels.0.len() as u32, bin.packed_volume());
                let last = instance.boxes().nth(run.placed.len()).unwrap();
                let ways = ways(&voxels, setting, last);
                assert!(ways.iter().all(|placed| !bin.accepts(placed)), "{method:?}");
            }
        }
    }
}
