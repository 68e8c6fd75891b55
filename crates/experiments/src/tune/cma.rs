//! CMA-ES: minimisation by covariance matrix adaptation.
//!
//! As in Hansen, *The CMA Evolution Strategy: A Tutorial* (arXiv:1604.00772, 2016): weighted recombination, cumulative
//! step-size adaptation, rank-one and rank-mu updates of the covariance, with its default parameters (table 1). Negative
//! recombination weights are left out. Symbols in backquotes are the tutorial's. Points and step sizes have whatever unit
//! the start has; losses may have any, since they are only ranked.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use ppnpack_numbers::gaussian;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The smallest eigenvalue of the covariance, as a share of the greatest.
const LEAST_EIGENVALUE: f64 = 1e-14;

/// The most iterations of one eigendecomposition.
const EIGEN_ITERATIONS: usize = 10_000;

/// A search for the minimum of a function. It follows from the seed and the losses alone.
#[derive(Debug)]
pub(super) struct Cma {
    rates: Rates,
    /// Of the better half of a generation, the best first: `w`.
    weights: Vec<f64>,
    population: usize,
    mean: DVector<f64>,
    sigma: f64,
    /// `C`.
    covariance: DMatrix<f64>,
    /// Its eigenvectors, as columns: `B`.
    axes: DMatrix<f64>,
    /// The square roots of its eigenvalues: `D`.
    lengths: DVector<f64>,
    /// `p_sigma`.
    sigma_path: DVector<f64>,
    /// `p_c`.
    covariance_path: DVector<f64>,
    /// How many generations have been told.
    generations: i32,
    random: ChaCha8Rng,
}

/// The parameters of the tutorial's table 1.
#[derive(Debug, Clone, Copy)]
struct Rates {
    /// `mu_eff`.
    effective: f64,
    /// `c_sigma`.
    sigma_path: f64,
    /// `d_sigma`.
    damping: f64,
    /// `c_c`.
    covariance_path: f64,
    /// `c_1`.
    rank_one: f64,
    /// `c_mu`.
    rank_mu: f64,
    /// How long a standard normal vector is expected to be: `chi_n`.
    normal_length: f64,
}

impl Rates {
    fn new(dimensions: usize, weights: &[f64]) -> Self {
        let n = dimensions as f64;
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let sigma_path = (effective + 2.0) / (n + effective + 5.0);
        let excess = ((effective - 1.0).max(0.0) / (n + 1.0)).sqrt() - 1.0;
        let rank_one = 2.0 / ((n + 1.3).powi(2) + effective);
        let rank_mu = 2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective);
        Self {
            effective,
            sigma_path,
            damping: 1.0 + 2.0 * excess.max(0.0) + sigma_path,
            covariance_path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one,
            rank_mu: rank_mu.min(1.0 - rank_one),
            normal_length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

/// The weights of the better half, which add up to 1.
fn recombination_weights(population: usize) -> Vec<f64> {
    let middle = (population as f64 + 1.0) / 2.0;
    let ranks = 1..=population / 2;
    let weights: Vec<f64> = ranks.map(|rank| (middle / rank as f64).ln()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

impl Cma {
    /// Starts at a point, with a standard deviation of `sigma` along every coordinate and `population` points a
    /// generation, which are at least 2.
    pub(super) fn new(start: DVector<f64>, sigma: f64, population: usize, seed: u64) -> Self {
        let dimensions = start.len();
        let population = population.max(2);
        let weights = recombination_weights(population);
        Self {
            rates: Rates::new(dimensions, &weights),
            weights,
            population,
            mean: start,
            sigma,
            covariance: DMatrix::identity(dimensions, dimensions),
            axes: DMatrix::identity(dimensions, dimensions),
            lengths: DVector::from_element(dimensions, 1.0),
            sigma_path: DVector::zeros(dimensions),
            covariance_path: DVector::zeros(dimensions),
            generations: 0,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// The points of the next generation.
    pub(super) fn ask(&mut self) -> Vec<DVector<f64>> {
        (0..self.population).map(|_| self.sample()).collect()
    }

    /// Takes in what the points came to, in their order; lower is better. What is not finite counts as the worst.
    pub(super) fn tell(&mut self, points: &[DVector<f64>], losses: &[f64]) {
        let steps = self.best_steps(points, losses);
        let mut mean_step: DVector<f64> = DVector::zeros(self.mean.len());
        for (weight, step) in &steps {
            mean_step += step * *weight;
        }
        self.mean += &mean_step * self.sigma;
        let is_held = self.follow(&mean_step);
        self.adapt_covariance(&steps, is_held);
        self.adapt_sigma();
        self.decompose();
    }

    /// Where the search is.
    pub(super) fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    /// The step size.
    pub(super) fn sigma(&self) -> f64 {
        self.sigma
    }

    fn sample(&mut self) -> DVector<f64> {
        let random = &mut self.random;
        let normal: DVector<f64> = DVector::from_fn(self.mean.len(), |_, _| {
            gaussian(random.random(), random.random())
        });
        let step = &self.axes * self.lengths.component_mul(&normal);
        &self.mean + step * self.sigma
    }

    /// The steps of the better half, in units of sigma, with their weights; the best first.
    fn best_steps(&self, points: &[DVector<f64>], losses: &[f64]) -> Vec<(f64, DVector<f64>)> {
        let ranking = |loss: &f64| match loss.is_finite() {
            true => *loss,
            false => f64::INFINITY,
        };
        let mut ranked: Vec<(f64, &DVector<f64>)> =
            losses.iter().map(ranking).zip(points).collect();
        ranked.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let best = self.weights.iter().zip(ranked);
        best.map(|(weight, (_, point))| (*weight, (point - &self.mean) / self.sigma))
            .collect()
    }

    /// Moves both paths along; says whether the covariance's is held (`h_sigma = 0`), because sigma is growing fast.
    fn follow(&mut self, mean_step: &DVector<f64>) -> bool {
        let rates = self.rates;
        let gain = |rate: f64| (rate * (2.0 - rate) * rates.effective).sqrt();
        self.generations += 1;
        self.sigma_path = &self.sigma_path * (1.0 - rates.sigma_path)
            + self.whitened(mean_step) * gain(rates.sigma_path);
        let forgotten = (1.0 - rates.sigma_path).powi(2 * self.generations);
        let length = self.sigma_path.norm() / (1.0 - forgotten).sqrt();
        let usual = (1.4 + 2.0 / (self.mean.len() as f64 + 1.0)) * rates.normal_length;
        let is_held = length >= usual;
        self.covariance_path *= 1.0 - rates.covariance_path;
        if !is_held {
            self.covariance_path += mean_step * gain(rates.covariance_path);
        }
        is_held
    }

    /// `C^(-1/2) y`.
    fn whitened(&self, step: &DVector<f64>) -> DVector<f64> {
        &self.axes * self.axes.tr_mul(step).component_div(&self.lengths)
    }

    fn adapt_covariance(&mut self, steps: &[(f64, DVector<f64>)], is_held: bool) {
        let rates = self.rates;
        let lost = match is_held {
            true => rates.covariance_path * (2.0 - rates.covariance_path),
            false => 0.0,
        };
        let kept = 1.0 - rates.rank_one * (1.0 - lost) - rates.rank_mu;
        let path = &self.covariance_path;
        self.covariance.ger(rates.rank_one, path, path, kept);
        for (weight, step) in steps {
            let rate = rates.rank_mu * weight;
            self.covariance.ger(rate, step, step, 1.0);
        }
    }

    fn adapt_sigma(&mut self) {
        let growth = self.sigma_path.norm() / self.rates.normal_length - 1.0;
        self.sigma *= (self.rates.sigma_path / self.rates.damping * growth).exp();
    }

    /// The axes and their lengths stay where the covariance has none.
    fn decompose(&mut self) {
        let covariance = self.covariance.clone();
        let eigen = SymmetricEigen::try_new(covariance, f64::EPSILON, EIGEN_ITERATIONS);
        if let Some(eigen) = eigen {
            let least = LEAST_EIGENVALUE * eigen.eigenvalues.max();
            self.lengths = eigen.eigenvalues.map(|value| value.max(least).sqrt());
            self.axes = eigen.eigenvectors;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimum(
        start: &[f64],
        generations: usize,
        loss: impl Fn(&DVector<f64>) -> f64,
    ) -> DVector<f64> {
        let mut cma = Cma::new(DVector::from_vec(start.to_vec()), 0.5, 10, 7);
        for _ in 0..generations {
            let points = cma.ask();
            let losses: Vec<f64> = points.iter().map(&loss).collect();
            cma.tell(&points, &losses);
        }
        cma.mean().clone()
    }

    fn assert_near(found: &DVector<f64>, expected: &[f64]) {
        let difference = found - DVector::from_vec(expected.to_vec());
        assert!(difference.amax() < 1e-3, "{found} instead of {expected:?}");
    }

    #[test]
    fn the_minimum_of_a_shifted_ellipsoid_is_found() {
        let centre = [1.0, -2.0, 0.5, 3.0];
        let loss = |point: &DVector<f64>| {
            let terms = point.iter().zip(centre).enumerate();
            let term = |(axis, (x, centre)): (usize, (&f64, f64))| {
                100.0_f64.powf(axis as f64 / 3.0) * (x - centre).powi(2)
            };
            terms.map(term).sum::<f64>()
        };
        assert_near(&minimum(&[0.0; 4], 200, loss), &centre);
    }

    #[test]
    fn the_minimum_of_rosenbrocks_function_is_found() {
        let loss = |point: &DVector<f64>| {
            let (x, y) = (point[0], point[1]);
            100.0 * (y - x * x).powi(2) + (1.0 - x).powi(2)
        };
        assert_near(&minimum(&[-1.0, 1.0], 150, loss), &[1.0, 1.0]);
    }

    #[test]
    fn the_same_seed_gives_the_same_points() {
        let points = |seed| {
            let mut cma = Cma::new(DVector::zeros(3), 1.0, 6, seed);
            let first = cma.ask();
            let losses: Vec<f64> = first.iter().map(|point| point.norm()).collect();
            cma.tell(&first, &losses);
            (first, cma.ask())
        };
        assert_eq!(points(1), points(1));
        assert_ne!(points(1), points(2));
    }

    #[test]
    fn losses_that_are_not_finite_count_as_the_worst() {
        let told = |worst: f64| {
            let mut cma = Cma::new(DVector::zeros(2), 1.0, 4, 0);
            for _ in 0..5 {
                let points = cma.ask();
                cma.tell(&points, &[worst, 2.0, 1.0, worst]);
            }
            (cma.mean().clone(), cma.sigma())
        };
        let expected = told(1e9);
        assert!(expected.0.iter().all(|value| value.is_finite()) && expected.1.is_finite());
        for worst in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(told(worst), expected, "{worst}");
        }
    }

    #[test]
    fn recombination_weights_fall_and_add_up_to_1() {
        for population in [2, 5, 8, 20] {
            let weights = recombination_weights(population);
            assert_eq!(weights.len(), population / 2);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(weights.is_sorted_by(|one, other| one > other));
        }
    }
}
