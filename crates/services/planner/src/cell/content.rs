//! What lies in the container, as solids: what placements are tried among, and what carries them.

use std::sync::Arc;
use std::time::Instant;

use ppnpack_packing::candidate::Rules;
use ppnpack_packing::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::item::Item;
use ppnpack_packing::loads::Burden;
use ppnpack_packing::model::Model;
use ppnpack_protocol::message::read_pose;
use ppnpack_protocol::placing::KnownPose;
use ppnpack_protocol::session::item::told_kg;
use ppnpack_protocol::session::{Packed, message};
use ppnpack_wire::v1;

use super::{CellPlanner, Shape, lying};

impl CellPlanner {
    /// What lies in a container: where the bridge found it, else where the session last knew each
    /// packed item.
    pub(super) fn content(&mut self, container: &str, deadline: Instant) -> Content {
        if let Some(told) = self.told(container, deadline) {
            return told;
        }
        let items: Vec<v1::SessionItem> = self.session.packed_in(container).cloned().collect();
        let packed = items.iter().filter_map(packed);
        let bodies = packed.map(|(item, pose)| self.solid_of_item(item, &pose));
        bodies.collect()
    }

    /// Whether plans need to know what lies in a container, which has a picture with bounds or
    /// without.
    pub(super) fn plans_by_content(&self, container: &str, has_bounds: bool) -> bool {
        self.settings.method.trial.is_on() || has_bounds || self.has_loads(container)
    }

    /// What the bridge says that lies in a container now, where it does.
    fn told(&mut self, container: &str, deadline: Instant) -> Option<Content> {
        let place = self.place_of(container).ok()?;
        let state = place.bridge_state(deadline)?;
        place.has_told_bodies |= !state.bodies.is_empty();
        let has_told = place.has_told_bodies;
        if state.state_number < self.session.least_state_number(container) {
            return None;
        }
        if state.bodies.is_empty() && !state.is_simulated {
            // All was taken out, or it has lost what it knew: the picture says what is there.
            return has_told.then(|| [LyingBody::Unknown].into_iter().collect());
        }
        let bodies = state.bodies.iter();
        Some(bodies.map(|body| self.solid_of_body(body)).collect())
    }

    /// The solid of a body where the bridge says that it is; where that is only assumed, where the
    /// session has it found, or nowhere where it is gone there. A body that is another object than
    /// its item has another frame.
    fn solid_of_body(&mut self, body: &v1::Body) -> LyingBody {
        let told = read_pose(body.container_from_item.as_ref(), body.is_found);
        let mut items = self.session.items().iter();
        let item = items.find(|item| item.item_id == body.item_id).cloned();
        let own = item.as_ref().and_then(packed);
        let is_told = told.is_some_and(|told| told.is_found());
        let is_gone = |item: &v1::SessionItem| item.state() == v1::ItemState::Gone;
        if !is_told && item.as_ref().is_some_and(is_gone) {
            return LyingBody::Unknown;
        }
        if let Some((item, pose)) = own.filter(|(_, pose)| pose.is_found() && !is_told) {
            return self.solid_of_item(item, &pose);
        }
        let is_named =
            |item: &&v1::SessionItem| item.object == body.object || body.object.is_empty();
        if let Some((item, told)) = item.as_ref().filter(is_named).zip(told) {
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

    /// The solid of an item of the session, whose own frame is there: the catalogue's, or that of its heightmaps.
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

    /// The solid of what was seen of an item.
    fn seen_model(&mut self, item: &Arc<Item>) -> Option<Arc<Model>> {
        // All containers of a cell are planned as finely.
        let place = self.places.first()?;
        self.seen.of(item, place.planning.grid().resolution())
    }

    /// What an item weighs, in kilograms: as it was told, as the catalogue has it, or as what was seen of it is estimated to.
    pub(super) fn mass_kg(&mut self, item: &v1::SessionItem) -> Option<f64> {
        if let Some(told_kg) = told_kg(item) {
            return Some(told_kg);
        }
        let Shape { item, model } = self.shape(item).ok()?;
        let model = model.or_else(|| self.seen_model(&item))?;
        Some(model.mass.mass_kg)
    }

    /// Whether something lies in a container that may not carry anything, or the container has to be balanced.
    fn has_loads(&self, container: &str) -> bool {
        if self.settings.method.loads.imbalance_kg_m.is_some() {
            return true;
        }
        let mut packed = self.session.packed_in(container);
        if packed.any(|item| item.rules.is_some_and(|rules| rules.carries_kg.is_some())) {
            return true;
        }
        let objects = self.objects.as_ref();
        if !objects.is_some_and(|objects| objects.have_limits()) {
            return false;
        }
        let mut packed = self.session.packed_in(container);
        packed.any(|item| {
            let known = self.named(&item.object);
            known.is_some_and(|known| known.model.carries_kg.is_some())
        })
    }
}

/// What an item weighs and may carry, by what was told of it; elsewhere by its solid.
fn burden(item: &v1::SessionItem, rules: &Rules, model: &Model) -> Burden {
    let known = Burden::of(model);
    Burden {
        name: item.item_id.as_str().into(),
        mass_kg: told_kg(item).unwrap_or(known.mass_kg),
        carries_kg: rules.carries_kg.or(known.carries_kg),
    }
}

/// A body by how its pose is known. Nothing is tried among those that nobody found.
fn by_pose(body: LyingBody, pose: &KnownPose) -> LyingBody {
    match pose.is_found() {
        true => body,
        false => body.assumed(),
    }
}

/// A packed item, and where it is by what was reported and found.
fn packed(item: &v1::SessionItem) -> Option<(&v1::SessionItem, KnownPose)> {
    let packed = Packed::read(item).ok().flatten()?;
    Some((item, packed.container_from_item))
}
