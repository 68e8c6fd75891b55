//! The reach of a cell: its objects, and the poses in or near its container.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Vector3, center};
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_wire::v1::Status;

use super::Refusal;
use crate::robot::{Placement, Robot};

/// The maximum distance of an item's middle from the container, in metres: an item may reach above
/// the rim.
const MARGIN_M: f64 = 0.1;

/// The maximum distance of an item's own frame from the container, in metres, where its size is not
/// known.
const FRAME_MARGIN_M: f64 = 1.0;

/// The objects of a cell, and its container.
pub(crate) struct Reach {
    container: ContainerSize,
    /// The bounds of each object by name; `None` where any object can be placed.
    objects: Option<BTreeMap<String, Bounds>>,
}

impl Reach {
    pub(crate) fn of(robot: &dyn Robot) -> Self {
        Self {
            container: robot.container(),
            objects: robot.objects(),
        }
    }

    /// Says why an item's own frame cannot be there, where it cannot.
    ///
    /// # Errors
    /// How far it is outside, for people.
    pub(crate) fn check_frame(&self, container_from_item: &Isometry3<f64>) -> Result<(), String> {
        let checked = self.check_at(container_from_item, &Point3::origin(), FRAME_MARGIN_M);
        checked.map_err(|Refusal(_, why)| why)
    }

    /// Refuses a placement that is not for this cell.
    pub(super) fn check(&self, placement: &Placement) -> Result<(), Refusal> {
        let object = &placement.object;
        let Some(objects) = &self.objects else {
            let origin = Point3::origin();
            return self.check_at(&placement.container_from_item, &origin, FRAME_MARGIN_M);
        };
        let Some(Bounds { lowest, highest }) = objects.get(object) else {
            let message = format!("the cell has no object '{object}'");
            return Err(Refusal(Status::NotFound, message));
        };
        let middle = center(lowest, highest);
        self.check_at(&placement.container_from_item, &middle, MARGIN_M)
    }

    /// Refuses where a point of an item is outside the container by more than a margin in metres.
    fn check_at(
        &self,
        container_from_item: &Isometry3<f64>,
        point: &Point3<f64>,
        margin_m: f64,
    ) -> Result<(), Refusal> {
        let ContainerSize { x_m, y_m, z_m, .. } = self.container;
        let at = (container_from_item * point).coords;
        let nearest = at.sup(&Vector3::zeros()).inf(&Vector3::new(x_m, y_m, z_m));
        let outside_m = (at - nearest).norm();
        if outside_m <= margin_m {
            return Ok(());
        }
        let message =
            format!("container_from_item: that is {outside_m:.2} m outside the container");
        Err(Refusal(Status::Invalid, message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placement(object: &str, [x_m, y_m, z_m]: [f64; 3]) -> Placement {
        Placement {
            placement_id: "p1".to_owned(),
            item_id: "i1".to_owned(),
            object: object.to_owned(),
            container_from_item: Isometry3::translation(x_m, y_m, z_m),
            state_number: 1,
            cycle: None,
        }
    }

    fn reach(objects: Option<BTreeMap<String, Bounds>>) -> Reach {
        Reach {
            container: ContainerSize::REFERENCE,
            objects,
        }
    }

    #[test]
    fn the_middle_of_an_object_is_in_the_container_or_close_to_it() {
        // Its frame is half a metre below its middle.
        let high = Bounds {
            lowest: Point3::new(-0.1, -0.1, 0.4),
            highest: Point3::new(0.1, 0.1, 0.6),
        };
        let reach = reach(Some(BTreeMap::from([("high".to_owned(), high)])));
        let refused = |at| reach.check(&placement("high", at)).err();
        assert_eq!(refused([0.16, 0.16, -0.35]), None);
        assert_eq!(refused([0.16, 0.16, -0.11]), None);
        for outside in [[0.16, 0.16, 0.0], [0.43, 0.16, -0.3], [0.16, -0.11, -0.3]] {
            let Refusal(status, message) = refused(outside).unwrap();
            assert_eq!(status, Status::Invalid);
            assert!(message.contains("outside the container"), "{message}");
        }
        let Refusal(status, _) = reach.check(&placement("other", [0.1; 3])).unwrap_err();
        assert_eq!(status, Status::NotFound);
    }

    #[test]
    fn of_what_is_not_known_the_frame_is_within_a_metre() {
        let reach = reach(None);
        assert_eq!(reach.check(&placement("any", [-0.9, 0.1, 0.1])), Ok(()));
        for outside in [[-1.1, 0.1, 0.1], [0.1, 0.1, 1e6]] {
            assert!(reach.check(&placement("any", outside)).is_err());
        }
    }
}
