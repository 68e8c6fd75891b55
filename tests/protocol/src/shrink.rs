//! The shortest story of a broken promise.

use crate::{Action, Configuration, World};

/// Leaves out of a story what it does not need to end as it does.
pub fn shrink(story: &[Action], configuration: &Configuration) -> Vec<Action> {
    let Some(end) = tell(story, configuration).and_then(|world| world.broken()) else {
        return story.to_vec();
    };
    let mut story = story.to_vec();
    let mut length = story.len();
    while length > 0 {
        let mut first = 0;
        while first + length <= story.len() {
            let without = story
                .iter()
                .take(first)
                .chain(story.iter().skip(first + length));
            let without: Vec<Action> = without.copied().collect();
            let ends = tell(&without, configuration).and_then(|world| world.broken());
            if ends == Some(end) {
                story = without;
            } else {
                first += 1;
            }
        }
        length /= 2;
    }
    story
}

/// The world at the end of a story; `None` where it cannot happen.
pub fn tell(story: &[Action], configuration: &Configuration) -> Option<World> {
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
