//! Settings of the planner service.

mod cell;
mod containers;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::PathBuf;

use ppnpack_numbers::settings;
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::in_range;
use ppnpack_wire::keys::Cell;

use crate::store::Store;

pub use cell::{CellSettings, Where};
pub(crate) use cell::{MAX_ALTERNATIVES, set_aside_in_range};
pub(crate) use containers::ContainerPlan;
pub use containers::{ClosingSettings, ContainerSettings};

settings! {
    /// Settings of the planner service.
    pub struct Settings {
        /// The cells, by their names.
        pub cells: BTreeMap<String, CellSettings> = BTreeMap::from([("cell-1".to_owned(), CellSettings::default())]),
        /// The file that keeps the sessions; without one they are lost with the process.
        pub store: Option<PathBuf> = None,
        /// The objects that can be announced by name: `builtin`, or a folder of meshes.
        pub catalogue: String = ppnpack_household::BUILTIN.to_owned(),
        /// Maximum number of requests that wait for a cell; more are refused.
        pub queue: usize = 64,
        /// Maximum size of the heightmaps that items of one session were announced with, in MiB as
        /// they are encoded. An announcement with more is refused.
        pub shapes_mib: usize = 64,
    }
}

impl Settings {
    /// Checks the containers: each is of one cell alone.
    fn validate_containers(&self) -> Result<(), String> {
        let mut names: Vec<&String> = self.cells.keys().collect();
        for (cell, settings) in &self.cells {
            for (name, own) in &settings.containers {
                let at = format!("cells.{cell}.containers.{name}");
                Cell::new(name).map_err(|error| format!("{at}: {error}"))?;
                if names.contains(&name) {
                    return Err(format!(
                        "{at}: another cell or container has this name: each container needs one of its own"
                    ));
                }
                names.push(name);
                let possible = settings.of_container(own).validate();
                possible.map_err(|error| format!("{at}.{error}"))?;
            }
        }
        Ok(())
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        for (name, cell) in &self.cells {
            Cell::new(name).map_err(|error| error.to_string())?;
            cell.validate()
                .map_err(|error| format!("cells.{name}.{error}"))?;
        }
        self.validate_containers()?;
        in_range("queue", self.queue, 1..=65_536)?;
        in_range("shapes_mib", self.shapes_mib, 1..=65_536)
    }

    fn after_restore(&self) -> Result<String, String> {
        let path = self.store.as_deref();
        let path = path.ok_or("service.store is not given: there is nothing to be restored")?;
        let ended = Store::after_restore(path).map_err(|error| error.to_string())?;
        let list = ended.join(", ");
        Ok(format!("sessions that somebody has to look at: {list}"))
    }
}
