//! Random numbers of the simulation.

/// A standard normal number from two uniform ones in [0, 1), by the Box-Muller transform.
pub(crate) fn gaussian(first: f64, second: f64) -> f64 {
    // 1 - first is in (0, 1], where the logarithm is finite.
    (-2.0 * (1.0 - first).ln()).sqrt() * (std::f64::consts::TAU * second).cos()
}
