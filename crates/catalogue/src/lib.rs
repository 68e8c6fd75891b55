//! Meshes to packable items.
//!
//! A [`catalogue::Catalogue`] is loaded from a folder of mesh files, or from meshes that the program has. Each mesh
//! is read ([`reader`]), checked and repaired ([`repair`]), and becomes a model ([`build`]): its
//! mass, convex pieces for physics and resting poses. A model at a resolution of the grid is an
//! item ([`views`]), rasterised exactly ([`raster`]).

pub mod build;
pub mod cache;
pub mod catalogue;
pub mod convex;
mod error;
mod guard;
mod hull;
pub mod mass;
pub mod mesh;
pub mod object;
pub mod raster;
pub mod reader;
pub mod repair;
pub mod report;
pub mod resting;
#[cfg(test)]
mod shapes;
mod source;
mod table;
pub mod unit;
pub mod views;
