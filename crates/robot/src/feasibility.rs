//! Arm feasibility as a validity check of the planning engine.

use std::collections::HashMap;

use ppnpack_packing::check::{Cost, ValidityCheck};
use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::{Item, ShapeId};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::step::{Candidate, StageError, StepInput};

use crate::motion::{PlaceMotion, PlacePlanner, Placing};
use crate::pick::{self, NoPickPoint, PickPoint};
use crate::refusal::Refusal;
use crate::surface::UpperSurface;

/// Accepts placements that the arm can make: the item can be held, and the place motion is possible.
///
/// Where an item is held is looked for once per shape: in the model's mesh where it was given by
/// [`hold`](Self::hold), else in the item's heightmap at its first yaw.
#[derive(Debug, Clone)]
pub struct ArmCheck {
    planner: PlacePlanner,
    picks: HashMap<ShapeId, Result<PickPoint, NoPickPoint>>,
    last_refusal: Option<Refusal>,
}

impl ArmCheck {
    /// The check with a planner of place motions.
    pub fn new(planner: PlacePlanner) -> Self {
        Self {
            planner,
            picks: HashMap::new(),
            last_refusal: None,
        }
    }

    /// Looks for an item's pick point on a finely sampled surface, such as its model's.
    ///
    /// # Errors
    /// [`NoPickPoint`] where it cannot be held; its placements are refused from then on.
    pub fn hold(&mut self, item: &Item, surface: &UpperSurface) -> Result<PickPoint, NoPickPoint> {
        let found = self.find(surface);
        self.picks.insert(item.shape(), found);
        found
    }

    /// Where an item is held.
    ///
    /// # Errors
    /// [`NoPickPoint`] where it cannot be held.
    pub fn pick(&mut self, item: &Item, resolution: &Resolution) -> Result<PickPoint, NoPickPoint> {
        if let Some(known) = self.picks.get(&item.shape()) {
            return *known;
        }
        let surface = UpperSurface::of_item(item, resolution);
        let found = surface.map_or(Err(NoPickPoint::Empty), |surface| self.find(&surface));
        self.picks.insert(item.shape(), found);
        found
    }

    /// The motion that places a candidate.
    ///
    /// # Errors
    /// [`Refusal`] where there is none.
    pub fn plan(
        &mut self,
        input: &StepInput<'_>,
        item: &Item,
        resting: &RestingPlacement,
    ) -> Result<PlaceMotion, Refusal> {
        let pick = self.pick(item, input.grid.resolution())?;
        self.planner.plan(&Placing {
            grid: input.grid,
            scene: input.scene,
            item,
            resting,
            pick: &pick,
        })
    }

    /// Why the last placement that was refused was.
    pub fn last_refusal(&self) -> Option<&Refusal> {
        self.last_refusal.as_ref()
    }

    fn find(&self, surface: &UpperSurface) -> Result<PickPoint, NoPickPoint> {
        let gripper = self.planner.arm().gripper();
        pick::find(surface, gripper, &self.planner.cell().pick)
    }
}

impl ValidityCheck for ArmCheck {
    fn name(&self) -> &'static str {
        "not possible for the arm"
    }

    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        match self.plan(input, &candidate.item, resting) {
            Ok(_) => Ok(true),
            Err(refusal) => {
                self.last_refusal = Some(refusal);
                Ok(false)
            }
        }
    }
}
