//! The joint density of a Gaussian mixture as bin averages on the comparison grid.
//!
//! A bin holds the integral of Eq. 14 over its area, divided by that area. A Gaussian in `(phi, e)` is the marginal in
//! `phi` times the conditional in `e`, so its probability in the bin `[a, b] x [c, d]` is
//!
//! ```text
//! w ∫_a^b N(phi; m_phi, P_phiphi) [Φ((d - μ)/s) - Φ((c - μ)/s)] dphi
//! μ(phi) = m_e + (P_phie/P_phiphi) (phi - m_phi),   s² = P_ee - P_phie²/P_phiphi
//! ```
//!
//! with `Φ` the standard normal distribution function. The integral is exact in `e`; in `phi` it is taken by
//! Gauss-Legendre panels no wider than 1.5 `sigma_phi`. Where a thin tilted ellipse crosses an edge in `e`, the bracket
//! changes over the much shorter length `s P_phiphi/|P_phie|`; there panels are halved until they are no wider than 1.5
//! times that length. The error is below 1e-6 of a component's weight for correlations up to 0.999999. Sampling the
//! density at bin centres instead would be wrong wherever a component is thinner than a bin, as in the clouds of
//! scenarios 1 and 2.
//!
//! A panel is integrated by a rule of two, three or four points, fewer for a shorter panel. Over bins narrower than
//! half an `s` the bracket is the density in the middle of the bin with two terms of its expansion (accurate to a
//! relative 1e-6), computed for several bins at a time; otherwise `Φ` is interpolated in a table.
//!
//! `phi` lives on a circle: every image of a component that is shifted by a multiple of 2π and reaches the grid counts.
//! The probability that a component has at `e < 0` lies outside every grid and is lost;
//! [`crate::estimate::Estimate::mass`] shows how much.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI, TAU};

use multiversion::multiversion;
use rayon::prelude::*;

use super::PlanarComponent;
use super::normal::{NormalDistribution, REACH, exp_of_negative};
use crate::grid::Grid;

/// Largest number of times that a panel is halved.
const MOST_HALVINGS: usize = 16;
/// Largest width of a panel, in units of the length over which the integrand changes.
const PANEL: f64 = 1.5;
/// Widths of a panel, in the same units, up to which two nodes and three nodes are enough. The error of both rules is
/// below 3e-5 of the panel's integral, and has the other sign in the panel beside it.
const SHORT: [f64; 2] = [0.4, 0.9];
/// Largest width of a bin, in standard deviations, for which the density in its middle is expanded.
const NARROW: f64 = 0.5;
/// Nodes and weights of the Gauss-Legendre rules on `[-1, 1]`.
const GAUSS_2: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
const GAUSS_3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
const GAUSS_4: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Mean density of the mixture in each bin \[1/rad\], `phi` outermost.
pub fn bin_averages(components: &[PlanarComponent], grid: &Grid) -> Vec<f64> {
    let conditionals: Vec<Conditional> = components.iter().filter_map(Conditional::new).collect();
    let normal = NormalDistribution::new();
    let mut joint = vec![0.0; grid.len()];
    joint.par_chunks_mut(grid.e.bins).enumerate().for_each(|(i, row)| {
        let (low, high) = (grid.phi.edge(i), grid.phi.edge(i + 1));
        let (low_e, width) = (grid.e.low, grid.e.width());
        add_row(
            &conditionals,
            low,
            high,
            &mut Row { low: low_e, width, per_unit: 1.0 / width, normal: &normal, bins: row },
        );
        row.iter_mut().for_each(|bin| *bin /= grid.bin_area());
    });
    joint
}

/// Adds the probability of all components in every bin of the row `low <= phi < high`. All functions called are inlined
/// here, so that they use the vector instructions of the machine. No fused operations are used, so the result is the
/// same on every machine.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn add_row(components: &[Conditional], low: f64, high: f64, row: &mut Row) {
    for component in components {
        component.add_to_row(low, high, row);
    }
}

/// A component as its marginal in `phi` and its conditional in `e`.
struct Conditional {
    weight: f64,
    mean_phi: f64,
    sigma_phi: f64,
    mean_e: f64,
    /// `P_phie/P_phiphi` \[1/rad\].
    slope: f64,
    /// Standard deviation of `e` at a given `phi`.
    sigma_e: f64,
    /// Length in `phi` over which an edge in `e` is crossed \[rad\].
    crossing: f64,
}

impl Conditional {
    /// `None` if the component has no weight.
    fn new(component: &PlanarComponent) -> Option<Self> {
        let sigma_phi = component.var_phi.sqrt().max(f64::MIN_POSITIVE.sqrt());
        let slope = component.cov_phi_e / (sigma_phi * sigma_phi);
        let sigma_e = (component.var_e - slope * component.cov_phi_e).max(1e-14 * component.var_e).sqrt();
        let crossing = sigma_e / slope.abs().max(f64::MIN_POSITIVE);
        let (weight, mean_phi, mean_e) = (component.weight, component.mean_phi, component.mean_e);
        (weight != 0.0).then_some(Self { weight, mean_phi, sigma_phi, mean_e, slope, sigma_e, crossing })
    }

    /// Adds the probability in every bin of the row `low <= phi < high`.
    #[inline(always)]
    fn add_to_row(&self, low: f64, high: f64, row: &mut Row) {
        let reach = REACH * self.sigma_phi;
        let first = ((low - reach - self.mean_phi) / TAU).ceil() as i64;
        let last = ((high + reach - self.mean_phi) / TAU).floor() as i64;
        for image in first..=last {
            let mean_phi = self.mean_phi + TAU * image as f64;
            let (from, to) = (low.max(mean_phi - reach), high.min(mean_phi + reach));
            if from < to {
                self.add_interval(from - mean_phi, to - mean_phi, row);
            }
        }
    }

    /// Integrates over the offsets `from..to` from the component's mean in `phi`.
    #[inline(always)]
    fn add_interval(&self, from: f64, to: f64, row: &mut Row) {
        let panels = ((to - from) / (PANEL * self.sigma_phi)).ceil().max(1.0);
        let width = (to - from) / panels;
        for panel in 0..panels as usize {
            let start = from + width * panel as f64;
            self.add_panel(start, start + width, row);
        }
    }

    /// Integrates over a panel, halved as often as needed.
    #[inline(always)]
    fn add_panel(&self, from: f64, to: f64, row: &mut Row) {
        // Parts still to be done, from right to left; there are never more than two of each size.
        let mut parts = [(from, to, 0); 2 * MOST_HALVINGS];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (from, to, halvings) = parts[count];
            if !self.add_part(from, to, halvings == MOST_HALVINGS, row) {
                let middle = from.midpoint(to);
                (parts[count], parts[count + 1]) = ((middle, to, halvings + 1), (from, middle, halvings + 1));
                count += 2;
            }
        }
    }

    /// Integrates over a part of a panel, unless it is too long and not `last_chance`; returns whether it did.
    #[inline(always)]
    fn add_part(&self, from: f64, to: f64, last_chance: bool, row: &mut Row) -> bool {
        let (start, end) = (self.mean_e + self.slope * from, self.mean_e + self.slope * to);
        let reach = REACH * self.sigma_e;
        let (first, last) = (row.position(start.min(end) - reach), row.position(start.max(end) + reach));
        if last < 0.0 || first >= row.bins.len() as f64 {
            return true;
        }
        if first == last {
            let below = |offset: f64| row.normal.below(offset / self.sigma_phi);
            row.bins[first as usize] += self.weight * (below(to) - below(from));
        } else if to - from <= PANEL * self.crossing || last_chance {
            for (offset, mass) in self.quadrature(from, to) {
                row.add_column(mass, self.mean_e + self.slope * offset, self.sigma_e);
            }
        } else {
            return false;
        }
        true
    }

    /// Offsets in `phi`, and the probability at each.
    #[inline(always)]
    fn quadrature(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
        let (middle, half) = (from.midpoint(to), 0.5 * (to - from));
        let width = (to - from) / self.sigma_phi.min(self.crossing);
        let scale = self.weight * half * 0.5 * FRAC_2_SQRT_PI * FRAC_1_SQRT_2 / self.sigma_phi;
        let rule: &[(f64, f64)] = match SHORT {
            [two, _] if width <= two => &GAUSS_2,
            [_, three] if width <= three => &GAUSS_3,
            _ => &GAUSS_4,
        };
        rule.iter().map(move |&(node, weight)| {
            let offset = middle + half * node;
            let standard = offset / self.sigma_phi;
            (offset, scale * weight * exp_of_negative(-0.5 * standard * standard))
        })
    }
}

/// The bins of one interval of `phi`.
struct Row<'a> {
    /// Lower edge of the first bin in `e`.
    low: f64,
    /// Width of a bin in `e`, and its inverse.
    width: f64,
    per_unit: f64,
    normal: &'a NormalDistribution,
    bins: &'a mut [f64],
}

impl Row<'_> {
    /// The number of the bin that holds `e`, also beyond the grid.
    #[inline(always)]
    fn position(&self, e: f64) -> f64 {
        ((e - self.low) * self.per_unit).floor()
    }

    /// Distributes `mass` over the bins in `e` as a Gaussian.
    #[inline(always)]
    fn add_column(&mut self, mass: f64, mean: f64, sigma: f64) {
        let bins = self.bins.len() as f64;
        let first = self.position(mean - REACH * sigma).clamp(0.0, bins) as usize;
        let last = self.position(mean + REACH * sigma).clamp(-1.0, bins - 1.0) + 1.0;
        let (step, start) = (self.width / sigma, (self.low - mean) / sigma);
        if step <= NARROW {
            let bins = self.bins.get_mut(first..last as usize).unwrap_or_default();
            return add_narrow(bins, mass, start + step * (first as f64 + 0.5), step);
        }
        let below_edge = |i: usize| self.normal.below(start + step * i as f64);
        let mut below = below_edge(first);
        for (i, bin) in self.bins.iter_mut().enumerate().take(last as usize).skip(first) {
            let above = below_edge(i + 1);
            *bin += mass * (above - below);
            below = above;
        }
    }
}

/// Distributes `mass` as a Gaussian over bins of width `step` whose middles lie at `first`, `first + step`, ..., in
/// standard deviations: `∫ φ = step φ(x) (1 + step² (x² - 1)/24 + step⁴ (x⁴ - 6 x² + 3)/1920)`. Written to be
/// vectorised.
#[inline(always)]
fn add_narrow(bins: &mut [f64], mass: f64, first: f64, step: f64) {
    let scale = mass * step * FRAC_1_SQRT_2 * 0.5 * FRAC_2_SQRT_PI;
    let (a, b) = (step * step / 24.0, step * step * step * step / 1920.0);
    let coefficients = [1.0 - a + 3.0 * b, a - 6.0 * b, b];
    for (i, bin) in (0i32..).zip(bins) {
        let x = first + step * f64::from(i);
        let square = x * x;
        let correction = coefficients[0] + square * (coefficients[1] + square * coefficients[2]);
        *bin += scale * correction * exp_of_negative(-0.5 * square);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Axis;

    fn component(mean_phi: f64, mean_e: f64, [sigma_phi, sigma_e, correlation]: [f64; 3]) -> PlanarComponent {
        let (var_phi, var_e) = (sigma_phi * sigma_phi, sigma_e * sigma_e);
        PlanarComponent { weight: 1.0, mean_phi, mean_e, var_phi, cov_phi_e: correlation * sigma_phi * sigma_e, var_e }
    }

    fn grid(phi: (f64, f64), e: (f64, f64), bins: usize) -> Grid {
        let axis = |(low, high)| Axis { low, high, bins };
        Grid { phi: axis(phi), e: axis(e) }
    }

    fn masses(components: &[PlanarComponent], grid: &Grid) -> Vec<f64> {
        bin_averages(components, grid).iter().map(|average| average * grid.bin_area()).collect()
    }

    #[test]
    fn narrow_bins_hold_differences_of_the_distribution_function() {
        for step in [0.03, 0.2, NARROW] {
            let count = (13.0 / step) as usize;
            let mut bins = vec![0.0; count];
            add_narrow(&mut bins, 2.0, -6.5 + 0.5 * step, step);
            for (k, bin) in bins.iter().enumerate() {
                let below = |k: usize| 0.5 * libm::erfc((6.5 - step * k as f64) * FRAC_1_SQRT_2);
                let exact = 2.0 * (below(k + 1) - below(k));
                assert!((bin - exact).abs() < 2e-6 * step, "{step} {k}: {bin} {exact}");
            }
        }
    }

    #[test]
    fn quadrants_hold_the_orthant_probability_at_every_correlation() {
        // Sheppard (1899): P(x > 0, y > 0) = 1/4 + asin(rho)/(2 pi).
        let grid = grid((1.0, 3.0), (0.2, 0.6), 2);
        for correlation in [-0.999_999, -0.99, -0.5, 0.0, 0.3, 0.9, 0.999, 0.999_999] {
            let masses = masses(&[component(2.0, 0.4, [0.1, 0.02, correlation])], &grid);
            let expected = 0.25 + f64::asin(correlation) / TAU;
            for (quadrant, expected) in [(0, expected), (1, 0.5 - expected), (2, 0.5 - expected), (3, expected)] {
                assert!((masses[quadrant] - expected).abs() < 1e-6, "{correlation}: {masses:?}");
            }
        }
    }

    #[test]
    fn marginal_masses_of_a_tilted_component_are_differences_of_the_distribution_function() {
        let grid = grid((0.7, 3.1), (0.21, 0.62), 30);
        let masses = masses(&[component(2.0, 0.4, [0.3, 0.05, -0.8])], &grid);
        let probability = |low: f64, high: f64, mean: f64, sigma: f64| {
            let below = |x: f64| 0.5 * libm::erfc((mean - x) * FRAC_1_SQRT_2 / sigma);
            below(high) - below(low)
        };
        for j in 0..30 {
            let column: f64 = masses.iter().skip(j).step_by(30).sum();
            let cut = probability(0.7, 3.1, 2.0, 0.3);
            let whole = probability(grid.e.edge(j), grid.e.edge(j + 1), 0.4, 0.05);
            assert!((column - whole).abs() < 1e-6 + (1.0 - cut), "{j}: {column} {whole}");
        }
        assert!((masses.iter().sum::<f64>() - 1.0).abs() < 3e-4);
    }

    #[test]
    fn a_component_far_thinner_than_a_bin_lies_in_its_bin() {
        let grid = grid((0.0, 1.0), (0.0, 1.0), 10);
        let masses = masses(&[component(0.35, 0.65, [1e-7, 1e-9, 0.5])], &grid);
        for (bin, mass) in masses.iter().enumerate() {
            assert!((mass - f64::from(bin == 36)).abs() < 1e-6, "{bin}: {mass}");
        }
    }

    #[test]
    fn images_of_a_component_round_the_circle_count() {
        let grid = grid((-1.0, 1.0), (0.3, 0.5), 8);
        let near = masses(&[component(0.2, 0.4, [0.3, 0.02, 0.4])], &grid);
        let far = masses(&[component(0.2 + 3.0 * TAU, 0.4, [0.3, 0.02, 0.4])], &grid);
        near.iter().zip(&far).for_each(|(near, far)| assert!((near - far).abs() < 1e-13));

        let full = super::tests::grid((0.0, TAU), (0.3, 0.5), 8);
        let wide = masses(&[component(0.2, 0.4, [2.0, 0.01, 0.0])], &full);
        assert!(
            (wide.iter().sum::<f64>() - 1.0).abs() < 1e-7,
            "a component wider than the circle keeps its mass on it"
        );
    }
}
