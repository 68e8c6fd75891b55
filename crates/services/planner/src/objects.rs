//! The objects that can be announced by name, on the grids of the cells.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::Item;
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;

use crate::settings::CellSettings;

/// Objects for each resolution.
#[derive(Debug, Default)]
pub(crate) struct Objects(Vec<OfResolution>);

#[derive(Debug)]
struct OfResolution {
    resolution: Resolution,
    by_name: HashMap<String, Object>,
    /// In the order of the catalogue.
    items: Vec<Arc<Item>>,
}

/// An object on one grid.
#[derive(Debug, Clone)]
pub(crate) struct Object {
    pub(crate) shape: ItemId,
    pub(crate) item: Arc<Item>,
    pub(crate) model: Arc<Model>,
    /// As a candidate, in each pose in which it may be packed: first as the catalogue has it.
    pub(crate) poses: Vec<Candidate>,
}

impl Objects {
    /// The objects of catalogues, one per resolution.
    pub(crate) fn new(catalogues: &[Arc<Catalogue>]) -> Self {
        let of_catalogue = |catalogue: &Arc<Catalogue>| {
            let objects = catalogue.objects.iter().map(|object| {
                let object = Object {
                    shape: ItemId::of(&convert::item::write(&object.item)),
                    item: Arc::clone(&object.item),
                    model: Arc::clone(&object.model),
                    poses: object.candidates(0),
                };
                (object.item.name().to_string(), object)
            });
            OfResolution {
                resolution: catalogue.resolution.clone(),
                by_name: objects.collect(),
                items: catalogue.items(),
            }
        };
        Self(catalogues.iter().map(of_catalogue).collect())
    }

    /// An object by its name, on a cell's grid.
    pub(crate) fn named(&self, settings: &CellSettings, name: &str) -> Option<&Object> {
        self.of(settings)?.by_name.get(name)
    }

    /// All objects on a cell's grid: what may arrive there.
    pub(crate) fn items(&self, settings: &CellSettings) -> &[Arc<Item>] {
        self.of(settings).map_or(&[], |objects| &objects.items)
    }

    fn of(&self, settings: &CellSettings) -> Option<&OfResolution> {
        let grid = settings.grid.build().ok()?;
        let mut catalogues = self.0.iter();
        catalogues.find(|objects| objects.resolution == *grid.resolution())
    }
}
