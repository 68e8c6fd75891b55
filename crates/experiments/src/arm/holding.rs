//! `ppnpack experiment holding`: which of the built-in household objects the built-in grippers can hold, and where.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Context;
use nalgebra::Point3;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_robot::arms;
use ppnpack_robot::pick::{PickSettings, find};
use ppnpack_robot::surface::UpperSurface;

use crate::scene::objects;

const PITCH_M: f64 = 0.002;

pub(crate) fn run() -> Outcome {
    let catalogue = objects(&ppnpack_household::builtin())?;
    let arm = arms::arm("nachi-mz07l").or_run()?;
    let (mut held, mut coarsely_held) = (0, 0);
    let mut refusals: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let start = Instant::now();
    for object in &catalogue.objects {
        let picks = PickSettings::default();
        let bare = || format!("{} has no surface", object.model.name);
        let coarse = UpperSurface::of_item(&object.item, &catalogue.resolution);
        let coarse = coarse.with_context(bare).or_run()?;
        coarsely_held += usize::from(find(&coarse, arm.gripper(), &picks).is_ok());
        let surface = UpperSurface::of_model(&object.model, PITCH_M);
        let surface = surface.with_context(bare).or_run()?;
        match find(&surface, arm.gripper(), &picks) {
            Ok(found) => {
                held += 1;
                let triangles = object.model.mesh.corners();
                let heights_m = triangles.filter_map(|triangle| below(&found.in_item, triangle));
                let top_m = heights_m.fold(f64::NEG_INFINITY, f64::max);
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
    Ok(())
}

/// The height at which a vertical line through a point meets a triangle.
fn below(point: &Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> Option<f64> {
    let (u, v, w) = ((b - a).xy(), (c - a).xy(), (point - a).xy());
    let area = u.perp(&v);
    let (s, t) = (w.perp(&v) / area, u.perp(&w) / area);
    let is_inside = s >= -1e-9 && t >= -1e-9 && s + t <= 1.0 + 1e-9;
    is_inside.then(|| a.z + s * (b.z - a.z) + t * (c.z - a.z))
}
