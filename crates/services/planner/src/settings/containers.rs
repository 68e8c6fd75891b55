//! The containers of a cell: in what each is otherwise than the cell, and when one is closed.

use std::collections::BTreeMap;

use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::streams::closing::ClosingRules;
use ppnpack_robot::station::StationSettings;
use ppnpack_wire::keys::{Cell, KeyError};
use serde::{Deserialize, Serialize};

use super::cell::CellSettings;

/// One of the containers of a cell, where it is otherwise than the cell says.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContainerSettings {
    /// Its inner size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub container: Option<ContainerSize>,
    /// The arm, as it stands to this container.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<StationSettings>,
}

/// When a container is closed without a request that says so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClosingSettings {
    /// Whether the bridge brings an empty container for each that is closed so. In automatic mode
    /// the fullest is closed then where nothing in the buffer has a valid placement; otherwise it
    /// ends.
    pub renews: bool,
    /// The rules; their keys stand beside. With `order_complete`, announce all of an order before
    /// the last of it is packed, or how many items it has.
    #[serde(flatten)]
    pub rules: ClosingRules,
}

/// A container of a cell, and how it is planned.
#[derive(Debug, Clone)]
pub(crate) struct ContainerPlan {
    /// The name in sessions; empty where it is the cell itself.
    pub(crate) name: String,
    /// The name under which bridge and perception serve it.
    pub(crate) address: Cell,
    /// The cell's settings, with its own size and arm.
    pub(crate) settings: CellSettings,
}

impl CellSettings {
    /// Gives the containers of the cell of this name.
    ///
    /// # Errors
    /// [`KeyError`] where one has a name that keys cannot have.
    pub(crate) fn container_plans(&self, cell: &Cell) -> Result<Vec<ContainerPlan>, KeyError> {
        if self.containers.is_empty() {
            return Ok(vec![ContainerPlan {
                name: String::new(),
                address: cell.clone(),
                settings: self.with_weights(),
            }]);
        }
        let containers = self.containers.iter().map(|(name, own)| {
            Ok(ContainerPlan {
                name: name.clone(),
                address: Cell::new(name)?,
                settings: self.of_container(own),
            })
        });
        containers.collect()
    }

    /// Gives the settings with the weights that suit their poses, where they name none.
    fn with_weights(&self) -> Self {
        Self {
            method: self.method.clone().for_poses(self.poses),
            ..self.clone()
        }
    }

    /// Gives the settings for one of its containers: those of a cell that has it alone.
    pub(super) fn of_container(&self, own: &ContainerSettings) -> Self {
        let mut alone = Self {
            containers: BTreeMap::new(),
            ..self.with_weights()
        };
        alone.grid.container = own.container.unwrap_or(self.grid.container);
        alone.arm = own.arm.clone().or(alone.arm);
        alone
    }
}
