//! The last fractions of a millimetre: a pose that fits the outline, too.

use nalgebra::Isometry3;

use crate::expected::{Observation, Sketch};
use crate::object::LibraryObject;
use crate::pattern::Pattern;
use crate::segmentation::Cluster;

/// How a pose is laid where the outline fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PolishSettings {
    /// The width of the expected view's pixels, in spacings of the points.
    pub(crate) pixel_spacings: f64,
    /// Points of the cluster that are compared.
    pub(crate) compared: usize,
    /// With more points than this, the surroundings' among them, alignment alone is exact enough, and a search would take
    /// long.
    pub(crate) most_points: usize,
    /// The shifts and turns that are tried.
    pub(crate) pattern: Pattern,
}

/// A search for the shift and yaw at which the expected view fits best.
///
/// Alignment pulls a surface to the points but does not push it away from where the camera saw none. On small items that
/// leaves some degrees of yaw; the outline holds them.
pub(crate) struct Polish {
    observation: Observation,
    sketch: Sketch,
    pattern: Pattern,
}

impl Polish {
    /// Prepares a search at a cluster whose points are `spacing_m` apart; `None` where it would not help.
    pub(crate) fn new(
        cluster: &Cluster,
        spacing_m: f64,
        settings: &PolishSettings,
    ) -> Option<Self> {
        let pixel_m = settings.pixel_spacings * spacing_m;
        let observation = Observation::new(cluster, pixel_m, settings.compared)?;
        (observation.points() <= settings.most_points).then(|| Self {
            observation,
            sketch: Sketch::default(),
            pattern: settings.pattern,
        })
    }

    /// A pose near another that fits better.
    pub(crate) fn polished(
        &mut self,
        object: &LibraryObject,
        pose: &Isometry3<f64>,
    ) -> Isometry3<f64> {
        let (observation, sketch) = (&self.observation, &mut self.sketch);
        let mut cost = |pose: &Isometry3<f64>| observation.strict_cost(object, pose, sketch);
        let start = (cost(pose), *pose);
        self.pattern.least(object, start, cost).1
    }
}
