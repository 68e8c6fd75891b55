//! How well calibrations of a simulated depth camera agree with the truth, and what is refused.
//!
//! usage: `calibration_accuracy [CASES]`, by default 200.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a measurement that cannot run should say so at once"
)]

#[path = "../tests/simulated/mod.rs"]
mod simulated;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ppnpack_camera::{DepthEdges, NoiseModel};
use ppnpack_perception::calibration::{CalibrationSettings, calibrate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simulated::{Case, Errors, cuboid};

fn main() {
    let cases: usize = std::env::args()
        .nth(1)
        .map_or(200, |text| text.parse().unwrap());
    println!(
        "| clouds | accepted | within the aims | wrong | position: median, 95 % | angle | size | time |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    measure("1 mm, 5 % dropouts", cases, false, |_, _| {});
    measure("the same, size known", cases, true, |_, _| {});
    measure("3 mm, 20 % dropouts", cases, false, |case, _| {
        case.noise.deviation_m = 0.003;
        case.noise.dropout = 0.2;
    });
    measure(
        "flying pixels at edges, grazing walls not seen",
        cases,
        false,
        |case, _| {
            case.noise = NoiseModel {
                edges: DepthEdges {
                    dropout: 0.3,
                    flying_pixels: 0.3,
                    ..DepthEdges::default()
                },
                grazing_limit_rad: 1.25,
                ..NoiseModel::default()
            };
        },
    );
    measure("an item on the floor", cases, false, |case, random| {
        let [x_m, y_m, _] = case.size_m;
        let [x, y] = [x_m, y_m].map(|side_m| random.random_range(0.2..0.6) * side_m);
        let high_m = random.random_range(0.01..0.06);
        case.others = vec![cuboid([x, y, 0.0], [x + 0.03, y + 0.05, high_m])];
    });
    measure("a wall bulges by 12 mm", cases, false, |case, _| {
        case.bulge_m = 0.012;
    });
}

fn measure(name: &str, cases: usize, is_size_known: bool, change: fn(&mut Case, &mut ChaCha8Rng)) {
    let mut random = ChaCha8Rng::seed_from_u64(42);
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    let mut errors: Vec<Errors> = Vec::new();
    let mut took = Vec::new();
    for index in 0..cases {
        let mut case = Case::any(&mut random);
        change(&mut case, &mut random);
        let settings = CalibrationSettings {
            size: is_size_known.then(|| case.size()),
            ..CalibrationSettings::default()
        };
        let cloud = case.cloud();
        let began = Instant::now();
        let found = calibrate(cloud, &settings);
        took.push(began.elapsed());
        match found {
            Ok(found) => {
                let error = case.errors(&found);
                if !error.are_small() {
                    eprintln!(
                        "{name}, case {index}: {error:?} {:?} {:?}",
                        case.size_m, found.residuals
                    );
                }
                errors.push(error);
            }
            Err(error) => {
                let text = format!("{error:?}");
                let reason = text.split([' ', '{']).next().unwrap().to_owned();
                if std::env::var_os("REASONS").is_some() {
                    eprintln!(
                        "{name}, case {index}: {error} {:?} wall {}",
                        case.size_m, case.wall_m
                    );
                }
                *reasons.entry(reason).or_default() += 1;
            }
        }
    }
    let accepted = errors.len();
    let small = errors.iter().filter(|error| error.are_small()).count();
    let quantiles = |of: fn(&Errors) -> f64| {
        let mut values: Vec<f64> = errors.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((share * accepted as f64) as usize).copied();
        [0.5, 0.95].map(|share| at(share).unwrap_or(f64::NAN))
    };
    let [position, position_95] = quantiles(|error| 1e3 * error.position_m);
    let [angle, angle_95] = quantiles(|error| error.angle_rad.to_degrees());
    let [size, size_95] = quantiles(|error| 1e3 * error.size_m);
    took.sort();
    let time: Duration = took[took.len() / 2];
    println!(
        "| {name} | {accepted} of {cases} | {small} | {} | {position:.2}, {position_95:.2} mm | {angle:.3}, {angle_95:.3} deg | \
         {size:.2}, {size_95:.2} mm | {:.0} ms |",
        accepted - small,
        1e3 * time.as_secs_f64()
    );
    println!("refused: {reasons:?}");
}
