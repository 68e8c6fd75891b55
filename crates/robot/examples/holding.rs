//! Which of the built-in household objects the built-in grippers can hold, and where.
//!
//! `cargo run --release -p ppnpack-robot --example holding`
#![allow(
    clippy::unwrap_used,
    reason = "an experiment that cannot run should say so at once"
)]

use std::collections::BTreeMap;
use std::time::Instant;

use nalgebra::Point3;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::grid::Resolution;
use ppnpack_robot::arms;
use ppnpack_robot::pick::{PickSettings, find};
use ppnpack_robot::surface::UpperSurface;

const PITCH_M: f64 = 0.002;

fn main() {
    let directory = std::env::temp_dir().join(format!("ppnpack-robot-{}", std::process::id()));
    let cache = CacheDir::At(directory.clone());
    let settings = Settings {
        cache,
        ..Settings::default()
    };
    let resolution = Resolution::reference();
    let catalogue = Catalogue::load(
        &ppnpack_household::builtin(),
        &settings,
        &resolution,
        &|_, _| (),
    )
    .unwrap();
    std::fs::remove_dir_all(&directory).unwrap();
    let arm = arms::arm("nachi-mz07l").unwrap();
    let (mut held, mut coarsely_held) = (0, 0);
    let mut refusals: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let start = Instant::now();
    for object in &catalogue.objects {
        let picks = PickSettings::default();
        let coarse = UpperSurface::of_item(&object.item, &resolution).unwrap();
        coarsely_held += usize::from(find(&coarse, arm.gripper(), &picks).is_ok());
        let surface = UpperSurface::of_model(&object.model, PITCH_M).unwrap();
        match find(&surface, arm.gripper(), &picks) {
            Ok(found) => {
                held += 1;
                let top_m = object
                    .model
                    .mesh
                    .corners()
                    .filter_map(|triangle| below(&found.in_item, triangle));
                let top_m = top_m.fold(f64::NEG_INFINITY, f64::max);
                let apart_m = (found.in_item.z - top_m).abs();
                assert!(
                    apart_m < 0.004,
                    "{}: {found:?}, but the mesh is at {top_m}",
                    object.model.name
                );
            }
            Err(refusal) => {
                let names = refusals.entry(refusal.to_string()).or_default();
                names.push(object.model.name.clone());
            }
        }
    }
    let all = catalogue.objects.len();
    println!(
        "{held} of {all} can be held on their meshes, {coarsely_held} on 1 cm heightmaps; {:?} each",
        start.elapsed() / all as u32
    );
    for (refusal, names) in refusals {
        println!("{:3} {refusal}: {}", names.len(), names.join(", "));
    }
}

/// The height at which a vertical line through a point meets a triangle.
fn below(point: &Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> Option<f64> {
    let (u, v, w) = ((b - a).xy(), (c - a).xy(), (point - a).xy());
    let area = u.perp(&v);
    let (s, t) = (w.perp(&v) / area, u.perp(&w) / area);
    let is_inside = s >= -1e-9 && t >= -1e-9 && s + t <= 1.0 + 1e-9;
    is_inside.then(|| a.z + s * (b.z - a.z) + t * (c.z - a.z))
}
