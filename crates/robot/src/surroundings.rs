//! Surroundings of the arm that do not move: walls, table, boxes, and the content as columns.

use std::sync::Arc;

use ppnpack_packing::kernel::grid::ContainerSize;

use crate::cell::CellSettings;
use crate::columns::Columns;
use crate::refusal::{Body, Obstacle, Refusal};
use crate::shapes::{AxisBox, Capsule, UprightCylinder};

/// Maximum distance that is told apart, in metres.
pub(crate) const FAR_M: f64 = 0.25;

/// Links from this one on can come near the table; the lower ones stand on it.
const FIRST_LINK_OVER_TABLE: usize = 2;

/// Walls, boxes and table of a cell.
#[derive(Debug, Clone)]
pub(crate) struct Surroundings {
    walls: [AxisBox; 4],
    boxes: Vec<(Arc<str>, AxisBox)>,
    table_height_m: f64,
}

/// A distance and what it was measured to.
pub(crate) type Nearest = (f64, Option<Obstacle>);

impl Surroundings {
    pub(crate) fn new(cell: &CellSettings, container: &ContainerSize) -> Self {
        let boxes = cell.boxes.iter();
        let boxes = boxes.map(|named| (Arc::from(named.name.as_str()), named.shape()));
        Self {
            walls: cell.walls(container),
            boxes: boxes.collect(),
            table_height_m: cell.table_height_m,
        }
    }

    /// Bounds a link's distance to everything from below, at most [`FAR_M`], in metres.
    pub(crate) fn nearest_to_link(
        &self,
        columns: &Columns,
        link: usize,
        capsule: &Capsule,
    ) -> Nearest {
        let mut nearest = (FAR_M, None);
        let content_m = columns.distance_m(capsule, FAR_M);
        keep(&mut nearest, content_m, || Obstacle::Content);
        let around = capsule.axis_box();
        let mut measure = |solid: &AxisBox, obstacle: &dyn Fn() -> Obstacle| {
            if around.distance_to_box_m(solid) - capsule.radius_m < nearest.0 {
                keep(&mut nearest, capsule.distance_m(solid), obstacle);
            }
        };
        for wall in &self.walls {
            measure(wall, &|| Obstacle::Wall);
        }
        for (name, solid) in &self.boxes {
            measure(solid, &|| Obstacle::Box(Arc::clone(name)));
        }
        if link >= FIRST_LINK_OVER_TABLE {
            let above_m = capsule.distance_above_m(self.table_height_m);
            keep(&mut nearest, above_m, || Obstacle::Table);
        }
        nearest
    }

    /// Measures an upright cylinder's distance to everything, at most [`FAR_M`], in metres.
    pub(crate) fn nearest_to_cylinder(
        &self,
        columns: &Columns,
        cylinder: &UprightCylinder,
    ) -> Nearest {
        let mut nearest = self.nearest_box(|solid| solid.distance_to_cylinder_m(cylinder));
        let content_m = columns.distance_to_cylinder_m(cylinder, FAR_M);
        keep(&mut nearest, content_m, || Obstacle::Content);
        for wall in &self.walls {
            let wall_m = wall.distance_to_cylinder_m(cylinder);
            keep(&mut nearest, wall_m, || Obstacle::Wall);
        }
        let above_m = (cylinder.lowest_m - self.table_height_m).max(0.0);
        keep(&mut nearest, above_m, || Obstacle::Table);
        nearest
    }

    /// Measures the distance to the configured boxes alone, at most [`FAR_M`], in metres.
    pub(crate) fn nearest_box(&self, distance_m: impl Fn(&AxisBox) -> f64) -> Nearest {
        let mut nearest = (FAR_M, None);
        for (name, solid) in &self.boxes {
            keep(&mut nearest, distance_m(solid), || {
                Obstacle::Box(Arc::clone(name))
            });
        }
        nearest
    }
}

/// Refuses a body that is nearer to something than it may be, which is less than [`FAR_M`].
pub(crate) fn keep_apart(body: Body, nearest: Nearest, apart_m: f64) -> Result<(), Refusal> {
    match nearest {
        (distance_m, Some(obstacle)) if distance_m < apart_m => {
            Err(Refusal::Collision { body, obstacle })
        }
        _ => Ok(()),
    }
}

fn keep(nearest: &mut Nearest, distance_m: f64, obstacle: impl FnOnce() -> Obstacle) {
    if distance_m < nearest.0 {
        *nearest = (distance_m, Some(obstacle()));
    }
}
