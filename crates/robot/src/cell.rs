//! Settings of the arm's surroundings and of its care in moving.

use nalgebra::Point3;
use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::kernel::grid::ContainerSize;
use serde::{Deserialize, Serialize};

use crate::parameters::length;
use crate::pick::PickSettings;
use crate::shapes::AxisBox;

settings! {
    /// Surroundings of the arm, and the checks of its motions. Lengths are in metres in the
    /// container frame.
    pub struct CellSettings with validate_numbers {
        /// Thickness of the container's walls, outwards.
        pub wall_thickness_m: f64 = 0.01 => within("0 to 1 m", 0.0..=1.0),
        /// Height of the table that everything stands on; the container's inner floor is at 0.
        pub table_height_m: f64 = -0.01 => within("-10 to 0 m", -10.0..=0.0),
        /// Other things that stand in the cell: the camera, its mount.
        pub boxes: Vec<BoxSettings> = camera_on_a_post(),
        /// Minimum distance between what moves and what does not.
        pub clearance_m: f64 = 0.003 => within("0 to 0.1 m", 0.0..=0.1),
        /// Height of the held item's lowest point above the rim when it is moved sideways.
        pub approach_clearance_m: f64 = 0.02 => within("0 to 1 m", 0.0..=1.0),
        /// Distance of the waypoints along a straight line; it is halved, twice at most, where the
        /// joints need it.
        pub waypoint_step_m: f64 = 0.01 => within("1 to 50 mm", 0.001..=0.05),
        /// Maximum distance of the executed motion from a straight line between two waypoints.
        pub path_tolerance_m: f64 = 0.001 => within("0.01 to 10 mm", 1e-5..=0.01),
        /// Minimum bend of the wrist along a path: with J5 at 0, J4 and J6 turn about one axis. 0
        /// lets the wrist pass there where its joints do not jump, which an arm that is given joint
        /// angles can do; one that follows straight lines itself may not.
        pub least_wrist_bend_deg: f64 = 2.0 => within("0 to 45", 0.0..=45.0),
        /// Number of turns of the flange, evenly over a full turn, at which an item may be picked.
        pub wrist_yaws: usize = 8 => within("1 to 64", 1.0..=64.0),
        /// Conditions of the place where the cup holds an item.
        pub pick: PickSettings = PickSettings::default(),
    }
}

/// A box along the container frame's axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSettings {
    /// Its name, for refusals.
    pub name: String,
    /// The corner with the lowest coordinates, in metres.
    pub lowest_m: [f64; 3],
    /// The corner with the greatest coordinates, in metres.
    pub highest_m: [f64; 3],
}

/// A camera 1.25 m above the reference container's floor, on a post on the side away from the arm.
fn camera_on_a_post() -> Vec<BoxSettings> {
    let boxes = [
        ("camera", [0.10, 0.10, 1.25], [0.22, 0.22, 1.32]),
        ("camera beam", [0.10, 0.14, 1.32], [0.66, 0.18, 1.36]),
        ("camera post", [0.60, 0.13, -0.01], [0.66, 0.19, 1.36]),
    ];
    let named = |(name, lowest_m, highest_m): (&str, _, _)| BoxSettings {
        name: name.to_owned(),
        lowest_m,
        highest_m,
    };
    boxes.map(named).into()
}

impl CellSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingError`] names the first field that is not possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        self.validate_numbers()?;
        for (index, named) in self.boxes.iter().enumerate() {
            let axes = named.lowest_m.iter().zip(&named.highest_m).enumerate();
            for (axis, (lowest, highest)) in axes {
                length(&format!("boxes[{index}].lowest_m[{axis}]"), *lowest)?;
                let above = within("from its lowest to 10 m", *lowest..=10.0);
                above(&format!("boxes[{index}].highest_m[{axis}]"), *highest)?;
            }
        }
        self.pick.validate()
    }

    /// Gives the walls of the box around the container's opening, up to the rim. What leans into
    /// that box is in every heightmap, and so among the content's columns.
    pub(crate) fn walls(&self, container: &ContainerSize) -> [AxisBox; 4] {
        let thick = self.wall_thickness_m;
        let (x, y, rim) = (container.x_m, container.y_m, container.z_m);
        let wall = |x0, y0, x1, y1| AxisBox {
            lowest: Point3::new(x0, y0, self.table_height_m),
            highest: Point3::new(x1, y1, rim),
        };
        [
            wall(-thick, -thick, 0.0, y + thick),
            wall(x, -thick, x + thick, y + thick),
            wall(0.0, -thick, x, 0.0),
            wall(0.0, y, x, y + thick),
        ]
    }
}

impl BoxSettings {
    pub(crate) fn shape(&self) -> AxisBox {
        AxisBox {
            lowest: self.lowest_m.into(),
            highest: self.highest_m.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_possible_and_wrong_values_are_refused_by_name() {
        CellSettings::default().validate().unwrap();
        let refusal = |change: fn(&mut CellSettings)| {
            let mut settings = CellSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert!(refusal(|cell| cell.clearance_m = f64::NAN).starts_with("clearance_m"));
        assert!(refusal(|cell| cell.waypoint_step_m = 0.0).starts_with("waypoint_step_m"));
        assert!(refusal(|cell| cell.wrist_yaws = 0).starts_with("wrist_yaws"));
        assert!(refusal(|cell| cell.pick.max_tilt_deg = -1.0).starts_with("pick.max_tilt_deg"));
        let flipped = refusal(|cell| {
            cell.boxes[0].highest_m[2] = -5.0;
        });
        assert!(flipped.starts_with("boxes[0].highest_m[2]"), "{flipped}");
    }
}
