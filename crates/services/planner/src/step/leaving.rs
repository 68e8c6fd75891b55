//! Stops at which the content of a container leaves it.

use nalgebra::Isometry3;
use ppnpack_packing::scene::leaving::{Leaving, Stop};
use ppnpack_protocol::session::Packed;
use ppnpack_protocol::session::item::stop;

use super::Stepper;
use super::footprint::footprint;
use crate::refusal::Refusal;

/// Maximum turn of an item that counts as lying as planned, in radians.
const AS_PLANNED_RAD: f64 = 0.035;

/// Maximum shift of an item that counts as lying as planned, in cells.
const AS_PLANNED_CELLS: f64 = 0.25;

impl Stepper {
    /// Gives the stops at which the items of a container leave, each where it lies now; `None`
    /// where no item has a stop.
    pub(super) fn leaving(&mut self, container: &str) -> Result<Option<Leaving>, Refusal> {
        let grid = self.container(container)?.planning.grid().clone();
        let packed = self.session.packed_in(container);
        let mut packed = packed.filter(|item| stop(item) != Stop::LAST).peekable();
        if packed.peek().is_none() {
            return Ok(None);
        }
        let mut leaving = Leaving::empty(&grid);
        for item in packed {
            let Some(Packed {
                placement,
                pose,
                planned,
                container_from_item,
            }) = Packed::read(item)?
            else {
                continue;
            };
            let shape = self.shapes.heightmaps(item, pose)?;
            let Some(view) = shape.views().get(placement.placement.yaw) else {
                continue;
            };
            let most_m = AS_PLANNED_CELLS * grid.resolution().cell_m();
            let container_from_item = container_from_item.isometry();
            if is_as_planned(&planned, container_from_item, most_m) {
                leaving.place(view, &placement, stop(item));
            } else {
                let moved = container_from_item * planned.inverse();
                leaving.cover(
                    &grid,
                    &footprint(&placement, view, &grid, &moved),
                    stop(item),
                );
            }
        }
        Ok(Some(leaving))
    }
}

fn is_as_planned(planned: &Isometry3<f64>, found: &Isometry3<f64>, most_m: f64) -> bool {
    let shift_m = (found.translation.vector - planned.translation.vector).norm();
    shift_m < most_m && found.rotation.angle_to(&planned.rotation) < AS_PLANNED_RAD
}
