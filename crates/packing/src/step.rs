//! What the parts of Algorithm 1 exchange in a step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::item::Item;
use crate::placement::RestingPlacement;

/// An error of a proposer, an evaluator or a check, local or remote.
pub type StageError = Box<dyn std::error::Error + Send + Sync>;

/// An item of the buffer that a step may choose.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Its place in the sequence of arrivals, from 0.
    pub arrival: usize,
    /// The item.
    pub item: Arc<Item>,
}

/// What one step is planned on.
#[derive(Debug, Clone, Copy)]
pub struct StepInput<'a> {
    /// The container's grid.
    pub grid: &'a Grid,
    /// The container's content.
    pub scene: &'a Scene,
    /// The buffer.
    pub candidates: &'a [Candidate],
    /// Number of the step, which stochastic parts mix into their seed.
    pub step: u64,
}

/// A placement with the value of the objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluated {
    /// Index into [`StepInput::candidates`].
    pub candidate: usize,
    /// Where, and how high.
    pub resting: RestingPlacement,
    /// `F(b, p)`; lower is better.
    pub value: f64,
}

/// How many placements of a candidate there were before any validity check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PlacementCounts {
    /// Placements whose footprint lies within the container, over all yaws, whether proposed or not.
    pub possible: u64,
    /// Those of them that were proposed.
    pub proposed: u64,
    /// Proposed ones that stay below the rim; of a search by bounds, those that it looked at, which are all only where
    /// none was valid.
    pub fitting: u64,
}
