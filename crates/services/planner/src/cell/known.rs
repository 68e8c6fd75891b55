//! A session held against what the bridges know: neither is taken for the newest by itself.

use std::collections::HashSet;
use std::time::Instant;

use ppnpack_protocol::session::{AFTER_ANOTHER, End};
use ppnpack_wire::v1::{self, Status};

use super::CellPlanner;
use super::refusal::Refusal;

impl CellPlanner {
    /// Ends a session that knows of a later state than a bridge is in: no picture of it comes,
    /// however long it is waited for.
    pub(super) fn must_not_be_ahead(&mut self) -> Result<(), Refusal> {
        let places = self.places.iter_mut();
        let behind = places.filter_map(|place| place.behind.take());
        match behind.last() {
            Some(why) => Err(self.fail(why)),
            None => Ok(()),
        }
    }

    /// Ends a session that was on disk as this process began, where the bridges tell that it is not
    /// the newest. It is held against them once, before anything is decided; in automatic mode they
    /// are waited for.
    pub(super) fn must_be_newest(&mut self, deadline: Instant) -> Result<(), Refusal> {
        if self.is_compared {
            return Ok(());
        }
        let is_automatic = self.session.is_automatic();
        let (mut unexplained, mut is_compared) = (None, true);
        for place in &mut self.places {
            match place.bridge.state(is_automatic, deadline)? {
                Some(state) => {
                    let found = self.session.unexplained(&place.name, &state);
                    unexplained = unexplained.or(found.map(str::to_owned));
                }
                // Where there is a bridge, it is asked again.
                None => is_compared = false,
            }
        }
        self.is_compared = is_compared || unexplained.is_some();
        match unexplained {
            Some(item_id) => Err(self.fail(format!("item {item_id} lies there: {AFTER_ANOTHER}"))),
            None => Ok(()),
        }
    }

    fn fail(&mut self, why: String) -> Refusal {
        tracing::error!(cell = %self.cell, why, "the session has failed");
        let ended = self.session.end(End::Failed(why.clone()));
        ended.err().unwrap_or_else(|| Refusal::unavailable(why))
    }

    /// Refuses new items with the ids of what lies in a container, by what the bridges say.
    pub(super) fn must_not_lie_there(
        &mut self,
        announced: &[v1::SessionItem],
        deadline: Instant,
    ) -> Result<(), Refusal> {
        let known: HashSet<&str> = ids(self.session.items()).collect();
        let new: HashSet<&str> = ids(announced).filter(|id| !known.contains(id)).collect();
        if new.is_empty() {
            return Ok(());
        }
        for place in &mut self.places {
            let state = place.bridge.state_if_there(deadline).unwrap_or_default();
            let mut bodies = state.bodies.iter();
            if let Some(body) = bodies.find(|body| new.contains(body.item_id.as_str())) {
                return Err(Refusal::new(
                    Status::Conflict,
                    format_args!(
                        "item {} lies in container {}: give another item another id, or have the container renewed, or tell the bridge \
                         that the item was removed (`changed`)",
                        body.item_id, place.address
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn ids(items: &[v1::SessionItem]) -> impl Iterator<Item = &str> {
    items.iter().map(|item| item.item_id.as_str())
}
