//! The content of a container as solids, among which placements are tried and which carry them.

use std::sync::Arc;
use std::time::Instant;

use ppnpack_packing::ranking::candidate::Rules;
use ppnpack_packing::scene::content::Burden;
use ppnpack_packing::scene::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::scene::model::Model;
use ppnpack_protocol::message::read_pose;
use ppnpack_protocol::placing::KnownPose;
use ppnpack_protocol::session::item::told_kg;
use ppnpack_protocol::session::{Packed, message};
use ppnpack_wire::v1;

use super::Stepper;
use crate::shapes::{ItemShapes, lying};

impl Stepper {
    /// Gives the content of a container: where the bridge found it, else where the session last
    /// knew each packed item.
    pub(super) fn content(&mut self, container: &str, deadline: Instant) -> Content {
        if let Some(told) = self.told(container, deadline) {
            return told;
        }
        let packed = self.session.packed_in(container).filter_map(packed);
        let bodies = packed.map(|(item, pose)| self.shapes.solid_of_item(item, &pose));
        bodies.collect()
    }

    /// Says whether plans need to know what lies in a container, whose picture has bounds or not.
    pub(super) fn plans_by_content(&self, container: &str, has_bounds: bool) -> bool {
        self.settings.method.trial.is_on() || has_bounds || self.has_loads(container)
    }

    /// Gives the present content of a container where the bridge tells it.
    fn told(&mut self, container: &str, deadline: Instant) -> Option<Content> {
        let own = self.container(container).ok()?;
        let state = own.bridge.useful_state(deadline)?;
        own.has_told_bodies |= !state.bodies.is_empty();
        let has_told = own.has_told_bodies;
        if state.state_number < self.session.least_state_number(container) {
            return None;
        }
        if state.bodies.is_empty() && !state.is_simulated {
            // All was taken out, or it has lost what it knew: the picture says what is there.
            return has_told.then(|| [LyingBody::Unknown].into_iter().collect());
        }
        let items = self.session.items();
        let bodies = state.bodies.iter();
        let bodies = bodies.map(|body| self.shapes.solid_of_body(body, items));
        Some(bodies.collect())
    }

    /// Says whether a container has to be balanced, or holds something that may not carry anything.
    fn has_loads(&self, container: &str) -> bool {
        if self.settings.method.loads.imbalance_kg_m.is_some() {
            return true;
        }
        let mut packed = self.session.packed_in(container);
        if packed.any(|item| item.rules.is_some_and(|rules| rules.carries_kg.is_some())) {
            return true;
        }
        if !self.shapes.have_limits() {
            return false;
        }
        let mut packed = self.session.packed_in(container);
        packed.any(|item| {
            let known = self.shapes.named(&item.object);
            known.is_some_and(|known| known.model.carries_kg.is_some())
        })
    }
}

impl ItemShapes {
    /// Gives the solid of a body where the bridge says that it is; where that is only assumed,
    /// where the session has it found, or nowhere where it is gone there. A body that is another
    /// object than its item has another frame.
    fn solid_of_body(&mut self, body: &v1::Body, items: &[v1::SessionItem]) -> LyingBody {
        let told = read_pose(body.container_from_item.as_ref(), body.is_found);
        let item = items.iter().find(|item| item.item_id == body.item_id);
        let own = item.and_then(packed);
        let is_told = told.is_some_and(|told| told.is_found());
        let is_gone = |item: &v1::SessionItem| item.state() == v1::ItemState::Gone;
        if !is_told && item.is_some_and(is_gone) {
            return LyingBody::Unknown;
        }
        if let Some((item, pose)) = own.filter(|(_, pose)| pose.is_found() && !is_told) {
            return self.solid_of_item(item, &pose);
        }
        let is_named =
            |item: &&v1::SessionItem| item.object == body.object || body.object.is_empty();
        if let Some((item, told)) = item.filter(is_named).zip(told) {
            return self.solid_of_item(item, &told);
        }
        if let Some((known, told)) = self.named(&body.object).zip(told) {
            let model = Arc::clone(&known.model);
            let solid = LyingBody::Known(LyingSolid {
                burden: Burden {
                    name: body.item_id.as_str().into(),
                    ..Burden::of(&model)
                },
                model,
                container_from_item: *told.isometry(),
            });
            return by_pose(solid, &told);
        }
        match own {
            Some((item, pose)) => self.solid_of_item(item, &pose),
            None => LyingBody::Unknown,
        }
    }

    /// Gives the solid of an item of the session, by the pose of its own frame: the catalogue's, or
    /// that of its heightmaps.
    fn solid_of_item(&mut self, item: &v1::SessionItem, pose: &KnownPose) -> LyingBody {
        let (Ok(shape), Ok(lying), Ok(rules)) = (
            self.shape(item),
            lying(item),
            message::read_rules(item.rules.as_ref()),
        ) else {
            return LyingBody::Unknown;
        };
        let own = lying.heightmap_from_item.unwrap_or_default();
        let solid = |model: Arc<Model>| LyingSolid {
            burden: burden(item, &rules, &model),
            model,
            container_from_item: pose.isometry() * own.inverse(),
        };
        let body = match shape.model {
            Some(model) => LyingBody::Known(solid(model)),
            None => match self.seen_model(&shape.item) {
                Some(model) => LyingBody::Seen(solid(model)),
                None => LyingBody::Unknown,
            },
        };
        by_pose(body, pose)
    }
}

/// Gives the mass of an item and what it may carry, as was told of it, else by its solid.
fn burden(item: &v1::SessionItem, rules: &Rules, model: &Model) -> Burden {
    let known = Burden::of(model);
    Burden {
        name: item.item_id.as_str().into(),
        mass_kg: told_kg(item).unwrap_or(known.mass_kg),
        carries_kg: rules.carries_kg.or(known.carries_kg),
    }
}

/// Marks a body that nobody found as assumed: nothing is tried among those.
fn by_pose(body: LyingBody, pose: &KnownPose) -> LyingBody {
    match pose.is_found() {
        true => body,
        false => body.assumed(),
    }
}

/// Gives a packed item with the pose in which it was reported or found.
fn packed(item: &v1::SessionItem) -> Option<(&v1::SessionItem, KnownPose)> {
    let packed = Packed::read(item).ok().flatten()?;
    Some((item, packed.container_from_item))
}
