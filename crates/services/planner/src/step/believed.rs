//! Pictures that are held against what the cell believes to lie in its containers.

use std::time::Instant;

use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_protocol::session::SessionError;

use super::Stepper;
use crate::refusal::Refusal;
use crate::scenes::Seen;

impl Stepper {
    /// Gives a picture of a container that nothing contradicts, with its content where plans need
    /// that. Picture and bridge are waited for until then; the plan has time until its deadline.
    pub(super) fn believed(
        &mut self,
        container: &str,
        [until, bridge_until]: [Instant; 2],
        deadline: Instant,
    ) -> Result<Result<Seen, Refusal>, SessionError> {
        let least = self.session.least_state_number(container);
        // The automatic mode has its decisions carried out by a bridge.
        let needs_bridge = self.session.is_automatic();
        loop {
            let own = self.container(container)?;
            let mut seen = match own.seen(least, needs_bridge, until, bridge_until) {
                Ok(seen) => seen,
                Err(refusal) => return Ok(Err(refusal)),
            };
            let has_bounds = seen.scene.surface().is_some_and(Surface::has_bounds);
            let is_needed = self.plans_by_content(container, has_bounds);
            let is_compared = self.settings.compare_content;
            if !is_needed && !is_compared {
                return Ok(Ok(seen));
            }
            let mut content = self.content(container, deadline);
            if is_compared {
                let own = self.container(container)?;
                match own.compared(least, &seen, content) {
                    Some(compared) => content = compared,
                    None => continue,
                }
            }
            if is_needed {
                seen.scene = seen.scene.with_content(content);
            }
            return Ok(Ok(seen));
        }
    }
}
