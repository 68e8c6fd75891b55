//! The heuristics `F(b, p)`: their terms, weights and lower bounds.
//!
//! An item `b` at a placement `p = (r, x, y)` rests at the height `k`. Under the default weights,
//! with `k` in 0.2 cm, `x` and `y` in centimetres, `V` the item's volume, `B` that of its bounding
//! box and `C` the container's:
//!
//! | | `F(b, p)`, without the balance term | source |
//! |---|---|---|
//! | SDFM | `k + 2.5 d + 10 (1 - cbrt(V / B))`, `d` the mean over the item's voxels of the distance to content, truncated to 5 cm | Pan et al., *SDF-Pack: Towards Compact Bin Packing with Signed-Distance-Field Minimization*, IROS 2023 |
//! | DBL | `k + x + y` | Karabulut and İnceoğlu, *A Hybrid Genetic Algorithm for Packing in 3D with Deepest Bottom Left with Fill Method*, ADVIS 2004 |
//! | HM | `s + x + y`, `s` the volume under the surface over the footprint's bounding rectangle once the item is placed, per square centimetre and 0.2 cm | Wang and Hauser, *Stable Bin Packing of Non-convex 3D Objects with a Robot Manipulator*, ICRA 2019 |
//! | MTA | `-a`, `a` the area of the item's faces that touch content, walls or floor, in square centimetres | of this project: the touching perimeter of Lodi, Martello and Vigo (1999) in three dimensions |
//!
//! [`Order::Balance`] adds `80 (1 - cbrt(V / C))` to each, the size-balancing term of SDF-Pack,
//! which prefers large items early. The other weights are in [`Weights`].

pub use ppnpack_numbers::SettingError;
use ppnpack_numbers::{settings, within};
use serde::{Deserialize, Serialize};

use crate::kernel::grid::{Grid, Units};
use crate::kernel::item::{Columns, ItemView};
use crate::kernel::lanes::Contact;

/// Heights enter the published objectives in units of 0.2 cm.
const REFERENCE_UNIT_M: f64 = 0.002;

/// Offsets along the floor enter them in centimetres.
const REFERENCE_CELL_M: f64 = 0.01;

/// The range of a weight, in words.
const WEIGHT: &str = "a finite number of at least 0";

/// Objective of a placement; lower is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Heuristic {
    /// SDF minimisation: low, close to content, compact.
    Sdfm,
    /// Deepest bottom-left: low, then towards the origin's corner.
    Dbl,
    /// Heightmap minimisation: the least volume under the surface afterwards.
    Hm,
    /// Maximum touching area, negated.
    Mta,
    /// The first valid placement in the order of yaw, x, y.
    FirstFit,
    /// A valid placement at random: the lower bound of all methods.
    Random,
}

/// Competition among the items of the buffer in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Order {
    /// All together, with the size-balancing term that prefers large items early.
    Balance,
    /// One after another by decreasing volume of the bounding box, without that term; the first
    /// that has a valid placement is packed.
    BboxVolume,
    /// One after another as they arrived, without that term.
    Arrival,
    /// One after another in random order, without that term.
    Shuffled,
}

settings! {
    /// The weights of the objectives' terms; the defaults are the published ones. The search's
    /// bounds rely on all being finite and at least 0.
    #[derive(Copy)]
    pub struct Weights with validate as "the weight " {
        /// Weight of the resting height, per 0.2 cm.
        pub resting_height: f64 = 1.0 => within(WEIGHT, 0.0..),
        /// Weight of the mean truncated distance to content, per step of 1 cm.
        pub distance: f64 = 2.5 => within(WEIGHT, 0.0..),
        /// Weight of the item's own height, per 0.2 cm: with that of the resting height, a price
        /// for where the top comes to lie. Of SDFM.
        pub top_height: f64 = 0.0 => within(WEIGHT, 0.0..),
        /// Weight of `1 - cbrt(V / B)`, the item's share of its bounding box.
        pub box_share: f64 = 10.0 => within(WEIGHT, 0.0..),
        /// Weight of `1 - cbrt(V / C)`, the item's share of the container, in the Balance order.
        pub balance: f64 = 80.0 => within(WEIGHT, 0.0..),
        /// Weight of the offset from the origin's corner, per centimetre.
        pub corner: f64 = 1.0 => within(WEIGHT, 0.0..),
        /// Weight of the volume under the surface, per square centimetre and 0.2 cm.
        pub surface_volume: f64 = 1.0 => within(WEIGHT, 0.0..),
        /// Weight of the touching area, per square centimetre.
        pub touching_area: f64 = 1.0 => within(WEIGHT, 0.0..),
    }
}

impl Weights {
    /// Weights that also price where an item's top comes to lie, and so fill containers more
    /// tightly than the published ones where each item comes in one pose.
    pub fn low() -> Self {
        Self {
            top_height: 0.2,
            ..Self::default()
        }
    }

    /// Weights for items in several resting poses, which also judge how high an item stands.
    pub fn dense() -> Self {
        Self {
            distance: 5.0,
            top_height: 0.3,
            balance: 120.0,
            ..Self::default()
        }
    }

    /// The weights that fill containers most tightly with items in so many resting poses.
    pub fn for_poses(poses: usize) -> Self {
        match poses {
            0 | 1 => Self::low(),
            _ => Self::dense(),
        }
    }
}

/// An objective at one resolution: weights for its cells and units, lengths staying physical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Objective {
    pub(crate) heuristic: Heuristic,
    per_unit: f64,
    per_cell: f64,
    per_column_unit: f64,
    per_floor_face: f64,
    per_side_face: f64,
    distance: f64,
    per_unit_of_item: f64,
    box_share: f64,
    balance: f64,
    container_voxels: f64,
}

impl Objective {
    pub(crate) fn new(
        grid: &Grid,
        heuristic: Heuristic,
        weights: &Weights,
        balanced: bool,
    ) -> Self {
        let unit = grid.resolution().height_unit_m() / REFERENCE_UNIT_M;
        let cell = grid.resolution().cell_m() / REFERENCE_CELL_M;
        let unit_cm = unit * REFERENCE_UNIT_M / REFERENCE_CELL_M;
        Self {
            heuristic,
            per_unit: weights.resting_height * unit,
            per_cell: weights.corner * cell,
            per_column_unit: weights.surface_volume * unit * cell * cell,
            per_floor_face: weights.touching_area * cell * cell,
            per_side_face: weights.touching_area * cell * unit_cm,
            distance: weights.distance,
            per_unit_of_item: weights.top_height * unit,
            box_share: weights.box_share,
            balance: if balanced { weights.balance } else { 0.0 },
            container_voxels: grid.voxel_count(),
        }
    }

    /// Gives the terms that depend on the item and yaw alone: the balance term `80 (1 - cbrt(V / C))`
    /// and of SDFM `10 (1 - cbrt(V / B))`, both of Pan et al. (2023), and the price of its height.
    pub(crate) fn constant(&self, view: &ItemView) -> f64 {
        let voxels = view.voxel_count() as f64;
        let balance = self.balance * (1.0 - (voxels / self.container_voxels).cbrt());
        match self.heuristic {
            Heuristic::Sdfm => {
                let share = voxels / view.box_voxel_count() as f64;
                let top = self.per_unit_of_item * f64::from(view.height());
                self.box_share * (1.0 - share.cbrt()) + top + balance
            }
            Heuristic::Dbl | Heuristic::Hm | Heuristic::Mta => balance,
            Heuristic::FirstFit | Heuristic::Random => 0.0,
        }
    }

    /// Bounds the values of a block from below: it starts at the cell `at`, rests at `height` at
    /// least and has at least this sum of distances. Of a single placement it is its SDFM or DBL.
    /// `constant` is [`Self::constant`] of the view.
    pub(crate) fn block_bound(
        &self,
        view: &ItemView,
        constant: f64,
        at: (usize, usize),
        height: Units,
        distance_sum: u64,
    ) -> f64 {
        // Terms are added in the values' order: rounding cannot lift a bound above a value.
        match self.heuristic {
            Heuristic::Sdfm => {
                let mean_distance = distance_sum as f64 / view.voxel_count() as f64;
                self.sdfm(height, mean_distance, constant)
            }
            Heuristic::Dbl => self.dbl(height, at.0, at.1, constant),
            Heuristic::Hm => {
                let Columns { cells, top_sum } = view.columns;
                let columns = cells as i64 * i64::from(height) + top_sum;
                self.hm(columns, at.0, at.1, constant)
            }
            Heuristic::Mta => {
                let largest = Contact {
                    floor_faces: (view.nx() * view.ny()) as u64,
                    side_faces: 4 * view.voxel_count(),
                };
                self.mta(largest, constant)
            }
            Heuristic::FirstFit | Heuristic::Random => 0.0,
        }
    }

    /// SDFM: `k + 2.5 d + constant` (Pan et al., 2023).
    pub(crate) fn sdfm(&self, height: Units, mean_distance: f64, constant: f64) -> f64 {
        self.per_unit * f64::from(height) + self.distance * mean_distance + constant
    }

    /// DBL: `k + x + y + constant` (Karabulut and İnceoğlu, 2004).
    pub(crate) fn dbl(&self, height: Units, x: usize, y: usize, constant: f64) -> f64 {
        self.per_unit * f64::from(height) + self.per_cell * (x + y) as f64 + constant
    }

    /// HM: `s + x + y + constant`, `columns` being `s` in cells times units (Wang and Hauser, 2019).
    pub(crate) fn hm(&self, columns: i64, x: usize, y: usize, constant: f64) -> f64 {
        self.per_column_unit * columns as f64 + self.per_cell * (x + y) as f64 + constant
    }

    /// MTA: `constant - a`.
    pub(crate) fn mta(&self, contact: Contact, constant: f64) -> f64 {
        let area = self.per_floor_face * contact.floor_faces as f64
            + self.per_side_face * contact.side_faces as f64;
        constant - area
    }
}
