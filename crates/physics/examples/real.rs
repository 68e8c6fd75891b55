use nalgebra::*;
use ppnpack_catalogue::{catalogue::*, object::Model};
use ppnpack_packing::{grid::*, heightmap::Surface};
use ppnpack_physics::{cell::*, settings::*};
use std::{path::PathBuf, sync::Arc, time::Instant};
fn plan(grid: &Grid, s: &Surface, m: &Model) -> Option<Isometry3<f64>> {
    let b = m.mesh.bounds()?;
    let e = b.extents_m();
    let c = grid.container();
    let p = s.pitch_m();
    let mut best: Option<(f64, f64, f64)> = None;
    let (w, d) = ((e.x / p).ceil() as usize + 1, (e.y / p).ceil() as usize + 1);
    let mut x0 = 0;
    while x0 + w <= s.nx() {
        let mut y0 = 0;
        while y0 + d <= s.ny() {
            let mut z = 0f32;
            for x in x0..x0 + w {
                for y in y0..y0 + d {
                    z = z.max(s.heights_m()[x * s.ny() + y]);
                }
            }
            let z = z as f64;
            if z + e.z <= c.z_m
                && best.is_none_or(|b| z + 0.1 * (x0 + y0) as f64 * p < b.2 + 0.1 * (b.0 + b.1))
            {
                best = Some((x0 as f64 * p, y0 as f64 * p, z));
            }
            y0 += 4;
        }
        x0 += 4;
    }
    let (x, y, z) = best?;
    Some(Isometry3::translation(
        x + 0.5 * p - b.lowest.x,
        y + 0.5 * p - b.lowest.y,
        z - b.lowest.z,
    ))
}
fn main() {
    let source = match std::env::args().nth(1).as_deref() {
        Some("builtin") | None => Source::Builtin,
        Some(f) => Source::Folder(PathBuf::from(f)),
    };
    let t = Instant::now();
    let cat = Catalogue::load(
        &source,
        &Settings::default(),
        &Resolution::reference(),
        &|_, _| (),
    )
    .unwrap();
    println!(
        "{} objects in {:.1} s; pieces {} vertices max {}",
        cat.objects.len(),
        t.elapsed().as_secs_f64(),
        cat.objects
            .iter()
            .map(|o| o.model.pieces.len())
            .sum::<usize>(),
        cat.objects
            .iter()
            .flat_map(|o| &o.model.pieces)
            .map(|p| p.vertices.len())
            .max()
            .unwrap()
    );
    let grid = Grid::reference();
    let e = |n: &str, d: f64| {
        std::env::var(n)
            .ok()
            .and_then(|v| v.parse().ok())
            .unwrap_or(d)
    };
    let mut st = CellSettings::default();
    st.solver.substeps = e("SUB", 4.0) as usize;
    st.solver.sweeps = e("SW", 3.0) as usize;
    st.solver.length_scale_m = e("LU", 0.1);
    st.solver.sleep_speed_m_s = e("SLEEPV", 0.01);
    st.solver.sleep_time_s = e("SLEEPT", 0.1);
    st.settle_time_s = e("TIME", 0.375);
    let mut cell = SimulatedCell::new(st).unwrap();
    let mut ovs = vec![];
    let mut totals = vec![];
    let (
        mut tilts,
        mut slides,
        mut dz,
        mut dist,
        mut n,
        mut toppled,
        mut nstill,
        mut maxov,
        mut sim,
    ) = (vec![], vec![], vec![], vec![], 0, 0, 0, 0f64, 0.0);
    let mut seq = 12345u64;
    let episodes = std::env::var("EP")
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or(8);
    for ep in 0..episodes {
        cell.reset();
        let (mut tp, mut ts, mut placed) = (0.0, 0.0, 0);
        let (mut worst_place, mut misses) = (0.0f64, 0);
        let mut surface = cell.scan_surface(&grid).unwrap();
        while placed < 40 && misses < 60 {
            seq = seq
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            let o = &cat.objects[(seq >> 33) as usize % cat.objects.len()];
            let Some(pose) = plan(&grid, &surface, &o.model) else {
                misses += 1;
                continue;
            };
            let t = Instant::now();
            let r = cell.place(&o.model, &pose).unwrap();
            let e = t.elapsed().as_secs_f64();
            tp += e;
            worst_place = worst_place.max(e);
            let t = Instant::now();
            surface = cell.scan_surface(&grid).unwrap();
            ts += t.elapsed().as_secs_f64();
            placed += 1;
            n += 1;
            ovs.push(if std::env::var("NOOV").is_ok() {
                0.0
            } else {
                cell.deepest_overlap_m()
            });
            tilts.push(r.tilt_rad);
            slides.push(r.slide_m);
            dz.push(r.height_change_m);
            dist.push(r.disturbance_m());
            toppled += r.toppled as i32;
            nstill += r.still as i32;
            sim += r.simulated_s;
        }
        let ov = cell.deepest_overlap_m();
        maxov = maxov.max(ov);
        let t = Instant::now();
        let s = cell.snapshot();
        let tsnap = t.elapsed().as_secs_f64();
        let t = Instant::now();
        cell.restore(&s).unwrap();
        let trest = t.elapsed().as_secs_f64();
        println!(
            "episode {ep}: {placed} placed, {} inside; place {tp:.3} s (worst {worst_place:.3}) scan {ts:.3} s; overlap {:.2} mm; snapshot {:.2} ms restore {:.2} ms",
            cell.contents().iter().filter(|b| b.inside).count(),
            ov * 1e3,
            tsnap * 1e3,
            trest * 1e3
        );
        totals.push(tp + ts);
    }
    totals.sort_by(f64::total_cmp);
    let q = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        let k = v.len();
        format!(
            "p10 {:.4} median {:.4} p90 {:.4} max {:.4}",
            v[k / 10],
            v[k / 2],
            v[k * 9 / 10],
            v[k - 1]
        )
    };
    println!(
        "median episode {:.3} s; {n} placed, {toppled} toppled, {nstill} still, mean simulated {:.3} s, worst overlap {:.2} mm",
        totals[totals.len() / 2],
        sim / n as f64,
        maxov * 1e3
    );
    println!("overlap {}", q(&mut ovs));
    println!(
        "tilt {}\nslide {}\ndz {}\ndisturbance {}",
        q(&mut tilts),
        q(&mut slides),
        q(&mut dz),
        q(&mut dist)
    );
    let _: Option<Arc<Model>> = None;
}
