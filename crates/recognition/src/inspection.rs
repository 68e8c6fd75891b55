//! Inspection of placed items: whether each lies where it was planned.
//!
//! After an item was placed, the container is seen again from above. What is new against the
//! surface before is the item, if it fits: first near the planned pose, then in any orientation.
//! What is said is what is seen; where that is not enough, it is [`Inspection::Unclear`].

mod changes;
mod judge;
mod lying;
mod outcome;
mod search;
mod settings;
mod squares;
mod stances;

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::kernel::heightmap::Surface;

use crate::expected::expected_loss;
use crate::groups::joined;
use crate::object::LibraryObject;
use crate::refinement::Fit;

use changes::Changes;
use lying::Kind;
use search::Search;
use stances::stances;

pub use lying::Lying;
pub use outcome::{Absence, ContainerCloud, Inspection, Unclear, UnclearReason};
pub use settings::InspectionSettings;

/// Minimum share of the least area that is new by which the item may be what is new.
const MISSING_SHARE: f64 = 0.25;

/// Minimum share of the planned view that must be new for the item's absence to be noticed.
const NOTICED_SHARE: f64 = 0.4;

/// Maximum gap, seen from above, between new points that belong together, in metres.
const JOIN_M: f64 = 0.008;
/// Minimum share of all new points of a group; smaller ones are taken for what shifted, or for
/// specks.
const LEAST_GROUP_SHARE: f64 = 0.05;
/// Maximum number of groups that are looked at each by itself.
const ALONE: usize = 3;

/// Maximum share of the limits that a fit near the planned pose may lose and need no search: as
/// planned, and moved.
const GOOD_ENOUGH: f64 = 0.3;
const EXCELLENT: f64 = 0.2;

/// Maximum distance of fits that say the same, in metres.
const SAME_PLACE_M: f64 = 0.015;

/// Says what became of an item that was placed at `planned` (`container_from_item`).
///
/// `before` is the surface of the container's content before, `after` what is seen now. Points that
/// rise above the surface around them are new. Where there are hardly any, the item is missing,
/// unless it could lie hidden. Else the object is aligned with them from the planned pose, and
/// where it does not agree well then, from orientations all over; a pose counts if the camera
/// should see what it sees, and if it is possible among what was there before.
pub fn inspect(
    object: &LibraryObject,
    planned: &Isometry3<f64>,
    before: &Surface,
    after: &ContainerCloud<'_>,
    container: ContainerSize,
    settings: &InspectionSettings,
) -> Inspection {
    let bounds = object.model.mesh.bounds();
    let inspector = Inspector {
        object,
        planned,
        container,
        eye_m: after.eye_m,
        diameter_m: bounds.map_or(0.0, |bounds| bounds.extents_m().norm()),
        settings,
    };
    if !inspector.is_usable() {
        return unclear(UnclearReason::Unusable, None);
    }
    let highest_m = container.z_m + inspector.diameter_m;
    match Changes::new(before, after, container, highest_m, settings) {
        Some(changes) => inspector.judged(&changes),
        None => unclear(UnclearReason::Unusable, None),
    }
}

fn unclear(reason: UnclearReason, best: Option<Lying>) -> Inspection {
    Inspection::Unclear(Unclear { reason, best })
}

/// An inspection under way.
struct Inspector<'item> {
    object: &'item LibraryObject,
    planned: &'item Isometry3<f64>,
    container: ContainerSize,
    eye_m: Point3<f64>,
    /// Diagonal of the object's box.
    diameter_m: f64,
    settings: &'item InspectionSettings,
}

impl Inspector<'_> {
    fn is_usable(&self) -> bool {
        let size = [self.container.x_m, self.container.y_m, self.container.z_m];
        let pose = self.planned.to_homogeneous();
        let mut numbers = pose.iter().chain(self.eye_m.iter());
        let is_finite = numbers.all(|value| value.abs() < 1e3)
            && size.iter().all(|side| (1e-3..1e3).contains(side));
        is_finite && self.eye_m.z > self.container.z_m
    }

    fn judged(&self, changes: &Changes<'_>) -> Inspection {
        let seen_share = changes.seen_share;
        if seen_share < self.settings.least_container_seen {
            return unclear(UnclearReason::LittleSeen(seen_share), None);
        }
        let stances = stances(self.object);
        let areas_m2 = stances.iter().map(|stance| stance.area_m2);
        let absence = Absence {
            new_m2: changes.new_area_m2(),
            least_m2: areas_m2.fold(f64::INFINITY, f64::min),
            seen_share,
        };
        let points = changes.new_m.len();
        if absence.new_m2 < MISSING_SHARE * absence.least_m2 {
            let could_hide =
                self.noticed_share(changes) < NOTICED_SHARE || changes.could_hide(&stances);
            match could_hide {
                true => unclear(UnclearReason::CouldHide, None),
                false => Inspection::Missing(absence),
            }
        } else if points < self.settings.least_points {
            unclear(UnclearReason::FewPoints(points), None)
        } else {
            self.found(changes)
        }
    }

    /// Gives the share of the item's upper side in the planned pose that would be new.
    fn noticed_share(&self, changes: &Changes<'_>) -> f64 {
        let (mut upper, mut noticed) = (0_u32, 0_u32);
        let points = self.object.points.iter();
        for point in points.filter(|point| (self.planned.rotation * point.normal).z >= 0.3) {
            let place = self.planned * point.point;
            let below_m = changes.blurred_at(place.x, place.y);
            let least_m = self.settings.least_rise_m;
            upper += 1;
            noticed += u32::from(below_m.is_some_and(|below_m| place.z > below_m + least_m));
        }
        f64::from(noticed) / f64::from(upper.max(1))
    }

    fn found(&self, changes: &Changes<'_>) -> Inspection {
        let (all, groups) = grouped(&changes.new_m);
        let together = all.len();
        let mut sets = vec![all];
        if groups.len() > 1 {
            sets.extend(groups.into_iter().take(ALONE));
        }
        let searches = sets.iter().filter_map(|own_m| self.search(own_m, changes));
        let mut searches: Vec<Search<'_>> = searches.collect();
        let mut starts = Vec::new();
        for search in &mut searches {
            let fit = search.near_planned(self.planned, self.settings.least_margin);
            let share = match self.lying(&fit).kind(self.settings) {
                Kind::AsPlanned => GOOD_ENOUGH,
                Kind::Moved | Kind::Toppled => EXCELLENT,
            };
            let is_good = self.agrees(&fit, share) && changes.admit(self.object, &fit.pose);
            if is_good && search.seen_share(&fit.pose) >= self.settings.least_seen {
                return self.told(&self.lying(&fit));
            }
            starts.push(fit);
        }
        let mut refused = None;
        for (search, start) in searches.iter_mut().zip(starts) {
            match self.searched(search, start, changes) {
                unclear @ Inspection::Unclear(_) => refused = refused.or(Some(unclear)),
                told => return told,
            }
        }
        refused.unwrap_or_else(|| unclear(UnclearReason::FewPoints(together), None))
    }

    /// Makes a search at some of the new points; all others are its surroundings.
    fn search<'scene>(
        &'scene self,
        own_m: &'scene [Point3<f64>],
        changes: &Changes<'_>,
    ) -> Option<Search<'scene>> {
        if own_m.len() < self.settings.least_points {
            return None;
        }
        let mut others_m = changes.others_m.clone();
        if own_m.len() < changes.new_m.len() {
            let key = |point: &Point3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
            let own: std::collections::HashSet<_> = own_m.iter().map(key).collect();
            let all = changes.new_m.iter().copied();
            others_m.extend(all.filter(|point| !own.contains(&key(point))));
        }
        Search::new(self.object, own_m, &others_m, self.eye_m, self.diameter_m)
    }

    /// Chooses the best fit from anywhere, with the one from the planned pose.
    fn searched<'object>(
        &self,
        search: &mut Search<'object>,
        start: Fit<'object>,
        changes: &Changes<'_>,
    ) -> Inspection {
        let mut fits = search.anywhere(self.planned, changes);
        // The first of equals is the one nearest to the plan.
        if changes.admit(self.object, &start.pose) {
            fits.insert(0, start);
        }
        let fitness = |fit: &Fit<'_>| fit.agreement.fitness;
        let by_fitness = |a: &&Fit<'_>, b: &&Fit<'_>| fitness(a).total_cmp(&fitness(b));
        let best = fits.iter().max_by(by_fitness).map(|fit| self.lying(fit));
        fits.retain(|fit| self.agrees(fit, 1.0));
        let greatest = fits.iter().map(fitness).fold(0.0, f64::max);
        fits.retain(|fit| fitness(fit) >= greatest - self.settings.least_margin);
        let is_near = fits.first().is_some_and(|fit| fit.pose == start.pose);
        let ways: Vec<Lying> = fits.iter().map(|fit| self.lying(fit)).collect();
        self.chosen(search, &ways, is_near)
            .unwrap_or_else(|| unclear(UnclearReason::DoesNotFit, best))
    }

    /// Chooses the fit that is told, of some that agree about equally well; the first may be the
    /// one that lies near the plan. To lie as planned, or to have slid there, is more likely than
    /// to have come to lie otherwise and look the same.
    fn chosen(&self, search: &mut Search<'_>, ways: &[Lying], is_near: bool) -> Option<Inspection> {
        let is_planned = |lying: &&Lying| lying.kind(self.settings) == Kind::AsPlanned;
        let best = ways.iter().find(is_planned).or(ways.first())?;
        let seen_share = search.seen_share(&best.container_from_item);
        if seen_share < self.settings.least_seen {
            return Some(unclear(UnclearReason::ItemHidden(seen_share), Some(*best)));
        }
        let says_the_same = |other: &Lying| {
            let centre = |lying: &Lying| lying.container_from_item * self.object.centre_m;
            other.kind(self.settings) == best.kind(self.settings)
                && nalgebra::distance(&centre(other), &centre(best)) < SAME_PLACE_M
        };
        let is_likely = is_near || best.kind(self.settings) == Kind::AsPlanned;
        if !is_likely && !ways.iter().all(says_the_same) {
            return Some(unclear(UnclearReason::Ambiguous, Some(*best)));
        }
        Some(self.told(best))
    }

    fn told(&self, lying: &Lying) -> Inspection {
        match lying.kind(self.settings) {
            Kind::AsPlanned => Inspection::AsPlanned(*lying),
            Kind::Moved => Inspection::Moved(*lying),
            Kind::Toppled => Inspection::Toppled(*lying),
        }
    }

    fn lying(&self, fit: &Fit<'_>) -> Lying {
        let poses = [self.planned, &fit.pose];
        Lying::new(self.object, poses, self.container, fit.agreement)
    }

    /// Says whether a fit agrees within a share of what the settings allow it to lose.
    fn agrees(&self, fit: &Fit<'_>, share: f64) -> bool {
        let settings = self.settings;
        let loss =
            share * (1.0 - settings.least_fitness) + expected_loss(settings.sensor_deviation_m);
        let agreement = fit.agreement;
        agreement.fitness >= 1.0 - loss
            && agreement.unexplained <= share * settings.most_unexplained
            && agreement.contradicted <= share * settings.most_contradicted
    }
}

/// Gives the new points that hang together in groups worth a look: all of them, and by group, the
/// largest first.
fn grouped(new_m: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<Vec<Point3<f64>>>) {
    let mut groups = joined(new_m.to_vec(), JOIN_M);
    let least = LEAST_GROUP_SHARE * new_m.len() as f64;
    groups.retain(|group| group.len() as f64 >= least);
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    (groups.concat(), groups)
}
