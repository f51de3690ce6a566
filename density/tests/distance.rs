//! Tests of the distances of densities against the closed forms for Gaussians.
//!
//! For normal densities with the same standard deviation `s` whose means lie `d` apart, with `D = d/s`:
//! `TV = erf(D / (2 sqrt 2))`, Kolmogorov the same value (the distribution functions differ most midway),
//! `h² = 1 - exp(-D²/8)`, Kullback-Leibler `D²/2`, `L2² = (1 - exp(-D²/4)) / (s sqrt pi)`
//! (Gibbs & Su 2002; the last from the product of two Gaussians). In the plane the first, third and fourth of these
//! hold with Mahalanobis' distance for `D`.

use std::f64::consts::{PI, SQRT_2};

use density::angle::Circular;
use density::distance::{Distances, FLOOR, between, between_marginals, compare};
use density::estimate::{Estimate, Moments};
use density::grid::{Axis, Grid};

/// Averages of the normal density over the bins.
fn normal(axis: Axis, mean: f64, sigma: f64) -> Vec<f64> {
    let tail = |edge: f64| 0.5 * libm::erfc((edge - mean) / (sigma * SQRT_2));
    axis.edges().windows(2).map(|edges| (tail(edges[0]) - tail(edges[1])) / axis.width()).collect()
}

/// By how much an average over bins may fall short. With `x = h/s` and `D`, a second-order expansion in the bin's width
/// `h` gives `x² D²/24` for Kullback-Leibler, `x² D²/96` for `h²`, `x² D/(8 sqrt(2 pi))` for TV (from the one bin where
/// the densities cross) and `x²/12` times `∫ f'² / ∫ f² s²` for `L2²`; half of that is added for the higher orders.
fn assert_close(distances: Distances, shift: f64, sigma: f64, width: f64) {
    let (x2, d2) = ((width / sigma).powi(2), shift * shift);
    let tv = libm::erf(shift / (2.0 * SQRT_2));
    let (h2, kl) = (1.0 - (-d2 / 8.0).exp(), 0.5 * d2);
    let l2 = (1.0 - (-d2 / 4.0).exp()) / (sigma * PI.sqrt());
    let slope2 = (0.5 - (0.5 - d2 / 4.0) * (-d2 / 4.0).exp()) / (sigma * PI.sqrt());
    let short = |value: f64, exact: f64, bound: f64| {
        assert!(value <= exact + 1e-12 && exact - value <= 1.5 * bound + 1e-12, "{value} {exact} {bound}");
    };
    short(distances.total_variation, tv, x2 * shift / (8.0 * (2.0 * PI).sqrt()));
    short(distances.kolmogorov, tv, x2 * shift / (8.0 * (2.0 * PI).sqrt()));
    short(distances.hellinger.powi(2), h2, x2 * d2 / 96.0);
    short(distances.kullback_leibler, kl, x2 * d2 / 24.0);
    short(distances.l2.powi(2), l2, x2 / 12.0 * slope2);
}

#[test]
fn distances_of_shifted_normal_densities_are_those_of_the_closed_forms() {
    for (shift, bins) in [(0.1, 80), (0.5, 57), (1.0, 100), (1.0, 400), (2.0, 160), (3.0, 1600)] {
        let sigma = 0.3;
        let axis = Axis { low: -10.0 * sigma, high: (10.0 + shift) * sigma, bins };
        let (method, reference) = (normal(axis, shift * sigma, sigma), normal(axis, 0.0, sigma));
        assert_close(between_marginals(&method, &reference, axis.width()), shift, sigma, axis.width());
    }
}

#[test]
fn divergence_is_of_the_method_relative_to_the_reference() {
    // D(N(0, a²) ‖ N(0, b²)) = ln(b/a) + a²/(2b²) - 1/2.
    let axis = Axis { low: -8.0, high: 8.0, bins: 3200 };
    let (narrow, wide) = (normal(axis, 0.0, 0.5), normal(axis, 0.0, 1.0));
    let forward = between(&narrow, &wide, axis.width()).kullback_leibler;
    let backward = between(&wide, &narrow, axis.width()).kullback_leibler;
    // Bins of 1/100 of the smaller deviation: x²/24 times the mean squared slope of ln(p/q), which is 9/4 and 9.
    assert!((forward - (2f64.ln() + 0.125 - 0.5)).abs() < 1e-4 / 24.0 * 9.0, "{forward}");
    // Beyond 3.95 the narrow density is below FLOOR per bin; the wide one has 7.8e-5 there, on which 2x² - 31 is
    // about 4.
    assert!(backward > forward && (backward - (0.5f64.ln() + 2.0 - 0.5)).abs() < 5e-4, "{backward}");
}

/// A normal estimate in the plane, independent in both directions.
fn plane(grid: Grid, means: (f64, f64), sigmas: (f64, f64)) -> Estimate {
    let (phi, e) = (normal(grid.phi, means.0, sigmas.0), normal(grid.e, means.1, sigmas.1));
    let joint = phi.iter().flat_map(|a| e.iter().map(move |b| a * b)).collect();
    Estimate::from_joint(grid, joint, Moments::NONE, Circular::default())
}

#[test]
fn joint_distances_are_those_of_mahalanobis_shift_and_marginal_ones_of_their_own() {
    let grid = Grid { phi: Axis { low: 0.0, high: 4.0, bins: 200 }, e: Axis { low: 0.2, high: 0.8, bins: 150 } };
    let sigmas = (0.2, 0.03);
    let method = plane(grid, (2.0 + 0.6 * sigmas.0, 0.5 - 0.8 * sigmas.1), sigmas);
    let comparison = compare(&method, &plane(grid, (2.0, 0.5), sigmas)).unwrap();
    assert_close(comparison.marginal_phi, 0.6, sigmas.0, grid.phi.width());
    assert_close(comparison.marginal_e, 0.8, sigmas.1, grid.e.width());
    let joint = comparison.joint;
    // Bins of 0.1 and 0.133 standard deviations: x² D² / 96 and / 24 with D = 1. In total variation, cells that the
    // line of equal density crosses fall short, by less than x²/8 times the density's slope along the shift.
    let x2 = 0.02;
    assert!(joint.kolmogorov.is_nan());
    assert!((joint.total_variation - libm::erf(1.0 / (2.0 * SQRT_2))).abs() < x2 / 8.0);
    assert!((joint.hellinger.powi(2) - (1.0 - (-0.125f64).exp())).abs() < x2 / 96.0);
    assert!((joint.kullback_leibler - 0.5).abs() < x2 / 24.0);
    let l2 = ((1.0 - (-0.25f64).exp()) / (2.0 * PI * sigmas.0 * sigmas.1)).sqrt();
    assert!((joint.l2 / l2 - 1.0).abs() < x2);
    assert!(comparison.mass_outside.abs() < 1e-12 && comparison.reference_mass_outside.abs() < 1e-12);
}

#[test]
fn an_estimate_is_at_distance_zero_from_itself() {
    let grid = Grid { phi: Axis { low: 0.0, high: 4.0, bins: 50 }, e: Axis { low: 0.2, high: 0.8, bins: 40 } };
    let estimate = plane(grid, (3.5, 0.7), (0.3, 0.05)); // a part lies outside the grid
    let comparison = compare(&estimate, &estimate).unwrap();
    for distances in [comparison.joint, comparison.marginal_phi, comparison.marginal_e] {
        let Distances { total_variation, l2, hellinger, kullback_leibler, .. } = distances;
        assert_eq!([total_variation, l2, hellinger, kullback_leibler], [0.0; 4]);
    }
    assert_eq!(comparison.marginal_e.kolmogorov, 0.0);
    assert!(comparison.mass_outside > 0.02);
}

#[test]
fn lost_mass_is_a_distance() {
    // A method that keeps only 0.9 of every bin; the other 0.1 of all bins has moved to the outside.
    let axis = Axis { low: -10.0, high: 10.0, bins: 500 };
    let reference = normal(axis, 0.0, 1.0);
    let method: Vec<f64> = reference.iter().map(|density| 0.9 * density).collect();
    let distances = between_marginals(&method, &reference, axis.width());
    assert!((distances.total_variation - 0.1).abs() < 1e-12);
    assert!((distances.kolmogorov - 0.1).abs() < 1e-12);
    assert!((distances.hellinger.powi(2) - (1.0 - 0.9f64.sqrt())).abs() < 1e-12);
    // 0.9 ln 0.9 on the grid; outside, 0.1 against the floor.
    let expected = 0.9 * 0.9f64.ln() + 0.1 * (0.1 / FLOOR).ln();
    assert!((distances.kullback_leibler - expected).abs() < 1e-3, "{} {expected}", distances.kullback_leibler);
}

#[test]
fn densities_without_a_common_cell_are_as_far_apart_as_can_be() {
    let distances = between_marginals(&[2.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 2.0], 0.5);
    assert_eq!([distances.total_variation, distances.hellinger, distances.kolmogorov], [1.0; 3]);
    assert!((distances.kullback_leibler + FLOOR.ln()).abs() < 1e-9 && distances.l2 == 2.0);
}

#[test]
fn estimates_on_different_grids_are_an_error_that_names_both() {
    let grid = Grid { phi: Axis { low: 0.0, high: 4.0, bins: 5 }, e: Axis { low: 0.2, high: 0.8, bins: 4 } };
    let other = Grid { e: Axis { bins: 5, ..grid.e }, ..grid };
    let [a, b] = [grid, other].map(|grid| plane(grid, (2.0, 0.5), (0.2, 0.03)));
    assert!(compare(&a, &b).unwrap_err().to_string().contains("one grid"));
}
