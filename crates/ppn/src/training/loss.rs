//! What training minimises, and how good scores are.

use tch::{Kind, Reduction, TchError, Tensor};

use ppnpack_model::settings::Loss;

use super::batch::Labels;

/// Stands for minus infinity where a difference is still formed.
const LOWEST: f64 = -1e9;

/// The loss of `scores`, `[N, R, L]`, as a number on their device.
pub(crate) fn loss(
    scores: &Tensor,
    labels: &Labels,
    kind: Loss,
    margin: f64,
) -> Result<Tensor, TchError> {
    match kind {
        Loss::Ranking => ranking(scores, labels, margin),
        Loss::Mse => regression(scores, labels),
    }
}

/// `(sum_r L_loc(r) + L_glo) / |P|`, the mean over the candidates that have an optimum; where several placements are
/// optimal, all of them are to rank above the rest.
fn ranking(scores: &Tensor, labels: &Labels, margin: f64) -> Result<Tensor, TchError> {
    let over_cells = [2_i64];
    let over_all = [1_i64, 2];
    let local = hinge(scores, &labels.fits, &labels.optimal, &over_cells, margin)?;
    let global = hinge(scores, &labels.fits, &labels.best, &over_all, 2.0 * margin)?;
    let counted = has_optimum(labels)?.f_sum(Kind::Float)?.f_clamp_min(1.0)?;
    let mean = local.f_add(&global)?.f_div(&counted)?;
    mean.f_div_scalar(labels.possible)
}

/// `sum max(0, margin - (M(p) - M(p*)))` over the fitting placements that are not optimal; `p*` is the worst-scored
/// optimum among those over which `group` runs. Groups without an optimum do not count.
fn hinge(
    scores: &Tensor,
    fits: &Tensor,
    optimal: &Tensor,
    group: &[i64],
    margin: f64,
) -> Result<Tensor, TchError> {
    let others = fits.f_logical_and(&optimal.f_logical_not()?)?;
    let worst = scores.f_masked_fill(&optimal.f_logical_not()?, LOWEST)?;
    let worst = worst.f_amax(group, true)?;
    // Without an optimum the difference is a billion, so nothing is left.
    let violation = worst.f_sub(scores)?.f_add_scalar(margin)?.f_relu()?;
    violation
        .f_mul(&others.f_to_kind(Kind::Float)?)?
        .f_sum(Kind::Float)
}

/// The mean squared difference to the heuristic's values above the candidate's optimum.
fn regression(scores: &Tensor, labels: &Labels) -> Result<Tensor, TchError> {
    let Some(values) = &labels.values else {
        let what = "the data has no values to regress to".to_owned();
        return Err(TchError::Shape(what));
    };
    let squares = scores.f_mse_loss(values, Reduction::None)?;
    let has_optimum = has_optimum(labels)?.f_view([-1, 1, 1])?;
    let counted = labels.fits.f_logical_and(&has_optimum)?;
    let counted = counted.f_to_kind(Kind::Float)?;
    let sum = squares.f_mul(&counted)?.f_sum(Kind::Float)?;
    sum.f_div(&counted.f_sum(Kind::Float)?.f_clamp_min(1.0)?)
}

/// `[N]`: whether a candidate has a valid placement.
fn has_optimum(labels: &Labels) -> Result<Tensor, TchError> {
    labels.best.f_flatten(1, -1)?.f_any_dim(1, false)
}

/// For each candidate with an optimum: how many placements that are none score at least as well as its best-scored one.
pub(crate) fn ranks(scores: &Tensor, labels: &Labels) -> Result<Vec<i64>, TchError> {
    let scores = scores.f_flatten(1, -1)?;
    let (fits, best) = (labels.fits.f_flatten(1, -1)?, labels.best.f_flatten(1, -1)?);
    let others = fits.f_logical_and(&best.f_logical_not()?)?;
    let of_best = scores.f_masked_fill(&best.f_logical_not()?, f64::INFINITY)?;
    let of_best = of_best.f_amin([1_i64].as_slice(), true)?;
    let before = scores.f_le_tensor(&of_best)?.f_logical_and(&others)?;
    let ranks = before.f_sum_dim_intlist([1_i64].as_slice(), false, Kind::Int64)?;
    let counted = ranks.f_masked_select(&has_optimum(labels)?)?;
    Vec::<i64>::try_from(counted.f_to(tch::Device::Cpu)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One candidate, two yaws, three cells; the optima are yaw 0 cell 0 and yaw 1 cell 2, the first one best.
    fn labels() -> Labels {
        let mask = |values: [bool; 6]| Tensor::from_slice(&values).view([1, 2, 3]);
        Labels {
            fits: mask([true, true, false, true, true, true]),
            optimal: mask([true, false, false, false, false, true]),
            best: mask([true, false, false, false, false, false]),
            values: Some(Tensor::from_slice(&[0.0_f32, 1.0, 9.0, 2.0, 3.0, 0.5]).view([1, 2, 3])),
            possible: 6.0,
        }
    }

    fn scores(values: [f32; 6]) -> Tensor {
        Tensor::from_slice(&values).view([1, 2, 3])
    }

    #[test]
    fn the_ranking_loss_is_that_of_the_paper() {
        let scores = scores([0.0, 0.5, -9.0, 1.5, 0.75, 1.0]);
        let loss = loss(&scores, &labels(), Loss::Ranking, 1.0).unwrap();
        // Yaw 0: cell 1 is 0.5 above, 0.5 short; cell 2 does not fit. Yaw 1: 0.5 short and 1.25 short.
        let local = 0.5 + (0.5 + 1.25);
        // All: margins of 2 against the best.
        let global = 1.5 + 0.5 + 1.25 + 1.0;
        assert!((loss.double_value(&[]) - (local + global) / 6.0).abs() < 1e-6);
    }

    #[test]
    fn equal_optima_all_rank_above_the_rest() {
        let mut labels = labels();
        labels.best = Tensor::from_slice(&[true, false, false, false, false, true]).view([1, 2, 3]);
        let scores = scores([0.0, 9.0, 0.0, 9.0, 9.0, 8.0]);
        let loss = loss(&scores, &labels, Loss::Ranking, 1.0).unwrap();
        // The worst-scored optimum counts: three others are 1 short of the margin of 2.
        assert!((loss.double_value(&[]) - 3.0 / 6.0).abs() < 1e-6);
    }

    #[test]
    fn candidates_without_an_optimum_do_not_count() {
        let mut labels = labels();
        labels.best = labels.best.logical_and(&Tensor::from(false));
        labels.optimal = labels.best.shallow_clone();
        let scores = scores([1.0; 6]);
        for kind in [Loss::Ranking, Loss::Mse] {
            let loss = loss(&scores, &labels, kind, 1.0).unwrap();
            assert_eq!(loss.double_value(&[]), 0.0);
        }
        assert!(ranks(&scores, &labels).unwrap().is_empty());
    }

    #[test]
    fn a_rank_counts_what_is_scored_as_well_or_better() {
        let ranked = |values| ranks(&scores(values), &labels()).unwrap();
        assert_eq!(ranked([0.0, 0.5, -9.0, 1.5, 0.75, 1.0]), [0]);
        assert_eq!(ranked([0.75, 0.5, -9.0, 1.5, 0.75, 1.0]), [2]);
    }

    #[test]
    fn regression_looks_at_fitting_placements_alone() {
        let scores = scores([0.0, 1.0, 0.0, 2.0, 3.0, 1.5]);
        let loss = loss(&scores, &labels(), Loss::Mse, 1.0).unwrap();
        assert!((loss.double_value(&[]) - 1.0 / 5.0).abs() < 1e-6);
    }
}
