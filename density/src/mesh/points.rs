//! Where the characteristics start: points in the `(phi, e)` plane that represent the initial Gaussian.

use std::f64::consts::{SQRT_2, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::MeshError;
use crate::angle::{fold, nearest};
use crate::problem::{InitialGaussian, Problem};
use crate::sampling::draw_one;

/// How initial points are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// Independent draws from the initial Gaussian, as in the paper. Draw `i` depends only on the seed and `i`.
    Random,
    /// A square lattice over [`lattice_reach`] standard deviations to each side. Its number of points is the largest
    /// square that does not exceed the count.
    #[default]
    Lattice,
    /// The R2 sequence, an additive recurrence by powers of the plastic number (after Roberts 2018, *The unreasonable
    /// effectiveness of quasirandom sequences*), shifted by the seed and mapped through the inverse normal
    /// distribution.
    LowDiscrepancy,
}

/// Initial points, column by column.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Solar angle \[rad\], not folded: on the branch of the initial mean.
    pub phi: Vec<f64>,
    /// Eccentricity.
    pub e: Vec<f64>,
    /// Points per side if they form a lattice (solar angle outermost, both ascending).
    pub lattice: Option<usize>,
}

/// Places about `count` initial points: exactly `count`, or for a lattice the largest square number that does not
/// exceed it.
///
/// # Errors
/// [`MeshError::TooFewPoints`] below four points; [`MeshError::Initial`] if the Gaussian's parameters are not finite, a
/// standard deviation is not positive, the mean eccentricity is outside (0, 1), or under 1 % of it lies in `0 < e < 1`.
pub fn initial_points<M>(
    problem: &Problem<M>,
    count: usize,
    placement: Placement,
    seed: u64,
) -> Result<Points, MeshError> {
    let initial = &problem.initial;
    check(initial)?;
    if count < 4 {
        return Err(MeshError::TooFewPoints { found: count, needed: 4 });
    }
    if placement == Placement::Lattice {
        return lattice_points(problem, count.isqrt(), lattice_reach(count.isqrt()));
    }
    let shift = rotation(seed);
    let generator = ChaCha8Rng::seed_from_u64(seed);
    let draw = |index: usize| match placement {
        Placement::LowDiscrepancy => low_discrepancy(initial, shift, index),
        _ => draw_one(initial, &generator, index as u64),
    };
    let (phi, e) = (0..count).into_par_iter().map(draw).unzip();
    Ok(Points { phi, e, lattice: None })
}

fn check(initial: &InitialGaussian) -> Result<(), MeshError> {
    let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation } = *initial;
    if !(mean_phi.is_finite() && 0.0 < mean_e && mean_e < 1.0) {
        return Err(MeshError::Initial("the mean solar angle must be finite and the mean eccentricity in (0, 1)"));
    }
    if !(sigma_phi.is_finite() && sigma_e.is_finite() && sigma_phi > 0.0 && sigma_e > 0.0) {
        return Err(MeshError::Initial("both standard deviations must be positive and finite"));
    }
    if correlation.is_nan() || correlation.abs() >= 1.0 {
        return Err(MeshError::Initial("the correlation must be between -1 and 1"));
    }
    if initial.mass_inside() < 0.01 {
        return Err(MeshError::Initial("less than 1 % of it lies in 0 < e < 1"));
    }
    Ok(())
}

/// How far a lattice of `side` points per side reaches by default \[standard deviations\].
///
/// A wider lattice loses resolution, a narrower one loses the tails: beyond `k` standard deviations lies a share
/// `sqrt(2/π) k exp(-k²/2)` of the variance. The values were chosen by measurement for interpolation of degree 7: 31
/// points per side over 5.5 keep every moment of the paper's scenarios to 0.005 %, 15 over 4.5 to 0.3 %. Straight
/// triangles need a denser lattice: 4.2 for 31 points per side.
pub fn lattice_reach(side: usize) -> f64 {
    const NARROWEST: f64 = 3.0;
    const WIDEST: f64 = 5.5;
    (3.0 + 0.1 * side as f64).clamp(NARROWEST, WIDEST)
}

/// A lattice of `side` points per side in the standardised coordinates ([`InitialGaussian::standardise`]), over `reach`
/// standard deviations to each side of the mean, cut to `0 < e < 1`. Its solar angles are not folded, even where they
/// span several turns.
///
/// # Errors
/// As [`initial_points`]; [`MeshError::Initial`] if `reach` is not positive and finite.
pub fn lattice_points<M>(problem: &Problem<M>, side: usize, reach: f64) -> Result<Points, MeshError> {
    const E_RANGE: (f64, f64) = (1e-12, 1.0 - 1e-6);
    let initial = &problem.initial;
    check(initial)?;
    if side < 2 {
        return Err(MeshError::TooFewPoints { found: side, needed: 2 });
    }
    if !(reach > 0.0 && reach.is_finite()) {
        return Err(MeshError::Initial(
            "a lattice over it must reach a positive, finite number of standard deviations",
        ));
    }
    let (low, high) = (initial.point(-reach, 0.0), initial.point(reach, 0.0));
    if (high.0 - low.0) / (side - 1) as f64 >= TAU {
        return Err(MeshError::Initial(
            "it spans so many turns that the lines of the lattice lie a turn apart; take more points",
        ));
    }
    let (e_low, e_high) = (initial.point(0.0, -reach).1.max(E_RANGE.0), initial.point(0.0, reach).1.min(E_RANGE.1));
    let between = |low: f64, high: f64, i: usize| low + (high - low) * (i as f64 / (side - 1) as f64);
    let point = |row: usize| {
        let e = between(e_low, e_high, row % side);
        (between(low.0, high.0, row / side) + shear(initial, e), e)
    };
    let (phi, e) = (0..side * side).map(point).unzip();
    Ok(Points { phi, e, lattice: Some(side) })
}

/// How far the solar angle's mean given `e` lies from its mean \[rad\].
fn shear(initial: &InitialGaussian, e: f64) -> f64 {
    if initial.correlation == 0.0 {
        return 0.0;
    }
    let (_, v) = initial.standardise(initial.mean_phi, e);
    initial.mean_phi_given(v) - initial.mean_phi
}

/// The shift of the low-discrepancy sequence for a seed: a number in `[0, 1)` for each direction.
fn rotation(seed: u64) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (rng.random(), rng.random())
}

fn low_discrepancy(initial: &InitialGaussian, shift: (f64, f64), index: usize) -> (f64, f64) {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    const OPEN: (f64, f64) = (1e-12, 1.0 - 1e-12);
    let position = (index + 1) as f64;
    let unit = |step: f64, shift: f64| (shift + position * step).fract().clamp(OPEN.0, OPEN.1);
    let (phi_share, e_share) = (unit(1.0 / PLASTIC, shift.0), unit(1.0 / (PLASTIC * PLASTIC), shift.1));
    let below = normal_cdf(-initial.mean_e / initial.sigma_e);
    let u = normal_quantile(phi_share);
    let v = normal_quantile((below + e_share * initial.mass_inside()).clamp(OPEN.0, OPEN.1));
    initial.point(u, v)
}

fn normal_cdf(sigmas: f64) -> f64 {
    0.5 * libm::erfc(-sigmas / SQRT_2)
}

/// The inverse of the standard normal distribution function: a rational start (Abramowitz & Stegun 26.2.23, accurate to
/// 4.5e-4) and two steps of Halley's method, each of which triples the number of correct digits.
pub fn normal_quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability);
    let t = (-2.0 * tail.ln()).sqrt();
    let start =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let mut sigmas = -start;
    for _ in 0..2 {
        let step = (normal_cdf(sigmas) - tail) * TAU.sqrt() * (0.5 * sigmas * sigmas).exp();
        sigmas -= step / (1.0 + 0.5 * sigmas * step);
    }
    if probability <= 0.5 { sigmas } else { -sigmas }
}

/// The solar angles \[rad\] of a lattice of `side` points per side at `t = 0`, which were read out modulo a turn, as
/// they were placed: the lattice lines ascend by less than a turn, and their middle lies within half a turn of the
/// mean. Along a line the angle follows its mean given the eccentricity. Columns that are not such a lattice are not
/// refused here.
pub fn unfold(initial: &InitialGaussian, phi: &[f64], e: &[f64], side: usize) -> Vec<f64> {
    let near = |(&phi, &e): (&f64, &f64)| nearest(phi, initial.mean_phi + shear(initial, e));
    if side < 2 || phi.len() != side * side || e.len() != phi.len() {
        return phi.iter().zip(e).map(near).collect();
    }
    let first_of = |i: usize| phi[i * side] - shear(initial, e[i * side]);
    let mut lines = vec![first_of(0); side];
    for i in 1..side {
        lines[i] = fold(first_of(i), lines[i - 1]);
    }
    let middle = lines[0].midpoint(lines[side - 1]);
    let shift = nearest(middle, initial.mean_phi) - middle;
    let placed = phi.iter().zip(e).enumerate();
    placed.map(|(row, (&phi, &e))| nearest(phi, lines[row / side] + shift + shear(initial, e))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::paper::scenario;

    #[test]
    fn quantile_inverts_the_normal_distribution() {
        for sigmas in [-6.0, -2.5, -0.3, 0.0, 0.7, 3.0] {
            assert!((normal_quantile(normal_cdf(sigmas)) - sigmas).abs() < 1e-9, "{sigmas}");
        }
        // Abramowitz & Stegun, Table 26.5.
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-12);
    }

    #[test]
    fn a_draw_depends_on_seed_and_index_alone() {
        let problem = scenario(1);
        let few = initial_points(&problem, 100, Placement::Random, 7).unwrap();
        let many = initial_points(&problem, 1000, Placement::Random, 7).unwrap();
        assert_eq!(few.phi, many.phi[..100]);
        assert_eq!(few.e, many.e[..100]);
        assert_ne!(few, initial_points(&problem, 100, Placement::Random, 8).unwrap());
    }

    #[test]
    fn random_and_low_discrepancy_points_have_the_moments_of_the_gaussian() {
        let initial = scenario(2).initial;
        for (placement, tolerance) in [(Placement::Random, 4.0 / 100.0), (Placement::LowDiscrepancy, 2e-3)] {
            let points = initial_points(&scenario(2), 10_000, placement, 3).unwrap();
            let standard: Vec<_> = points.phi.iter().zip(&points.e).map(|(&p, &e)| initial.standardise(p, e)).collect();
            let mean = |f: fn(&(f64, f64)) -> f64| standard.iter().map(f).sum::<f64>() / 1e4;
            assert!(mean(|p| p.0).abs() < tolerance && mean(|p| p.1).abs() < tolerance);
            assert!((mean(|p| p.0 * p.0) - 1.0).abs() < 1.5 * tolerance);
            assert!((mean(|p| p.1 * p.1) - 1.0).abs() < 1.5 * tolerance);
        }
    }

    #[test]
    fn no_point_leaves_the_elliptic_orbits_even_if_half_of_the_gaussian_does() {
        let mut problem = scenario(1);
        problem.initial.mean_e = 1e-3;
        for placement in [Placement::Random, Placement::Lattice, Placement::LowDiscrepancy] {
            let points = initial_points(&problem, 1000, placement, 1).unwrap();
            assert!(points.e.iter().all(|&e| 0.0 < e && e < 1.0), "{placement:?}");
        }
    }

    #[test]
    fn a_hundred_thousand_points_make_the_316_lattice() {
        let points = initial_points(&scenario(1), 100_000, Placement::Lattice, 0).unwrap();
        assert_eq!((points.lattice, points.e.len()), (Some(316), 99_856));
    }

    #[test]
    fn a_lattice_over_several_turns_is_unfolded_as_it_was_placed() {
        for (sigma_phi, mean_phi, correlation) in
            [(0.1, 0.02, 0.0), (0.6, 2.2, 0.0), (3.1, 6.0, 0.0), (0.1, 0.02, 0.9), (0.6, 2.2, -0.99), (3.0, 6.0, 0.5)]
        {
            let mut problem = scenario(1);
            problem.initial = InitialGaussian { sigma_phi, mean_phi, correlation, ..problem.initial };
            let points = initial_points(&problem, 961, Placement::Lattice, 0).unwrap();
            let folded: Vec<f64> = points.phi.iter().map(|&phi| fold(phi, 0.0)).collect();
            let unfolded = unfold(&problem.initial, &folded, &points.e, 31);
            assert!(points.phi.iter().zip(&unfolded).all(|(a, b)| (a - b).abs() < 1e-12), "{sigma_phi}");
        }
    }

    #[test]
    fn impossible_gaussians_are_refused() {
        let mut problem = scenario(1);
        problem.initial.sigma_e = 0.0;
        assert!(matches!(initial_points(&problem, 10, Placement::Random, 0), Err(MeshError::Initial(_))));
        assert!(matches!(
            initial_points(&scenario(1), 3, Placement::Lattice, 0),
            Err(MeshError::TooFewPoints { found: 3, needed: 4 })
        ));
    }
}
