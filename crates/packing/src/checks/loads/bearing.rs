//! Weight of an item spread over its contacts with what is below.

use nalgebra::{Matrix3, Point2, Vector3};

/// The most steps of Newton's method; some ten are usual.
const STEPS: usize = 100;

/// The most halvings of a step that goes too far.
const HALVINGS: i32 = 60;

/// Contacts that are closer to the centre of mass than this lie right below it, in metres.
const POINT_M: f64 = 1e-9;

/// Maximum imbalance, as a share of the weight for forces, and of weight times size for moments.
const BALANCED: f64 = 1e-6;

/// Stiffness added against turning for contacts on a line or at a point, as a share of that of all.
const STIFFENED: f64 = 1e-8;

/// The share of the weight that each contact bears; `None` where the item does not stand on them.
///
/// The pressure is that of a stiff item on soft ground (Winkler's foundation): linear across the
/// contacts, nowhere below 0, in balance: the lever rule on two narrow supports, the most even of
/// many ways on more than three. Positions are along the floor, in any unit.
pub fn bearing_shares(contacts: &[Point2<f64>], centre_of_mass: &Point2<f64>) -> Option<Vec<f64>> {
    let size_m = contacts.iter().fold(0.0_f64, |size_m, contact| {
        size_m.max((contact - centre_of_mass).amax())
    });
    let is_known = contacts
        .iter()
        .chain([centre_of_mass])
        .all(|at| at.iter().all(|at| at.is_finite()));
    if contacts.is_empty() || !is_known {
        return None;
    }
    if size_m < POINT_M {
        return Some(vec![1.0 / contacts.len() as f64; contacts.len()]);
    }
    let arms: Vec<Vector3<f64>> = contacts
        .iter()
        .map(|contact| {
            let arm = (contact - centre_of_mass) / size_m;
            Vector3::new(1.0, arm.x, arm.y)
        })
        .collect();
    let plane = balanced_plane(&arms)?;
    let shares = arms.iter().map(|arm| pressure(&plane, arm)).collect();
    Some(shares)
}

/// Gives the pressure of a plane at an arm: `max(0, plane . arm)`, as nothing pulls.
fn pressure(plane: &Vector3<f64>, arm: &Vector3<f64>) -> f64 {
    plane.dot(arm).max(0.0)
}

/// The weight: one downwards, and no moment about the centre of mass.
fn weight() -> Vector3<f64> {
    Vector3::new(1.0, 0.0, 0.0)
}

fn unbalanced(plane: &Vector3<f64>, arms: &[Vector3<f64>]) -> Vector3<f64> {
    let borne: Vector3<f64> = arms.iter().map(|arm| arm * pressure(plane, arm)).sum();
    weight() - borne
}

/// Gives the concave potential whose maximum is the balance: the dual of the least squares.
fn potential(plane: &Vector3<f64>, arms: &[Vector3<f64>]) -> f64 {
    let squares: f64 = arms.iter().map(|arm| pressure(plane, arm).powi(2)).sum();
    plane.dot(&weight()) - squares / 2.0
}

/// The plane of pressure that balances the weight, by Newton's method; `None` where it would tip.
fn balanced_plane(arms: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let mut plane = weight() / arms.len() as f64;
    for _ in 0..STEPS {
        let left = unbalanced(&plane, arms);
        if left.amax() < BALANCED {
            return Some(plane);
        }
        let bearing = arms.iter().filter(|arm| plane.dot(arm) > 0.0);
        let (count, stiffness) = bearing.fold((0, Matrix3::zeros()), |(count, sum), arm| {
            (count + 1, sum + arm * arm.transpose())
        });
        // A plane above 0 below the weight alone shows that it lies beside all (Farkas's lemma).
        if count == 0 && plane.dot(&weight()) > 0.0 {
            return None;
        }
        let stiffened = STIFFENED * (arms.len() as f64);
        let step = (stiffness + Matrix3::identity() * stiffened)
            .cholesky()?
            .solve(&left);
        let before = potential(&plane, arms);
        let mut shorter = (0..HALVINGS).map(|halvings| plane + step * 0.5_f64.powi(halvings));
        plane = shorter.find(|next| potential(next, arms) > before)?;
    }
    None
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn shares(contacts: &[(f64, f64)], centre: (f64, f64)) -> Option<Vec<f64>> {
        let contacts: Vec<_> = contacts.iter().map(|(x, y)| Point2::new(*x, *y)).collect();
        bearing_shares(&contacts, &Point2::new(centre.0, centre.1))
    }

    fn assert_near(found: Option<Vec<f64>>, expected: &[f64]) {
        let found = found.unwrap();
        assert_eq!(found.len(), expected.len());
        let far = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(far.fold(0.0, f64::max) < 1e-5, "{found:?}");
    }

    #[test]
    fn two_supports_bear_by_the_lever_rule_and_four_legs_more_where_the_weight_is() {
        let ends = [(0.0, 0.0), (1.0, 0.0)];
        assert_near(shares(&ends, (0.25, 0.0)), &[0.75, 0.25]);
        assert_near(shares(&ends, (0.0, 0.0)), &[1.0, 0.0]);
        let legs = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        assert_near(shares(&legs, (0.5, 0.5)), &[0.25; 4]);
        assert_near(shares(&legs, (0.25, 0.5)), &[0.375, 0.125, 0.375, 0.125]);
        assert_near(shares(&legs, (0.0, 0.0)), &[1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_beam_on_a_row_of_contacts_lifts_off_beyond_its_third() {
        // The textbook's footing: a row of contacts of length 1 with its weight at 0.1 bears on the
        // first 0.3 alone.
        let row: Vec<(f64, f64)> = (0..1000)
            .map(|index| ((f64::from(index) + 0.5) / 1000.0, 0.0))
            .collect();
        let found = shares(&row, (0.1, 0.0)).unwrap();
        let bearing = found.iter().filter(|share| **share > 0.0).count();
        assert!((299..=301).contains(&bearing), "{bearing}");
        // The greatest pressure, at the end, is twice the mean of what bears.
        assert!((found[0] * 300.0 - 2.0).abs() < 0.02, "{}", found[0]);
    }

    #[test]
    fn what_would_tip_has_no_shares() {
        let ends = [(0.0, 0.0), (1.0, 0.0)];
        assert_eq!(shares(&ends, (1.1, 0.0)), None);
        assert_eq!(shares(&ends, (0.5, 0.1)), None);
        assert_eq!(shares(&[], (0.0, 0.0)), None);
        assert_eq!(shares(&ends, (f64::NAN, 0.0)), None);
        assert_near(shares(&[(0.0, 0.0)], (0.0, 0.0)), &[1.0]);
    }

    proptest! {
        #[test]
        fn forces_and_moments_balance_and_nothing_pulls(
            contacts in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64), 1..60),
            weights in prop::collection::vec(0.01..1.0_f64, 60),
        ) {
            // Any mean of the contacts is within their hull.
            let total: f64 = weights.iter().take(contacts.len()).sum();
            let mean = |part: fn(&(f64, f64)) -> f64| {
                let parts = contacts.iter().zip(&weights).map(|(contact, weight)| weight * part(contact));
                parts.sum::<f64>() / total
            };
            let centre = (mean(|at| at.0), mean(|at| at.1));
            let found = shares(&contacts, centre).unwrap();
            prop_assert!(found.iter().all(|share| *share >= 0.0));
            let moment = |part: fn(&(f64, f64)) -> f64| -> f64 {
                found.iter().zip(&contacts).map(|(share, contact)| share * part(contact)).sum()
            };
            prop_assert!((moment(|_| 1.0) - 1.0).abs() < 1e-5);
            prop_assert!((moment(|at| at.0) - centre.0).abs() < 1e-5);
            prop_assert!((moment(|at| at.1) - centre.1).abs() < 1e-5);
        }
    }
}
