//! A recorded step as a scene.

use foxglove::messages::SceneUpdate;
use nalgebra::Isometry3;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::model::Model;
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_wire::debug::ItemBox;
use ppnpack_wire::debug_plan::{self, Placed, PlannedStep};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};

use crate::arm::Arms;
use crate::shapes::Shapes;

/// Draws a record, in the container that was chosen, or the fullest one where nothing was.
pub(crate) fn draw(
    cell: &Cell,
    record: &v1::PlanningRecord,
    shapes: &mut Shapes,
    arms: &mut Arms,
) -> Result<SceneUpdate, String> {
    let decision = record.decision.as_ref();
    let chosen = decision.map(|decision| decision.container.as_str());
    let mut containers = record.containers.iter();
    let named = chosen.and_then(|name| containers.find(|at| at.container == name));
    let at = named
        .or(record.containers.first())
        .ok_or("it has no container")?;
    let scene = convert::scene::read_required("scene", at.scene.as_ref());
    let (grid, _) = scene.map_err(|error| error.to_string())?;
    let bodies = at.content.iter().flat_map(|content| &content.bodies);
    shapes.fetch(cell, record);
    let step = Step {
        record,
        grid: &grid,
        shapes,
    };
    let bodies = bodies.filter_map(|body| step.body(body));
    let planned = PlannedStep {
        bodies: bodies.collect(),
        choice: decision.and_then(|decision| step.choice(decision)),
        choice_box: decision.and_then(|decision| step.choice_box(decision)),
        runners_up: decision.map_or_else(Vec::new, |decision| step.runners_up(decision)),
        arm: decision.and_then(|decision| arms.lines(cell, &record.settings, decision)),
    };
    Ok(debug_plan::scene(
        cell,
        record.planned_at_ns,
        grid.container(),
        &planned,
    ))
}

struct Step<'a> {
    record: &'a v1::PlanningRecord,
    grid: &'a Grid,
    shapes: &'a Shapes,
}

impl<'a> Step<'a> {
    fn body(&self, body: &'a v1::RecordedBody) -> Option<Placed<'a>> {
        let pose = body.container_from_item.as_ref();
        Some(Placed {
            id: &body.name,
            label: &body.name,
            model: self.solid(&body.solid)?,
            container_from_item: convert::pose::read_required("pose", pose).ok()?,
        })
    }

    fn choice(&self, decision: &'a v1::Decision) -> Option<Placed<'a>> {
        let held = self.held(&decision.item_id, decision.pose)?;
        Some(Placed {
            id: &decision.item_id,
            label: &decision.object,
            model: self.solid(&held.solid)?,
            container_from_item: self.heightmap_frame(held, decision.placement.as_ref()?)?,
        })
    }

    fn choice_box(&self, decision: &v1::Decision) -> Option<ItemBox> {
        let held = self.held(&decision.item_id, decision.pose)?;
        let boxed = self.item_box(held, decision.placement.as_ref()?)?;
        let value = decision.value;
        Some(ItemBox {
            label: format!("{} {value:.3}", decision.object),
            ..boxed
        })
    }

    fn runners_up(&self, decision: &v1::Decision) -> Vec<ItemBox> {
        let next = decision.alternatives.iter().filter_map(|ranked| {
            let index = usize::try_from(ranked.candidate).ok()?;
            let item_id = decision.buffer.get(index)?;
            let held = self.held(item_id, ranked.pose)?;
            let boxed = self.item_box(held, ranked.placement.as_ref()?)?;
            Some(ItemBox {
                label: format!("{} {:.3}", boxed.label, ranked.value),
                ..boxed
            })
        });
        next.collect()
    }

    /// The item of this id in one of its poses.
    fn held(&self, item_id: &str, pose: u32) -> Option<&'a v1::RecordedCandidate> {
        let item = self
            .record
            .items
            .iter()
            .find(|item| item.item_id == item_id)?;
        let mut candidates = self.record.candidates.iter();
        candidates.find(|held| held.arrival == item.arrival && held.pose == pose)
    }

    fn item_box(
        &self,
        held: &v1::RecordedCandidate,
        resting: &v1::RestingPlacement,
    ) -> Option<ItemBox> {
        let item = self.shapes.item(&held.item)?;
        let frame = self.heightmap_frame(held, resting)?;
        ItemBox::of(self.grid, item, read(resting)?.placement.yaw, &frame)
    }

    /// Where the frame of an item's heightmaps is.
    fn heightmap_frame(
        &self,
        held: &v1::RecordedCandidate,
        resting: &v1::RestingPlacement,
    ) -> Option<Isometry3<f64>> {
        let item = self.shapes.item(&held.item)?;
        item.container_from_item(self.grid, &read(resting)?)
    }

    fn solid(&self, id: &[u8]) -> Option<&'a Model> {
        self.shapes.solid(id).map(|model| &**model)
    }
}

fn read(resting: &v1::RestingPlacement) -> Option<RestingPlacement> {
    convert::placement::read_resting(resting).ok()
}
