//! `ppnpack experiment calibration`: how well calibrations of a simulated depth camera agree with the truth, and what is
//! refused.

use std::collections::BTreeMap;

use clap::Args;
use ppnpack_camera::{DepthEdges, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_cli::failure::Outcome;
use ppnpack_perception::calibration::{CalibrationSettings, calibrate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::simulated::{Case, Errors};
use super::timed;
use crate::statistics::quantiles;

/// Calibrates on simulated clouds of empty containers, with noise, dropouts, flying pixels and things in the way.
#[derive(Debug, Args)]
pub(crate) struct CalibrationArguments {
    /// How many containers of each kind
    #[arg(long, value_name = "COUNT", default_value_t = 200)]
    cases: usize,

    /// Say of each refused cloud why
    #[arg(long)]
    reasons: bool,
}

pub(crate) fn run(arguments: &CalibrationArguments) -> Outcome {
    println!(
        "| clouds | accepted | within the aims | wrong | position: median, 95 % | angle | size | time |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    measure(arguments, "1 mm, 5 % dropouts", false, |_, _| {});
    measure(arguments, "the same, size known", true, |_, _| {});
    measure(arguments, "3 mm, 20 % dropouts", false, |case, _| {
        case.noise.deviation_m = 0.003;
        case.noise.dropout = 0.2;
    });
    measure(
        arguments,
        "flying pixels at edges, grazing walls not seen",
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
    measure(arguments, "an item on the floor", false, |case, random| {
        let [x_m, y_m, _] = case.size_m;
        let [x, y] = [x_m, y_m].map(|side_m| random.random_range(0.2..0.6) * side_m);
        let high_m = random.random_range(0.01..0.06);
        case.others = vec![Mesh::cuboid([x, y, 0.0], [x + 0.03, y + 0.05, high_m])];
    });
    measure(arguments, "a wall bulges by 12 mm", false, |case, _| {
        case.bulge_m = 0.012;
    });
    Ok(())
}

/// What is changed in each case.
type Change = fn(&mut Case, &mut ChaCha8Rng);

fn measure(arguments: &CalibrationArguments, name: &str, is_size_known: bool, change: Change) {
    let cases = arguments.cases;
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
        let (found, took_ms) = timed(|| calibrate(cloud, &settings));
        took.push(took_ms);
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
                let reason = text.split([' ', '{']).next().unwrap_or_default().to_owned();
                if arguments.reasons {
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
    let spread = |of: fn(&Errors) -> f64| quantiles(errors.iter().map(of), [0.5, 0.95]);
    let [position, position_95] = spread(|error| 1e3 * error.position_m);
    let [angle, angle_95] = spread(|error| error.angle_rad.to_degrees());
    let [size, size_95] = spread(|error| 1e3 * error.size_m);
    let [took_ms] = quantiles(took.into_iter(), [0.5]);
    println!(
        "| {name} | {accepted} of {cases} | {small} | {} | {position:.2}, {position_95:.2} mm | {angle:.3}, {angle_95:.3} deg | \
         {size:.2}, {size_95:.2} mm | {took_ms:.0} ms |",
        accepted - small
    );
    println!("refused: {reasons:?}");
}
