//! Objectives.

use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use ppnpack_packing::ranking::search::SearchSettings;

use super::pairs;
use crate::error::{WireError, needed};
use crate::limits::checked;
use crate::v1;

const HEURISTICS: [(v1::Heuristic, Heuristic); 6] = [
    (v1::Heuristic::Sdfm, Heuristic::Sdfm),
    (v1::Heuristic::Dbl, Heuristic::Dbl),
    (v1::Heuristic::Hm, Heuristic::Hm),
    (v1::Heuristic::Mta, Heuristic::Mta),
    (v1::Heuristic::FirstFit, Heuristic::FirstFit),
    (v1::Heuristic::Random, Heuristic::Random),
];

/// Reads the objective of a field. Searches only ask whether the order is balanced: else it is
/// [`Order::Arrival`].
///
/// # Errors
/// [`WireError`] where there is none, the heuristic is not known, or a weight is negative or not
/// finite.
pub fn read_required(
    field: &'static str,
    message: Option<&v1::Objective>,
) -> Result<SearchSettings, WireError> {
    let message = needed(field, message)?;
    let heuristic = pairs::read(&HEURISTICS, &message.heuristic()).ok_or_else(|| {
        let reason = format_args!("{} is no heuristic that is known", message.heuristic);
        WireError::invalid("objective.heuristic", reason)
    })?;
    let weights = message.weights.as_ref();
    let weights = weights.map_or_else(Weights::default, read_weights);
    weights
        .validate()
        .map_err(|error| WireError::invalid("objective.weights", error))?;
    Ok(SearchSettings {
        heuristic,
        order: match message.is_balanced {
            true => Order::Balance,
            false => Order::Arrival,
        },
        weights,
        seed: message.seed,
        above_rim_m: checked(
            "objective.above_rim_m",
            message.above_rim_m,
            (0.0..=1.0).contains(&message.above_rim_m),
            "0 to 1 m are possible",
        )?,
    })
}

fn read_weights(weights: &v1::Weights) -> Weights {
    Weights {
        resting_height: weights.resting_height,
        distance: weights.distance,
        box_share: weights.box_share,
        balance: weights.balance,
        corner: weights.corner,
        surface_volume: weights.surface_volume,
        touching_area: weights.touching_area,
        top_height: weights.top_height,
    }
}

/// Writes an objective.
pub fn write(settings: &SearchSettings) -> v1::Objective {
    let weights = &settings.weights;
    v1::Objective {
        heuristic: pairs::write(&HEURISTICS, &settings.heuristic).into(),
        is_balanced: settings.order == Order::Balance,
        weights: Some(v1::Weights {
            resting_height: weights.resting_height,
            distance: weights.distance,
            box_share: weights.box_share,
            balance: weights.balance,
            corner: weights.corner,
            surface_volume: weights.surface_volume,
            touching_area: weights.touching_area,
            top_height: weights.top_height,
        }),
        seed: settings.seed,
        above_rim_m: settings.above_rim_m,
    }
}
