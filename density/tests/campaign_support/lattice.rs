//! Orbits on lines of constant solar angle that fill the initial Gaussian.
//!
//! Along `phi` the lines are evenly spaced, over 8 standard deviations to either side. If that is more than a circle,
//! they go round the circle, and their weight is the Gaussian summed over all turns. Both sums converge faster than any
//! power. Along `e` the nodes are the middles of even cells of a parameter `x`. Where the Gaussian is cut at `e = 0` or
//! `e = 1` within 8 standard deviations, `e(x)` is a polynomial with three vanishing derivatives at both ends, so that
//! the convergence is still of order `1/n⁴` or better.

use std::f64::consts::{PI, SQRT_2, TAU};

use density::problem::InitialGaussian;

/// Standard deviations beyond which the Gaussian counts as zero.
const REACH: f64 = 8.0;

/// Lines and nodes.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// Solar angle of each line \[rad\].
    pub phi: Vec<f64>,
    /// Probability of each line.
    pub line_weight: Vec<f64>,
    /// Whether the last line is a neighbour of the first.
    pub periodic: bool,
    /// Eccentricity of each node of a line.
    pub e: Vec<f64>,
    /// Weight of each node of a line in an integral along it.
    pub node_weight: Vec<f64>,
    gaussian: InitialGaussian,
    low: f64,
    high: f64,
    cut: bool,
    mass: f64,
}

impl Lattice {
    /// A lattice of `lines` lines with `nodes` nodes each.
    pub fn new(gaussian: InitialGaussian, lines: usize, nodes: usize) -> Self {
        let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, .. } = gaussian;
        let (below, above) = (mean_e - REACH * sigma_e, mean_e + REACH * sigma_e);
        let periodic = 2.0 * REACH * sigma_phi >= TAU;
        let width = if periodic { TAU } else { 2.0 * REACH * sigma_phi };
        let middle = |i: usize| mean_phi + width * ((i as f64 + 0.5) / lines as f64 - 0.5);
        let mut lattice = Self {
            phi: (0..lines).map(middle).collect(),
            line_weight: Vec::new(),
            periodic,
            e: Vec::new(),
            node_weight: Vec::new(),
            gaussian,
            low: below.max(0.0),
            high: above.min(1.0),
            cut: below < 0.0 || above > 1.0,
            mass: 1.0,
        };
        lattice.mass = lattice.probability(lattice.low, lattice.high);
        lattice.line_weight = normalised(lattice.phi.iter().map(|&phi| lattice.line_density(phi)).collect());
        let x = |j: usize| (j as f64 + 0.5) / nodes as f64;
        lattice.e = (0..nodes).map(|j| lattice.e_at(x(j))).collect();
        lattice.node_weight = normalised((0..nodes).map(|j| lattice.density_in_x(x(j))).collect());
        lattice
    }

    /// Number of orbits.
    pub fn len(&self) -> usize {
        self.phi.len() * self.e.len()
    }

    /// The starting points of all orbits, line after line.
    pub fn starts(&self) -> Vec<[f64; 2]> {
        self.phi.iter().flat_map(|&phi| self.e.iter().map(move |&e| [phi, e])).collect()
    }

    /// Distance of neighbouring lines \[rad\].
    pub fn spacing(&self) -> f64 {
        self.phi[1] - self.phi[0]
    }

    /// Density of the initial solar angle, summed over all turns, up to a constant factor.
    pub fn line_density(&self, phi: f64) -> f64 {
        let InitialGaussian { mean_phi, sigma_phi, .. } = self.gaussian;
        let turns = if self.periodic { (1.0 + REACH * sigma_phi / TAU).ceil() as i32 } else { 0 };
        (-turns..=turns).map(|k| (-0.5 * ((phi + TAU * f64::from(k) - mean_phi) / sigma_phi).powi(2)).exp()).sum()
    }

    /// `e(x)`.
    pub fn e_at(&self, x: f64) -> f64 {
        let share = if self.cut { x.powi(4) * (35.0 - x * (84.0 - x * (70.0 - 20.0 * x))) } else { x };
        self.low + (self.high - self.low) * share
    }

    /// Probability density along a line with respect to `x`.
    pub fn density_in_x(&self, x: f64) -> f64 {
        let stretch = if self.cut { 140.0 * (x * (1.0 - x)).powi(3) } else { 1.0 };
        let InitialGaussian { mean_e, sigma_e, .. } = self.gaussian;
        let z = (self.e_at(x) - mean_e) / sigma_e;
        (-0.5 * z * z).exp() / (sigma_e * (2.0 * PI).sqrt() * self.mass) * stretch * (self.high - self.low)
    }

    /// Probability along a line between two eccentricities.
    pub fn probability(&self, from: f64, to: f64) -> f64 {
        let InitialGaussian { mean_e, sigma_e, .. } = self.gaussian;
        let (a, b) = ((from - mean_e) / sigma_e, (to - mean_e) / sigma_e);
        let tail = |z: f64| 0.5 * libm::erfc(z / SQRT_2);
        // Taken from the side on which no digits cancel.
        let between = if a + b > 0.0 { tail(a) - tail(b) } else { tail(-b) - tail(-a) };
        between / self.mass
    }

    /// Error of the sum over lines of one share per line, `shares`, if the share jumps within few lines.
    ///
    /// A step of size `S` that a Gaussian of `σ` line spacings smooths is summed with the error `exp(-2π²σ²)` (the
    /// first term of Poisson's summation formula). Its steepest part is `S/(σ √2π)` per line, with σ² less 1/12 for the
    /// width of a line.
    pub fn doubt_of_steps(&self, shares: &[f64]) -> f64 {
        let heaviest = self.line_weight.iter().copied().fold(0.0, f64::max);
        let steps = || shares.windows(2).zip(&self.line_weight).filter(|(_, weight)| **weight > 1e-10 * heaviest);
        let steepest = steps().map(|(pair, _)| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        if steepest < 1e-12 {
            return 0.0;
        }
        let least = steps().map(|(pair, _)| pair[0].min(pair[1])).fold(f64::INFINITY, f64::min);
        let most = steps().map(|(pair, _)| pair[0].max(pair[1])).fold(f64::NEG_INFINITY, f64::max);
        let variance = (((most - least) / steepest).powi(2) / TAU - 1.0 / 12.0).max(0.0);
        let weighted: f64 = steps().map(|(pair, weight)| weight * (pair[1] - pair[0]).abs()).sum();
        weighted * (-2.0 * PI * PI * variance).exp()
    }

    /// Eccentricity at the border below node `j`.
    pub fn border(&self, j: usize) -> f64 {
        self.e_at(j as f64 / self.e.len() as f64)
    }
}

fn normalised(weights: Vec<f64>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}
