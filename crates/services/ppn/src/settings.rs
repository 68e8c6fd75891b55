//! Settings of the ppn service.

use std::path::PathBuf;

use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{self, in_range, settings};
use serde::{Deserialize, Serialize};

settings! {
    /// Settings of the ppn service.
    pub struct Settings {
        /// The cells that are served, and their containers where one has several; where none is
        /// named, all.
        pub cells: Vec<String> = Vec::new(),
        /// The weights, a .safetensors file with its card beside it; by default those that ship.
        pub model: Option<PathBuf> = None,
        /// The device that the network runs on.
        pub device: Device = Device::Cpu,
        /// Maximum number of requests that wait for the network; more are refused.
        pub queue: usize = 16,
        /// Items kept between requests, in MiB as they are encoded.
        pub items_kept_mib: usize = 128,
        /// Grids that the network is kept ready for.
        pub grids_kept: usize = 4,
        /// Maximum number of cells of a container's grid that the network is made ready for.
        pub most_cells: usize = 1 << 16,
        /// Maximum work of one request: cells of the container times yaws times candidates, which
        /// is also what its memory grows with. More is refused before it is begun.
        pub most_placements: usize = 1 << 22,
    }
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
