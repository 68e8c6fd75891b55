//! Arm feasibility as a validity check of the planning engine.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use ppnpack_packing::check::{Cost, ValidityCheck};
use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::{Item, ShapeId};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::step::{Candidate, StageError, StepInput};

use crate::cycle::{Cycle, CycleSettings, PickPlace, PickPose};
use crate::motion::{PlaceMotion, PlacePlanner, Placing};
use crate::pick::{self, NoPickPoint, PickPoint};
use crate::refusal::Refusal;
use crate::surface::UpperSurface;

/// What the check calls itself.
pub const NAME: &str = "not possible for the arm";

/// Pick points found on heightmaps that are kept; items that come with heightmaps of their own never come again.
const PICKS_KEPT: usize = 4096;

/// Accepts placements that the arm can make: the item can be held, and the place motion is possible. Where it is
/// known where items are picked, the whole cycle has to be.
///
/// Where an item is held is looked for once per shape: in the model's mesh where it was given by
/// [`hold`](Self::hold), else in the item's heightmap at its first yaw.
#[derive(Debug, Clone)]
pub struct ArmCheck {
    planner: PlacePlanner,
    cycles: Option<(PickPlace, CycleSettings)>,
    held: HashMap<ShapeId, Result<PickPoint, NoPickPoint>>,
    masses_kg: HashMap<ShapeId, f64>,
    picks: HashMap<ShapeId, Result<PickPoint, NoPickPoint>>,
    /// By arrival: where items lie that are not brought to the usual place.
    lying: HashMap<usize, Isometry3<f64>>,
    last_refusal: Option<Refusal>,
    tally: Tally,
    /// By arrival: why placements were refused in the step.
    causes: HashMap<usize, BTreeMap<String, u64>>,
}

/// What a check was asked.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// For how many placements.
    pub asked: u64,
    /// How many of them were refused, by reason.
    pub refused: BTreeMap<String, u64>,
}

impl ArmCheck {
    /// The check with a planner of place motions.
    pub fn new(planner: PlacePlanner) -> Self {
        Self {
            planner,
            cycles: None,
            held: HashMap::new(),
            masses_kg: HashMap::new(),
            picks: HashMap::new(),
            lying: HashMap::new(),
            last_refusal: None,
            tally: Tally::default(),
            causes: HashMap::new(),
        }
    }

    /// Asks for whole cycles from the place where items are picked.
    #[must_use]
    pub fn with_cycles(mut self, from: PickPlace, settings: CycleSettings) -> Self {
        self.cycles = Some((from, settings));
        self
    }

    /// The planner of place motions.
    pub fn planner(&self) -> &PlacePlanner {
        &self.planner
    }

    /// Looks for an item's pick point on a finely sampled surface, such as its model's.
    ///
    /// # Errors
    /// [`NoPickPoint`] where it cannot be held; its placements are refused from then on.
    pub fn hold(&mut self, item: &Item, surface: &UpperSurface) -> Result<PickPoint, NoPickPoint> {
        let found = self.find(surface);
        self.held.insert(item.shape(), found);
        found
    }

    /// Whether [`hold`](Self::hold) was called for an item.
    pub fn holds(&self, item: &Item) -> bool {
        self.held.contains_key(&item.shape())
    }

    /// Forgets an item that will not come again.
    pub fn release(&mut self, item: &Item) {
        let shape = item.shape();
        self.held.remove(&shape);
        self.masses_kg.remove(&shape);
        self.picks.remove(&shape);
    }

    /// Says what an item weighs, in kilograms.
    pub fn weigh(&mut self, item: &Item, mass_kg: f64) {
        self.masses_kg.insert(item.shape(), mass_kg);
    }

    /// Says where the item of an arrival lies to be picked: the frame of its heightmaps, of which the place and the yaw
    /// count. `None` for the usual place.
    pub fn pick_from(&mut self, arrival: usize, container_from_item: Option<Isometry3<f64>>) {
        match container_from_item {
            Some(pose) => self.lying.insert(arrival, upright(&pose)),
            None => self.lying.remove(&arrival),
        };
    }

    /// Where an item is held.
    ///
    /// # Errors
    /// [`NoPickPoint`] where it cannot be held.
    pub fn pick(&mut self, item: &Item, resolution: &Resolution) -> Result<PickPoint, NoPickPoint> {
        let shape = item.shape();
        if let Some(known) = self.held.get(&shape).or_else(|| self.picks.get(&shape)) {
            return *known;
        }
        let surface = UpperSurface::of_item(item, resolution);
        let found = surface.map_or(Err(NoPickPoint::Empty), |surface| self.find(&surface));
        if self.picks.len() >= PICKS_KEPT {
            self.picks.clear();
        }
        self.picks.insert(shape, found);
        found
    }

    /// Where an item is held that the arm can lift.
    ///
    /// # Errors
    /// [`Refusal::Pick`] and [`Refusal::TooHeavy`], wherever the item would be placed.
    pub fn lift(&mut self, item: &Item, resolution: &Resolution) -> Result<PickPoint, Refusal> {
        let pick = self.pick(item, resolution)?;
        match self.masses_kg.get(&item.shape()) {
            Some(mass_kg) if *mass_kg > self.planner.arm().payload_kg() => {
                Err(Refusal::TooHeavy { mass_kg: *mass_kg })
            }
            _ => Ok(pick),
        }
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
        let pick = self.lift(item, input.grid.resolution())?;
        self.planner.plan(&Placing {
            grid: input.grid,
            scene: input.scene,
            item,
            resting,
            pick: &pick,
        })
    }

    /// The cycle that picks and places a candidate; `None` where it is not known where items are picked.
    ///
    /// # Errors
    /// [`Refusal`] where there is none.
    pub fn cycle(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Option<Cycle>, Refusal> {
        let item = &candidate.item;
        let Some((place, settings)) = self.cycles else {
            return Ok(None);
        };
        let pick = self.lift(item, input.grid.resolution())?;
        let mass_kg = self.masses_kg.get(&item.shape()).copied();
        let from = match self.lying.get(&candidate.arrival) {
            Some(lying) => Some(PickPose {
                container_from_item: self.on_table(lying, item),
                mass_kg,
            }),
            None => place.pose(item, &pick, mass_kg),
        };
        let from = from.ok_or(Refusal::Placement)?;
        let placing = Placing {
            grid: input.grid,
            scene: input.scene,
            item,
            resting,
            pick: &pick,
        };
        self.planner
            .plan_cycle(&placing, &from, &settings)
            .map(Some)
    }

    /// A pose that was seen, not below the table: cameras are off by some millimetres, items are not in the table.
    fn on_table(&self, lying: &Isometry3<f64>, item: &Item) -> Isometry3<f64> {
        let view = item.views().first();
        let above_lowest_m = view.map_or(0.0, |view| view.origin_from_corner_m().z);
        let mut pose = *lying;
        let z_m = &mut pose.translation.vector.z;
        *z_m = z_m.max(self.planner.cell().table_height_m + above_lowest_m);
        pose
    }

    /// Why the last placement that was refused was.
    pub fn last_refusal(&self) -> Option<&Refusal> {
        self.last_refusal.as_ref()
    }

    /// What it was asked since the last call.
    pub fn take_tally(&mut self) -> Tally {
        std::mem::take(&mut self.tally)
    }

    /// Why most placements of a candidate were refused in the step, by the candidate's arrival; `None` where none was.
    pub fn why(&self, arrival: usize) -> Option<&str> {
        let causes = self.causes.get(&arrival)?;
        let most = causes.iter().max_by_key(|(_, count)| **count);
        most.map(|(cause, _)| cause.as_str())
    }

    /// The place motion is tried first: it takes a tenth of the time of a cycle, and finds most of what is not possible.
    fn try_placement(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<(), Refusal> {
        self.plan(input, &candidate.item, resting)?;
        self.cycle(input, candidate, resting)?;
        Ok(())
    }

    fn note(&mut self, arrival: usize, refusal: Refusal) {
        let cause = refusal.cause();
        *self.tally.refused.entry(cause.clone()).or_default() += 1;
        let causes = self.causes.entry(arrival).or_default();
        *causes.entry(cause).or_default() += 1;
        self.last_refusal = Some(refusal);
    }

    fn find(&self, surface: &UpperSurface) -> Result<PickPoint, NoPickPoint> {
        let gripper = self.planner.arm().gripper();
        pick::find(surface, gripper, &self.planner.cell().pick)
    }
}

/// A pose without what it leans.
fn upright(pose: &Isometry3<f64>) -> Isometry3<f64> {
    let (_, _, yaw_rad) = pose.rotation.euler_angles();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    Isometry3::from_parts(pose.translation, turn)
}

impl ValidityCheck for ArmCheck {
    fn name(&self) -> &'static str {
        NAME
    }

    fn cost(&self) -> Cost {
        Cost::Motion
    }

    fn rules_out(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> Result<bool, StageError> {
        // Asked as a step begins: what was said of the candidate in another step is forgotten.
        self.causes.remove(&candidate.arrival);
        let Err(refusal) = self.lift(&candidate.item, input.grid.resolution()) else {
            return Ok(false);
        };
        let causes = self.causes.entry(candidate.arrival).or_default();
        causes.insert(refusal.cause(), 1);
        self.last_refusal = Some(refusal);
        Ok(true)
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        self.tally.asked += 1;
        match self.try_placement(input, candidate, resting) {
            Ok(()) => Ok(true),
            Err(refusal) => {
                self.note(candidate.arrival, refusal);
                Ok(false)
            }
        }
    }
}
