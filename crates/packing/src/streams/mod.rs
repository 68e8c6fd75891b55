//! Step after step: buffer, orders, containers that close, whole packings and their metrics.

pub mod buffer;
pub mod carton;
pub mod closing;
pub mod episode;
pub mod metrics;
pub mod orders;
pub mod stream;
