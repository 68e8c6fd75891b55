//! Boxes on a compact heightmap of the bin: what roll-outs are played on.

use serde::{Deserialize, Serialize};

/// Cells along each side of the bin.
pub(super) const SIDE: u8 = 10;

/// Units of volume in the bin.
pub(super) const BIN_VOLUME: u32 = (SIDE as u32).pow(3);

/// The longest side of a box.
pub(super) const LONGEST: u8 = 5;

/// Cells of the floor.
pub(super) const CELLS: usize = (SIDE as usize).pow(2);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct Sides {
    pub(super) x: u8,
    pub(super) y: u8,
    pub(super) z: u8,
}

impl Sides {
    pub(super) fn volume(self) -> u32 {
        self.floor_cells() * u32::from(self.z)
    }

    pub(super) fn turned(self) -> Self {
        Self {
            x: self.y,
            y: self.x,
            z: self.z,
        }
    }

    pub(super) fn floor_cells(self) -> u32 {
        u32::from(self.x) * u32::from(self.y)
    }
}

/// A box where it lies: its sides, and its corner with the lowest coordinates, in cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Placed {
    pub(super) sides: Sides,
    pub(super) x: u8,
    pub(super) y: u8,
    pub(super) z: u8,
}

impl Placed {
    pub(super) fn top(&self) -> u8 {
        self.z + self.sides.z
    }

    pub(super) fn cells(&self) -> impl Iterator<Item = (u8, u8)> + use<> {
        let Self { sides, x, y, .. } = *self;
        (x..x + sides.x).flat_map(move |x| (y..y + sides.y).map(move |y| (x, y)))
    }
}

/// The index of a cell, row-major as in the engine.
pub(super) fn index(x: u8, y: u8) -> usize {
    usize::from(x) * usize::from(SIDE) + usize::from(y)
}

/// Height of each cell. Boxes come from above, so that everything below counts as full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Surface {
    heights: [u8; CELLS],
}

impl Surface {
    pub(super) fn empty() -> Self {
        Self {
            heights: [0; CELLS],
        }
    }

    /// The height of a cell; 0 outside the bin.
    pub(super) fn height(&self, x: u8, y: u8) -> u8 {
        self.heights.get(index(x, y)).copied().unwrap_or(0)
    }

    pub(super) fn heights(&self) -> impl Iterator<Item = u8> {
        self.heights.iter().copied()
    }

    pub(super) fn place(&mut self, placed: &Placed) {
        let Placed { sides, x, y, .. } = *placed;
        for row in x..x + sides.x {
            let from = index(row, y);
            let cells = self.heights.get_mut(from..from + usize::from(sides.y));
            cells.unwrap_or_default().fill(placed.top());
        }
    }

    /// The greatest height below a bottom of these sides with its corner at a cell, where a box
    /// comes to rest; and the sum of the heights below it, at most 250.
    pub(super) fn below(&self, sides: Sides, x: u8, y: u8) -> (u8, u8) {
        let (mut greatest, mut sum) = (0, 0);
        for row in x..x + sides.x {
            let from = index(row, y);
            let cells = self.heights.get(from..from + usize::from(sides.y));
            for height in cells.unwrap_or_default() {
                greatest = u8::max(greatest, *height);
                sum += *height;
            }
        }
        (greatest, sum)
    }
}
