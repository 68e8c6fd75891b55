//! Clouds to scenes, and containers found in clouds.
#![cfg(test)]

mod calibrating;
mod doubts;
mod hidden;
mod mapping;
mod simulated;
