//! The conditions of a simulated cell, and what is usual under them.

use clap::ValueEnum;
use ppnpack_packing::grid::{Grid, GridSettings};
use ppnpack_packing::method::{Method, SET_ASIDE};

/// How items are released and seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Conditions {
    /// Laid down from 1 cm, given 2 s to settle, every cell seen exactly
    Robot,
    /// The reference's: dropped from 12 cm, given the 0.375 s of the published code (the paper says 0.25 s), seen by a camera
    /// with one pixel per cell
    Reference,
}

impl Conditions {
    /// The grid where nothing is said.
    pub(crate) fn grid(self) -> GridSettings {
        match self {
            Self::Robot => GridSettings::default(),
            Self::Reference => GridSettings::from(&Grid::reference()),
        }
    }

    /// The method where nothing is said.
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Robot => Method::default(),
            Self::Reference => Method::published(),
        }
    }

    /// How many items may be set aside where nothing is said.
    pub(crate) fn set_aside(self) -> usize {
        match self {
            Self::Robot => SET_ASIDE,
            Self::Reference => 0,
        }
    }
}
