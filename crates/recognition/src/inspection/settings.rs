//! How a placed item is inspected.

use std::f64::consts::PI;

use ppnpack_numbers::{settings, within};

settings! {
    /// How a placed item is looked for in a container, and when it counts as what.
    #[derive(Copy)]
    pub struct InspectionSettings with validate {
        /// A point this far above what was there before is new, in metres: five standard deviations
        /// of the noise.
        pub least_rise_m: f64 = 0.005 => within("0 to 1 m", 0.0..=1.0),
        /// What was there before counts as this much wider: items shift, and cameras blur edges. In
        /// metres.
        pub blur_m: f64 = 0.005 => within("0 to 1 m", 0.0..=1.0),
        /// Points within this distance of the walls' inner faces, or beyond them, may show the wall
        /// itself. In metres.
        pub wall_margin_m: f64 = 0.004 => within("0 to 1 m", 0.0..=1.0),
        /// The standard deviation of the sensor's noise, in metres: what a good fit is expected to
        /// be off by.
        pub sensor_deviation_m: f64 = 0.001 => within("0 to 1 m", 0.0..=1.0),
        /// Fewer new points than this are too few to tell a pose.
        pub least_points: usize = 30,
        /// Below this fitness, a pose is not taken; as a sensor without noise would give it.
        pub least_fitness: f64 = 0.85 => within("0 to 1", 0.0..=1.0),
        /// Where more than this share of the new points is not explained, a pose is not taken.
        pub most_unexplained: f64 = 0.08 => within("0 to 1", 0.0..=1.0),
        /// Where the camera looks through more than this share of what should be seen, a pose is
        /// not taken.
        pub most_contradicted: f64 = 0.04 => within("0 to 1", 0.0..=1.0),
        /// Of what should be seen of the item, this share must be, with nothing before it.
        pub least_seen: f64 = 0.4 => within("0 to 1", 0.0..=1.0),
        /// A pose goes before another that means something else only where its fitness is higher by
        /// this.
        pub least_margin: f64 = 0.005 => within("0 to 1", 0.0..=1.0),
        /// With less than this share of the container seen, nothing is said.
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
