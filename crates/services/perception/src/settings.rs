//! Settings of the service.

use std::collections::BTreeMap;
use std::time::Duration;

use ppnpack_numbers::{SettingError, settings};
use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_recognition::inspection::InspectionSettings;
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::in_range;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::Cell;

use crate::ros::settings::{self as ros, RosCamera};
use crate::router::MAX_CELLS;
use crate::sensors::Sensors;
use crate::tray::settings::TraySettings;

/// Maximum size of a heightmap's message beside heights, in bytes.
const MESSAGE_OVERHEAD_BYTES: usize = 16 << 10;

/// Maximum number of sensors of a cell: a cloud of each is kept.
const MAX_SENSORS: usize = 8;

/// Maximum length of a sensor's name, in bytes.
const MAX_SENSOR_NAME: usize = 64;

settings! {
    /// Settings of the perception service.
    pub struct Settings {
        /// Grids of cells, by the cells' names.
        pub cells: BTreeMap<String, GridSettings> = BTreeMap::new(),
        /// Whether cells that are not listed are served too, with the grid below.
        pub has_unlisted_cells: bool = true,
        /// Grid of cells that are not listed.
        pub grid: GridSettings = GridSettings::default(),
        /// Names of the sensors whose clouds make one heightmap together, by cell; at most 8 each.
        /// A cell that is not listed has one sensor, whatever its name.
        pub sensors: BTreeMap<String, Vec<String>> = BTreeMap::new(),
        /// Settings of the mapper; the defaults are those for a sensor without noise.
        pub mapper: MapperSettings = MapperSettings::default(),
        /// Time without a cloud, in seconds, after which a sensor is said to be silent. Clouds that
        /// come then may count anew: before, one that is older than the last is refused.
        pub sensor_restart_after_s: f64 = 2.0,
        /// Maximum of the memory that clouds take at once, in MiB: of all cells and trays, those
        /// that wait, are looked at or are kept to be looked at again. One that has no room is
        /// dropped.
        pub clouds_mib: usize = 192,
        /// Maximum number of requests that wait for a heightmap; more are refused.
        pub queue: usize = 256,
        /// Cameras whose drivers publish clouds as ROS 2 does.
        pub ros: Vec<RosCamera> = Vec::new(),
        /// The objects that can be recognised: `builtin`, or a folder of meshes. Without, nothing
        /// is recognised.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub catalogue: Option<String> = None,
        /// Trays, where items wait to be packed, by cell.
        pub trays: BTreeMap<String, TraySettings> = BTreeMap::new(),
        /// Settings of the inspection of placed items.
        pub inspection: InspectionSettings = InspectionSettings::default(),
    }
}

/// Refuses a grid that a mapper with these settings cannot serve.
fn validate_grid(grid: &GridSettings, mapper: &MapperSettings) -> Result<(), String> {
    let grid = grid.build().map_err(|error| error.to_string())?;
    mapper
        .validate_on(&grid)
        .map_err(|error| format!("mapper: {error}"))?;
    let samples = grid.resolution().samples_per_cell();
    let cells = grid.nx() * grid.ny();
    let bytes = cells
        .saturating_mul(samples.saturating_mul(samples))
        // Heights, and which of them were seen.
        .saturating_mul(2 * 4)
        .saturating_add(2 * cells + MESSAGE_OVERHEAD_BYTES);
    match bytes {
        0..=MAX_MESSAGE_BYTES => Ok(()),
        _ => Err(format!(
            "its heightmaps would take {bytes} bytes where messages have at most {MAX_MESSAGE_BYTES}: \
             choose larger cells"
        )),
    }
}

impl Settings {
    pub(crate) fn sensor_restart_after(&self) -> Duration {
        Duration::try_from_secs_f64(self.sensor_restart_after_s).unwrap_or(Duration::MAX)
    }

    pub(crate) fn grid_of(&self, cell: &Cell) -> Option<&GridSettings> {
        let listed = self.cells.get(cell.as_str());
        listed.or_else(|| self.has_unlisted_cells.then_some(&self.grid))
    }

    /// Hashes the settings that decide what the heightmaps of a cell say.
    pub(crate) fn fingerprint_of(&self, cell: &Cell) -> u64 {
        let cameras = self.ros.iter();
        let cameras = cameras.filter(|camera| camera.cell == cell.as_str() && !camera.is_tray);
        let cameras: Vec<&RosCamera> = cameras.collect();
        let sensors = self.sensors.get(cell.as_str());
        // Numbers are written exactly.
        let text = format!(
            "{:?} {:?} {sensors:?} {cameras:?}",
            self.grid_of(cell),
            self.mapper
        );
        let hash = blake3::hash(text.as_bytes());
        let first = hash.as_bytes().first_chunk();
        first.map_or(0, |first| u64::from_le_bytes(*first))
    }

    pub(crate) fn sensors_of(&self, cell: &Cell) -> Sensors {
        let names = self.sensors.get(cell.as_str());
        Sensors::new(names.map_or(&[], Vec::as_slice))
    }

    fn validate_trays(&self) -> Result<(), String> {
        for (name, tray) in &self.trays {
            let cell = Cell::new(name).map_err(|error| error.to_string())?;
            if self.grid_of(&cell).is_none() {
                return Err(format!("trays.{name}: the cell is not served"));
            }
            let refused = |what, error: SettingError| format!("trays.{name}.{what}.{error}");
            let (segmentation, recognition) = (tray.segmentation, tray.recognition);
            segmentation
                .validate()
                .map_err(|error| refused("segmentation", error))?;
            recognition
                .validate()
                .map_err(|error| refused("recognition", error))?;
        }
        if self.catalogue.is_none() && !self.trays.is_empty() {
            return Err(
                "trays: say what lies there: catalogue, \"builtin\" or a folder".to_owned(),
            );
        }
        Ok(())
    }

    fn validate_sensors(&self) -> Result<(), String> {
        for (cell, names) in &self.sensors {
            let named = Cell::new(cell).map_err(|error| error.to_string())?;
            if self.grid_of(&named).is_none() {
                return Err(format!("sensors.{cell}: the cell is not served"));
            }
            let is_possible = |name: &String| (1..=MAX_SENSOR_NAME).contains(&name.len());
            let is_new = |(index, name)| !names.iter().take(index).any(|other| other == name);
            if names.len() > MAX_SENSORS
                || !names.iter().all(is_possible)
                || !names.iter().enumerate().all(is_new)
            {
                return Err(format!(
                    "sensors.{cell}: at most {MAX_SENSORS} different names of 1 to {MAX_SENSOR_NAME} bytes are possible"
                ));
            }
        }
        Ok(())
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        for (name, grid) in &self.cells {
            Cell::new(name).map_err(|error| error.to_string())?;
            validate_grid(grid, &self.mapper).map_err(|error| format!("cells.{name}: {error}"))?;
        }
        validate_grid(&self.grid, &self.mapper).map_err(|error| format!("grid: {error}"))?;
        in_range("the number of cells", self.cells.len(), 0..=MAX_CELLS)?;
        if self.cells.is_empty() && !self.has_unlisted_cells {
            let reason = "no cell is served: list one in cells, or set has_unlisted_cells";
            return Err(reason.to_owned());
        }
        self.validate_sensors()?;
        self.validate_trays()?;
        self.inspection
            .validate()
            .map_err(|error| format!("inspection.{error}"))?;
        let restart_s = self.sensor_restart_after_s;
        in_range("sensor_restart_after_s", restart_s, 0.0..=3600.0)?;
        in_range("clouds_mib", self.clouds_mib, 1..=65_536)?;
        in_range("queue", self.queue, 1..=65_536)?;
        ros::validate(&self.ros, |cell, is_tray| match is_tray {
            true => self.trays.get(cell.as_str()).map(|_| Sensors::new(&[])),
            false => self.grid_of(cell).map(|_| self.sensors_of(cell)),
        })
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::Grid;

    use super::*;

    #[test]
    fn what_decides_what_heightmaps_say_has_another_fingerprint() {
        let cell = Cell::new("cell-1").unwrap();
        let camera = |cell: &str, x_m| {
            let mut camera = ros::tests::camera();
            camera.cell = cell.to_owned();
            camera.container_from_sensor.position_m[0] = x_m;
            camera
        };
        let with = |change: &dyn Fn(&mut Settings)| {
            let mut settings = Settings::default();
            settings.ros.push(camera("cell-1", 0.16));
            change(&mut settings);
            settings.fingerprint_of(&cell)
        };
        let plain = with(&|_| {});
        assert_ne!(plain, 0);
        assert_eq!(with(&|s| s.queue = 7), plain);
        assert_eq!(with(&|s| s.ros.push(camera("cell-2", 0.2))), plain);
        let left = || vec!["left".to_owned()];
        let others = [
            with(&|s| s.grid.cell_m = 0.02),
            with(&|s| s.mapper.floor_tolerance_m += 1e-9),
            with(&|s| s.ros = vec![camera("cell-1", 0.16 + 1e-12)]),
            with(&|s| s.sensors = BTreeMap::from([("cell-1".to_owned(), left())])),
        ];
        for (index, other) in others.iter().enumerate() {
            assert_ne!(*other, plain, "{index}");
        }
    }

    #[test]
    fn impossible_settings_are_named() {
        Settings::default().validate().unwrap();
        let refused = |change: fn(&mut Settings)| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.validate().unwrap_err()
        };
        assert!(refused(|s| s.grid.cell_m = -1.0).contains("grid: "));
        assert!(refused(|s| s.mapper.floor_tolerance_m = -1.0).contains("floor_tolerance_m"));
        let wide = refused(|s| {
            s.mapper.point_radius_m = 0.002;
            // Wide for the samples of a small cell, narrow for those of the others.
            s.grid.cell_m = 0.002;
            s.cells.insert("small".to_owned(), s.grid);
            s.grid.cell_m = 0.02;
        });
        assert!(wide.contains("cells.small") && wide.contains("point_radius_m"));
        let sensors = |cell: &str, names: &[&str]| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            let mut settings = Settings::default();
            settings.sensors.insert(cell.to_owned(), names);
            settings.validate()
        };
        assert!(sensors("cell-1", &["left", "right"]).is_ok());
        assert!(sensors("cell-1", &["left", "left"]).is_err());
        assert!(sensors("cell-1", &[""]).is_err());
        assert!(sensors("cell-1", &["a"; 9]).is_err());
        assert!(sensors("a b", &["left"]).is_err());
        assert!(refused(|s| s.sensor_restart_after_s = f64::NAN).contains("sensor_restart"));
        assert!(refused(|s| s.queue = 0).contains("queue"));
        assert!(refused(|s| s.has_unlisted_cells = false).contains("no cell is served"));
        let named = refused(|s| {
            s.cells.insert("a b".to_owned(), GridSettings::default());
        });
        assert!(named.contains("a b"));
        let many = refused(|s| {
            let cells = 0..=MAX_CELLS;
            s.cells = cells.map(|number| (format!("c{number}"), s.grid)).collect();
        });
        assert!(many.contains("the number of cells is 65"), "{many}");
        let hall = refused(|s| {
            s.grid = GridSettings::from(&Grid::reference());
            (s.grid.container.x_m, s.grid.container.y_m) = (10.0, 10.0);
        });
        assert!(hall.contains("choose larger cells"));
    }
}
