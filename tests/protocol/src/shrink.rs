//! The shortest story of a broken promise.

use crate::{Action, Broken, Configuration, World};

/// Leaves out of a story what it does not need to end as it does.
pub fn shrink(story: &[Action], configuration: &Configuration) -> Vec<Action> {
    let Some(end) = end_of(story, configuration) else {
        return story.to_vec();
    };
    let mut story = story.to_vec();
    loop {
        let shorter = leave_out(&story, |without| {
            end_of(without, configuration) == Some(end)
        });
        if shorter.len() == story.len() {
            return story;
        }
        story = shorter;
    }
}

/// Leaves parts out that are not needed: ever shorter ones, down to single steps.
fn leave_out(story: &[Action], still_ends: impl Fn(&[Action]) -> bool) -> Vec<Action> {
    let mut story = story.to_vec();
    let mut length = story.len();
    while length > 0 {
        let mut first = 0;
        while first + length <= story.len() {
            let after = story.iter().skip(first + length);
            let without: Vec<Action> = story.iter().take(first).chain(after).copied().collect();
            if still_ends(&without) {
                story = without;
            } else {
                first += 1;
            }
        }
        length /= 2;
    }
    story
}

/// The promise that a story breaks, if it does; also that it goes on afterwards.
pub fn end_of(story: &[Action], configuration: &Configuration) -> Option<Broken> {
    tell(story, configuration)?.end(configuration)
}

/// The world at the end of a story; `None` where it cannot happen.
fn tell(story: &[Action], configuration: &Configuration) -> Option<World> {
    let mut steps = story.iter();
    steps.try_fold(World::new(configuration), |world, action| {
        match world.broken() {
            Some(_) => Some(world),
            None => world.after(*action, configuration),
        }
    })
}

/// A story, as people read it.
pub fn written(story: &[Action]) -> String {
    let steps = story.iter().map(|action| format!("{action:?}"));
    steps.collect::<Vec<_>>().join(", ")
}
