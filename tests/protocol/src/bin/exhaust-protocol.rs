//! Goes through the protocol of a cell for as long as it is given, and says as Markdown what it went through.

use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use clap::Parser;
use ppnpack_protocol_tests::exhaust::exhaust;
use ppnpack_protocol_tests::shrink::{shrink, written};
use ppnpack_protocol_tests::wander::wander;
use ppnpack_protocol_tests::{Action, Configuration};

/// Steps of a random way at most.
const MOST_STEPS: usize = 200;

/// Exhausts small worlds, and goes random ways through large ones until the time is over.
#[derive(Debug, Parser)]
struct Arguments {
    /// How long, in minutes; the small worlds take some of it, whatever it is
    #[arg(long, value_name = "COUNT", default_value_t = 60)]
    minutes: u64,

    /// The first seed of the random ways
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let end = Instant::now() + Duration::from_secs(60 * arguments.minutes);
    let is_kept = exhaust_small() & wander_large(end, arguments.seed);
    match is_kept {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

/// Says whether every promise is kept in the small worlds.
fn exhaust_small() -> bool {
    println!("| small world | different states | steps | longest way | time |");
    println!("|---|---|---|---|---|");
    let mut is_kept = true;
    for configuration in Configuration::small() {
        let began = Instant::now();
        let found = exhaust(&configuration, Duration::from_secs(600), threads());
        println!(
            "| {} | {} | {} | {} | {:.1} s{} |",
            configuration.name,
            found.worlds,
            found.steps,
            found.depth,
            began.elapsed().as_secs_f64(),
            if found.is_complete { "" } else { ", cut off" }
        );
        is_kept &= found.is_complete && is_told(found.broken.as_deref(), &configuration);
    }
    is_kept
}

/// Says whether every promise is kept on random ways through the large worlds until the time is over.
fn wander_large(end: Instant, first_seed: u64) -> bool {
    let large = Configuration::large();
    let count = u32::try_from(large.len()).unwrap_or(1);
    println!("\n| large world | random ways | steps | all packed at the end |");
    println!("|---|---|---|---|");
    let mut is_kept = true;
    for (number, configuration) in (0_u32..).zip(&large) {
        let left = end.saturating_duration_since(Instant::now());
        let until = Instant::now() + left / (count - number);
        let workers = threads() as u64;
        let walked = thread::scope(|scope| {
            let walkers = (0..workers).map(|worker| {
                let seeds = (first_seed + worker..).step_by(threads());
                scope.spawn(move || walk(configuration, seeds, until))
            });
            let walkers: Vec<_> = walkers.collect();
            let walked = walkers.into_iter().filter_map(|walker| walker.join().ok());
            walked.fold(Walked::default(), Walked::and)
        });
        let Walked {
            ways,
            steps,
            packed,
            broken,
        } = walked;
        println!("| {} | {ways} | {steps} | {packed} |", configuration.name);
        is_kept &= is_told(broken.as_deref(), configuration);
    }
    is_kept
}

#[derive(Debug, Default)]
struct Walked {
    ways: u64,
    steps: u64,
    packed: u64,
    broken: Option<Vec<Action>>,
}

impl Walked {
    fn and(self, other: Self) -> Self {
        Self {
            ways: self.ways + other.ways,
            steps: self.steps + other.steps,
            packed: self.packed + other.packed,
            broken: self.broken.or(other.broken),
        }
    }
}

/// Random ways until the time is over, or one breaks a promise.
fn walk(
    configuration: &Configuration,
    mut seeds: impl Iterator<Item = u64>,
    until: Instant,
) -> Walked {
    let mut walked = Walked::default();
    while let Some(seed) = seeds.next().filter(|_| Instant::now() < until) {
        let way = wander(configuration, seed, MOST_STEPS);
        walked.ways += 1;
        walked.steps += way.story.len() as u64;
        walked.packed += u64::from(way.packs);
        if way.broken.is_some() {
            walked.broken = Some(way.story);
            break;
        }
    }
    walked
}

/// Tells the shortest story of a broken promise; says whether there is none to tell.
fn is_told(broken: Option<&[Action]>, configuration: &Configuration) -> bool {
    if let Some(story) = broken {
        let story = shrink(story, configuration);
        eprintln!("{}: broken by {}", configuration.name, written(&story));
    }
    broken.is_none()
}

fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
