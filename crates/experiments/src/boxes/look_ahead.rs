//! Looking ahead over the known distribution of boxes.
//!
//! The best placements by a one-step policy are followed to the episode's end by its roll-outs, all
//! through the same futures (common random numbers), so that differences scatter less. By
//! sequential halving (Karnin, Koren and Somekh, *Almost Optimal Exploration in Multi-Armed
//! Bandits*, ICML 2013) each round leaves out the worse half. The policy's own choice stays to the
//! end, and is left only where another packs more by a margin of standard errors: the best mean is
//! often the luckiest.
//!
//! Where boxes have to be stable, the roll-outs ask of each box whether it stands by itself, but
//! not whether it tips another one; what is chosen in the end passes the whole rule.

use super::bin::Bin;
use super::snug::Snug;
use super::source::Boxes;
use super::surface::{BIN_VOLUME, Placed, Sides};

/// How many of the policy's best placements are followed.
const PLACEMENTS: usize = 8;

/// Standard errors of the mean difference by which a placement has to pack more than the policy's.
const MARGIN: f64 = 1.0;

/// A decision by roll-outs: about so many.
#[derive(Debug, Clone, Copy)]
pub(super) struct LookAhead {
    pub(super) policy: Snug,
    pub(super) rollouts: usize,
}

/// A placement with the volumes that its roll-outs packed so far, a future each, in cells cubed.
#[derive(Debug, Clone)]
struct Arm {
    placed: Placed,
    volumes: Vec<u32>,
}

impl Arm {
    fn volume(&self) -> u32 {
        self.volumes.iter().sum()
    }
}

impl LookAhead {
    /// The accepted placement whose roll-outs fill the bin most; `None` where there is none.
    pub(super) fn choose(&self, bin: &Bin, arriving: Sides, futures: &mut Boxes) -> Option<Placed> {
        let ranked = self.policy.ranked(bin.surface(), arriving);
        let accepted = ranked.into_iter().filter(|placed| bin.accepts(placed));
        let arms = accepted.take(PLACEMENTS).map(|placed| Arm {
            placed,
            volumes: Vec::new(),
        });
        let mut arms: Vec<Arm> = arms.collect();
        let rounds = rounds(arms.len());
        for _ in 0..rounds {
            let count = self.rollouts / rounds / arms.len();
            for _ in 0..count.max(1) {
                let free_volume = BIN_VOLUME.saturating_sub(bin.packed_volume());
                self.follow(bin, &mut arms, &future(free_volume, futures));
            }
            halve(&mut arms);
        }
        Some(preferred(&arms, MARGIN)?.placed)
    }

    /// Plays one future out after each of the placements.
    fn follow(&self, bin: &Bin, arms: &mut [Arm], future: &[Sides]) {
        for arm in arms {
            let mut surface = *bin.surface();
            surface.place(&arm.placed);
            let volume = self.policy.play_out(surface, future);
            arm.volumes.push(volume);
        }
    }
}

/// Leaves out the worse half, but never the first, the policy's choice, nor the last one beside it.
fn halve(arms: &mut Vec<Arm>) {
    if let Some((_, others)) = arms.split_first_mut() {
        // Equal ones stay in the policy's order.
        others.sort_by_key(|arm| std::cmp::Reverse(arm.volume()));
    }
    arms.truncate(arms.len().div_ceil(2).max(2));
}

/// The one that packs most, where that is more than the first by a margin of standard errors.
fn preferred(arms: &[Arm], margin: f64) -> Option<&Arm> {
    let (first, others) = arms.split_first()?;
    let mut best = (first, 0.0);
    for arm in others {
        let pairs = arm.volumes.iter().zip(&first.volumes);
        let gains = pairs.map(|(volume, first)| f64::from(*volume) - f64::from(*first));
        let count = arm.volumes.len() as f64;
        let mean = gains.clone().sum::<f64>() / count;
        let squares: f64 = gains.map(|gain| (gain - mean).powi(2)).sum();
        let error = (squares / (count - 1.0).max(1.0) / count).sqrt();
        if mean > margin * error && mean > best.1 {
            best = (arm, mean);
        }
    }
    Some(best.0)
}

/// How often so many are halved until one is left.
fn rounds(arms: usize) -> usize {
    arms.next_power_of_two().ilog2() as usize
}

/// Boxes that arrive next: more than there is room for.
fn future(free_volume: u32, boxes: &mut Boxes) -> Vec<Sides> {
    let mut drawn = 0;
    let fitting = boxes.take_while(|sides| {
        let is_open = drawn <= free_volume;
        drawn += sides.volume();
        is_open
    });
    fitting.collect()
}

#[cfg(test)]
mod tests {
    use super::super::rules::Setting;
    use super::super::source::Instance;
    use super::*;

    const INSTANCE: Instance = Instance { seed: 5, number: 0 };

    /// Gives what is packed of an instance by 100 roll-outs a decision, or by the policy alone.
    fn packed_volume(number: u32, looks_ahead: bool) -> u32 {
        let policy = Snug::new(Setting::Stable);
        let look_ahead = LookAhead {
            policy,
            rollouts: 100,
        };
        let instance = Instance { number, ..INSTANCE };
        let mut bin = Bin::empty(Setting::Stable);
        let mut futures = instance.futures();
        for arriving in instance.boxes() {
            let choice = match looks_ahead {
                true => look_ahead.choose(&bin, arriving, &mut futures),
                false => policy.best(&bin, arriving),
            };
            let Some(placed) = choice else {
                break;
            };
            bin.place(&placed);
        }
        bin.packed_volume()
    }

    #[test]
    fn looking_ahead_fills_more_than_the_policy_and_repeats_itself() {
        assert_eq!(packed_volume(0, true), packed_volume(0, true));
        let volume = |looks_ahead| {
            let packed = (0..12).map(|number| packed_volume(number, looks_ahead));
            packed.sum::<u32>()
        };
        let (ahead, alone) = (volume(true), volume(false));
        assert!(ahead > alone, "{ahead} against {alone}");
    }

    #[test]
    fn the_policys_choice_is_left_only_where_another_packs_more_by_the_margin() {
        let arm = |x: u8, volumes: [u32; 2]| Arm {
            placed: Placed {
                sides: Sides { x: 1, y: 1, z: 1 },
                x,
                y: 0,
                z: 0,
            },
            volumes: volumes.to_vec(),
        };
        let chosen = |arms: &[Arm], margin| preferred(arms, margin).map(|arm| arm.placed.x);
        // The second is better by 2 on average, with a standard error of 1.
        let mut arms = vec![arm(0, [10, 10]), arm(1, [11, 13])];
        assert_eq!(chosen(&arms, 1.9), Some(1));
        assert_eq!(chosen(&arms, 2.0), Some(0));
        arms.extend([arm(2, [9, 9]), arm(3, [20, 20]), arm(4, [12, 12])]);
        halve(&mut arms);
        let kept: Vec<u8> = arms.iter().map(|arm| arm.placed.x).collect();
        assert_eq!(kept, [0, 3, 1]);
        halve(&mut arms);
        assert_eq!(chosen(&arms, 100.0), Some(3));
        assert_eq!(arms.len(), 2);
        assert_eq!(chosen(&[], 0.0), None);
    }

    #[test]
    fn a_future_has_more_than_there_is_room_for() {
        let future = future(1000, &mut INSTANCE.futures());
        let volume = |boxes: &[Sides]| boxes.iter().map(|sides| sides.volume()).sum::<u32>();
        assert!(volume(&future) > 1000);
        assert!(volume(&future[..future.len() - 1]) <= 1000);
        assert_eq!([1, 2, 3, 8, 9].map(rounds), [0, 1, 2, 3, 4]);
    }
}
