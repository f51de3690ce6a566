//! The univariate splitting library: the standard normal as a sum of `N` equally wide Gaussians.
//!
//! Vittaldev & Russell (CMES 111(1), 2016), first rule: fix `sigma² = 1/N`, then minimise over weights and means
//!
//! ```text
//! J = ∫ [N(x; 0, 1) - Σ w_i N(x; m_i, sigma²)]² dx,    Σ w_i = 1,   symmetric in x
//! ```
//!
//! `J` has a closed form in Gaussians, but that form subtracts numbers of order 1 to leave 1e-11, and loses the digits
//! that decide the means. The integral is therefore kept as a sum of squares on an even grid of spacing `0.4 sigma`,
//! which for these integrands is exact to rounding (the trapezoidal rule converges exponentially). It is minimised by
//! the Levenberg-Marquardt method with the sum of weights eliminated. The library is solved for at run time: 39
//! components take about 30 ms. The minimum lies in a flat valley, so compare libraries by cost and moments, not digit
//! by digit. From 49 components on the optimiser stops on its way down the valley, once `J` is below 2e-12.
//!
//! The first rule loses variance: 2.6 % for `N` = 7, 4e-5 for 39. [`Variance::Kept`] minimises the same `J` under the
//! additional condition `Σ w_i m_i² + sigma² = 1`. That condition is eliminated, too: the means are `κ m_i` with the
//! factor `κ² = (1 - sigma²)/Σ w_i m_i²`, whose derivatives enter those of the residuals.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::error::MixtureError;

/// Largest number of components of a library.
pub const MOST: usize = 99;
/// Number of iterations after which the optimiser gives up; 39 components take about 100.
const MOST_ITERATIONS: usize = 500;
/// A cost that needs no further improvement: the mixture is within 1.4e-6 of the normal in the L2 norm.
const NEGLIGIBLE_COST: f64 = 2e-12;

/// Whether a library keeps the variance of the standard normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Variance {
    /// Vittaldev & Russell's first rule: the variance is the one that the smallest cost leads to.
    Free,
    /// The variance is exactly 1.
    #[default]
    Kept,
}

/// A homoscedastic mixture that stands for the standard normal.
#[derive(Debug, Clone, PartialEq)]
pub struct Library {
    /// Standard deviation of every component.
    pub sigma: f64,
    /// Weights, ascending with the means; they sum to 1.
    pub weights: Vec<f64>,
    /// Means, ascending and symmetric.
    pub means: Vec<f64>,
    /// The squared L2 distance `J` from the standard normal.
    pub cost: f64,
}

impl Library {
    /// The standard normal itself, unsplit.
    pub fn unsplit() -> Self {
        Self { sigma: 1.0, weights: vec![1.0], means: vec![0.0], cost: 0.0 }
    }

    /// The library of `components` components, an odd number; 1 is [`Library::unsplit`].
    ///
    /// # Errors
    /// [`MixtureError::LibrarySize`] for an even number or one above [`MOST`], [`MixtureError::LibraryDiverged`].
    pub fn new(components: usize, variance: Variance) -> Result<Self, MixtureError> {
        match components {
            1 => return Ok(Self::unsplit()),
            n if n.is_multiple_of(2) || n > MOST => {
                return Err(MixtureError::LibrarySize { components: n, most: MOST });
            }
            _ => {}
        }
        let fit = Fit::new(components, variance);
        let half = fit.minimise().ok_or(MixtureError::LibraryDiverged(components))?;
        Ok(fit.library(half))
    }

    /// Variance of the mixture.
    pub fn variance(&self) -> f64 {
        self.sigma * self.sigma + self.weights.iter().zip(&self.means).map(|(w, m)| w * m * m).sum::<f64>()
    }
}

/// The density of a normal of standard deviation `sigma` at a distance `x` from its mean.
fn normal(x: f64, sigma: f64) -> f64 {
    (-0.5 * (x / sigma).powi(2)).exp() / (sigma * (2.0 * PI).sqrt())
}

/// The least-squares problem. Its unknowns are the weights, then the means, of the components right of the central one.
struct Fit {
    pairs: usize,
    sigma: f64,
    variance: Variance,
    nodes: Vec<f64>,
    /// Square root of the weight of a node; the weight is twice the spacing, as the integrand is even.
    root: f64,
}

impl Fit {
    fn new(components: usize, variance: Variance) -> Self {
        const SPACING: f64 = 0.4;
        const END: f64 = 9.0;
        let sigma = 1.0 / (components as f64).sqrt();
        let spacing = SPACING * sigma;
        let nodes = (0..(END / spacing) as usize).map(|i| (i as f64 + 0.5) * spacing).collect();
        Self { pairs: components / 2, sigma, variance, nodes, root: (2.0 * spacing).sqrt() }
    }

    /// The means lie a bit wider apart outwards, and the weights are those of a Gaussian: close enough for every `N`.
    /// The outermost mean is a fit to the solutions (1.08 for `N` = 3, 4.38 for 39).
    fn initial_guess(&self) -> DVector<f64> {
        let outermost = 1.25 * ((2 * self.pairs + 1) as f64).ln() - 0.33;
        let even = (1.22 * self.sigma * self.pairs as f64).min(outermost);
        let mean = |i: usize| {
            let share = (i + 1) as f64 / self.pairs as f64;
            share * (even + (outermost - even) * share * share)
        };
        let weight = |i: usize| normal(mean(i), (1.0 - self.sigma * self.sigma).sqrt());
        let total = weight_sum(normal(0.0, (1.0 - self.sigma * self.sigma).sqrt()), (0..self.pairs).map(weight));
        DVector::from_fn(2 * self.pairs, |k, _| if k < self.pairs { weight(k) / total } else { mean(k - self.pairs) })
    }

    /// Residuals and their derivatives.
    fn linearise(&self, unknowns: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let mut residual = DVector::zeros(self.nodes.len());
        let mut slope = DMatrix::zeros(self.nodes.len(), 2 * self.pairs);
        let central = 1.0 - 2.0 * unknowns.rows(0, self.pairs).sum();
        for (row, &x) in self.nodes.iter().enumerate() {
            let middle = normal(x, self.sigma);
            let mut sum = central * middle - normal(x, 1.0);
            for i in 0..self.pairs {
                let (weight, mean) = (unknowns[i], unknowns[self.pairs + i]);
                let (right, left) = (normal(x - mean, self.sigma), normal(x + mean, self.sigma));
                sum += weight * (right + left);
                slope[(row, i)] = self.root * (right + left - 2.0 * middle);
                slope[(row, self.pairs + i)] =
                    self.root * weight * (right * (x - mean) - left * (x + mean)) / (self.sigma * self.sigma);
            }
            residual[row] = self.root * sum;
        }
        if self.variance == Variance::Kept {
            self.add_slope_of_scale(unknowns, &mut slope);
        }
        (residual, slope)
    }

    /// `dκ/dm_j = -w_j m_j/S`, `dκ/dw_j = -m_j²/(2 S)` with `S = Σ w_i m_i²` over the right half, at `κ = 1`.
    fn add_slope_of_scale(&self, unknowns: &DVector<f64>, slope: &mut DMatrix<f64>) {
        let means = unknowns.rows(self.pairs, self.pairs);
        let by_scale = slope.columns(self.pairs, self.pairs) * means;
        let second = self.half_second_moment(unknowns);
        for j in 0..self.pairs {
            let (weight, mean) = (unknowns[j], means[j]);
            slope.column_mut(j).axpy(-mean * mean / (2.0 * second), &by_scale, 1.0);
            slope.column_mut(self.pairs + j).axpy(-weight * mean / second, &by_scale, 1.0);
        }
    }

    fn half_second_moment(&self, unknowns: &DVector<f64>) -> f64 {
        (0..self.pairs).map(|i| unknowns[i] * unknowns[self.pairs + i].powi(2)).sum()
    }

    /// Scales the means so that `κ = 1`, if the variance is to be kept.
    fn on_condition(&self, mut unknowns: DVector<f64>) -> DVector<f64> {
        if self.variance == Variance::Kept {
            let scale = ((1.0 - self.sigma * self.sigma) / (2.0 * self.half_second_moment(&unknowns))).sqrt();
            unknowns.rows_mut(self.pairs, self.pairs).scale_mut(scale);
        }
        unknowns
    }

    /// Levenberg-Marquardt method; `None` if it does not converge.
    fn minimise(&self) -> Option<DVector<f64>> {
        let mut unknowns = self.on_condition(self.initial_guess());
        let (mut residual, mut slope) = self.linearise(&unknowns);
        let mut damping = 1e-3;
        for _ in 0..MOST_ITERATIONS {
            let cost = residual.norm_squared();
            let tried = self.on_condition(&unknowns + damped_step(&residual, &slope, damping)?);
            let (tried_residual, tried_slope) = self.linearise(&tried);
            let tried_cost = tried_residual.norm_squared();
            if tried_cost <= cost {
                damping = (damping / 5.0).max(1e-16);
                let settled = cost - tried_cost < 1e-13 * cost || tried_cost < NEGLIGIBLE_COST;
                (unknowns, residual, slope) = (tried, tried_residual, tried_slope);
                if settled {
                    return Some(unknowns);
                }
            } else if damping > 1e8 {
                return Some(unknowns); // no direction lowers the cost any more
            } else {
                damping *= 4.0;
            }
        }
        None
    }

    fn library(&self, half: DVector<f64>) -> Library {
        let (weights, means) = (half.rows(0, self.pairs), half.rows(self.pairs, self.pairs));
        let mut pairs: Vec<(f64, f64)> = weights.iter().copied().zip(means.iter().copied()).collect();
        pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
        let left = pairs.iter().rev().map(|&(w, m)| (w, -m));
        let all = left.chain([(1.0 - 2.0 * weights.sum(), 0.0)]).chain(pairs.iter().copied());
        let (weights, means) = all.unzip();
        Library { sigma: self.sigma, weights, means, cost: self.linearise(&half).0.norm_squared() }
    }
}

fn weight_sum(central: f64, right: impl Iterator<Item = f64>) -> f64 {
    central + 2.0 * right.sum::<f64>()
}

/// Solves `min |residual + slope step|² + damping |D step|²`, `D` the column norms, by a QR decomposition.
fn damped_step(residual: &DVector<f64>, slope: &DMatrix<f64>, damping: f64) -> Option<DVector<f64>> {
    let (rows, columns) = slope.shape();
    let norms: Vec<f64> = slope.column_iter().map(|column| column.norm().max(1e-150)).collect();
    let matrix = DMatrix::from_fn(rows + columns, columns, |i, j| match i.checked_sub(rows) {
        None => slope[(i, j)] / norms[j],
        Some(k) if k == j => damping.sqrt(),
        Some(_) => 0.0,
    });
    let right = DVector::from_fn(rows + columns, |i, _| if i < rows { -residual[i] } else { 0.0 });
    let qr = matrix.qr();
    let mut projected = right;
    qr.q_tr_mul(&mut projected);
    let step = qr.r().solve_upper_triangular(&projected.rows(0, columns).into_owned())?;
    Some(DVector::from_fn(columns, |j, _| step[j] / norms[j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ [N(x; 0, 1) - Σ w N(x; m, s²)]² dx` in closed form, which is not how it was minimised.
    fn closed_form_cost(library: &Library) -> f64 {
        let (wide, wider) = ((1.0 + library.sigma * library.sigma).sqrt(), 2f64.sqrt() * library.sigma);
        let pairs = || library.weights.iter().zip(&library.means);
        let cross: f64 = pairs().map(|(w, m)| w * normal(*m, wide)).sum();
        let own: f64 = pairs().map(|(w, m)| w * pairs().map(|(v, n)| v * normal(m - n, wider)).sum::<f64>()).sum();
        normal(0.0, 2f64.sqrt()) - 2.0 * cross + own
    }

    #[test]
    fn seven_components_are_those_published_by_vittaldev_and_russell() {
        let library = Library::new(7, Variance::Free).unwrap();
        let weights = [0.277891321731891, 0.222379075167735, 0.109875486136781, 0.028799777829539];
        let means = [0.0, 0.648762460764688, 1.329872113204359, 2.107361692265483];
        for k in 0..4 {
            for i in [3 - k, 3 + k] {
                assert!((library.weights[i] - weights[k]).abs() < 1e-7, "{library:?}");
                assert!((library.means[i].abs() - means[k]).abs() < 1e-7, "{library:?}");
            }
        }
    }

    #[test]
    fn thirty_nine_components_reach_the_cost_and_variance_of_the_high_precision_solution() {
        let library = Library::new(39, Variance::Free).unwrap();
        assert!((library.cost / 2.4246e-11 - 1.0).abs() < 1e-4, "{}", library.cost);
        assert!((library.variance() - 0.9999575).abs() < 1e-6, "{}", library.variance());
        let reference = include_str!("../../tests/reference/univariate-split-39.csv");
        let rows = reference.lines().skip(1).map(|line| line.split_once(',').unwrap());
        for ((weight, mean), (w, m)) in rows.zip(library.weights.iter().zip(&library.means)) {
            assert!((weight.parse::<f64>().unwrap() - w).abs() < 1e-5);
            assert!((mean.parse::<f64>().unwrap() - m).abs() < 1e-3);
        }
    }

    #[test]
    fn every_odd_size_gives_positive_weights_that_sum_to_one_and_a_falling_cost() {
        let mut last = f64::INFINITY;
        for components in (3..=39).step_by(2) {
            let library = Library::new(components, Variance::Free).unwrap();
            assert!(library.weights.iter().all(|&w| w > 0.0) && library.means.is_sorted());
            assert!((library.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert!((closed_form_cost(&library) - library.cost).abs() < 1e-15);
            assert!(library.cost < last, "{components}: {}", library.cost);
            last = library.cost;
        }
    }

    #[test]
    fn large_libraries_equal_the_normal_to_the_cost_at_which_the_optimiser_stops() {
        for components in [59, 99] {
            let library = Library::new(components, Variance::Free).unwrap();
            assert!(library.cost < 2e-12 && closed_form_cost(&library).abs() < 2e-12, "{components}: {}", library.cost);
            assert!((library.variance() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_variance_is_kept_on_request_at_a_small_cost() {
        for components in [3, 7, 15, 25, 39] {
            let free = Library::new(components, Variance::Free).unwrap();
            let kept = Library::new(components, Variance::Kept).unwrap();
            assert!((kept.variance() - 1.0).abs() < 1e-14);
            let cost = closed_form_cost(&kept);
            assert!(cost >= free.cost - 1e-15 && cost < 20.0 * free.cost + 1e-15, "{components}: {} {cost}", free.cost);
        }
    }

    #[test]
    fn even_or_excessive_sizes_are_refused() {
        for components in [0, 2, 38, MOST + 2] {
            assert_eq!(
                Library::new(components, Variance::Free),
                Err(MixtureError::LibrarySize { components, most: MOST })
            );
        }
    }
}
