//! The services as processes.

mod clocks;
mod commands;
mod common;
mod console;
mod containers;
mod controllers;
mod disk;
mod faults;
mod hostile;
mod leases;
mod stopping;
mod traces;
