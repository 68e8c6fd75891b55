//! The objects that can be announced by name, on the grids of the cells.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;

use crate::settings::CellSettings;

/// Objects for each resolution.
#[derive(Debug, Default)]
pub(crate) struct Objects(Vec<Arc<GridObjects>>);

/// The objects on one grid.
#[derive(Debug)]
pub(crate) struct GridObjects {
    resolution: Resolution,
    by_name: HashMap<String, Object>,
    /// Whether some of them may not carry anything.
    pub(crate) have_limits: bool,
}

/// An object on one grid.
#[derive(Debug, Clone)]
pub(crate) struct Object {
    pub(crate) shape: ItemId,
    pub(crate) item: Arc<Item>,
    pub(crate) model: Arc<Model>,
    /// Candidates in each pose in which it may be packed: first as the catalogue has it.
    pub(crate) poses: Vec<Candidate>,
}

impl Objects {
    /// Reads the objects of catalogues, one per resolution.
    pub(crate) fn new(catalogues: &[Arc<Catalogue>]) -> Self {
        let catalogues = catalogues.iter();
        Self(
            catalogues
                .map(|of| Arc::new(GridObjects::new(of)))
                .collect(),
        )
    }

    /// Gives the objects on a cell's grid; none where there is no catalogue for it.
    pub(crate) fn of(&self, settings: &CellSettings) -> Option<Arc<GridObjects>> {
        let grid = settings.grid.build().ok()?;
        let mut catalogues = self.0.iter();
        let known = catalogues.find(|objects| objects.resolution == *grid.resolution());
        known.cloned()
    }
}

impl GridObjects {
    fn new(catalogue: &Arc<Catalogue>) -> Self {
        let objects = catalogue.objects.iter().map(|object| {
            let object = Object {
                shape: ItemId::of(&convert::item::write(&object.item)),
                item: Arc::clone(&object.item),
                model: Arc::clone(&object.model),
                poses: object.candidates(0),
            };
            (object.item.name().to_string(), object)
        });
        let mut limits = catalogue.objects.iter();
        Self {
            resolution: catalogue.resolution.clone(),
            by_name: objects.collect(),
            have_limits: limits.any(|object| object.model.carries_kg.is_some()),
        }
    }

    pub(crate) fn named(&self, name: &str) -> Option<&Object> {
        self.by_name.get(name)
    }
}
