//! Stability: would the item stand where it comes to rest?
//!
//! Both tests ask whether the centre of mass lies over the support polygon, the convex hull of the
//! contact points. They differ in what counts as contact and in the margin they ask for.

mod physical;
mod published;

pub use physical::{PhysicalStability, PhysicalStabilitySettings};
pub use published::PublishedStability;
