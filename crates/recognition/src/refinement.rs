//! Poses refined from many rough ones to a few exact ones.
//!
//! Recognition looks for many objects on a support, an inspection for one that may lie anyhow. Both
//! align all they start from with few points, those that then agree best with more, and lay the
//! best where the outline fits.

use nalgebra::{Isometry3, Point3};

use crate::align::{AlignSettings, align};
use crate::expected::{Agreement, Observation};
use crate::object::LibraryObject;
use crate::pattern::Pattern;
use crate::samples::spread;
use crate::segmentation::Cluster;
use crate::spacing::spacing_m;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RefinementSettings {
    /// The pass over all poses.
    pub(crate) quick: PassSettings,
    /// The pass over those that agree best after the quick one.
    pub(crate) thorough: PassSettings,
    /// Limits within which poses after the quick pass are one.
    pub(crate) same: SamePose,
    /// The search for the outline.
    pub(crate) polish: PolishSettings,
}

/// Settings of a pass, in which poses are aligned and compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PassSettings {
    /// The width of the expected view's pixels, in spacings of the points.
    pub(crate) pixel_spacings: f64,
    /// Points of the cluster that are compared.
    pub(crate) compared: usize,
    /// Points of the cluster that are aligned.
    pub(crate) aligned: usize,
    pub(crate) align: AlignSettings,
}

/// Settings of the search for the pose where the outline fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PolishSettings {
    /// The width of the expected view's pixels, in spacings of the points.
    pub(crate) pixel_spacings: f64,
    /// Points of the cluster that are compared.
    pub(crate) compared: usize,
    /// Maximum number of points, the surroundings' included. With more, alignment is exact enough,
    /// and a search would take long.
    pub(crate) most_points: usize,
    /// The shifts and turns that are tried.
    pub(crate) pattern: Pattern,
}

/// Limits within which two poses count as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SamePose {
    /// Angle between their orientations, in radians.
    pub(crate) angle_rad: f64,
    /// Distance of their origins, in metres.
    pub(crate) distance_m: f64,
}

impl SamePose {
    pub(crate) fn holds(&self, one: &Isometry3<f64>, other: &Isometry3<f64>) -> bool {
        one.rotation.angle_to(&other.rotation) < self.angle_rad
            && (one.translation.vector - other.translation.vector).norm() < self.distance_m
    }
}

/// An object and a pose to refine, in the frame of the cluster.
pub(crate) type Start<'object> = (&'object LibraryObject, Isometry3<f64>);

/// An object in a pose, and how well it agrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit<'object> {
    pub(crate) object: &'object LibraryObject,
    /// The item frame in that of the cluster.
    pub(crate) pose: Isometry3<f64>,
    pub(crate) agreement: Agreement,
}

/// Refines poses at a cluster.
pub(crate) struct Refinement {
    settings: &'static RefinementSettings,
    quick: Option<Pass>,
    pub(crate) thorough: Pass,
    /// The view that the outline is fitted to; `None` where that would not help.
    outline: Option<Observation>,
}

impl Refinement {
    /// Makes a refinement; `None` where the cluster is not before the camera.
    pub(crate) fn new(cluster: &Cluster, settings: &'static RefinementSettings) -> Option<Self> {
        let spacing_m = spacing_m(cluster);
        let polish = &settings.polish;
        let outline = Observation::new(cluster, polish.pixel_spacings * spacing_m, polish.compared);
        Some(Self {
            settings,
            quick: Pass::new(cluster, spacing_m, &settings.quick),
            thorough: Pass::new(cluster, spacing_m, &settings.thorough)?,
            outline: outline.filter(|outline| outline.points() <= polish.most_points),
        })
    }

    /// Aligns poses to fits, best first: all quickly, and as many thoroughly as asked for.
    pub(crate) fn refined<'object>(
        &mut self,
        starts: impl IntoIterator<Item = Start<'object>>,
        count: usize,
    ) -> Vec<Fit<'object>> {
        let Some(quick) = &mut self.quick else {
            return Vec::new();
        };
        let is_same = |one: &Fit<'_>, other: &Fit<'_>| {
            std::ptr::eq(one.object, other.object)
                && self.settings.same.holds(&one.pose, &other.pose)
        };
        let fits = quick.refined(starts, &self.settings.quick.align);
        let fits = distinct(fits, count, is_same);
        let starts = fits.iter().map(|fit| (fit.object, fit.pose));
        self.thorough.refined(starts, &self.settings.thorough.align)
    }

    /// Finds a pose near another at which the expected view fits better; `None` where a search
    /// would not help.
    ///
    /// Alignment pulls a surface to the points but does not push it away from where the camera saw
    /// none. On small items that leaves some degrees of yaw; the outline holds them.
    pub(crate) fn polished(
        &mut self,
        object: &LibraryObject,
        pose: &Isometry3<f64>,
    ) -> Option<Isometry3<f64>> {
        let outline = self.outline.as_mut()?;
        let mut cost = |pose: &Isometry3<f64>| outline.strict_cost(object, pose);
        let start = (cost(pose), *pose);
        Some(self.settings.polish.pattern.least(object, start, cost).1)
    }
}

/// Aligns poses with a cluster, and compares them with it.
pub(crate) struct Pass {
    observation: Observation,
    points: Vec<Point3<f64>>,
}

impl Pass {
    fn new(cluster: &Cluster, spacing_m: f64, settings: &PassSettings) -> Option<Self> {
        let pixel_m = settings.pixel_spacings * spacing_m;
        Some(Self {
            observation: Observation::new(cluster, pixel_m, settings.compared)?,
            points: spread(&cluster.points_m, settings.aligned),
        })
    }

    fn refined<'object>(
        &mut self,
        starts: impl IntoIterator<Item = Start<'object>>,
        settings: &AlignSettings,
    ) -> Vec<Fit<'object>> {
        let starts = starts.into_iter();
        let fits = starts.map(|(object, pose)| self.aligned(object, &pose, settings));
        let mut fits: Vec<Fit<'object>> = fits.collect();
        sort(&mut fits);
        fits
    }

    /// Aligns a pose to a fit.
    pub(crate) fn aligned<'object>(
        &mut self,
        object: &'object LibraryObject,
        start: &Isometry3<f64>,
        settings: &AlignSettings,
    ) -> Fit<'object> {
        let pose = align(&object.nearest, &self.points, start, settings);
        self.compared(object, &pose)
    }

    /// Gives the fit of a pose as it is.
    pub(crate) fn compared<'object>(
        &mut self,
        object: &'object LibraryObject,
        pose: &Isometry3<f64>,
    ) -> Fit<'object> {
        Fit {
            object,
            pose: *pose,
            agreement: self.observation.compare(object, pose),
        }
    }

    /// Gives the share of what should be seen of an object in a pose that is seen, about.
    pub(crate) fn seen_share(&mut self, object: &LibraryObject, pose: &Isometry3<f64>) -> f64 {
        self.observation.seen_share(object, pose)
    }
}

/// Sorts fits, the best first.
pub(crate) fn sort(fits: &mut [Fit<'_>]) {
    fits.sort_by(|a, b| b.agreement.fitness.total_cmp(&a.agreement.fitness));
}

/// Gives the first of those that are the same, in their order, as many as asked for.
pub(crate) fn distinct<T>(all: Vec<T>, count: usize, is_same: impl Fn(&T, &T) -> bool) -> Vec<T> {
    let mut chosen: Vec<T> = Vec::with_capacity(count);
    for one in all {
        if chosen.len() < count && !chosen.iter().any(|other| is_same(other, &one)) {
            chosen.push(one);
        }
    }
    chosen
}
