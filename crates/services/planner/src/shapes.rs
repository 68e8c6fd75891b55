//! The shapes of a session's items: of the catalogue, as they were announced, or as they were seen.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use ppnpack_catalogue::seen::SeenSolids;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::candidate::Lying;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::model::Model;
use ppnpack_protocol::session::item::{arrival, may_be_in, stop, told_kg};
use ppnpack_protocol::session::message;
use ppnpack_service::ServiceError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{WireError, convert, v1};

use crate::cell::Shared;
use crate::objects::{GridObjects, Object};
use crate::refusal::Refusal;
use crate::settings::CellSettings;

/// The shapes of the items of a cell's session.
pub(crate) struct ItemShapes {
    cell: Cell,
    shared: Arc<Shared>,
    resolution: Resolution,
    /// Maximum number of poses in which an object may be packed.
    poses: usize,
    /// The objects that can be announced by name.
    objects: Option<Arc<GridObjects>>,
    /// Items that have heightmaps of their own.
    announced: HashMap<ItemId, Arc<Item>>,
    /// Solids of those of them that the catalogue has, as they lie.
    posed_models: HashMap<ItemId, Arc<Model>>,
    /// Solids of what was seen of the others.
    seen: SeenSolids,
}

/// The shape of an item, as far as it is known.
pub(crate) struct Shape {
    pub(crate) item: Arc<Item>,
    /// In the frame of the heightmaps.
    pub(crate) model: Option<Arc<Model>>,
}

impl ItemShapes {
    pub(crate) fn new(
        cell: &Cell,
        settings: &CellSettings,
        shared: &Arc<Shared>,
    ) -> Result<Self, ServiceError> {
        let resolution = settings.grid.resolution();
        Ok(Self {
            cell: cell.clone(),
            shared: Arc::clone(shared),
            resolution: resolution.map_err(ServiceError::start)?,
            poses: settings.poses,
            objects: shared.objects.of(settings),
            announced: HashMap::new(),
            posed_models: HashMap::new(),
            seen: SeenSolids::default(),
        })
    }

    /// Forgets the items of a session that is over.
    pub(crate) fn forget(&mut self) {
        self.announced.clear();
        self.posed_models.clear();
    }

    /// Adds items that were announced with heightmaps.
    pub(crate) fn add(&mut self, new: Vec<(ItemId, Arc<Item>)>) {
        for (shape, item) in new {
            self.announced.entry(shape).or_insert(item);
        }
    }

    /// Forgets shapes that no item of the session has any more, where there are such.
    pub(crate) fn keep(&mut self, all: &[v1::SessionItem]) {
        if self.announced.len().max(self.posed_models.len()) <= all.len() {
            return;
        }
        let used: HashSet<&[u8]> = all.iter().map(|item| item.shape.as_slice()).collect();
        let is_used = |shape: &ItemId| used.contains(shape.to_bytes().as_slice());
        self.announced.retain(|shape, _| is_used(shape));
        self.posed_models.retain(|shape, _| is_used(shape));
    }

    pub(crate) fn named(&self, object: &str) -> Option<&Object> {
        self.objects.as_ref()?.named(object)
    }

    /// Says whether some objects of the catalogue may not carry anything.
    pub(crate) fn have_limits(&self) -> bool {
        let objects = self.objects.as_ref();
        objects.is_some_and(|objects| objects.have_limits)
    }

    /// Finds the object of the catalogue that an item is, where it stands as that has it.
    fn object(&self, item: &v1::SessionItem) -> Option<&Object> {
        let known = self.named(&item.object);
        known.filter(|known| known.shape.to_bytes() == item.shape)
    }

    /// Gives an item in each pose in which it may be packed, first as it was announced.
    pub(crate) fn candidates(&mut self, item: &v1::SessionItem) -> Result<Vec<Candidate>, Refusal> {
        let mass_kg = self.mass_kg(item);
        let rules = message::read_rules(item.rules.as_ref())?;
        let own = lying(item)?;
        let Some(known) = self.object(item) else {
            let Shape { item: shape, model } = self.shape(item)?;
            return Ok(vec![Candidate {
                model,
                mass_kg,
                lying: own,
                rules,
                stop: stop(item),
                ..Candidate::new(arrival(item), shape)
            }]);
        };
        let posed = known.poses.iter().take(self.poses);
        let allowed = posed.filter(|posed| may_be_in(item, posed.pose));
        let posed = allowed.map(|posed| Candidate {
            arrival: arrival(item),
            mass_kg,
            lying: match posed.pose {
                0 => own,
                _ => posed.lying,
            },
            rules,
            stop: stop(item),
            ..posed.clone()
        });
        let posed: Vec<Candidate> = posed.collect();
        match posed.is_empty() {
            true => Err(unknown_poses(
                item,
                "may only be packed",
                &item.allowed_poses,
            )),
            false => Ok(posed),
        }
    }

    /// Gives the heightmaps of an item in one of its poses.
    pub(crate) fn heightmaps(
        &mut self,
        item: &v1::SessionItem,
        pose: usize,
    ) -> Result<Arc<Item>, Refusal> {
        if pose == 0 {
            return Ok(self.shape(item)?.item);
        }
        let posed = self.object(item).and_then(|known| known.poses.get(pose));
        let posed = posed.ok_or_else(|| unknown_poses(item, "was packed", &[pose]))?;
        Ok(Arc::clone(&posed.item))
    }

    /// Gives an item's heightmaps as announced, and its solid where the catalogue has it.
    pub(crate) fn shape(&mut self, item: &v1::SessionItem) -> Result<Shape, Refusal> {
        if let Some(known) = self.object(item) {
            return Ok(Shape {
                item: Arc::clone(&known.item),
                model: Some(Arc::clone(&known.model)),
            });
        }
        Ok(Shape {
            item: self.own_shape(item)?,
            model: self.posed_model(item)?,
        })
    }

    /// Gives the solid of an object of the catalogue that lies otherwise than there.
    fn posed_model(&mut self, item: &v1::SessionItem) -> Result<Option<Arc<Model>>, Refusal> {
        let shape = ItemId::from_bytes("items.shape", &item.shape)?;
        if let Some(known) = self.posed_models.get(&shape) {
            return Ok(Some(Arc::clone(known)));
        }
        let frame = lying(item)?.heightmap_from_item;
        let Some((frame, known)) = frame.zip(self.named(&item.object)) else {
            return Ok(None);
        };
        let model = Arc::new(known.model.turned(&frame.rotation));
        self.posed_models.insert(shape, Arc::clone(&model));
        Ok(Some(model))
    }

    fn own_shape(&mut self, item: &v1::SessionItem) -> Result<Arc<Item>, Refusal> {
        let object = &item.object;
        let shape = ItemId::from_bytes("items.shape", &item.shape)?;
        if let Some(item) = self.announced.get(&shape) {
            return Ok(Arc::clone(item));
        }
        let message = self.shared.store.shape(&self.cell, shape)?.ok_or_else(|| {
            Refusal::unavailable(format_args!(
                "the heightmaps of {object} are not known any more: withdraw the item and announce it anew"
            ))
        })?;
        let item = Arc::new(convert::item::read(&message)?);
        self.announced.insert(shape, Arc::clone(&item));
        Ok(item)
    }

    pub(crate) fn seen_model(&mut self, item: &Item) -> Option<Arc<Model>> {
        self.seen.of(item, &self.resolution)
    }

    /// Gives the mass of an item in kilograms: as it was told, as the catalogue has it, or as what
    /// was seen is estimated to have.
    pub(crate) fn mass_kg(&mut self, item: &v1::SessionItem) -> Option<f64> {
        if let Some(told_kg) = told_kg(item) {
            return Some(told_kg);
        }
        let Shape { item, model } = self.shape(item).ok()?;
        let model = model.or_else(|| self.seen_model(&item))?;
        Some(model.mass.mass_kg)
    }
}

pub(crate) fn lying(item: &v1::SessionItem) -> Result<Lying, WireError> {
    message::read_lying(item.heightmap_from_item.as_ref(), item.waits_at.as_deref())
}

fn unknown_poses<N: ToString>(item: &v1::SessionItem, what: &str, poses: &[N]) -> Refusal {
    let v1::SessionItem {
        item_id, object, ..
    } = item;
    let poses: Vec<String> = poses.iter().map(ToString::to_string).collect();
    Refusal::unavailable(format_args!(
        "item {item_id} {what} in pose {} of {object}, which is not known any more: `poses` of the cell has to be as great as \
         then",
        poses.join(" or ")
    ))
}
