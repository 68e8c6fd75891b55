//! Placements.

use ppnpack_packing::kernel::grid::{MAX_CELLS, MAX_UNITS, MAX_YAWS, Units};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::planning::valid::Tally;
use ppnpack_packing::ranking::step::{Evaluated, PlacementCounts};

use super::check;
use crate::error::{WireError, needed};
use crate::limits::{MAX_CANDIDATES, MAX_PLACEMENTS, checked, count, index, to_index};
use crate::v1;

fn candidate(field: &'static str, value: u32) -> Result<usize, WireError> {
    index(field, value, MAX_CANDIDATES)
}

fn cell(field: &'static str, yaw: u32, x: u32, y: u32) -> Result<Placement, WireError> {
    Ok(Placement {
        yaw: index(field, yaw, MAX_YAWS)?,
        x: index(field, x, MAX_CELLS)?,
        y: index(field, y, MAX_CELLS)?,
    })
}

/// Reads the placements that a field holds in columns. Whether they lie within a container is not
/// checked.
///
/// # Errors
/// [`WireError`] where the columns differ in length, are too long, or hold an index that no grid
/// has.
pub fn read_all(
    field: &'static str,
    message: &v1::Placements,
) -> Result<Vec<Placement>, WireError> {
    let v1::Placements { yaw, x, y } = message;
    count(field, yaw.len(), 0..=MAX_PLACEMENTS)?;
    count(field, x.len(), yaw.len()..=yaw.len())?;
    count(field, y.len(), yaw.len()..=yaw.len())?;
    let columns = yaw.iter().zip(x).zip(y);
    let placements = columns.map(|((yaw, x), y)| cell(field, *yaw, *x, *y));
    placements.collect()
}

/// Writes placements in columns.
pub fn write_all(placements: impl Iterator<Item = Placement>) -> v1::Placements {
    let mut columns = v1::Placements::default();
    for Placement { yaw, x, y } in placements {
        columns.yaw.push(to_index(yaw));
        columns.x.push(to_index(x));
        columns.y.push(to_index(y));
    }
    columns
}

/// Reads a placement with its resting height.
///
/// # Errors
/// [`WireError`] where an index or the height is one that no grid has.
pub fn read_resting(message: &v1::RestingPlacement) -> Result<RestingPlacement, WireError> {
    let height = message.resting_height;
    let resting_height = Units::try_from(height).unwrap_or(Units::MAX);
    let range = format_args!("0 to {MAX_UNITS} is possible");
    let is_possible = resting_height <= MAX_UNITS;
    checked("placement.resting_height", height, is_possible, range)?;
    Ok(RestingPlacement {
        placement: cell("placement", message.yaw, message.x, message.y)?,
        resting_height,
    })
}

/// Writes a placement with its resting height.
pub fn write_resting(resting: &RestingPlacement) -> v1::RestingPlacement {
    v1::RestingPlacement {
        yaw: to_index(resting.placement.yaw),
        x: to_index(resting.placement.x),
        y: to_index(resting.placement.y),
        resting_height: u32::try_from(resting.resting_height).unwrap_or(0),
    }
}

/// Reads a placement with its value.
///
/// # Errors
/// [`WireError`] where the placement is missing or impossible, or the value is not finite.
pub fn read_ranked(message: &v1::RankedPlacement) -> Result<Evaluated, WireError> {
    let resting = needed("ranked_placement.placement", message.placement.as_ref())?;
    let (value, possible) = (message.value, "a finite number is needed");
    checked("ranked_placement.value", value, value.is_finite(), possible)?;
    Ok(Evaluated {
        candidate: candidate("ranked_placement.candidate", message.candidate)?,
        resting: read_resting(resting)?,
        value,
    })
}

/// Writes a placement with its value. Its candidate is that of the request, whatever its pose.
pub fn write_ranked(evaluated: &Evaluated) -> v1::RankedPlacement {
    v1::RankedPlacement {
        candidate: to_index(evaluated.candidate),
        placement: Some(write_resting(&evaluated.resting)),
        value: evaluated.value,
        ..v1::RankedPlacement::default()
    }
}

/// Writes a placement with its value, for those to whom items are candidates: the item's index, and
/// that of its pose.
pub fn write_ranked_item(evaluated: &Evaluated, item: usize, pose: usize) -> v1::RankedPlacement {
    v1::RankedPlacement {
        candidate: to_index(item),
        pose: to_index(pose),
        ..write_ranked(evaluated)
    }
}

/// Reads the tally of a candidate's placements.
///
/// # Errors
/// [`WireError`] where the candidate or a check is not possible.
pub fn read_tally(message: &v1::PlacementCounts) -> Result<Tally, WireError> {
    let refusals = message.refusals.iter().map(check::read_refusals);
    Ok(Tally {
        candidate: candidate("placement_counts.candidate", message.candidate)?,
        counts: PlacementCounts {
            possible: message.possible,
            proposed: message.proposed,
            fitting: message.fitting,
        },
        refusals: refusals.collect::<Result<_, _>>()?,
    })
}

/// Writes the tally of a candidate's placements.
pub fn write_tally(tally: &Tally) -> v1::PlacementCounts {
    v1::PlacementCounts {
        candidate: to_index(tally.candidate),
        possible: tally.counts.possible,
        proposed: tally.counts.proposed,
        fitting: tally.counts.fitting,
        refusals: tally.refusals.iter().map(check::write_refusals).collect(),
    }
}
