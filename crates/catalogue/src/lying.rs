//! Tables of what lies in a container from the start.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::Deserialize;

use crate::catalogue::Catalogue;
use crate::object::Model;
use crate::rows::{self, TableError};

/// Columns that are read.
const COLUMNS: &[&str] = &[
    "item", "end_x_m", "end_y_m", "end_z_m", "end_qw", "end_qx", "end_qy", "end_qz",
];

/// Model and pose of an item: its own frame in that of the container.
pub type Lying = (Arc<Model>, Isometry3<f64>);

/// Maximum that the length of an orientation differs from 1, as it was rounded.
const ROUNDING: f64 = 0.01;

/// A line of the table; other columns are ignored.
#[derive(Debug, Deserialize)]
struct Row {
    item: String,
    end_x_m: Option<f64>,
    end_y_m: Option<f64>,
    end_z_m: Option<f64>,
    end_qw: Option<f64>,
    end_qx: Option<f64>,
    end_qy: Option<f64>,
    end_qz: Option<f64>,
}

impl Row {
    /// Gives the pose of the object's own frame in that of the container; `None` of what is in no
    /// container.
    fn container_from_item(&self) -> Result<Option<Isometry3<f64>>, String> {
        let position = [self.end_x_m, self.end_y_m, self.end_z_m];
        let turn = [self.end_qw, self.end_qx, self.end_qy, self.end_qz];
        if position.iter().chain(&turn).all(Option::is_none) {
            return Ok(None);
        }
        let (&[Some(x), Some(y), Some(z)], &[Some(w), Some(i), Some(j), Some(k)]) =
            (&position, &turn)
        else {
            return Err("a pose has all of end_x_m to end_qz, or none".to_owned());
        };
        let turn = Quaternion::new(w, i, j, k);
        if !(1.0 - ROUNDING..=1.0 + ROUNDING).contains(&turn.norm()) {
            return Err("end_qw to end_qz are no unit quaternion".to_owned());
        }
        let turn = UnitQuaternion::from_quaternion(turn);
        Ok(Some(Isometry3::from_parts(
            Translation3::new(x, y, z),
            turn,
        )))
    }
}

/// Reads what lies in a container: CSV with the columns `item` (name of an object of the
/// catalogue), `end_x_m` to `end_z_m` and `end_qw` to `end_qz` (pose of its own frame in the
/// container's), such as a packing's `placements.csv`. Lines without a pose are left out.
///
/// # Errors
/// [`TableError`] with the line, and what is wrong there.
pub fn read(path: &Path, catalogue: &Catalogue) -> Result<Vec<Lying>, TableError> {
    let mut lying = Vec::new();
    let needed = "the columns 'item', 'end_x_m' to 'end_z_m' and 'end_qw' to 'end_qz' are needed";
    rows::read(path, COLUMNS, needed, |row: Row| {
        let (_, object) = catalogue.find(&row.item).ok_or_else(|| {
            format!(
                "the catalogue has no object '{}'; `ppnpack catalogue list` names them",
                row.item
            )
        })?;
        let pose = row.container_from_item()?;
        lying.extend(pose.map(|pose| (Arc::clone(&object.model), pose)));
        Ok(())
    })?;
    Ok(lying)
}
