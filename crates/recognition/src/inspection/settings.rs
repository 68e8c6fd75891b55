//! Settings of the inspection of placed items.

use std::f64::consts::PI;

use ppnpack_numbers::{settings, within};

settings! {
    /// Settings by which a placed item is looked for in a container, and by which it counts as
    /// what.
    #[derive(Copy)]
    pub struct InspectionSettings with validate {
        /// Minimum height of a new point above what was there before, in metres: five standard
        /// deviations of the noise.
        pub least_rise_m: f64 = 0.005 => within("0 to 1 m", 0.0..=1.0),
        /// Distance by which the content before counts as wider, in metres: items shift, and
        /// cameras blur edges.
        pub blur_m: f64 = 0.005 => within("0 to 1 m", 0.0..=1.0),
        /// Points within this distance of the walls' inner faces, or beyond them, may show the wall
        /// itself. In metres.
        pub wall_margin_m: f64 = 0.004 => within("0 to 1 m", 0.0..=1.0),
        /// The standard deviation of the sensor's noise, in metres: what a good fit is expected to
        /// be off by.
        pub sensor_deviation_m: f64 = 0.001 => within("0 to 1 m", 0.0..=1.0),
        /// Minimum number of new points that tell a pose.
        pub least_points: usize = 30,
        /// Minimum fitness of a pose, as a sensor without noise would give it.
        pub least_fitness: f64 = 0.85 => within("0 to 1", 0.0..=1.0),
        /// Maximum share of the new points that a pose does not explain.
        pub most_unexplained: f64 = 0.08 => within("0 to 1", 0.0..=1.0),
        /// Maximum share of what should be seen of a pose that the camera looks through.
        pub most_contradicted: f64 = 0.04 => within("0 to 1", 0.0..=1.0),
        /// Minimum share of what should be seen of the item that is, with nothing before it.
        pub least_seen: f64 = 0.4 => within("0 to 1", 0.0..=1.0),
        /// Minimum excess of fitness by which a pose goes before another that means something else.
        pub least_margin: f64 = 0.005 => within("0 to 1", 0.0..=1.0),
        /// Minimum share of the container that is seen; with less, nothing is said.
        pub least_container_seen: f64 = 0.6 => within("0 to 1", 0.0..=1.0),
        /// An item whose centre is nearer to where it was planned than this, seen from above, lies
        /// as planned. In metres.
        pub slide_m: f64 = 0.006 => within("0 to 1 m", 0.0..=1.0),
        /// An item whose centre is at most this much higher or lower than planned lies as planned,
        /// in metres.
        pub rise_m: f64 = 0.008 => within("0 to 1 m", 0.0..=1.0),
        /// An item that is turned by less than this, modulo its near symmetry, lies as planned. In
        /// radians.
        pub turn_rad: f64 = 0.12 => within("0 to pi", 0.0..=PI),
        /// An item that is tilted by more than this, modulo its near symmetry, toppled. In radians.
        pub topple_rad: f64 = 0.35 => within("0 to pi", 0.0..=PI),
    }
}
