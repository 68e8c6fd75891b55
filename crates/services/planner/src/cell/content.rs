//! What lies in the container, as solids: what placements are tried among.

use std::sync::Arc;
use std::time::Instant;

use nalgebra::Isometry3;
use ppnpack_packing::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::model::Model;
use ppnpack_wire::{convert, v1};

use super::CellPlanner;
use ppnpack_protocol::session::{ItemState, SessionItem};

impl CellPlanner {
    /// What lies in a container: where the bridge knows it, else where the session last knew each packed item. `None`
    /// where nothing is tried.
    pub(super) fn content(&mut self, container: &str, deadline: Instant) -> Option<Content> {
        if !self.settings.method.trial.is_on() {
            return None;
        }
        if let Some(bodies) = self.bodies(container, deadline) {
            let bodies = bodies.iter().map(|body| self.solid_of_body(body));
            return Some(bodies.collect());
        }
        let items: Vec<SessionItem> = self.session.packed_in(container).cloned().collect();
        let packed = items.iter().filter_map(packed);
        let bodies = packed.map(|(item, pose)| self.solid_of_item(item, pose));
        Some(bodies.collect())
    }

    /// What the bridge says that lies in a container now, where it does.
    fn bodies(&mut self, container: &str, deadline: Instant) -> Option<Vec<v1::Body>> {
        let state = self.place_of(container).ok()?.bridge_state(deadline)?;
        let is_told = state.is_simulated || !state.bodies.is_empty();
        let is_now = state.state_number >= self.session.least_state_number(container);
        (is_told && is_now).then_some(state.bodies)
    }

    /// The solid of a body where the bridge says that it is. A body that is another object than its item of the session
    /// has another frame than that.
    fn solid_of_body(&mut self, body: &v1::Body) -> LyingBody {
        let pose = body.container_from_item.as_ref();
        let pose = convert::pose::read_required("pose", pose).ok();
        let mut items = self.session.items().iter();
        let item = items.find(|item| item.item_id == body.item_id).cloned();
        let is_named = |item: &&SessionItem| item.object == body.object || body.object.is_empty();
        if let Some((item, pose)) = item.as_ref().filter(is_named).zip(pose) {
            return self.solid_of_item(item, &pose);
        }
        let known = self.shared.objects.named(&self.settings, &body.object);
        if let Some((known, container_from_item)) = known.zip(pose) {
            return LyingBody::Known(LyingSolid::new(
                Arc::clone(&known.model),
                container_from_item,
            ));
        }
        match item.as_ref().and_then(packed) {
            Some((item, pose)) => self.solid_of_item(item, pose),
            None => LyingBody::Unknown,
        }
    }

    /// The solid of an item of the session, whose own frame is there: the catalogue's, or that of its heightmaps.
    fn solid_of_item(
        &mut self,
        item: &SessionItem,
        container_from_item: &Isometry3<f64>,
    ) -> LyingBody {
        let Ok(shape) = self.shape(item) else {
            return LyingBody::Unknown;
        };
        let own = item.lying.heightmap_from_item.unwrap_or_default();
        let solid = |model: Arc<Model>| LyingSolid::new(model, container_from_item * own.inverse());
        if let Some(model) = shape.model {
            return LyingBody::Known(solid(model));
        }
        // All containers of a cell are planned as finely.
        let Some(place) = self.places.first() else {
            return LyingBody::Unknown;
        };
        let resolution = place.planning.grid().resolution();
        let seen = self.seen.of(&shape.item, resolution);
        seen.map_or(LyingBody::Unknown, |model| LyingBody::Seen(solid(model)))
    }
}

/// A packed item, and where it is by what was reported.
fn packed(item: &SessionItem) -> Option<(&SessionItem, &Isometry3<f64>)> {
    match &item.state {
        ItemState::Packed {
            container_from_item,
            ..
        } => Some((item, container_from_item)),
        _ => None,
    }
}
