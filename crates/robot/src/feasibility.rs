//! Arm feasibility as a validity check of the planning engine.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use ppnpack_packing::checks::check::{Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::{Item, ShapeId};
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::refusal::{Cause, Refusal as Refused};
use ppnpack_packing::ranking::step::{Candidate, StageResult, StepInput};

use crate::cycle::{CycleSettings, PickPlace, PlannedCycle};
use crate::motion::{PlaceMotion, PlacePlanner, Placing};
use crate::pick::{self, NoPickPoint, PickPoint};
use crate::refusal::Refusal;
use crate::surface::UpperSurface;

/// Pitch at which models are sampled for a place to hold them, in metres.
const SURFACE_PITCH_M: f64 = 0.002;

/// Default number of refused cycles after which an item is left out of a step.
pub(crate) const REFUSED_CYCLES_PER_ITEM: usize = 100;

/// Maximum of pick points that are kept; items that come with heightmaps of their own never come
/// again.
const PICKS_KEPT: usize = 4096;

/// Accepts placements that the arm can make: the item can be held, and the place motion is
/// possible. With a place where items are picked, the whole cycle has to be possible, and is the
/// evidence.
///
/// The place to hold an item is looked for once per shape: on its model where that is known, else
/// in its heightmap at the first yaw.
///
/// After so many refused cycles of an item in a step, and no possible one before, the item is left
/// out of the step: the arm cannot take it from where it lies, and on a fine grid there are ten
/// thousand placements to find that out on.
#[derive(Debug, Clone)]
pub struct ArmCheck {
    planner: PlacePlanner,
    cycles: Option<(PickPlace, CycleSettings)>,
    refused_cycles_per_item: usize,
    /// Refused cycles of this step, by arrival and shape: their count and the last refusal; `None`
    /// once a cycle was possible.
    fetching: HashMap<(usize, ShapeId), Option<(usize, Refused)>>,
    /// Pick points, by shape, and whether the model is known.
    picks: HashMap<(ShapeId, bool), Result<PickPoint, NoPickPoint>>,
}

impl ArmCheck {
    /// Makes the check with a planner of place motions.
    pub fn new(planner: PlacePlanner) -> Self {
        Self {
            planner,
            cycles: None,
            refused_cycles_per_item: REFUSED_CYCLES_PER_ITEM,
            fetching: HashMap::new(),
            picks: HashMap::new(),
        }
    }

    /// Asks for whole cycles from the place where items are picked.
    #[must_use]
    pub fn with_cycles(mut self, from: PickPlace, settings: CycleSettings) -> Self {
        self.cycles = Some((from, settings));
        self
    }

    /// Leaves an item out of a step once so many of its placements were refused for their cycles
    /// alone, and none accepted.
    #[must_use]
    pub fn with_refused_cycles_per_item(mut self, refused: usize) -> Self {
        self.refused_cycles_per_item = refused;
        self
    }

    /// Gives the planner of place motions.
    pub fn planner(&self) -> &PlacePlanner {
        &self.planner
    }

    /// Finds where to hold an item.
    ///
    /// # Errors
    /// [`NoPickPoint`] where it cannot be held.
    pub fn pick(
        &mut self,
        candidate: &Candidate,
        resolution: &Resolution,
    ) -> Result<PickPoint, NoPickPoint> {
        let key = (candidate.item.shape(), candidate.model.is_some());
        if let Some(known) = self.picks.get(&key) {
            return *known;
        }
        let model = candidate.model.as_ref();
        let of_model = model.and_then(|model| UpperSurface::of_model(model, SURFACE_PITCH_M));
        let surface = of_model.or_else(|| UpperSurface::of_item(&candidate.item, resolution));
        let found = surface.map_or(Err(NoPickPoint::Empty), |surface| {
            let gripper = self.planner.arm().gripper();
            pick::find(&surface, gripper, &self.planner.cell().pick)
        });
        if self.picks.len() >= PICKS_KEPT {
            self.picks.clear();
        }
        self.picks.insert(key, found);
        found
    }

    /// Finds where to hold an item that the arm can lift.
    ///
    /// # Errors
    /// [`Refusal::Pick`] and [`Refusal::TooHeavy`], wherever the item would be placed.
    pub fn lift(
        &mut self,
        candidate: &Candidate,
        resolution: &Resolution,
    ) -> Result<PickPoint, Refusal> {
        let pick = self.pick(candidate, resolution)?;
        match candidate.weighs_kg() {
            Some(mass_kg) if mass_kg > self.planner.arm().payload_kg() => {
                Err(Refusal::TooHeavy { mass_kg })
            }
            _ => Ok(pick),
        }
    }

    /// Plans the motion that places a candidate.
    ///
    /// # Errors
    /// [`Refusal`] where there is none.
    pub fn plan(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<PlaceMotion, Refusal> {
        let pick = self.lift(candidate, input.grid.resolution())?;
        self.planner
            .plan(&placing(input, candidate, resting, &pick))
    }

    /// Plans the cycle that picks and places a candidate; `None` without a place where items are
    /// picked.
    ///
    /// # Errors
    /// [`Refusal`] where there is none.
    pub fn cycle(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Option<PlannedCycle>, Refusal> {
        let Some((place, settings)) = self.cycles else {
            return Ok(None);
        };
        let item = &candidate.item;
        let pick = self.lift(candidate, input.grid.resolution())?;
        let from = match candidate.lying.heightmap_frame() {
            Some(lying) => Some(self.on_table(&upright(&lying), item)),
            None => place.pose(item, &pick),
        };
        let from = from.ok_or(Refusal::Placement)?;
        let placing = placing(input, candidate, resting, &pick);
        let cycle = self.planner.plan_cycle(&placing, &from, &settings)?;
        Ok(Some(cycle))
    }

    /// Raises a pose that was seen to the table: cameras are off by some millimetres, items are not
    /// in the table.
    fn on_table(&self, lying: &Isometry3<f64>, item: &Item) -> Isometry3<f64> {
        let view = item.views().first();
        let above_lowest_m = view.map_or(0.0, |view| view.origin_from_corner_m().z);
        let mut pose = *lying;
        let z_m = &mut pose.translation.vector.z;
        *z_m = z_m.max(self.planner.cell().table_height_m + above_lowest_m);
        pose
    }

    /// Notes whether a cycle is possible. Once one was, no refusal counts: what else is asked may
    /// then depend on how many placements are looked at ahead, and whether an item is left out must
    /// not.
    fn note(&mut self, candidate: &Candidate, cycle: &Result<Option<PlannedCycle>, Refusal>) {
        let key = (candidate.arrival, candidate.item.shape());
        let refused = match (cycle, self.fetching.get(&key)) {
            (Ok(_), _) | (_, Some(None)) => None,
            (Err(why), Some(Some((count, _)))) => Some((count + 1, why.into())),
            (Err(why), None) => Some((1, why.into())),
        };
        self.fetching.insert(key, refused);
    }

    /// Gives the last refusal of an item's cycles in this step, where it is left out.
    fn left_out(&self, candidate: &Candidate) -> Option<&Refused> {
        let key = (candidate.arrival, candidate.item.shape());
        let (count, last) = self.fetching.get(&key)?.as_ref()?;
        (*count >= self.refused_cycles_per_item).then_some(last)
    }

    /// Tries the place motion first: it takes a tenth of the time of a cycle, and finds most of
    /// what is not possible.
    fn try_placement(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Evidence, Refusal> {
        self.plan(input, candidate, resting)?;
        let cycle = self.cycle(input, candidate, resting);
        self.note(candidate, &cycle);
        let cycle = cycle?;
        let arm = self.planner.arm().name();
        Ok(Evidence {
            cycle: cycle.map(|cycle| Arc::new(cycle.sampled(arm, &candidate.lying))),
            ..Evidence::default()
        })
    }
}

fn placing<'a>(
    input: &StepInput<'a>,
    candidate: &'a Candidate,
    resting: &'a RestingPlacement,
    pick: &'a PickPoint,
) -> Placing<'a> {
    Placing {
        grid: input.grid,
        scene: input.scene,
        item: &candidate.item,
        resting,
        pick,
    }
}

/// Takes the lean out of a pose.
fn upright(pose: &Isometry3<f64>) -> Isometry3<f64> {
    let (_, _, yaw_rad) = pose.rotation.euler_angles();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    Isometry3::from_parts(pose.translation, turn)
}

/// Converts a refusal of the arm to one of the engine.
impl From<&Refusal> for Refused {
    fn from(refusal: &Refusal) -> Self {
        Self::because(Cause::Arm, refusal.cause())
    }
}

impl ValidityCheck for ArmCheck {
    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn begin(&mut self, _: &StepInput<'_>) -> StageResult {
        self.fetching.clear();
        Ok(())
    }

    fn rules_out(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> StageResult<Option<Refused>> {
        let lifted = self.lift(candidate, input.grid.resolution());
        Ok(lifted.err().as_ref().map(Refused::from))
    }

    fn refuses_unseen(
        &self,
        _: &StepInput<'_>,
        candidate: &Candidate,
        _: &RestingPlacement,
    ) -> Option<Refused> {
        self.left_out(candidate).cloned()
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        Ok(match self.try_placement(input, candidate, resting) {
            Ok(evidence) => Verdict::Accepted(evidence),
            Err(refusal) => Verdict::Refused(Refused::from(&refusal)),
        })
    }

    fn is_done_with(&self, candidate: &Candidate) -> bool {
        self.left_out(candidate).is_some()
    }
}
