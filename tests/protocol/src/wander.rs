//! Random orders of larger worlds, and the shortest story of one that breaks a promise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Action, Broken, Configuration, World};

/// A way through a world.
#[derive(Debug)]
pub struct Way {
    /// What happened, in its order.
    pub story: Vec<Action>,
    /// The promise that it broke, if it did.
    pub broken: Option<Broken>,
    /// Whether everything was packed at its end.
    pub packs: bool,
}

/// Goes one random way of so many steps at most, and then looks whether it goes on.
pub fn wander(configuration: &Configuration, seed: u64, most_steps: usize) -> Way {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut world = World::new(configuration);
    let mut story = Vec::new();
    while story.len() < most_steps && world.broken.is_none() {
        let mut actions = world.actions(configuration);
        let next = loop {
            if actions.is_empty() {
                break None;
            }
            let action = actions.swap_remove(random.random_range(0..actions.len()));
            if let Some(next) = world.after(action, configuration) {
                break Some((action, next));
            }
        };
        let Some((action, next)) = next else { break };
        story.push(action);
        world = next;
    }
    Way {
        story,
        broken: world.end(configuration),
        packs: world.is_packed(),
    }
}

/// Leaves out of a story, step by step, what it does not need to end as it does.
pub fn shrink(story: &[Action], configuration: &Configuration) -> Vec<Action> {
    let end = end_of(story, configuration);
    let mut story = story.to_vec();
    let mut at = 0;
    while at < story.len() {
        let mut without = story.clone();
        without.remove(at);
        if end_of(&without, configuration) == end {
            story = without;
            at = 0;
        } else {
            at += 1;
        }
    }
    story
}

/// The promise that a story breaks, also that it goes on afterwards; `None` where it breaks none,
/// or cannot happen.
pub fn end_of(story: &[Action], configuration: &Configuration) -> Option<Broken> {
    let mut steps = story.iter();
    let world = steps.try_fold(World::new(configuration), |world, action| {
        match world.broken {
            Some(_) => Some(world),
            None => world.after(*action, configuration),
        }
    });
    world?.end(configuration)
}
