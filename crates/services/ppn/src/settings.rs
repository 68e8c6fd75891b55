//! What can be set.

use std::path::PathBuf;

use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{self, in_range};
use serde::{Deserialize, Serialize};

/// Settings of the ppn service.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The cells that are served, and their containers where a cell has several; where none is named, all.
    pub cells: Vec<String>,
    /// The weights, a .safetensors file with its card beside it; those that ship where none is given.
    pub model: Option<PathBuf>,
    /// Where the network runs.
    pub device: Device,
    /// Requests that wait for the network at most; more are refused.
    pub queue: usize,
    /// Items kept between requests, in MiB as they are encoded.
    pub items_kept_mib: usize,
    /// Grids that the network is kept ready for.
    pub grids_kept: usize,
    /// The most cells of a container's grid that the network is made ready for.
    pub most_cells: usize,
    /// The most work of one request: cells of the container times yaws times candidates, which is also what its memory grows
    /// with. More is refused before it is begun.
    pub most_placements: usize,
}

/// Where a network runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Device {
    /// On the processor.
    Cpu,
    /// On the first CUDA device.
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
