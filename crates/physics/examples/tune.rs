#[path = "../tests/common/mod.rs"]
mod common;
use common::*;
use ppnpack_physics::{cell::*, settings::*};
use ppnpack_packing::grid::Grid;
use std::time::Instant;
fn main() {
    let e = |n: &str, d: f64| std::env::var(n).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let mut s = CellSettings::default();
    s.solver.sleep_speed_m_s = e("SLEEPV", 0.01);
    s.solver.sleep_time_s = e("SLEEPT", 0.1);
    s.contact.restitution = e("REST", 0.0);
    let mut cell = SimulatedCell::new(s.clone()).unwrap();
    let m = cuboid([0.06, 0.06, 0.05]);
    let mut out = String::new();
    for l in 0..5 {
        let r = cell.place(&m, &at(0.16, 0.16, 0.025 + 0.05 * l as f64)).unwrap();
        out += &format!("{:.2}/{:.2}/{:.2}s ", r.height_change_m * 1e3, r.slide_m * 1e3, r.simulated_s);
    }
    println!("stack  dz mm/slide mm: {out} overlap {:.2}", cell.deepest_overlap_m() * 1e3);
    cell.reset();
    let p = cuboid([0.12, 0.1, 0.002]);
    out.clear();
    for l in 0..8 {
        let r = cell.place(&p, &at(0.16, 0.16, 0.001 + 0.002 * l as f64)).unwrap();
        out += &format!("{:.2}/{:.2}/{:.2}s ", r.height_change_m * 1e3, r.slide_m * 1e3, r.simulated_s);
    }
    println!("plates dz mm: {out} overlap {:.2}", cell.deepest_overlap_m() * 1e3);
    // Pile of compounds.
    cell.reset();
    let grid = Grid::reference();
    let models = [
        cuboids("angle", &[([0.0; 3], [0.09, 0.03, 0.03]), ([0.03, 0.0, 0.03], [0.03; 3])]),
        ball(0.025),
        cuboid([0.08, 0.06, 0.04]),
        cuboids("grid", &(0..8).map(|i| ([0.012 * i as f64 - 0.042, if i % 2 == 0 { 0.01 } else { -0.01 }, 0.0], [0.012, 0.04, 0.03])).collect::<Vec<_>>()),
        ball(0.035),
        cuboid([0.05, 0.1, 0.03]),
    ];
    let (mut t_place, mut t_scan) = (0.0, 0.0);
    let (mut sim, mut worst, mut still, mut sum) = (0.0, 0.0_f64, 0, 0.0);
    for i in 0..40 {
        let m = &models[i % models.len()];
        let scene = cell.scan_surface(&grid).unwrap();
        let a = i as f64;
        let (x, y) = (0.16 + 0.1 * (1.7 * a).cos(), 0.16 + 0.1 * (2.3 * a).sin());
        let low = m.mesh.vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
        // highest surface within 6 cm
        let pitch = scene.pitch_m();
        let mut top = 0.0_f32;
        for (k, h) in scene.heights_m().iter().enumerate() {
            let (px, py) = ((k / scene.ny()) as f64 * pitch, (k % scene.ny()) as f64 * pitch);
            if (px - x).abs() < 0.05 && (py - y).abs() < 0.05 { top = top.max(*h); }
        }
        let t = Instant::now();
        let r = cell.place(m, &turned(x, y, top as f64 - low, 0.4 * a)).unwrap();
        t_place += t.elapsed().as_secs_f64();
        let t = Instant::now();
        cell.scan_surface(&grid).unwrap();
        t_scan += t.elapsed().as_secs_f64();
        sim += r.simulated_s;
        still += r.still as i32;
        worst = worst.max(cell.deepest_overlap_m());
        sum += cell.deepest_overlap_m();
    }
    println!("pile: place {:.3} s scan {:.3} s; simulated {:.2} of 15 s; still {still}; overlap worst {:.2} mean {:.2} mm; {} bodies", t_place, t_scan, sim, worst * 1e3, sum / 40.0 * 1e3, cell.contents().len());
    let before = cell.contents();
    let mut more = SimulatedCell::new(CellSettings { settle_time_s: 4.0, ..s }).unwrap();
    let _ = &mut more;
    let mut tt = 0.0; let mut n = 0;
    while n < 20 { let r = cell.settle(); tt += r.simulated_s; n += 1; if r.simulated_s < 0.374 { break; } }
    let moved = before.iter().zip(cell.contents().iter()).map(|(a, b)| (a.container_from_item.translation.vector - b.container_from_item.translation.vector).norm()).fold(0.0, f64::max);
    println!("afterwards: asleep after {tt:.2} s, moved {:.2} mm, overlap {:.2}", moved * 1e3, cell.deepest_overlap_m() * 1e3);
}
