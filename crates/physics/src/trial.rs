//! The simulated check: a placement is tried in the twin of the cell before it is made.

mod loads;

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::seen::SeenSolids;
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::check::{BoxedCheck, Cost, Evidence, LastResort, ValidityCheck, Verdict};
use ppnpack_packing::content::Content;
use ppnpack_packing::item::ShapeId;
use ppnpack_packing::loads::{Load, LoadSettings};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::step::{StageResult, StepInput};
use ppnpack_packing::trial::{Settling, TrialLimits, TrialSettings};
use rayon::prelude::*;

use loads::LoadTries;

use crate::error::PhysicsError;
use crate::twin::{Solid, Twin, TwinSettings};

/// Divisor of the tries of an item that has a last resort: what rolls seldom stays at the next places, either, and all of them
/// are tried again and again as it is left for later steps.
const TRIES_WITH_RESORT: usize = 4;

/// Factor of the distance between tries in a widened search, in which it holds at any yaw and in any pose.
const WIDE: f64 = 4.0;

/// So many tries are kept from one step to the next at most.
const TRIES_KEPT: usize = 10_000;

/// Of a try with what was seen of the item.
const SEEN_ITEM: &str =
    "the item was tried with the shape that was seen of it, as its solid is not known";

/// Of an item that was not tried.
const UNTRIED_ITEM: &str = "the item was not tried, as what was seen of it makes no solid";

/// Of a try among items of which no more is known than what was seen.
const SEEN_CONTENT: &str =
    "items in the container took part with the shapes that were seen of them";

/// Of a try where not all that lies in the container is known.
const PARTIAL_CONTENT: &str =
    "the item was tried among the known ones in the container, and on the heightmap of the others";

/// Accepts placements whose item stays where it is placed, as the twin of the cell tells.
///
/// An item whose solid is not known takes part with the shape that was seen; what lies in the container and has no known
/// shape is as high as the heightmap shows it. The evidence says so. Where nothing is known of the content, placements
/// are accepted without evidence.
///
/// Its answers are the same with any number of threads, and whatever was tried in earlier steps.
pub struct TrialCheck {
    settings: TrialSettings,
    twin: Twin,
    /// Of items whose own solids are not known.
    seen: SeenSolids,
    /// What this step lacks of the container's content.
    lacks: Vec<&'static str>,
    /// Spreads the tries of a step; without one they are made one after another.
    pool: Option<Arc<rayon::ThreadPool>>,
    /// Tries of this step, and those of earlier steps that would not go otherwise now.
    known: HashMap<Place, Tried>,
    /// Of this step.
    refused: Vec<Refused>,
    /// What tried placements load the items below with.
    loads: LoadTries,
    /// By arrival: tries of this step that counted.
    tries: HashMap<usize, usize>,
    /// Whether tries are far from each other in this search, so that they reach other places than those before.
    is_wide: bool,
}

/// The check of a method that tries placements, in a twin, on the threads of a pool; `None` of one that does not. Where items have
/// limits, loads are held against them by the settings of `loads`.
///
/// # Errors
/// [`PhysicsError::Setting`] where a setting is impossible.
pub fn check(
    settings: TrialSettings,
    loads: &LoadSettings,
    twin: TwinSettings,
    pool: Option<Arc<rayon::ThreadPool>>,
) -> Result<Option<BoxedCheck>, PhysicsError> {
    if !settings.is_on() {
        return Ok(None);
    }
    let check = TrialCheck::new(settings, twin)?.with_loads(loads);
    Ok(Some(Box::new(TrialCheck { pool, ..check })))
}

/// Threads for the tries of a step; none are needed for one at a time.
///
/// # Errors
/// [`PhysicsError::Threads`] where they cannot be had.
pub fn pool(threads: usize) -> Result<Option<Arc<rayon::ThreadPool>>, PhysicsError> {
    if threads < 2 {
        return Ok(None);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| PhysicsError::Threads(error.to_string()))?;
    Ok(Some(Arc::new(pool)))
}

/// An item at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Place {
    arrival: usize,
    shape: ShapeId,
    /// Whether no more is known of the item than the shape that was seen.
    is_seen: bool,
    resting: RestingPlacement,
}

/// A placement that was refused, and why.
#[derive(Debug, Clone, Copy)]
struct Refused {
    place: Place,
    settling: Settling,
    why: &'static str,
}

impl TrialCheck {
    /// A check by these settings, in the twin of a cell.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where a setting is impossible.
    pub fn new(settings: TrialSettings, twin: TwinSettings) -> Result<Self, PhysicsError> {
        settings.validate()?;
        Ok(Self {
            settings,
            twin: Twin::new(twin)?,
            seen: SeenSolids::default(),
            lacks: Vec::new(),
            pool: None,
            known: HashMap::new(),
            refused: Vec::new(),
            loads: LoadTries::new(LoadSettings::default().tried_margin),
            tries: HashMap::new(),
            is_wide: false,
        })
    }

    /// Holds loads against what items may carry by these settings.
    #[must_use]
    pub fn with_loads(self, settings: &LoadSettings) -> Self {
        Self {
            loads: LoadTries::new(settings.tried_margin),
            ..self
        }
    }

    /// How many placements of this step it was asked about that it did not refuse unasked.
    pub fn tries(&self) -> usize {
        self.tries.values().sum()
    }

    /// What was refused close to a placement, of the same item and yaw.
    fn refused_near(&self, input: &StepInput<'_>, place: &Place) -> Option<&Refused> {
        let mut refused = self.refused.iter();
        refused.find(|refused| self.is_near(input, place, &refused.place))
    }

    /// What was refused by its load close to a placement, of the same item and yaw.
    fn overloaded_near(&self, input: &StepInput<'_>, place: &Place) -> Option<&Refusal> {
        self.loads
            .refused(|other| self.is_near(input, place, other))
    }

    /// What was refused last of the same item.
    fn refused_last(&self, place: &Place) -> Option<&Refused> {
        let mut refused = self.refused.iter().rev();
        refused.find(|refused| refused.place.arrival == place.arrival)
    }

    /// What was refused as it rolls, and is within the limits of all.
    fn resorts(&self) -> impl Iterator<Item = &Refused> {
        let limits = &self.settings.limits;
        let refused = self.refused.iter();
        refused.filter(|refused| refused.settling.beyond(limits).is_none())
    }

    /// Refuses a placement as it, or one like it, goes beyond the limits.
    fn refusal(&self, like: Option<&Refused>) -> Refusal {
        let why = like.map(|refused| refused.why);
        let because = |why| Refusal::because(Cause::Unsteady, why);
        why.map_or(Cause::Unsteady.into(), because)
    }

    fn is_near(&self, input: &StepInput<'_>, place: &Place, other: &Place) -> bool {
        let (at, near) = (place.resting.placement, other.resting.placement);
        let is_turned = place.shape != other.shape || at.yaw != near.yaw;
        let near_m = match self.is_wide {
            true => WIDE * self.settings.neighbour_m,
            false => self.settings.neighbour_m,
        };
        let cell_m = input.grid.resolution().cell_m();
        let apart_m = |a: usize, b: usize| a.abs_diff(b) as f64 * cell_m;
        let (x_m, y_m) = (apart_m(at.x, near.x), apart_m(at.y, near.y));
        place.arrival == other.arrival
            && (self.is_wide || !is_turned)
            && x_m.max(y_m) <= near_m + 1e-9
    }

    /// Takes over what lies in the container.
    fn lay_down(&mut self, input: &StepInput<'_>, content: &Content) -> Result<(), PhysicsError> {
        let is_all = self.twin.lay_down(content.solids());
        if content.has_seen() {
            self.lacks.push(SEEN_CONTENT);
        }
        if content.is_partial() || !is_all {
            self.lacks.push(PARTIAL_CONTENT);
            self.twin.fill_up(input.grid, input.scene)?;
        }
        Ok(())
    }

    /// A candidate as it can be tried at a place; `None` where it cannot.
    fn solid_at(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Option<(Solid, Isometry3<f64>)>, PhysicsError> {
        let Some(pose) = candidate.item.container_from_item(input.grid, resting) else {
            return Ok(None);
        };
        match &candidate.model {
            Some(model) => Ok(Some((self.twin.solid(model)?, pose))),
            None => Ok(self.seen_at(input, candidate, pose)),
        }
    }

    /// As [`Self::solid_at`], with what was seen of the candidate.
    fn seen_at(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        pose: Isometry3<f64>,
    ) -> Option<(Solid, Isometry3<f64>)> {
        let model = self.seen.of(&candidate.item, input.grid.resolution())?;
        let solid = self.twin.solid(&model).ok()?;
        self.twin.can_try(&solid, &pose).then_some((solid, pose))
    }

    /// The item below that the placement loads most, where one has a limit: of what was tried and is not refused anyway.
    fn load(
        &self,
        candidate: &Candidate,
        place: &Place,
        settling: &Settling,
    ) -> Result<Option<Load>, PhysicsError> {
        let is_possible = settling.beyond(&self.settings.limits).is_none();
        match self.known.get(place).filter(|_| is_possible) {
            Some(tried) => self.loads.greatest(
                &self.twin,
                &tried.solid,
                candidate.weighs_kg(),
                &tried.container_from_item,
                self.pool.as_deref(),
            ),
            None => Ok(None),
        }
    }

    fn evidence(&self, place: &Place, settling: Settling, load: Option<Load>) -> Evidence {
        let item = place.is_seen.then_some(SEEN_ITEM);
        let degraded = item.iter().chain(&self.lacks);
        // It was tried from its place, so that it falls no farther in the cell than it did here.
        let clearance_m = |tried: &Tried| {
            let pose = &tried.container_from_item;
            self.twin.clearance_m(&tried.solid, pose)
        };
        Evidence {
            settling: Some(settling),
            load,
            degraded: degraded.map(|reason| (*reason).to_owned()).collect(),
            lowered_m: self.known.get(place).map_or(0.0, clearance_m),
            ..Evidence::default()
        }
    }

    /// Forgets the tries that may go otherwise now, as something is not as it was, and those of items that are gone.
    fn forget(&mut self, input: &StepInput<'_>, changed: &[Bounds]) {
        let twin = &self.twin;
        let waits = |place: &Place| {
            let mut candidates = input.candidates.iter();
            candidates.any(|held| (held.arrival, held.item.shape()) == (place.arrival, place.shape))
        };
        self.known.retain(|place, tried| {
            waits(place) && twin.is_beyond_reach(&tried.solid, &tried.container_from_item, changed)
        });
        if self.known.len() > TRIES_KEPT {
            self.known.clear();
        }
    }

    /// Tries a candidate at a place, where that is not known yet; `None` where it cannot be tried.
    fn settling(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        place: &Place,
    ) -> Result<Option<Settling>, PhysicsError> {
        if let Some(tried) = self.known.get(place) {
            return Ok(Some(tried.settling));
        }
        let Some((solid, pose)) = self.solid_at(input, candidate, &place.resting)? else {
            return Ok(None);
        };
        let tried = Tried::now(&self.twin, solid, pose, &self.settings.limits)?;
        let settling = tried.settling;
        self.known.insert(*place, tried);
        Ok(Some(settling))
    }

    /// As [`ValidityCheck::judge`].
    fn judge_by_tries(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, PhysicsError> {
        if input.scene.content().is_none() {
            return Ok(untried(input, candidate, resting, Vec::new()));
        }
        let place = Place::of(candidate, resting);
        let Some(settling) = self.settling(input, candidate, &place)? else {
            let degraded = vec![UNTRIED_ITEM.to_owned()];
            return Ok(untried(input, candidate, resting, degraded));
        };
        *self.tries.entry(place.arrival).or_default() += 1;
        let load = self.load(candidate, &place, &settling)?;
        if let Some(refusal) = load
            .as_ref()
            .and_then(|load| self.loads.refuse(place, load))
        {
            return Ok(Verdict::Refused(refusal));
        }
        let tried = self.known.get(&place);
        if let Some(why) = tried.and_then(|tried| tried.beyond(&self.settings.limits)) {
            let refused = Refused {
                place,
                settling,
                why,
            };
            self.refused.push(refused);
            return Ok(Verdict::Refused(self.refusal(Some(&refused))));
        }
        Ok(Verdict::Accepted(self.evidence(&place, settling, load)))
    }
}

/// Of a placement that cannot be tried: it is made as planned if that is not above the rim.
fn untried(
    input: &StepInput<'_>,
    candidate: &Candidate,
    resting: &RestingPlacement,
    degraded: Vec<String>,
) -> Verdict {
    let view = candidate.item.views().get(resting.placement.yaw);
    if !view.is_some_and(|view| view.fits_at(input.grid, resting.resting_height)) {
        return Verdict::Refused(Cause::AboveRim.into());
    }
    Verdict::Accepted(Evidence {
        degraded,
        ..Evidence::default()
    })
}

/// What became of a solid at a place.
struct Tried {
    solid: Solid,
    container_from_item: Isometry3<f64>,
    settling: Settling,
}

impl Tried {
    fn now(
        twin: &Twin,
        solid: Solid,
        container_from_item: Isometry3<f64>,
        limits: &TrialLimits,
    ) -> Result<Self, PhysicsError> {
        let settling = twin.try_placement(&solid, &container_from_item, limits)?;
        Ok(Self {
            solid,
            container_from_item,
            settling,
        })
    }

    /// What keeps it from being accepted as long as another placement is valid.
    fn beyond(&self, limits: &TrialLimits) -> Option<&'static str> {
        if self.solid.can_roll() {
            self.settling.beyond(&limits.of_rolling())
        } else {
            self.settling.beyond(limits)
        }
    }
}

impl Place {
    fn of(candidate: &Candidate, resting: &RestingPlacement) -> Self {
        Self {
            arrival: candidate.arrival,
            shape: candidate.item.shape(),
            is_seen: candidate.model.is_none(),
            resting: *resting,
        }
    }
}

impl ValidityCheck for TrialCheck {
    fn cost(&self) -> Cost {
        Cost::Simulation
    }

    fn begin(&mut self, input: &StepInput<'_>) -> StageResult {
        self.refused.clear();
        self.loads.begin();
        self.tries.clear();
        self.is_wide = false;
        self.lacks.clear();
        self.twin.end_by(input.deadline);
        let Some(content) = input.scene.content() else {
            self.known.clear();
            return Ok(());
        };
        let before = self.twin.laid().clone();
        self.lay_down(input, content)?;
        let changed = before.difference(self.twin.laid());
        self.forget(input, &changed);
        Ok(())
    }

    fn refuses_unseen(
        &self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Option<Refusal> {
        let place = Place::of(candidate, resting);
        if let Some(near) = self.refused_near(input, &place) {
            return Some(self.refusal(Some(near)));
        }
        if let Some(refusal) = self.overloaded_near(input, &place) {
            return Some(refusal.clone());
        }
        if let Some(refusal) = self.loads.done_with(candidate.arrival) {
            return Some(refusal.clone());
        }
        let is_done = self.is_done_with(candidate);
        is_done.then(|| self.refusal(self.refused_last(&place)))
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        match self.judge_by_tries(input, candidate, resting) {
            // The search is cut then, and does not count it.
            Err(PhysicsError::Late) => Ok(Verdict::Refused(Cause::Unsteady.into())),
            verdict => Ok(verdict?),
        }
    }

    fn foresight(&self) -> usize {
        let threads = self.pool.as_ref().map(|pool| pool.current_num_threads());
        threads.unwrap_or(1)
    }

    fn is_known(&self, candidate: &Candidate, resting: &RestingPlacement) -> bool {
        let place = Place::of(candidate, resting);
        self.known.contains_key(&place) && !LoadTries::are_tried(&self.twin, candidate.weighs_kg())
    }

    fn foresee(
        &mut self,
        input: &StepInput<'_>,
        next: &[(&Candidate, RestingPlacement)],
    ) -> StageResult {
        let (Some(pool), Some(_)) = (self.pool.clone(), input.scene.content()) else {
            return Ok(());
        };
        let mut tries: Vec<(Place, Solid, Isometry3<f64>)> = Vec::new();
        for (candidate, resting) in next {
            let place = Place::of(candidate, resting);
            let mut others = tries.iter();
            let is_covered = self.is_done_with(candidate)
                || self.refused_near(input, &place).is_some()
                || self.overloaded_near(input, &place).is_some()
                || others.any(|(other, ..)| self.is_near(input, &place, other));
            if is_covered || self.known.contains_key(&place) {
                continue;
            }
            // What cannot be tried is said where it is asked about.
            if let Ok(Some((solid, pose))) = self.solid_at(input, candidate, resting) {
                tries.push((place, solid, pose));
            }
        }
        let (twin, limits) = (&self.twin, self.settings.limits);
        let tried = |(place, solid, pose): (Place, Solid, Isometry3<f64>)| {
            let tried = Tried::now(twin, solid, pose, &limits);
            tried.ok().map(|tried| (place, tried))
        };
        let tried: Vec<_> = pool.install(|| tries.into_par_iter().filter_map(tried).collect());
        self.known.extend(tried);
        Ok(())
    }

    fn widen(&mut self) -> bool {
        let most = self.settings.tries_per_item;
        self.is_wide = self.tries.values().any(|tries| *tries >= most);
        self.tries.clear();
        self.is_wide && self.resorts().next().is_none()
    }

    fn is_done_with(&self, candidate: &Candidate) -> bool {
        let tries = self.tries.get(&candidate.arrival).copied().unwrap_or(0);
        let most = match self
            .resorts()
            .any(|resort| resort.place.arrival == candidate.arrival)
        {
            true => self.settings.tries_per_item.div_ceil(TRIES_WITH_RESORT),
            false => self.settings.tries_per_item,
        };
        tries >= most || self.loads.done_with(candidate.arrival).is_some()
    }

    fn last_resort(&self) -> Option<LastResort> {
        let rolling = self.settings.limits.of_rolling();
        let severity = |refused: &Refused| refused.settling.severity(&rolling);
        let least = self
            .resorts()
            .min_by(|a, b| severity(a).total_cmp(&severity(b)));
        least.map(|refused| LastResort {
            arrival: refused.place.arrival,
            shape: refused.place.shape,
            resting: refused.place.resting,
            evidence: self.evidence(&refused.place, refused.settling, None),
        })
    }
}
