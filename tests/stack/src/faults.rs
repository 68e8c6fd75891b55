//! Faults at random, while a stack packs.

use std::collections::BTreeMap;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use ppnpack_wire::v1;
use rand::RngExt;
use rand::seq::IndexedRandom;
use serde::Serialize;

use crate::cell::CellClient;
use crate::{Signal, Stack};

/// How long a process is stopped, or a cell held, at most.
const LONGEST: Duration = Duration::from_secs(3);

/// What is done to a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Fault {
    /// A process is killed and started again.
    Kill,
    /// All processes are killed at once and started again.
    KillAll,
    /// A process is stopped for a while.
    Stop,
    /// A cell is held for a while, and somebody has a hand in it.
    Hold,
}

/// How often something was done, and how long after its end fresh requests to all services succeeded at the latest.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Recovered {
    /// How often.
    pub count: usize,
    /// The longest, in seconds.
    pub longest_s: f64,
}

/// What was done to a stack, and to whom.
pub type Faults = BTreeMap<String, Recovered>;

/// Does something to a stack, and waits until it serves again.
///
/// # Errors
/// Where it does not.
pub fn strike(stack: &mut Stack, cells: &[CellClient], faults: &mut Faults) -> Result<()> {
    let mut random = rand::rng();
    let kinds = [
        (Fault::Kill, 10),
        (Fault::Stop, 6),
        (Fault::Hold, 4),
        (Fault::KillAll, 1),
    ];
    let names: Vec<String> = stack.names().map(str::to_owned).collect();
    let (fault, _) = kinds.choose_weighted(&mut random, |(_, weight)| *weight)?;
    let name = names
        .choose(&mut random)
        .context("there are no processes")?;
    let span = LONGEST.mul_f64(random.random_range(0.1..1.0));
    let what = match fault {
        Fault::Kill => {
            stack.signal(name, Signal::Kill)?;
            stack.restart(name)?;
            format!("{name} killed")
        }
        Fault::KillAll => {
            for name in &names {
                stack.signal(name, Signal::Kill)?;
            }
            for name in &names {
                stack.restart(name)?;
            }
            "all killed at once".to_owned()
        }
        Fault::Stop => {
            stack.signal(name, Signal::Stop)?;
            thread::sleep(span);
            stack.signal(name, Signal::Continue)?;
            format!("{name} stopped")
        }
        Fault::Hold => {
            let cell = cells.choose(&mut random).context("there are no cells")?;
            hold(cell, span)?;
            "a cell held, a hand in it".to_owned()
        }
    };
    let ended = Instant::now();
    for cell in cells {
        cell.session()?;
        cell.state()?;
        cell.ask(v1::HeightmapRequest::default())?;
    }
    let recovered = faults.entry(what).or_default();
    recovered.count += 1;
    recovered.longest_s = recovered.longest_s.max(ended.elapsed().as_secs_f64());
    Ok(())
}

/// Holds a cell for a while, waits until its robot stands, says that there was a hand in it, and lets it go on.
fn hold(cell: &CellClient, span: Duration) -> Result<()> {
    let hold = v1::HoldRequest {
        reason: "a hand is in the cell".to_owned(),
        ..v1::HoldRequest::default()
    };
    cell.ask(hold)?;
    while !cell.state()?.executing_placement_id.is_empty() {
        thread::sleep(Duration::from_millis(20));
    }
    thread::sleep(span);
    cell.patiently(|cell| Ok(cell.ask(v1::ChangedRequest::default())?))?;
    cell.ask(v1::ResumeRequest::default())?;
    Ok(())
}
