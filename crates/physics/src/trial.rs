//! The simulated check: a placement is tried in the twin of the cell before it is made.

mod loads;
mod tried;

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_catalogue::mesh::Bounds;
use ppnpack_catalogue::seen::SeenSolids;
use ppnpack_packing::checks::check::{
    BoxedCheck, Cost, Evidence, LastResort, ValidityCheck, Verdict,
};
use ppnpack_packing::checks::loads::{Load, LoadSettings};
use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::kernel::placement::RestingPlacement;
use ppnpack_packing::ranking::refusal::{Cause, Refusal};
use ppnpack_packing::ranking::step::{Candidate, StageResult, StepInput};
use ppnpack_packing::scene::content::Content;

use loads::LoadTries;
use tried::{Place, Refused, Tried};

use crate::error::PhysicsError;
use crate::twin::{Placed, Twin, TwinSettings};

/// Divisor of the tries of an item that has a last resort: what rolls seldom stays at the next
/// places, either, and all of them are tried again and again as it is left for later steps.
const TRIES_WITH_RESORT: usize = 4;

/// Why an item was not tried, or not as often as others.
const NO_TRIES_LEFT: &str = "other items took the tries of this step";

/// Maximum number of times that the placements looked into together are doubled.
const MOST_DOUBLED: u32 = 2;

/// Maximum of tries that are kept from one step to the next.
const TRIES_KEPT: usize = 10_000;

/// Degradation of a try with what was seen of the item.
const SEEN_ITEM: &str =
    "the item was tried with the shape that was seen of it, as its solid is not known";

/// Degradation of an item that was not tried.
const UNTRIED_ITEM: &str = "the item was not tried, as what was seen of it makes no solid";

/// Degradation of a try among items of which no more is known than what was seen.
const SEEN_CONTENT: &str =
    "items in the container took part with the shapes that were seen of them";

/// Degradation of a try where not all that lies in the container is known.
const PARTIAL_CONTENT: &str =
    "the item was tried among the known ones in the container, and on the heightmap of the others";

/// Accepts placements whose item stays where it is placed, as the twin of the cell tells.
///
/// An item whose solid is not known takes part with the shape that was seen; what lies in the
/// container and has no known shape is as high as the heightmap shows it. The evidence says so.
/// Where nothing is known of the content, placements are accepted without evidence.
///
/// Its answers are the same with any number of threads, and whatever was tried in earlier steps.
pub struct TrialCheck {
    settings: TrialSettings,
    twin: Twin,
    /// Solids of items whose own are not known.
    seen: SeenSolids,
    /// Degradations of this step, by what is not known of the container's content.
    lacks: Vec<&'static str>,
    /// Threads that share the tries of a step; without them they are made one after another.
    pool: Option<Arc<rayon::ThreadPool>>,
    /// Tries of this step, and those of earlier steps that would not go otherwise now.
    known: HashMap<Place, Tried>,
    /// Refusals of this step.
    refused: Vec<Refused>,
    /// Loads of tried placements on the items below.
    loads: LoadTries,
    /// Tries of this step that counted, by arrival.
    tries: HashMap<usize, usize>,
    /// How often it was told of placements in this step.
    batches: u32,
}

/// Makes the check of a method that tries placements, in a twin, on the threads of a pool; `None`
/// of one that does not. Where items have limits, loads are held against them by the settings of
/// `loads`.
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

/// Starts threads for the tries of a step; none are needed for one at a time.
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

impl TrialCheck {
    /// Makes a check by these settings, in the twin of a cell.
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
            batches: 0,
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

    /// Counts the placements of this step that it was asked about and did not refuse unasked.
    pub fn tries(&self) -> usize {
        self.tries.values().sum()
    }

    /// Gives the maximum number of tries of all items in a step, half as many again as of one. The
    /// best placements of all come first, and more have filled no container better
    /// (`docs/results/filling.md`).
    fn tries_per_step(&self) -> usize {
        (3 * self.settings.tries_per_item).div_ceil(2)
    }

    /// Gives the refusal of a placement close to this one, of the same item and yaw.
    fn refused_near(&self, input: &StepInput<'_>, place: &Place) -> Option<Refusal> {
        let mut refused = self.refused.iter();
        let near = refused.find(|refused| self.is_near(input, place, &refused.place));
        let overloaded = || {
            self.loads
                .refused(|other| self.is_near(input, place, other))
        };
        near.map(Refused::refusal).or_else(|| overloaded().cloned())
    }

    /// Gives the placements that were refused as the item rolls, and are within the limits of all.
    fn resorts(&self) -> impl Iterator<Item = &Refused> {
        let limits = &self.settings.limits;
        let refused = self.refused.iter();
        refused.filter(|refused| refused.tried.settling.beyond(limits).is_none())
    }

    fn is_near(&self, input: &StepInput<'_>, place: &Place, other: &Place) -> bool {
        let (at, near) = (place.resting.placement, other.resting.placement);
        let is_turned = place.shape != other.shape || at.yaw != near.yaw;
        let cell_m = input.grid.resolution().cell_m();
        let apart_m = |a: usize, b: usize| a.abs_diff(b) as f64 * cell_m;
        let (x_m, y_m) = (apart_m(at.x, near.x), apart_m(at.y, near.y));
        place.arrival == other.arrival
            && !is_turned
            && x_m.max(y_m) <= self.settings.neighbour_m + 1e-9
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

    /// Gives a candidate as it can be tried at a place, with what was seen of it where its solid is
    /// not known; `None` where it cannot.
    fn solid_at(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Option<Placed>, PhysicsError> {
        let Some(pose) = candidate.item.container_from_item(input.grid, resting) else {
            return Ok(None);
        };
        if let Some(model) = &candidate.model {
            return Ok(Some((self.twin.solid(model)?, pose)));
        }
        let seen = self.seen.of(&candidate.item, input.grid.resolution());
        let solid = seen.and_then(|model| self.twin.solid(&model).ok());
        let solid = solid.filter(|solid| self.twin.can_try(solid, &pose));
        Ok(solid.map(|solid| (solid, pose)))
    }

    /// Gives the item below that a placement loads most, where one has a limit and the placement is
    /// not refused anyway.
    fn load(&self, candidate: &Candidate, tried: &Tried) -> Result<Option<Load>, PhysicsError> {
        if tried.settling.beyond(&self.settings.limits).is_some() {
            return Ok(None);
        }
        let (mass_kg, pose) = (candidate.weighs_kg(), &tried.container_from_item);
        let pool = self.pool.as_deref();
        self.loads
            .greatest(&self.twin, &tried.solid, mass_kg, pose, pool)
    }

    fn evidence(&self, place: &Place, tried: &Tried, load: Option<Load>) -> Evidence {
        let item = place.is_seen.then_some(SEEN_ITEM);
        let degraded = item.iter().chain(&self.lacks);
        Evidence {
            settling: Some(tried.settling),
            load,
            degraded: degraded.map(|reason| (*reason).to_owned()).collect(),
            // It was tried from its place, so that it falls no farther in the cell than here.
            lowered_m: self
                .twin
                .clearance_m(&tried.solid, &tried.container_from_item),
            ..Evidence::default()
        }
    }

    /// Forgets the tries that may go otherwise now, as something is not as it was, and those of
    /// items that are gone.
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
    fn tried(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        place: &Place,
    ) -> Result<Option<Tried>, PhysicsError> {
        if let Some(tried) = self.known.get(place) {
            return Ok(Some(tried.clone()));
        }
        let Some((solid, pose)) = self.solid_at(input, candidate, &place.resting)? else {
            return Ok(None);
        };
        let tried = Tried::now(&self.twin, solid, pose, &self.settings.limits)?;
        self.known.insert(*place, tried.clone());
        Ok(Some(tried))
    }

    /// Judges as [`ValidityCheck::judge`], but for time.
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
        let Some(tried) = self.tried(input, candidate, &place)? else {
            let degraded = vec![UNTRIED_ITEM.to_owned()];
            return Ok(untried(input, candidate, resting, degraded));
        };
        *self.tries.entry(place.arrival).or_default() += 1;
        let load = self.load(candidate, &tried)?;
        let overload = load
            .as_ref()
            .and_then(|load| self.loads.refuse(place, load));
        if let Some(refusal) = overload {
            return Ok(Verdict::Refused(refusal));
        }
        let Some(why) = tried.beyond(&self.settings.limits) else {
            return Ok(Verdict::Accepted(self.evidence(&place, &tried, load)));
        };
        let refused = Refused { place, tried, why };
        let refusal = refused.refusal();
        self.refused.push(refused);
        Ok(Verdict::Refused(refusal))
    }
}

/// Judges a placement that cannot be tried: it is made as planned if that is not above the rim.
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

impl ValidityCheck for TrialCheck {
    fn cost(&self) -> Cost {
        Cost::Simulation
    }

    fn begin(&mut self, input: &StepInput<'_>) -> StageResult {
        self.refused.clear();
        self.loads.begin();
        self.tries.clear();
        self.batches = 0;
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
        let near = self.refused_near(input, &Place::of(candidate, resting));
        let overload = || self.loads.done_with(candidate.arrival).cloned();
        if let Some(refusal) = near.or_else(overload) {
            return Some(refusal);
        }
        let last = || {
            let mut refused = self.refused.iter().rev();
            let last = refused.find(|refused| refused.place.arrival == candidate.arrival);
            let untried = || Refusal::because(Cause::Unsteady, NO_TRIES_LEFT);
            last.map_or_else(untried, Refused::refusal)
        };
        self.is_done_with(candidate).then(last)
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
        let Some(pool) = &self.pool else {
            return 1;
        };
        // Half of the steps end with one of the first few; longer ones keep all threads busy.
        pool.current_num_threads() << self.batches.min(MOST_DOUBLED)
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
        self.batches += 1;
        let mut tries: Vec<(Place, Placed)> = Vec::new();
        for (candidate, resting) in next {
            let place = Place::of(candidate, resting);
            let mut others = tries.iter();
            let is_covered = self.is_done_with(candidate)
                || self.refused_near(input, &place).is_some()
                || others.any(|(other, _)| self.is_near(input, &place, other));
            if is_covered || self.known.contains_key(&place) {
                continue;
            }
            // What cannot be tried is said where it is asked about.
            if let Ok(Some(placed)) = self.solid_at(input, candidate, resting) {
                tries.push((place, placed));
            }
        }
        let (places, placed): (Vec<Place>, Vec<Placed>) = tries.into_iter().unzip();
        let outcomes = self
            .twin
            .try_together(&placed, &self.settings.limits, &pool);
        let outcomes = places.into_iter().zip(placed).zip(outcomes);
        let tried = outcomes.filter_map(|((place, (solid, container_from_item)), settling)| {
            let tried = Tried {
                solid,
                container_from_item,
                settling: settling?,
            };
            Some((place, tried))
        });
        self.known.extend(tried);
        Ok(())
    }

    fn widen(&mut self) {
        self.tries.clear();
    }

    fn is_done_with(&self, candidate: &Candidate) -> bool {
        let tries = self.tries.get(&candidate.arrival).copied().unwrap_or(0);
        let mut resorts = self.resorts();
        let has_resort = resorts.any(|resort| resort.place.arrival == candidate.arrival);
        let divisor = if has_resort { TRIES_WITH_RESORT } else { 1 };
        tries >= self.settings.tries_per_item.div_ceil(divisor)
            || self.tries() >= self.tries_per_step()
            || self.loads.done_with(candidate.arrival).is_some()
    }

    fn last_resort(&self) -> Option<LastResort> {
        let rolling = self.settings.limits.of_rolling();
        let severity = |refused: &Refused| refused.tried.settling.severity(&rolling);
        let resorts = self.resorts();
        let least = resorts.min_by(|a, b| severity(a).total_cmp(&severity(b)));
        least.map(|refused| LastResort {
            arrival: refused.place.arrival,
            shape: refused.place.shape,
            resting: refused.place.resting,
            evidence: self.evidence(&refused.place, &refused.tried, None),
        })
    }
}
