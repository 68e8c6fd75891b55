//! Settings of the heuristic service.

use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{self, in_range, settings};

settings! {
    /// Settings of the heuristic service.
    pub struct Settings {
        /// The cells that are served, and their containers where one has several; where none is
        /// named, all.
        pub cells: Vec<String> = Vec::new(),
        /// Maximum number of requests that wait; more are refused.
        pub queue: usize = 16,
        /// Items kept between requests, in MiB as they are encoded.
        pub items_kept_mib: usize = 128,
        /// Searches that are kept, one per cell, grid and objective.
        pub searches_kept: usize = 16,
        /// The memory that the searches may take together, in MiB: half for those that are kept, of
        /// which the longest unused go first, and half for the one at work; what needs more is
        /// refused.
        pub searches_mib: usize = 256,
        /// The most work of one request: cells of the container times the yaws that are searched,
        /// of all candidates together. More is refused before it is begun.
        pub most_placements: usize = 1 << 30,
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        configuration::cells(&self.cells)?;
        in_range("queue", self.queue, 1..=65_536)?;
        in_range("items_kept_mib", self.items_kept_mib, 1..=65_536)?;
        in_range("searches_kept", self.searches_kept, 1..=4_096)?;
        in_range("searches_mib", self.searches_mib, 1..=65_536)?;
        in_range("most_placements", self.most_placements, 1..=1 << 48)
    }
}
