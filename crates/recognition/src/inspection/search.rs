//! Poses of one object at new points.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_catalogue::mesh::Bounds;

use crate::align::{AlignSettings, Hold};
use crate::inspection::changes::Changes;
use crate::inspection::judge::Judge;
use crate::object::LibraryObject;
use crate::pattern::{Move, Pattern};
use crate::refinement::{
    Fit, PassSettings, PolishSettings, Refinement, RefinementSettings, SamePose, distinct, sort,
};
use crate::samples::{direction, yaws_rad};
use crate::segmentation::Cluster;
use crate::symmetry::Symmetry;

/// Number of directions of the sphere that are tried to be down, besides those in which the object
/// rests.
const DIRECTIONS: usize = 32;
/// Maximum number of resting poses that are tried.
const RESTING: usize = 24;
/// Number of yaws that each direction is tried at.
const YAWS: usize = 20;
/// Number of hypotheses that are shifted.
const SHIFTED: usize = 60;
/// Number of hypotheses that are aligned quickly, and thoroughly.
const QUICK: usize = 24;
const THOROUGH: usize = 5;

/// Settings by which hypotheses are refined. An item may lie anyhow.
const REFINEMENT: RefinementSettings = RefinementSettings {
    quick: PassSettings {
        pixel_spacings: 2.0,
        compared: 300,
        aligned: 100,
        align: AlignSettings::new(10, (0.015, 0.004), None),
    },
    thorough: PassSettings {
        pixel_spacings: 1.0,
        compared: 2500,
        aligned: 400,
        align: AlignSettings::new(14, (0.006, 0.0015), None),
    },
    same: SamePose {
        angle_rad: 0.3,
        distance_m: 0.01,
    },
    polish: PolishSettings {
        pixel_spacings: 1.0,
        compared: 600,
        most_points: usize::MAX,
        pattern: Pattern {
            first_step_m: 0.004,
            moves: [Move::X, Move::Y, Move::Turn],
            sweeps: 1,
        },
    },
};

/// Number of the best fits that are laid where the outline fits, and settings by which they are
/// aligned then.
const POLISHED_FITS: usize = 2;
const POLISHED: AlignSettings = AlignSettings::new(6, (0.003, 0.0015), None);

/// Settings by which the planned pose is aligned.
const NEAR_PLAN: AlignSettings = AlignSettings::new(16, (0.012, 0.0015), None);
/// Minimum turn from the planned pose of a fit that is compared with an upright one, in radians.
const UPRIGHT_FROM_RAD: f64 = 0.1;
/// Settings by which an upright one is aligned.
const HELD_UPRIGHT: Hold = Hold {
    tilt_rad: 0.01,
    height_m: 0.1,
};
const UPRIGHT: AlignSettings = AlignSettings::new(10, (0.006, 0.0015), Some(HELD_UPRIGHT));
/// Minimum deviation of the outline near the planned pose, as shares of points, for which it is
/// fitted.
const POLISH_FROM: f64 = 0.008;

/// Looks for poses of an object that agree with new points.
pub(crate) struct Search<'scene> {
    object: &'scene LibraryObject,
    own_m: &'scene [Point3<f64>],
    refinement: Refinement,
}

impl<'scene> Search<'scene> {
    /// Makes a search at `own_m`, new points; `others_m` is all that is seen besides. `None` where
    /// nothing can be compared.
    pub(crate) fn new(
        object: &'scene LibraryObject,
        own_m: &'scene [Point3<f64>],
        others_m: &[Point3<f64>],
        eye_m: Point3<f64>,
        diameter_m: f64,
    ) -> Option<Self> {
        let Bounds { lowest, highest } = Bounds::of(own_m)?;
        // Wherever the object has some of the new points, all of it is within its diameter of them.
        let reach = Vector2::repeat(diameter_m);
        let (low, high) = (lowest.xy() - reach, highest.xy() + reach);
        let is_near = |point: &&Point3<f64>| point.xy() > low && point.xy() < high;
        let cluster = Cluster {
            points_m: own_m.to_vec(),
            surroundings_m: others_m.iter().filter(is_near).copied().collect(),
            eye_m,
            world_from_support: Isometry3::identity(),
        };
        Some(Self {
            object,
            own_m,
            refinement: Refinement::new(&cluster, &REFINEMENT)?,
        })
    }

    /// Aligns the planned pose; gives a fit that is as upright as planned where it agrees about as
    /// well, by `margin`. What is nearly round turns freely under alignment.
    pub(crate) fn near_planned(&mut self, planned: &Isometry3<f64>, margin: f64) -> Fit<'scene> {
        let (object, thorough) = (self.object, &mut self.refinement.thorough);
        let mut fit = thorough.aligned(object, planned, &NEAR_PLAN);
        if fit.pose.rotation.angle_to(&planned.rotation) > UPRIGHT_FROM_RAD {
            let shift = fit.pose * object.centre_m - planned * object.centre_m;
            let start = Translation3::from(shift) * planned;
            let upright = thorough.aligned(object, &start, &UPRIGHT);
            if upright.agreement.fitness >= fit.agreement.fitness - margin {
                fit = upright;
            }
        }
        let agreement = fit.agreement;
        if agreement.unexplained + agreement.contradicted > POLISH_FROM {
            self.polish(std::slice::from_mut(&mut fit));
        }
        fit
    }

    /// Gives the share of what should be seen of a pose that is seen, about.
    pub(crate) fn seen_share(&mut self, container_from_item: &Isometry3<f64>) -> f64 {
        let thorough = &mut self.refinement.thorough;
        thorough.seen_share(self.object, container_from_item)
    }

    /// Finds fits from all orientations, best first.
    pub(crate) fn anywhere(
        &mut self,
        planned: &Isometry3<f64>,
        changes: &Changes<'_>,
    ) -> Vec<Fit<'scene>> {
        let object = self.object;
        let starts = self.hypotheses(planned, changes).into_iter();
        let starts = starts.map(|start| (object, start));
        let mut fits = self.refinement.refined(starts, THOROUGH);
        fits.retain(|fit| changes.admit(object, &fit.pose));
        self.polish(&mut fits);
        fits.retain(|fit| changes.admit(object, &fit.pose));
        sort(&mut fits);
        fits
    }

    /// Lays the best fits where the outline fits.
    fn polish(&mut self, fits: &mut [Fit<'scene>]) {
        for fit in fits.iter_mut().take(POLISHED_FITS) {
            let Some(pose) = self.refinement.polished(self.object, &fit.pose) else {
                return;
            };
            let thorough = &mut self.refinement.thorough;
            let polished = thorough.aligned(self.object, &pose, &POLISHED);
            if polished.agreement.fitness > fit.agreement.fitness {
                *fit = polished;
            }
        }
    }

    /// Gives poses in all orientations whose outline is where the new points are, the most alike
    /// first.
    fn hypotheses(&self, planned: &Isometry3<f64>, changes: &Changes<'_>) -> Vec<Isometry3<f64>> {
        let judge = Judge::new(self.object, self.own_m, changes);
        let mut judged: Vec<(f64, Isometry3<f64>)> = Vec::new();
        let is_ball = matches!(self.object.near_symmetry, Symmetry::Ball);
        let yaws = if is_ball { 1 } else { YAWS };
        for upright in self.orientations(planned) {
            for yaw_rad in yaws_rad(YAWS).take(yaws) {
                let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
                let pose = judge.at_points(&(yaw * upright));
                judged.push((judge.cost(&pose), pose));
            }
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_same = |(_, one): &(f64, Isometry3<f64>), (_, other): &(f64, Isometry3<f64>)| {
            REFINEMENT.same.holds(one, other)
        };
        let mut judged = distinct(judged, SHIFTED, is_same);
        for (cost, pose) in &mut judged {
            (*cost, *pose) = judge.shifted(*cost, pose);
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let chosen = distinct(judged, QUICK, is_same);
        chosen.into_iter().map(|(_, pose)| pose).collect()
    }

    /// Gives orientations that differ in what is down: the planned one, those at rest, and others
    /// spread over the sphere.
    fn orientations(&self, planned: &Isometry3<f64>) -> Vec<UnitQuaternion<f64>> {
        let mut all = vec![planned.rotation];
        if matches!(self.object.near_symmetry, Symmetry::Ball) {
            return all;
        }
        let poses = self.object.poses.iter().take(RESTING);
        all.extend(poses.map(|pose| pose.support_from_item.rotation));
        let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
        let directions = (0..DIRECTIONS).map(|number| direction(number, DIRECTIONS));
        let down = -Vector3::z();
        let turns = directions.map(|from| UnitQuaternion::rotation_between(&from, &down));
        all.extend(turns.map(|turn| turn.unwrap_or_else(half_turn)));
        all
    }
}
