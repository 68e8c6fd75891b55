//! A session held against what the bridges know: neither is taken for the newest by itself.

use std::time::Instant;

use ppnpack_protocol::session::AFTER_ANOTHER;

use super::{NotPlanned, Stepper};

impl Stepper {
    /// Refuses a session that knows of a later state than a bridge is in: no picture of it comes,
    /// however long it is waited for.
    pub(super) fn must_not_be_ahead(&mut self) -> Result<(), NotPlanned> {
        let containers = self.containers.iter_mut();
        let behind = containers.filter_map(|container| container.behind.take());
        behind
            .last()
            .map_or(Ok(()), |why| Err(NotPlanned::Failed(why)))
    }

    /// Refuses a session that was on disk as this process began, where the bridges tell that it is
    /// not the newest. It is held against them once, before anything is decided; in automatic mode
    /// they are waited for.
    pub(super) fn must_be_newest(&mut self, deadline: Instant) -> Result<(), NotPlanned> {
        if self.to_compare.as_deref() != Some(self.session.id()) {
            return Ok(());
        }
        let is_automatic = self.session.is_automatic();
        let (mut unexplained, mut is_compared) = (None, true);
        for container in &mut self.containers {
            let told = container.bridge.state(is_automatic, deadline);
            match told.map_err(NotPlanned::Unseen)? {
                Some(state) => {
                    let found = self.session.unexplained(&container.name, &state);
                    unexplained = unexplained.or(found.map(str::to_owned));
                }
                // Where there is a bridge, it is asked again.
                None => is_compared = false,
            }
        }
        if is_compared || unexplained.is_some() {
            self.to_compare = None;
        }
        unexplained.map_or(Ok(()), |item_id| {
            let why = format!("item {item_id} lies there: {AFTER_ANOTHER}");
            Err(NotPlanned::Failed(why))
        })
    }
}
