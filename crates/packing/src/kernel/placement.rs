//! Placements: where on the grid an item goes, at which yaw and height.

use serde::{Deserialize, Serialize};

use crate::kernel::grid::Units;

/// A placement `p = (r, x, y)`: a yaw, and the footprint's cell with the lowest indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Placement {
    /// Index into the resolution's yaws.
    pub yaw: usize,
    /// Cell of the footprint's corner along x.
    pub x: usize,
    /// Cell of the footprint's corner along y.
    pub y: usize,
}

/// A placement with the height that the item reaches when it is lowered there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct RestingPlacement {
    /// Yaw and cell.
    pub placement: Placement,
    /// `k`: height of the item's lowest point above the floor, in units.
    pub resting_height: Units,
}
