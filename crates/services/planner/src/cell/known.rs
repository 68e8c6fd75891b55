//! New items held against what the bridges know to lie in the containers.

use std::collections::HashSet;
use std::time::Instant;

use ppnpack_wire::v1::{self, Status};

use super::CellPlanner;
use crate::refusal::Refusal;

impl CellPlanner {
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
