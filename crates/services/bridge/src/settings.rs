//! Settings of the bridge service.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use ppnpack_catalogue::catalogue::{self, Catalogue, CatalogueError};
use ppnpack_numbers::settings;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::in_range;
use ppnpack_wire::keys::Cell;

use crate::journal;
use crate::simulated::SimulatedSettings;

settings! {
    /// Settings of the bridge service.
    pub struct Settings {
        /// The simulated cells, by their names.
        pub cells: BTreeMap<String, SimulatedSettings> = BTreeMap::from([("cell-1".to_owned(), SimulatedSettings::default())]),
        /// The cells that are containers of one robot, by the robots' names. It places into one at
        /// a time, and where one is held, all are. Other cells have a robot each.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        pub robots: BTreeMap<String, Vec<String>> = BTreeMap::new(),
        /// The file of requests and their outcomes; without one they are lost with the process.
        pub journal: Option<PathBuf> = None,
        /// The objects that can be placed: `builtin`, or a folder of meshes.
        pub catalogue: String = ppnpack_household::BUILTIN.to_owned(),
        /// The maximum of requests that wait for a cell; more are refused.
        pub queue: usize = 64,
        /// Clouds that are published in a second while nothing changes, and one at once after a
        /// change.
        pub cloud_rate_hz: f64 = 2.0,
        /// The time between states that are published while nothing changes, in seconds.
        pub state_period_s: f64 = 2.0,
        /// The maximum by which a placement may take longer than its motion before the cell is
        /// held, in seconds; 0: any time.
        pub overdue_s: f64 = 30.0,
        /// The maximum age of a decision that begins, in seconds; 0: any age.
        pub decision_age_limit_s: f64 = 60.0,
    }
}

impl Settings {
    /// Loads the catalogue; the simulation needs the objects' models only.
    ///
    /// # Errors
    /// [`CatalogueError`] names what is wrong with it.
    pub fn load_catalogue(&self) -> Result<Catalogue, CatalogueError> {
        let settings = catalogue::Settings::default();
        let source = ppnpack_household::source(&self.catalogue);
        Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| {})
    }

    /// Checks that each cell has one robot.
    fn validate_robots(&self) -> Result<(), String> {
        let mut placed = Vec::new();
        for (robot, cells) in &self.robots {
            for cell in cells {
                Cell::new(cell).map_err(|error| format!("robots.{robot}: {error}"))?;
                if placed.contains(&cell) {
                    return Err(format!(
                        "robots.{robot}: cell '{cell}' has a robot already: name it once"
                    ));
                }
                placed.push(cell);
            }
        }
        Ok(())
    }
}

/// A span of time in the settings; one that is too long to be counted is for ever.
pub(crate) fn span(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        for (name, cell) in &self.cells {
            Cell::new(name).map_err(|error| error.to_string())?;
            cell.validate()
                .map_err(|error| format!("cells.{name}.{error}"))?;
        }
        self.validate_robots()?;
        in_range("queue", self.queue, 1..=65_536)?;
        in_range("cloud_rate_hz", self.cloud_rate_hz, 0.01..=1000.0)?;
        in_range("state_period_s", self.state_period_s, 0.01..=3600.0)?;
        in_range("overdue_s", self.overdue_s, 0.0..=86_400.0)?;
        let limit_s = self.decision_age_limit_s;
        in_range("decision_age_limit_s", limit_s, 0.0..=86_400.0)
    }

    fn after_restore(&self) -> Result<String, String> {
        let path = self.journal.as_deref();
        let path = path.ok_or("service.journal is not given: there is nothing to be restored")?;
        let held = journal::after_restore(path).map_err(|error| error.to_string())?;
        let list = held.join(", ");
        Ok(format!("held until somebody has looked: {list}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_settings_are_named() {
        Settings::default().validate().unwrap();
        let refused = |change: fn(&mut Settings)| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.validate().unwrap_err()
        };
        assert!(refused(|s| s.cloud_rate_hz = 0.0).contains("cloud_rate_hz"));
        assert!(refused(|s| s.state_period_s = f64::NAN).contains("state_period_s"));
        assert!(refused(|s| s.overdue_s = -1.0).contains("overdue_s"));
        let endless = refused(|s| s.decision_age_limit_s = f64::INFINITY);
        assert!(endless.contains("decision_age_limit_s"));
        assert!(refused(|s| s.queue = 0).contains("queue"));
        let named = refused(|s| {
            s.cells.insert("Cell".to_owned(), Default::default());
        });
        assert!(named.contains("'Cell'"));
        let broken = refused(|s| s.cells.get_mut("cell-1").unwrap().place_duration_s = -1.0);
        assert!(broken.starts_with("cells.cell-1.place_duration_s"));
    }
}
