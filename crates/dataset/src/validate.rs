//! Checks that a record is one that the expert can have made.

use std::sync::Arc;

use ppnpack_packing::kernel::grid::{Grid, MAX_UNITS};
use ppnpack_packing::kernel::item::Item;

use crate::record::{CandidateRecord, Corner, StepRecord, YawOptima};
use crate::settings::Settings;
use crate::values::offsets;

/// Checks the step with an index within a sequence; gives what is wrong.
pub(crate) fn step(
    settings: &Settings,
    items: &[Arc<Item>],
    sequence: u32,
    index: usize,
    step: &StepRecord,
) -> Result<(), String> {
    let refuse = |what: String| Err(format!("step {index} of sequence {sequence}: {what}"));
    if (step.sequence, step.step as usize) != (sequence, index) || index >= settings.length as usize
    {
        return refuse("its numbers are wrong".to_owned());
    }
    let cells = settings.grid.nx() * settings.grid.ny();
    let heights = step.heightmap.len();
    if heights != cells {
        return refuse(format!("it has {heights} heights instead of {cells}"));
    }
    let wrong = |height: &&i16| !(0..=MAX_UNITS).contains(*height);
    if let Some(height) = step.heightmap.iter().find(wrong) {
        return refuse(format!(
            "the height {height} is not within 0 and {MAX_UNITS}"
        ));
    }
    let (found, most) = (step.candidates.len(), settings.expert.buffer as usize);
    if !(1..=most).contains(&found) {
        return refuse(format!(
            "it has {found} candidates, and 1 to {most} are possible"
        ));
    }
    step.candidates
        .iter()
        .try_for_each(|found| candidate(&settings.grid, items, found))
        .or_else(refuse)
}

fn candidate(grid: &Grid, items: &[Arc<Item>], candidate: &CandidateRecord) -> Result<(), String> {
    let object = candidate.object;
    let Some(item) = items.get(object as usize) else {
        return Err(format!("there is no object {object}"));
    };
    if candidate.yaws.len() != item.views().len() {
        return Err(format!("object {object} has {} yaws", candidate.yaws.len()));
    }
    for (view, optima) in item.views().iter().zip(&candidate.yaws) {
        yaw(offsets(grid, view), optima).map_err(|what| format!("object {object}: {what}"))?;
    }
    Ok(())
}

/// Checks the optima of a view with this many placements along x and y.
fn yaw((nx, ny): (usize, usize), optima: &YawOptima) -> Result<(), String> {
    let YawOptima { value, placements } = optima;
    let has_value = if placements.is_empty() {
        *value == f64::INFINITY
    } else {
        value.is_finite()
    };
    if !has_value {
        let count = placements.len();
        return Err(format!("{count} placements cannot have the value {value}"));
    }
    if !placements.is_sorted_by(|a, b| a < b) {
        return Err("its placements are out of order".to_owned());
    }
    let is_outside = |corner: &&Corner| usize::from(corner.x) >= nx || usize::from(corner.y) >= ny;
    match placements.iter().find(is_outside) {
        Some(Corner { x, y }) => Err(format!("its placement ({x}, {y}) is not possible")),
        None => Ok(()),
    }
}
