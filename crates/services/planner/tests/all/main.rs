//! The planner from outside: one program, as linking what carries messages takes long.
#![cfg(test)]

mod believing;
mod bridges;
mod common;
mod containers;
mod contradicting;
mod counting;
mod inspecting;
mod interrupting;
mod limits;
mod loads;
mod orders;
mod poses;
mod replaying;
mod setting_aside;
mod stateless;
mod trying;
mod two_controllers;
mod versions;
