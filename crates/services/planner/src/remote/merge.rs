//! What several searched, together.

use ppnpack_packing::step::Evaluated;
use ppnpack_packing::valid::{BestValid, Tally};

/// The best `limit` of what several found, in the order of the search: by value, candidate, yaw, x, y.
pub(crate) fn merge(found: Vec<BestValid>, limit: usize) -> BestValid {
    let mut merged = BestValid {
        is_complete: true,
        ..BestValid::default()
    };
    for best in found {
        merged.is_complete &= best.is_complete;
        merged.placements.extend(best.placements);
        for tally in best.tallies {
            add_tally(&mut merged.tallies, tally);
        }
    }
    merged.placements.sort_by(|a, b| {
        let key = |found: &Evaluated| (found.candidate, found.resting.placement);
        a.value
            .total_cmp(&b.value)
            .then_with(|| key(a).cmp(&key(b)))
    });
    if merged.placements.len() > limit {
        merged.placements.truncate(limit);
        merged.is_complete = false;
    }
    merged
}

fn add_tally(tallies: &mut Vec<Tally>, tally: Tally) {
    let Some(sum) = tallies
        .iter_mut()
        .find(|sum| sum.candidate == tally.candidate)
    else {
        tallies.push(tally);
        return;
    };
    sum.counts.possible += tally.counts.possible;
    sum.counts.proposed += tally.counts.proposed;
    sum.counts.fitting += tally.counts.fitting;
    for (check, count) in tally.refusals {
        match sum.refusals.iter_mut().find(|(name, _)| *name == check) {
            Some((_, sum)) => *sum += count,
            None => sum.refusals.push((check, count)),
        }
    }
}
