//! Poses of one object at new points.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Bounds;

use crate::align::{AlignSettings, Hold};
use crate::inspection::changes::Changes;
use crate::inspection::judge::Judge;
use crate::object::LibraryObject;
use crate::pattern::{Move, Pattern};
use crate::polish::{Polish, PolishSettings};
use crate::refinement::{Fit, Pass, PassSettings, RefinementSettings, SamePose, distinct, sort};
use crate::samples::{direction, yaws_rad};
use crate::segmentation::Cluster;
use crate::spacing::spacing_m;
use crate::symmetry::Symmetry;

/// How poses in any orientation are tried.
struct HypothesisSettings {
    /// Directions of the sphere that are tried to be down, besides those in which the object rests.
    directions: usize,
    /// The most resting poses that are tried.
    resting: usize,
    /// Yaws that each direction is tried at.
    yaws: usize,
    /// Hypotheses that are shifted.
    shifted: usize,
    /// Hypotheses that are aligned quickly, and thoroughly.
    quick: usize,
    thorough: usize,
}

const HYPOTHESES: HypothesisSettings = HypothesisSettings {
    directions: 32,
    resting: 24,
    yaws: 20,
    shifted: 60,
    quick: 24,
    thorough: 5,
};

/// How hypotheses are refined. An item may lie anyhow.
const REFINEMENT: RefinementSettings = RefinementSettings {
    quick: PassSettings {
        pixel_spacings: 2.0,
        compared: 300,
        aligned: 100,
        align: freely(10, (0.015, 0.004)),
    },
    thorough: PassSettings {
        pixel_spacings: 1.0,
        compared: 2500,
        aligned: 400,
        align: freely(14, (0.006, 0.0015)),
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
            moves: [Move::ALONG_X, Move::ALONG_Y, Move::TURNS],
            sweeps: 1,
        },
    },
};

/// How many of the best fits are laid where the outline fits, and how they are aligned then.
const POLISHED_FITS: usize = 2;
const POLISHED: AlignSettings = freely(6, (0.003, 0.0015));

/// How the item is looked for near the planned pose.
struct NearPlanSettings {
    /// How the planned pose is aligned.
    align: AlignSettings,
    /// A fit that turned by more than this is compared with an upright one, in radians.
    upright_from_rad: f64,
    /// How an upright one is aligned.
    upright: AlignSettings,
    /// Where the outline is off by more than this, as shares of points, it is fitted.
    polish_from: f64,
}

const NEAR_PLAN: NearPlanSettings = NearPlanSettings {
    align: freely(16, (0.012, 0.0015)),
    upright_from_rad: 0.1,
    upright: AlignSettings {
        rounds: 10,
        scale_m: (0.006, 0.0015),
        hold: Some(Hold {
            tilt_rad: 0.01,
            height_m: 0.1,
        }),
    },
    polish_from: 0.008,
};

/// Alignment of an item that may turn and move in any way.
const fn freely(rounds: usize, scale_m: (f64, f64)) -> AlignSettings {
    AlignSettings {
        rounds,
        scale_m,
        hold: None,
    }
}

/// Looks for poses of an object that agree with new points.
pub(crate) struct Search<'object> {
    object: &'object LibraryObject,
    cluster: Cluster,
    spacing_m: f64,
    thorough: Pass,
}

impl<'object> Search<'object> {
    /// `own_m` are new points, `others_m` all that is seen besides. `None` where nothing can be compared.
    pub(crate) fn new(
        object: &'object LibraryObject,
        own_m: &[Point3<f64>],
        others_m: &[Point3<f64>],
        eye_m: Point3<f64>,
        diameter_m: f64,
    ) -> Option<Self> {
        let Bounds { lowest, highest } = Bounds::of(own_m)?;
        // Wherever the object has some of the new points, all of it is within its diameter of them.
        let is_near = |point: &&Point3<f64>| {
            point.x > lowest.x - diameter_m
                && point.x < highest.x + diameter_m
                && point.y > lowest.y - diameter_m
                && point.y < highest.y + diameter_m
        };
        let cluster = Cluster {
            points_m: own_m.to_vec(),
            surroundings_m: others_m.iter().filter(is_near).copied().collect(),
            eye_m,
            world_from_support: Isometry3::identity(),
        };
        let spacing_m = spacing_m(&cluster);
        Some(Self {
            object,
            thorough: Pass::new(&cluster, spacing_m, &REFINEMENT.thorough)?,
            cluster,
            spacing_m,
        })
    }

    /// The fit that alignment leads to from the planned pose; one that is as upright as planned where it agrees about as
    /// well, by `margin`. What is nearly round turns freely under alignment.
    pub(crate) fn near_planned(&mut self, planned: &Isometry3<f64>, margin: f64) -> Fit<'object> {
        let object = self.object;
        let mut fit = self.thorough.aligned(object, planned, &NEAR_PLAN.align);
        if fit.pose.rotation.angle_to(&planned.rotation) > NEAR_PLAN.upright_from_rad {
            let shift = fit.pose * object.centre_m - planned * object.centre_m;
            let start = Translation3::from(shift) * planned;
            let upright = self.thorough.aligned(object, &start, &NEAR_PLAN.upright);
            if upright.agreement.fitness >= fit.agreement.fitness - margin {
                fit = upright;
            }
        }
        let agreement = fit.agreement;
        if agreement.unexplained + agreement.contradicted > NEAR_PLAN.polish_from {
            self.polish(std::slice::from_mut(&mut fit));
        }
        fit
    }

    /// The share of what should be seen of a pose that is seen, about.
    pub(crate) fn seen_share(&mut self, container_from_item: &Isometry3<f64>) -> f64 {
        let measured = self.cluster.points_m.len() + self.cluster.surroundings_m.len();
        self.thorough
            .seen_share(self.object, container_from_item, measured)
    }

    /// Fits from all orientations, best first.
    pub(crate) fn anywhere(
        &mut self,
        planned: &Isometry3<f64>,
        changes: &Changes<'_>,
    ) -> Vec<Fit<'object>> {
        let object = self.object;
        let Some(mut quick) = Pass::new(&self.cluster, self.spacing_m, &REFINEMENT.quick) else {
            return Vec::new();
        };
        let starts = self.hypotheses(planned, changes).into_iter();
        let fits = quick.refined(starts.map(|start| (object, start)));
        let finalists = distinct(fits, HYPOTHESES.thorough, |one, other| {
            REFINEMENT.same.holds(&one.pose, &other.pose)
        });
        let starts = finalists.iter().map(|fit| (object, fit.pose));
        let mut fits = self.thorough.refined(starts);
        fits.retain(|fit| changes.admit(object, &fit.pose));
        self.polish(&mut fits);
        fits.retain(|fit| changes.admit(object, &fit.pose));
        sort(&mut fits);
        fits
    }

    /// Lays the best fits where the outline fits.
    fn polish(&mut self, fits: &mut [Fit<'object>]) {
        let Some(mut polish) = Polish::new(&self.cluster, self.spacing_m, &REFINEMENT.polish)
        else {
            return;
        };
        for fit in fits.iter_mut().take(POLISHED_FITS) {
            let pose = polish.polished(self.object, &fit.pose);
            let polished = self.thorough.aligned(self.object, &pose, &POLISHED);
            if polished.agreement.fitness > fit.agreement.fitness {
                *fit = polished;
            }
        }
    }

    /// Poses in all orientations whose outline is where the new points are, the most alike first.
    fn hypotheses(&self, planned: &Isometry3<f64>, changes: &Changes<'_>) -> Vec<Isometry3<f64>> {
        let judge = Judge::new(self.object, &self.cluster, changes);
        let mut judged: Vec<(f64, Isometry3<f64>)> = Vec::new();
        let is_ball = matches!(self.object.near_symmetry, Symmetry::Ball);
        let yaws = if is_ball { 1 } else { HYPOTHESES.yaws };
        for upright in self.orientations(planned) {
            for yaw_rad in yaws_rad(HYPOTHESES.yaws).take(yaws) {
                let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
                let pose = judge.at_points(&(yaw * upright));
                judged.push((judge.cost(&pose), pose));
            }
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_same = |(_, one): &(f64, Isometry3<f64>), (_, other): &(f64, Isometry3<f64>)| {
            REFINEMENT.same.holds(one, other)
        };
        let mut judged = distinct(judged, HYPOTHESES.shifted, is_same);
        for (cost, pose) in &mut judged {
            (*cost, *pose) = judge.shifted(*cost, pose);
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let chosen = distinct(judged, HYPOTHESES.quick, is_same);
        chosen.into_iter().map(|(_, pose)| pose).collect()
    }

    /// Orientations that differ in what is down: the planned one, those at rest, and others spread over the sphere.
    fn orientations(&self, planned: &Isometry3<f64>) -> Vec<UnitQuaternion<f64>> {
        let mut all = vec![planned.rotation];
        if matches!(self.object.near_symmetry, Symmetry::Ball) {
            return all;
        }
        let poses = self.object.poses.iter().take(HYPOTHESES.resting);
        all.extend(poses.map(|pose| pose.support_from_item.rotation));
        let down = -Vector3::z();
        all.extend((0..HYPOTHESES.directions).map(|number| {
            UnitQuaternion::rotation_between(&direction(number, HYPOTHESES.directions), &down)
                .unwrap_or_else(|| {
                    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
                })
        }));
        all
    }
}
