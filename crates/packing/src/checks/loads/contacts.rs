//! Contacts of an underside, and how they share the weight above.

use nalgebra::Point2;

use super::bearing::bearing_shares;
use super::stack::Shares;

/// Tolerances beyond the least gap, in metres, of which the first counts with which the item
/// stands: meshes are exact, but simulated bodies touch by their convex pieces.
const TOLERANCES_M: [f32; 6] = [0.001, 0.002, 0.004, 0.008, 0.016, WIDEST_M];

/// Maximum gap of a contact, in metres.
const WIDEST_M: f32 = 0.032;

#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// How far the one is above the other, in metres; only differences count.
    pub(super) gap_m: f32,
    pub(super) at: Point2<f64>,
    /// Solid below; `None` for the floor.
    pub(super) on: Option<usize>,
}

/// Gives the shares of the solids that bear an item with this underside; the floor bears the rest.
pub(super) fn shares(gaps: &[Gap], centre_of_mass: &Point2<f64>) -> Shares {
    let least_m = gaps
        .iter()
        .fold(f32::INFINITY, |least_m, gap| least_m.min(gap.gap_m));
    for tolerance_m in TOLERANCES_M {
        let touching = gaps.iter().filter(|gap| gap.gap_m <= least_m + tolerance_m);
        let touching: Vec<&Gap> = touching.collect();
        let contacts: Vec<Point2<f64>> = touching.iter().map(|gap| gap.at).collect();
        if let Some(parts) = bearing_shares(&contacts, centre_of_mass) {
            return by_item(touching.into_iter().zip(parts));
        }
    }
    // It would tip, or leans on what is not seen from above: the contact nearest its middle takes
    // all.
    let touching = gaps.iter().filter(|gap| gap.gap_m <= least_m + WIDEST_M);
    let nearest = touching.min_by(|one, other| {
        let far = |gap: &Gap| (gap.at - centre_of_mass).norm_squared();
        far(one).total_cmp(&far(other))
    });
    by_item(nearest.into_iter().map(|gap| (gap, 1.0)))
}

fn by_item<'a>(parts: impl Iterator<Item = (&'a Gap, f64)>) -> Shares {
    let mut shares = Shares::new();
    for (gap, part) in parts {
        if let Some(on) = gap.on.filter(|_| part > 0.0) {
            *shares.entry(on).or_default() += part;
        }
    }
    shares
}
