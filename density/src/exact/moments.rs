//! Moments without sampling noise: the initial Gaussian integrated along the flow.
//!
//! A moment at time `t` is `∫∫ f(Φ_t(phi_0, e_0)) n_0(phi_0, e_0) dphi_0 de_0`. Cells of the initial plane, out to
//! [`CUT`] standard deviations, carry Gauss-Kronrod product rules; cells with the largest error estimates are halved until
//! the sum of the estimates is small enough. The integrand is smooth but where the flow carries a cell over `e = 0`, and
//! for moments of `phi` where the cloud crosses the branch cut opposite its circular mean:
//! the latter is smoothed away by [`super::branch_cut`].

use rayon::prelude::*;

use crate::angle::{Circular, nearest};
use crate::dynamics::State;
use crate::flow::{Escaped, Flow};

use super::branch_cut::{Deviation, deviation};
use super::kronrod::{CELL, Cell, Integrals, Split, integrate};
use super::measure::Measure;

/// Standard deviations at which the Gaussian is cut: 2e-17 lies beyond.
pub(super) const CUT: f64 = 8.5;
/// Cells at the start in either direction.
const FIRST: usize = 6;

/// Number of functions integrated: 1, cos, sin, e, e², θ, θ², θ e, and what smoothing the branch cut
/// changes in `θ` and `θ²`.
const F: usize = 10;

/// First and second moments of a cloud and its circular mean, with error estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothMoments {
    /// Mean solar angle on the branch of the circular mean \[rad\].
    pub mean_phi: f64,
    /// Standard deviation of the solar angle on that branch \[rad\].
    pub std_phi: f64,
    /// Mean eccentricity.
    pub mean_e: f64,
    /// Standard deviation of the eccentricity.
    pub std_e: f64,
    /// Covariance \[rad\].
    pub cov_phi_e: f64,
    /// Circular mean and resultant length.
    pub circular: Circular,
    /// Largest error estimate of the five moments, in units of the standard deviations (or products of them).
    pub error: f64,
    /// Error estimate of the mean of `(cos phi, sin phi)`.
    pub circular_error: f64,
    /// Orbits propagated.
    pub orbits: usize,
}

/// A cell with its orbits at time `t`.
struct Leaf {
    cell: Cell,
    /// `(phi, e, weight)` at the nodes.
    points: Vec<(f64, f64, f64)>,
}

/// What the moments are centred on.
#[derive(Clone, Copy)]
struct Centre {
    phi: f64,
    e: f64,
}

/// The moments after `years`, refined until their error estimate is below `tolerance` or `most_orbits` are spent.
///
/// # Errors
/// [`Escaped`] if an orbit of the cloud cannot be continued.
pub fn smooth_moments(
    flow: &Flow,
    measure: &Measure,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Result<SmoothMoments, Escaped> {
    let mut leaves = Vec::new();
    let mut pending = first_cells(measure);
    let mut orbits = 0;
    loop {
        orbits += pending.len() * CELL;
        leaves.extend(propagate(flow, measure, &pending, years)?);
        let centre = centre(&leaves);
        let integrals: Vec<Integrals<F>> = leaves.par_iter().map(|leaf| leaf.integrals(centre)).collect();
        let (moments, errors) = moments(&integrals, centre, orbits);
        let most_cells = most_orbits.saturating_sub(orbits) / (4 * CELL);
        if moments.error <= tolerance || most_cells == 0 {
            return Ok(moments);
        }
        let worst = worst(&errors, 0.1 * tolerance, most_cells);
        if worst.is_empty() {
            // What is left is the smoothing of the branch cut, which finer cells do not change.
            return Ok(moments);
        }
        pending = worst.iter().flat_map(|&i| leaves[i].cell.split(direction(&integrals[i], &moments))).collect();
        let mut keep = vec![true; leaves.len()];
        worst.iter().for_each(|&i| keep[i] = false);
        let mut keep = keep.into_iter();
        leaves.retain(|_| keep.next().unwrap_or(true));
    }
}

fn first_cells(measure: &Measure) -> Vec<Cell> {
    let v_low = measure.e_sigmas(0.0).max(-CUT);
    let v_high = measure.e_sigmas(1.0).min(CUT);
    let part = |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / FIRST as f64;
    let range = |low, high, i| (part(low, high, i), part(low, high, i + 1));
    (0..FIRST * FIRST)
        .map(|k| Cell { u: range(-CUT, CUT, k / FIRST), v: range(v_low, v_high, k % FIRST) })
        .filter(|cell| cell.distance() < CUT)
        .collect()
}

fn propagate(flow: &Flow, measure: &Measure, cells: &[Cell], years: f64) -> Result<Vec<Leaf>, Escaped> {
    let nodes: Vec<(f64, f64, f64)> = cells.iter().flat_map(|cell| cell.nodes()).collect();
    let gaussian = measure.gaussian;
    let states = nodes.iter().map(|&(u, v, _)| {
        let (phi, e) = gaussian.point(u, v);
        State::from_polar(phi, e)
    });
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.map(|state| (state.x1, state.x2)).unzip();
    flow.advance(&mut x1, &mut x2, years)?;
    let point = |i: usize| {
        let (state, (u, v, area)) = (State { x1: x1[i], x2: x2[i] }, nodes[i]);
        let (phi, e) = gaussian.point(u, v);
        let weight = area * gaussian.density(phi, e) * gaussian.sigma_phi * gaussian.sigma_e;
        (state.solar_angle(), state.eccentricity(), weight)
    };
    let leaf = |(k, &cell): (usize, &Cell)| Leaf { cell, points: (k * CELL..(k + 1) * CELL).map(point).collect() };
    Ok(cells.iter().enumerate().map(leaf).collect())
}

/// The circular mean and mean eccentricity of the leaves.
fn centre(leaves: &[Leaf]) -> Centre {
    let mut sums = [0.0; 4];
    for &(phi, e, weight) in leaves.iter().flat_map(|leaf| &leaf.points) {
        let (sin, cos) = phi.sin_cos();
        sums.iter_mut().zip([1.0, sin, cos, e]).for_each(|(sum, term)| *sum += weight * term);
    }
    let [total, sin, cos, e] = sums;
    let phi = Circular::from_mean_vector(sin / total, cos / total).mean;
    Centre { phi, e: e / total }
}

impl Leaf {
    fn integrals(&self, centre: Centre) -> Integrals<F> {
        integrate(self.points.iter().map(|&(phi, e, weight)| {
            let theta = nearest(phi, centre.phi) - centre.phi;
            let (sin, cos) = theta.sin_cos();
            let Deviation { first, second, first_change, second_change } = deviation(theta);
            let de = e - centre.e;
            [1.0, cos, sin, de, de * de, first, second, first * de, first_change, second_change]
                .map(|term| weight * term)
        }))
    }
}

/// The moments and each leaf's share of their error.
fn moments(integrals: &[Integrals<F>], centre: Centre, orbits: usize) -> (SmoothMoments, Vec<f64>) {
    let mut sums = [[0.0; 2]; F];
    for leaf in integrals {
        for (f, sum) in sums.iter_mut().enumerate() {
            sum[0] += leaf.values[f];
            sum[1] += leaf.errors[f];
        }
    }
    let [_, cos, sin, de, de2, theta, theta2, theta_de, change, change2] = sums.map(|sum| sum[0] / sums[0][0]);
    let std_phi = (theta2 - theta * theta).max(f64::MIN_POSITIVE).sqrt();
    let std_e = (de2 - de * de).max(f64::MIN_POSITIVE).sqrt();
    let circular = Circular::from_mean_vector(sin, cos);
    let mut moments = SmoothMoments {
        mean_phi: centre.phi + theta,
        std_phi,
        mean_e: centre.e + de,
        std_e,
        cov_phi_e: theta_de - theta * de,
        circular: Circular { mean: crate::angle::fold(centre.phi + nearest(circular.mean, 0.0), 0.0), ..circular },
        error: 0.0,
        circular_error: sums[1][1] + sums[2][1],
        orbits,
    };
    let scaled = |errors: &[f64; F]| -> f64 {
        let scales = scales(&moments);
        errors.iter().zip(scales).map(|(error, scale)| error / scale).fold(0.0, f64::max)
    };
    let shares = integrals.iter().map(|leaf| scaled(&leaf.errors)).collect();
    let smoothing = (change / std_phi).abs().max((change2 / theta2.max(f64::MIN_POSITIVE)).abs());
    moments.error = scaled(&sums.map(|sum| sum[1])).max(smoothing);
    (moments, shares)
}

/// The natural size of each integrated function.
fn scales(moments: &SmoothMoments) -> [f64; F] {
    let (phi, e) = (moments.std_phi, moments.std_e);
    [1.0, phi.min(1.0), phi.min(1.0), e, e * e, phi, phi * phi, phi * e, phi, phi * phi]
}

/// The fewest leaves without which the rest have less than `left` of error, at most `most`, in their own order.
fn worst(errors: &[f64], left: f64, most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..errors.len()).collect();
    order.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
    let mut rest: f64 = errors.iter().sum();
    let mut worst: Vec<usize> = order
        .into_iter()
        .take_while(|&i| {
            let wanted = rest > left;
            rest -= errors[i];
            wanted
        })
        .take(most)
        .collect();
    worst.sort_unstable();
    worst
}

fn direction(integrals: &Integrals<F>, moments: &SmoothMoments) -> Split {
    let scales = scales(moments);
    let [u, v] = [0, 1].map(|d| (0..F).map(|f| integrals.directions[f][d] / scales[f]).fold(0.0, f64::max));
    if u > 8.0 * v {
        Split::U
    } else if v > 8.0 * u {
        Split::V
    } else {
        Split::Both
    }
}
