//! Losses, which training minimises, and ranks of scores.

use tch::{Kind, Reduction, TchError, Tensor};

use ppnpack_model::accuracy::Rank;
use ppnpack_model::settings::{Loss, LossOver, TrainingSettings};

use super::batch::Labels;

/// Stands for minus infinity where a difference is still formed.
const LOWEST: f64 = -1e9;

/// Gives the loss of `scores`, `[N, R, L]`, as a number on their device.
pub(crate) fn loss(
    scores: &Tensor,
    labels: &Labels,
    settings: &TrainingSettings,
) -> Result<Tensor, TchError> {
    let weights = weights(labels, settings)?;
    match settings.loss {
        Loss::Ranking => ranking(scores, labels, &weights, settings.margin),
        Loss::Mse => regression(scores, labels, &weights),
    }
}

/// Gives the weight of each placement, `[N, R, L]`.
fn weights(labels: &Labels, settings: &TrainingSettings) -> Result<Tensor, TchError> {
    let fits = labels.fits.f_to_kind(Kind::Float)?;
    match settings.loss_over {
        LossOver::Fitting => Ok(fits),
        LossOver::All => {
            let misfits = labels.inside.f_logical_and(&labels.fits.f_logical_not()?)?;
            let misfits = misfits.f_to_kind(Kind::Float)?;
            fits.f_add(&misfits.f_mul_scalar(settings.misfit_weight)?)
        }
    }
}

/// Gives `(sum_r L_loc(r) + L_glo) / |P|`, the mean over the candidates that have an optimum; where
/// several placements are optimal, all of them are to rank above the rest.
fn ranking(
    scores: &Tensor,
    labels: &Labels,
    weights: &Tensor,
    margin: f64,
) -> Result<Tensor, TchError> {
    let over_cells = [2_i64];
    let over_all = [1_i64, 2];
    let local = hinge(scores, weights, &labels.optimal, &over_cells, margin)?;
    let global = hinge(scores, weights, &labels.best, &over_all, 2.0 * margin)?;
    let counted = has_optimum(labels)?.f_sum(Kind::Float)?.f_clamp_min(1.0)?;
    let mean = local.f_add(&global)?.f_div(&counted)?;
    mean.f_div_scalar(labels.possible as f64)
}

/// Gives `sum w(p) max(0, margin - (M(p) - M(p*)))` over the placements that are not optimal, by
/// their weights; `p*` is the worst-scored optimum among those over which `group` runs. Groups
/// without an optimum do not count.
fn hinge(
    scores: &Tensor,
    weights: &Tensor,
    optimal: &Tensor,
    group: &[i64],
    margin: f64,
) -> Result<Tensor, TchError> {
    let others = weights.f_masked_fill(optimal, 0.0)?;
    let worst = scores.f_masked_fill(&optimal.f_logical_not()?, LOWEST)?;
    let worst = worst.f_amax(group, true)?;
    // Without an optimum the difference is a billion, so nothing is left.
    let violation = worst.f_sub(scores)?.f_add_scalar(margin)?.f_relu()?;
    violation.f_mul(&others)?.f_sum(Kind::Float)
}

/// Gives the mean squared difference to the targets, over the placements by their weights; those
/// that do not fit have the target at which all are cut off.
fn regression(scores: &Tensor, labels: &Labels, weights: &Tensor) -> Result<Tensor, TchError> {
    let Some(values) = &labels.values else {
        let what = "the data has no values to regress to".to_owned();
        return Err(TchError::Shape(what));
    };
    let squares = scores.f_mse_loss(values, Reduction::None)?;
    let has_optimum = has_optimum(labels)?.f_view([-1, 1, 1])?;
    let counted = weights.f_mul(&has_optimum.f_to_kind(Kind::Float)?)?;
    let sum = squares.f_mul(&counted)?.f_sum(Kind::Float)?;
    sum.f_div(&counted.f_sum(Kind::Float)?.f_clamp_min(1.0)?)
}

/// Says whether a candidate has a valid placement, `[N]`.
fn has_optimum(labels: &Labels) -> Result<Tensor, TchError> {
    labels.best.f_flatten(1, -1)?.f_any_dim(1, false)
}

/// Gives the rank of each candidate's best-scored optimum; none where it has no optimum.
pub(crate) fn ranks(scores: &Tensor, labels: &Labels) -> Result<Vec<Option<Rank>>, TchError> {
    let scores = scores.f_flatten(1, -1)?;
    let is_best = labels.best.f_flatten(1, -1)?;
    let is_other = is_best.f_logical_not()?;
    let of_best = scores.f_masked_fill(&is_other, f64::INFINITY)?;
    let of_best = of_best.f_amin([1_i64].as_slice(), true)?;
    let before = scores.f_le_tensor(&of_best)?.f_logical_and(&is_other)?;
    let count = |mask: &Tensor| {
        let counts = mask.f_sum_dim_intlist([1_i64].as_slice(), false, Kind::Int64)?;
        Vec::<i64>::try_from(counts.f_to(tch::Device::Cpu)?)
    };
    let fits = labels.fits.f_flatten(1, -1)?;
    let inside = labels.inside.f_expand_as(&labels.fits)?.f_flatten(1, -1)?;
    let all_before = count(&before.f_logical_and(&inside)?)?;
    let fitting_before = count(&before.f_logical_and(&fits)?)?;
    let fitting = count(&fits)?;
    let has_optimum = count(&is_best)?.into_iter().map(|optima| optima > 0);
    let counts = all_before.into_iter().zip(fitting_before).zip(fitting);
    let ranks = counts.map(|((before, fitting_before), fitting)| Rank {
        placements: labels.possible,
        fitting: fitting as u64,
        before: before as u64,
        fitting_before: fitting_before as u64,
    });
    let ranks = ranks.zip(has_optimum);
    Ok(ranks
        .map(|(rank, has_optimum)| has_optimum.then_some(rank))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One candidate, two yaws, three cells and one of padding; the optima are yaw 0 cell 0 and yaw
    /// 1 cell 2, the first one best. At yaw 0, cell 2 does not fit.
    fn labels() -> Labels {
        Labels {
            inside: Tensor::from_slice(&[true, true, true, false]).view([1, 1, 4]),
            fits: mask([true, true, false, false, true, true, true, false]),
            optimal: mask([true, false, false, false, false, false, true, false]),
            best: mask([true, false, false, false, false, false, false, false]),
            values: Some(scores([0.0, 1.0, 9.0, 9.0, 2.0, 3.0, 0.5, 9.0])),
            possible: 6,
        }
    }

    fn mask(values: [bool; 8]) -> Tensor {
        Tensor::from_slice(&values).view([1, 2, 4])
    }

    fn scores(values: [f32; 8]) -> Tensor {
        Tensor::from_slice(&values).view([1, 2, 4])
    }

    /// The loss of scores with a margin of 1.
    fn of(scores: &Tensor, labels: &Labels, kind: Loss, over: LossOver) -> f64 {
        weighted(scores, labels, kind, over, 1.0)
    }

    fn weighted(
        scores: &Tensor,
        labels: &Labels,
        kind: Loss,
        over: LossOver,
        misfit_weight: f64,
    ) -> f64 {
        let settings = TrainingSettings {
            loss: kind,
            loss_over: over,
            misfit_weight,
            margin: 1.0,
            ..TrainingSettings::default()
        };
        loss(scores, labels, &settings).unwrap().double_value(&[])
    }

    /// The paper's loss, placement by placement: `(sum_r L_loc(r) + L_glo) / |P|`.
    fn plain_ranking(scores: &Tensor, labels: &Labels, over: LossOver) -> f64 {
        let flat = |tensor: &Tensor| Vec::<bool>::try_from(tensor.flatten(0, -1)).unwrap();
        let scores = Vec::<f32>::try_from(scores.flatten(0, -1)).unwrap();
        let inside = flat(&labels.inside);
        let (fits, optimal, best) = (
            flat(&labels.fits),
            flat(&labels.optimal),
            flat(&labels.best),
        );
        let sum = |placements: std::ops::Range<usize>, optima: &[bool], margin: f64| {
            let of_optima = placements.clone().filter(|at| optima[*at]);
            let worst = of_optima.map(|at| f64::from(scores[at])).reduce(f64::max);
            let Some(worst) = worst else { return 0.0 };
            let counted = placements.filter(|at| match over {
                LossOver::All => inside[at % inside.len()] && !optima[*at],
                LossOver::Fitting => fits[*at] && !optima[*at],
            });
            counted
                .map(|at| (margin - (f64::from(scores[at]) - worst)).max(0.0))
                .sum()
        };
        let length = inside.len();
        let yaws = (0..scores.len()).step_by(length);
        let local: f64 = yaws
            .map(|first| sum(first..first + length, &optimal, 1.0))
            .sum();
        (local + sum(0..scores.len(), &best, 2.0)) / labels.possible as f64
    }

    #[test]
    fn the_ranking_loss_is_that_of_the_paper() {
        let scores = scores([0.0, 0.5, -9.0, -9.0, 1.5, 0.75, 1.0, -9.0]);
        let loss = |over| of(&scores, &labels(), Loss::Ranking, over);
        // Yaw 0: cell 1 is 0.5 above, 0.5 short; cell 2 does not fit. Yaw 1: 0.5 short and 1.25
        // short.
        let local = 0.5 + (0.5 + 1.25);
        // All: margins of 2 against the best.
        let global = 1.5 + 0.5 + 1.25 + 1.0;
        assert!((loss(LossOver::Fitting) - (local + global) / 6.0).abs() < 1e-6);
        // Over all, what does not fit is to rank behind as well: it is 9 below, so 10 and 11 short.
        // Padding never counts.
        assert!((loss(LossOver::All) - (local + global + 10.0 + 11.0) / 6.0).abs() < 1e-6);
    }

    #[test]
    fn the_ranking_loss_agrees_with_the_sums_placement_by_placement() {
        tch::manual_seed(3);
        for _ in 0..50 {
            let scores = Tensor::randn([1, 2, 4], (Kind::Float, tch::Device::Cpu)) * 2.0;
            for over in [LossOver::All, LossOver::Fitting] {
                let expected = plain_ranking(&scores, &labels(), over);
                let found = of(&scores, &labels(), Loss::Ranking, over);
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{over:?}: {found}, {expected}"
                );
            }
        }
    }

    #[test]
    fn what_does_not_fit_counts_by_its_weight() {
        let scores = scores([0.0, 0.5, -9.0, -9.0, 1.5, 0.75, 1.0, -9.0]);
        for kind in [Loss::Ranking, Loss::Mse] {
            let of_misfits = |weight| weighted(&scores, &labels(), kind, LossOver::All, weight);
            let bounds = [LossOver::Fitting, LossOver::All];
            let [fitting, all] = bounds.map(|over| of(&scores, &labels(), kind, over));
            assert!((of_misfits(0.0) - fitting).abs() < 1e-6);
            assert!((of_misfits(1.0) - all).abs() < 1e-5);
            // Regression is a mean by weights: of six placements one counts for a quarter.
            let quarter = match kind {
                Loss::Ranking => 0.75 * fitting + 0.25 * all,
                Loss::Mse => (0.75 * 5.0 * fitting + 0.25 * 6.0 * all) / 5.25,
            };
            assert!((of_misfits(0.25) - quarter).abs() < 1e-5, "{kind:?}");
        }
    }

    #[test]
    fn equal_optima_all_rank_above_the_rest() {
        let mut labels = labels();
        labels.best = mask([true, false, false, false, false, false, true, false]);
        let scores = scores([0.0, 9.0, 0.0, 0.0, 9.0, 9.0, 8.0, 0.0]);
        let loss = of(&scores, &labels, Loss::Ranking, LossOver::Fitting);
        // The worst-scored optimum counts: three others are 1 short of the margin of 2.
        assert!((loss - 3.0 / 6.0).abs() < 1e-6);
    }

    #[test]
    fn candidates_without_an_optimum_do_not_count() {
        let mut labels = labels();
        labels.best = labels.best.logical_and(&Tensor::from(false));
        labels.optimal = labels.best.shallow_clone();
        let scores = scores([1.0; 8]);
        for kind in [Loss::Ranking, Loss::Mse] {
            for over in [LossOver::All, LossOver::Fitting] {
                assert_eq!(of(&scores, &labels, kind, over), 0.0);
            }
        }
        assert_eq!(ranks(&scores, &labels).unwrap(), [None]);
    }

    #[test]
    fn a_rank_counts_what_is_scored_as_well_or_better() {
        let ranked = |values| {
            let ranks = ranks(&scores(values), &labels()).unwrap();
            let [Some(rank)] = ranks.as_slice() else {
                panic!("{ranks:?}");
            };
            assert_eq!((rank.placements, rank.fitting), (6, 5));
            (rank.before, rank.fitting_before)
        };
        // What does not fit is scored best; padding, scored better still, is no placement.
        assert_eq!(
            ranked([0.0, 0.5, -9.0, -10.0, 1.5, 0.75, 1.0, -10.0]),
            (1, 0)
        );
        assert_eq!(
            ranked([0.75, 0.5, 1.0, -10.0, 1.5, 0.75, 1.0, -10.0]),
            (2, 2)
        );
    }

    #[test]
    fn regression_counts_what_does_not_fit_where_it_is_over_all() {
        let scores = scores([0.0, 1.0, 0.0, 0.0, 2.0, 3.0, 1.5, 0.0]);
        let loss = |over| of(&scores, &labels(), Loss::Mse, over);
        assert!((loss(LossOver::Fitting) - 1.0 / 5.0).abs() < 1e-6);
        assert!((loss(LossOver::All) - (1.0 + 81.0) / 6.0).abs() < 1e-5);
    }
}
