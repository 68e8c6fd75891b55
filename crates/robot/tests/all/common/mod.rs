//! Random placements, and a brute-force oracle for the motions that make them.
pub(crate) mod oracle;
pub(crate) mod scenes;
