//! Settings of the ppn service.

use std::path::PathBuf;

use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{self, in_range};
use serde::{Deserialize, Serialize};

/// Settings of the ppn service.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The cells that are served, and their containers where one has several; where none is named, all.
    pub cells: Vec<String>,
    /// The weights, a .safetensors file with its card beside it; by default those that ship.
    pub model: Option<PathBuf>,
    /// The device that the network runs on.
    pub device: Device,
    /// Maximum number of requests that wait for the network; more are refused.
    pub queue: usize,
    /// Items kept between requests, in MiB as they are encoded.
    pub items_kept_mib: usize,
    /// Grids that the network is kept ready for.
    pub grids_kept: usize,
    /// Maximum number of cells of a container's grid that the network is made ready for.
    pub most_cells: usize,
    /// Maximum work of one request: cells of the container times yaws times candidates, which is
    /// also what its memory grows with. More is refused before it is begun.
    pub most_placements: usize,
}

/// A device that a network runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Device {
    /// The processor.
    Cpu,
    /// The first CUDA device.
    Cuda,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cells: Vec::new(),
            model: None,
            device: Device::Cpu,
            queue: 16,
            items_kept_mib: 128,
            grids_kept: 4,
            most_cells: 1 << 16,
            most_placements: 1 << 22,
        }
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        configuration::cells(&self.cells)?;
        in_range("queue", self.queue, 1..=65_536)?;
        in_range("items_kept_mib", self.items_kept_mib, 1..=65_536)?;
        in_range("grids_kept", self.grids_kept, 1..=256)?;
        in_range("most_cells", self.most_cells, 1..=1 << 22)?;
        in_range("most_placements", self.most_placements, 1..=1 << 40)
    }
}
