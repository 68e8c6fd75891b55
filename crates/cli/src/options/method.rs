//! Options for how placements are found and judged.

use clap::Args;
use clap::builder::TypedValueParser;
use ppnpack_packing::arm_time::ArmTime;
use ppnpack_packing::look_ahead::LookAheadSettings;
use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::scene_value::SceneValue;

use super::arm::ArmOptions;
use super::choice::{Choice, one_of};
use super::conditions::Conditions;
use super::loads::LoadOptions;
use super::objective::Objective;
use super::proposals::ProposalOptions;
use super::trial::TrialOptions;
use crate::failure::{Failure, OrInput, Outcome};

/// How placements are found and judged.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodOptions {
    /// What placements are judged by
    #[arg(long, value_parser = one_of(&HEURISTICS), default_value = "sdfm")]
    pub(crate) heuristic: Heuristic,

    /// How the items of the buffer compete for a step
    #[arg(long, value_parser = one_of(&ORDERS), default_value = "balance")]
    pub(crate) order: Order,

    #[command(flatten)]
    pub(crate) proposals: ProposalOptions,

    /// The geometric stability test that placements must pass before they are tried
    /// [default: none under robot conditions, published under the reference's]
    #[arg(long, value_parser = parse_stability())]
    pub(crate) stability: Option<Stability>,

    #[command(flatten)]
    pub(crate) trial: TrialOptions,

    #[command(flatten)]
    loads: LoadOptions,

    #[command(flatten)]
    pub(crate) arm: ArmOptions,

    /// The weights of the objective [default: low, or dense with several --poses, under robot conditions; published under the
    /// reference's]
    #[arg(long, value_enum, overrides_with = "objective")]
    objective: Option<Objective>,

    /// A weight of the objective that is another, such as distance=2.5 (may be repeated)
    #[arg(long = "weight", value_name = "NAME=VALUE")]
    pub(crate) weights: Vec<String>,

    /// What a litre that may still be packed after a placement is worth, in the objective's units, by a learned value of what it
    /// leaves; with 0 the objective alone counts [default: 30 under robot conditions, 0 under the reference's]
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    pub(crate) scene_value: Option<f64>,

    /// How many litres that may still be packed a second of the arm's cycle is worth: of the best valid placements the one is taken of the
    /// least value and time; with 0 time counts nothing. With an arm and a scene value
    #[arg(long, value_name = "LITRES", default_value_t = 0.0)]
    pub(crate) litres_per_second: f64,

    /// How many futures a step looks ahead through, for each item that it may choose; with 0 it does not
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    pub(crate) futures: u32,

    /// How many items the robot may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) buffer: u32,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Threads for one step; the result is the same with any number. The bounded search runs on one
    /// [default: one to search, one per core to try placements and to look ahead]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) threads: Option<u32>,
}

const HEURISTICS: [Choice<Heuristic>; 6] = [
    (
        "sdfm",
        Heuristic::Sdfm,
        "Low, close to content, compact (SDF minimisation)",
    ),
    ("dbl", Heuristic::Dbl, "Deepest bottom-left"),
    ("hm", Heuristic::Hm, "Heightmap minimisation"),
    ("mta", Heuristic::Mta, "Maximum touching area"),
    (
        "first-fit",
        Heuristic::FirstFit,
        "The first valid placement",
    ),
    ("random", Heuristic::Random, "A valid placement at random"),
];

const ORDERS: [Choice<Order>; 4] = [
    ("balance", Order::Balance, "All together, large items early"),
    (
        "bbox",
        Order::BboxVolume,
        "By decreasing volume of the bounding box",
    ),
    ("arrival", Order::Arrival, "As they arrived"),
    ("shuffled", Order::Shuffled, "In random order"),
];

const STABILITIES: [Choice<Stability>; 3] = [
    (
        "physical",
        Stability::Physical,
        "On the real surfaces, in metres",
    ),
    ("published", Stability::Published, "The paper's"),
    ("none", Stability::None, "None: only the fit is checked"),
];

/// Parses the name of a stability test.
pub fn parse_stability() -> impl TypedValueParser<Value = Stability> {
    one_of(&STABILITIES)
}

impl MethodOptions {
    /// The method with the first of these sources of proposals, by default that which suits the conditions, for items in so
    /// many poses.
    pub(crate) fn method(
        &self,
        sources: &[ProposalSource],
        conditions: Conditions,
        poses: u32,
    ) -> Outcome<Method> {
        let first = sources.first().cloned();
        let usual = conditions.usual();
        let preset = self.objective.map(Objective::weights);
        let preset = preset.unwrap_or_else(|| (usual.weights)(poses as usize));
        let look_ahead = LookAheadSettings {
            futures: self.futures as usize,
            ..LookAheadSettings::default()
        };
        look_ahead.validate().or_input()?;
        let scene_value = SceneValue {
            weight: self.scene_value.unwrap_or(usual.scene_value.weight),
            ..usual.scene_value
        };
        scene_value.validate().or_input()?;
        let arm_time = ArmTime {
            litres_per_s: self.litres_per_second,
            ..ArmTime::default()
        };
        arm_time.validate(scene_value.weight).or_input()?;
        Ok(Method {
            heuristic: self.heuristic,
            order: self.order,
            proposals: first.unwrap_or(ProposalSource::Bounded),
            stability: self.stability.unwrap_or(usual.stability),
            trial: self.trial.settings(conditions)?,
            loads: self.loads.settings()?,
            weights: weights(preset, &self.weights)?,
            scene_value,
            look_ahead,
            arm_time,
            buffer: self.buffer as usize,
            seed: self.seed,
        })
    }
}

fn weights(preset: Weights, assignments: &[String]) -> Outcome<Weights> {
    let mut named = match serde_json::to_value(preset).or_input()? {
        serde_json::Value::Object(named) => named,
        _ => serde_json::Map::new(),
    };
    for assignment in assignments {
        let wrong = |why: &str| {
            let names: Vec<&str> = named.keys().map(String::as_str).collect();
            Failure::input(format_args!(
                "--weight {assignment}: {why}; give NAME=VALUE with one of {}",
                names.join(", ")
            ))
        };
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(wrong("there is no '='"));
        };
        if !named.contains_key(name) {
            return Err(wrong("there is no such weight"));
        }
        let value = value.parse().ok().filter(|value: &f64| value.is_finite());
        let value = value.ok_or_else(|| wrong("the value is no finite number"))?;
        named.insert(name.to_owned(), serde_json::json!(value));
    }
    let weights: Weights = serde_json::from_value(serde_json::Value::Object(named)).or_input()?;
    weights.validate().or_input()?;
    Ok(weights)
}
