//! The content of a twin, and which tries a change of it touches.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::scene::content::Burden;
use rapier3d::math::Pose;
use rapier3d::parry::shape::Cuboid;

use crate::body::BodyTemplate;
use crate::convert::{engine_pose, engine_vector};

/// The content of a twin.
#[derive(Clone, Default)]
pub(crate) struct Laid {
    /// The known solids, as bodies.
    pub(crate) bodies: Vec<Lying>,
    /// Boxes that nothing moves, beside the container's own.
    pub(crate) terrain: Vec<Bounds>,
}

/// A body at rest.
#[derive(Clone)]
pub(crate) struct Lying {
    pub(crate) template: Arc<BodyTemplate>,
    pub(crate) container_from_item: Isometry3<f64>,
    pub(crate) bounds: Bounds,
    pub(crate) burden: Burden,
}

impl Laid {
    /// Gives the boxes around all that is only here or only there: what was added, moved or taken
    /// out. Bodies that are in both are looked for in their order.
    pub(crate) fn difference(&self, other: &Self) -> Vec<Bounds> {
        let mut later = other.bodies.iter().peekable();
        let mut different = Vec::new();
        for lying in &self.bodies {
            if later.next_if(|next| next.is_same(lying)).is_none() {
                different.push(lying.bounds);
                // It may have moved; then neither place is as it was.
                let moved = later.next_if(|next| Arc::ptr_eq(&next.template, &lying.template));
                different.extend(moved.map(|next| next.bounds));
            }
        }
        different.extend(later.map(|lying| lying.bounds));
        if self.terrain != other.terrain {
            different.extend(self.terrain.iter().chain(&other.terrain));
        }
        different
    }

    /// Measures how far an item can be lowered before it touches the content or the floor, at most
    /// `most_m`, in metres. Walls do not count.
    pub(crate) fn clearance_m(
        &self,
        template: &BodyTemplate,
        container_from_item: &Isometry3<f64>,
        most_m: f64,
    ) -> f64 {
        let mut swept = template.bounds(container_from_item);
        let most_m = most_m.min(swept.lowest.z);
        if most_m <= 0.0 {
            return 0.0;
        }
        swept.lowest.z -= most_m;
        let bodies = self.bodies.iter();
        let bodies = bodies.filter(|lying| are_near(&lying.bounds, &swept, 0.0));
        let bodies = bodies.map(|lying| {
            let pose = engine_pose(&lying.container_from_item);
            template.clearance_m(container_from_item, &*lying.template.shape, &pose, most_m)
        });
        let boxes = self.terrain.iter();
        let boxes = boxes.filter(|bounds| are_near(bounds, &swept, 0.0));
        let boxes = boxes.map(|Bounds { lowest, highest }| {
            let cuboid = Cuboid::new(engine_vector(&((highest - lowest) * 0.5)));
            let middle_m = nalgebra::center(lowest, highest).coords;
            let pose = Pose::from_translation(engine_vector(&middle_m));
            template.clearance_m(container_from_item, &cuboid, &pose, most_m)
        });
        bodies.chain(boxes).fold(most_m, f64::min)
    }

    /// Says whether what is in some boxes cannot matter to an item at a place: none of them is near
    /// it, nor near a body that it may touch.
    pub(crate) fn is_beyond_reach(&self, place: &Bounds, boxes: &[Bounds], reach_m: f64) -> bool {
        let is_reached = |from: &Bounds| boxes.iter().any(|other| are_near(other, from, reach_m));
        let bodies = self.bodies.iter().map(|lying| &lying.bounds);
        let mut touched = bodies.filter(|bounds| are_near(bounds, place, reach_m));
        !is_reached(place) && !touched.any(is_reached)
    }
}

impl Lying {
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.template, &other.template)
            && self.container_from_item == other.container_from_item
    }
}

/// Says whether two boxes are within a reach of each other along every axis, in metres.
pub(crate) fn are_near(one: &Bounds, other: &Bounds, reach_m: f64) -> bool {
    let reach = Vector3::repeat(reach_m);
    let (low, high) = (other.lowest - reach, other.highest + reach);
    (0..3).all(|axis| one.highest[axis] >= low[axis] && one.lowest[axis] <= high[axis])
}
