//! The content of the container, for people to look at.

use std::collections::BTreeMap;

use nalgebra::Translation3;
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::debug::{self, ItemBox, SceneUpdate};
use ppnpack_wire::keys::{Cell, Stream};

use crate::camera::now_ns;
use crate::robot::{Body, Robot};

/// Publishes the bodies as boxes.
pub(crate) struct DebugScene {
    scenes: Publisher<SceneUpdate>,
    cell: Cell,
    container: ContainerSize,
    outlines: BTreeMap<String, Bounds>,
}

impl DebugScene {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        robot: &dyn Robot,
    ) -> Result<Self, ServiceError> {
        Ok(Self {
            scenes: Publisher::new(process, cell, Stream::DebugScene)?,
            cell: cell.clone(),
            container: robot.container(),
            outlines: robot.objects().unwrap_or_default(),
        })
    }

    /// Publishes what lies in the container.
    pub(crate) fn tell(&self, bodies: &[Body]) -> Result<(), ServiceError> {
        let boxes = bodies.iter().filter_map(|body| self.item_box(body));
        let boxes: Vec<ItemBox> = boxes.collect();
        let scene = debug::scene(&self.cell, now_ns(), self.container, &boxes, None);
        self.scenes.put(&scene)
    }

    fn item_box(&self, body: &Body) -> Option<ItemBox> {
        let outline = self.outlines.get(&body.object)?;
        let middle = Translation3::from(nalgebra::center(&outline.lowest, &outline.highest));
        Some(ItemBox {
            id: body.item_id.clone(),
            label: body.object.clone(),
            container_from_middle: body.container_from_item.isometry() * middle,
            size_m: outline.extents_m(),
            is_inside: body.is_inside,
        })
    }
}
