//! Mixtures of Gaussians from which points are drawn, and their fit to weighted points.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use crate::gaussian::Gaussian;

/// A mixture of Gaussians over standardised coordinates.
#[derive(Debug, Clone, Default)]
pub(super) struct Proposal<const N: usize> {
    /// The weight of each component, which add up to 1, and the component.
    pub components: Vec<(f64, Gaussian<N>)>,
}

/// Steps of the fit, after which it no longer changes by much.
const STEPS: usize = 25;
/// The deviation, in standard deviations of the initial Gaussian, that a component has where points say little of it.
/// About five deviations from the mean the normal density falls by a factor of e within 0.2.
const NATURAL: f64 = 0.25;

impl<const N: usize> Proposal<N> {
    /// Logarithm of the density at a point.
    pub fn log_density(&self, point: &[f64; N]) -> f64 {
        let terms: Vec<f64> =
            self.components.iter().map(|(weight, component)| weight.ln() + component.log_density(point)).collect();
        log_sum(&terms)
    }

    /// A point drawn at random.
    pub fn draw(&self, random: &mut impl Rng) -> [f64; N] {
        let mut share: f64 = random.random();
        let chosen = self.components.iter().find(|(weight, _)| {
            share -= weight;
            share < 0.0
        });
        let (_, component) = chosen.or(self.components.last()).expect("a mixture has components");
        component.point(std::array::from_fn(|_| StandardNormal.sample(random)))
    }

    /// Kernels of one deviation about weighted points.
    pub fn kernels(points: &[[f64; N]], weights: &[f64], deviation: f64) -> Self {
        let kernel = |(point, weight): (&[f64; N], &f64)| (*weight, Gaussian::independent(*point, [deviation; N]));
        Self { components: points.iter().zip(weights).map(kernel).collect() }
    }

    /// A mixture of at most `most` components fitted to points with weights that add up to 1, by expectation and
    /// maximisation (Dempster, Laird & Rubin 1977). Covariances are drawn towards that of [`NATURAL`] where few points
    /// determine them.
    pub fn fit(points: &[[f64; N]], weights: &[f64], most: usize) -> Self {
        let centres = spread_out(points, weights, most);
        let mut fitted = Self::kernels(&centres, &vec![1.0 / centres.len() as f64; centres.len()], 2.0 * NATURAL);
        for _ in 0..STEPS {
            let shares: Vec<Vec<f64>> = points.iter().map(|point| fitted.shares(point)).collect();
            let component = |k: usize| {
                let of_point = |i: usize| weights[i] * shares[i][k];
                one_component(points, &of_point)
            };
            let components: Vec<_> = (0..fitted.components.len()).filter_map(component).collect();
            let total: f64 = components.iter().map(|(weight, _)| weight).sum();
            fitted.components = components.into_iter().map(|(weight, component)| (weight / total, component)).collect();
        }
        fitted
    }

    /// The share of each component in the density at a point.
    fn shares(&self, point: &[f64; N]) -> Vec<f64> {
        let terms: Vec<f64> =
            self.components.iter().map(|(weight, component)| weight.ln() + component.log_density(point)).collect();
        let sum = log_sum(&terms);
        terms.iter().map(|term| (term - sum).exp()).collect()
    }

    /// The same with the deviations of all components made `factor` times as large, at a share of the weight.
    pub fn widened(&self, factor: f64, share: f64) -> impl Iterator<Item = (f64, Gaussian<N>)> {
        self.components.iter().map(move |(weight, component)| {
            let widened = (0..N).fold(*component, |wide, k| wide.narrowed(wide.mean, k, factor));
            (share * weight, widened)
        })
    }
}

/// Logarithm of the sum of exponentials.
pub(super) fn log_sum(terms: &[f64]) -> f64 {
    let most = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY { most } else { most + terms.iter().map(|term| (term - most).exp()).sum::<f64>().ln() }
}

/// Logarithm of the standard normal density.
pub(super) fn log_normal<const N: usize>(point: &[f64; N]) -> f64 {
    -0.5 * (point.iter().map(|z| z * z).sum::<f64>() + N as f64 * TAU.ln())
}

/// Effective number of points with these weights (Kish 1965).
pub(super) fn effective(weights: impl Iterator<Item = f64>) -> f64 {
    let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Points far from one another, the first of which has the largest weight.
fn spread_out<const N: usize>(points: &[[f64; N]], weights: &[f64], most: usize) -> Vec<[f64; N]> {
    let heaviest = (0..points.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    let mut chosen = vec![points[heaviest]];
    while chosen.len() < most {
        let score = |i: usize| {
            let distance = |other: &[f64; N]| (0..N).map(|k| (points[i][k] - other[k]).powi(2)).sum::<f64>();
            weights[i] * chosen.iter().map(distance).fold(f64::INFINITY, f64::min)
        };
        let Some(next) = (0..points.len()).max_by(|&a, &b| score(a).total_cmp(&score(b))) else { break };
        if score(next) <= 0.0 {
            break;
        }
        chosen.push(points[next]);
    }
    chosen
}

/// The Gaussian of points with these weights, with the sum of the weights; `None` if that is as good as nothing.
fn one_component<const N: usize>(points: &[[f64; N]], weight: &dyn Fn(usize) -> f64) -> Option<(f64, Gaussian<N>)> {
    let total: f64 = (0..points.len()).map(weight).sum();
    if total.is_nan() || total <= 1e-6 {
        return None;
    }
    let mean_of = |f: &dyn Fn(usize) -> f64| (0..points.len()).map(|i| weight(i) * f(i)).sum::<f64>() / total;
    let mean: [f64; N] = std::array::from_fn(|k| mean_of(&|i| points[i][k]));
    let known = effective((0..points.len()).map(weight));
    let doubt = 2.0 * N as f64;
    let covariance = std::array::from_fn(|j| {
        std::array::from_fn(|k| {
            let found = mean_of(&|i| (points[i][j] - mean[j]) * (points[i][k] - mean[k]));
            let natural = if j == k { NATURAL * NATURAL } else { 0.0 };
            (known * found + doubt * natural) / (known + doubt)
        })
    });
    Gaussian::new(mean, covariance).ok().map(|component| (total, component))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn a_fit_to_draws_of_two_gaussians_finds_both() {
        let components = vec![
            (0.7, Gaussian::independent([4.0, 0.0], [0.3, 1.0])),
            (0.3, Gaussian::independent([-3.0, 2.0], [0.5, 0.5])),
        ];
        let truth = Proposal { components };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let points: Vec<[f64; 2]> = (0..2000).map(|_| truth.draw(&mut random)).collect();
        let fitted = Proposal::fit(&points, &vec![1.0 / 2000.0; 2000], 2);
        let first = fitted.components.iter().find(|(_, component)| component.mean[0] > 0.0).unwrap();
        assert!((first.0 - 0.7).abs() < 0.03, "{first:?}");
        assert!((first.1.mean[0] - 4.0).abs() < 0.05 && (first.1.deviation(1) - 1.0).abs() < 0.06, "{first:?}");
    }

    #[test]
    fn the_density_is_that_of_the_draws() {
        let truth = Proposal::<2>::kernels(&[[0.0, 1.0], [2.0, 0.0]], &[0.5, 0.5], 0.5);
        // The mean of 1/q over draws within a square is its area.
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let inside = |point: &[f64; 2]| point.iter().all(|z| (0.0..1.0).contains(z));
        let mean = (0..100_000).map(|_| truth.draw(&mut random)).filter(inside).map(|p| (-truth.log_density(&p)).exp());
        let area = mean.sum::<f64>() / 1e5;
        assert!((area - 1.0).abs() < 0.05, "{area}");
    }
}
