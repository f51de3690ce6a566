//! Adaptive quadrature: intervals, each with a Kronrod rule, of which those with the largest errors are halved.
//!
//! An interval with what the rule has given on it is called a panel. What is integrated differs: functions of an orbit
//! ([`super::family`]), the probabilities of many bins ([`super::by_orbits`]), and functions of a leaf
//! ([`super::over_leaves`]).

use super::rules::{POINTS, kronrod};

/// An interval of the variable of integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// Nodes, Kronrod weights and Gauss weights.
    pub(crate) fn nodes(self) -> [(f64, f64, f64); POINTS] {
        let (middle, half) = (self.low.midpoint(self.high), 0.5 * (self.high - self.low));
        kronrod().map(|(x, kronrod, gauss)| (middle + half * x, half * kronrod, half * gauss))
    }

    pub(crate) fn halves(self) -> [Self; 2] {
        let middle = self.low.midpoint(self.high);
        [Self { high: middle, ..self }, Self { low: middle, ..self }]
    }

    /// Whether the nodes of the halves are still different numbers.
    pub(crate) fn can_be_halved(self) -> bool {
        self.high - self.low > 1e3 * f64::EPSILON * self.low.abs().max(self.high.abs())
    }
}

/// The error of a Kronrod rule, from its difference to the Gauss rule and the size of the integral. Where the
/// difference is large, the integrand is rough and the error is the difference itself; for a smooth integrand it is
/// QUADPACK's power 3/2.
pub(super) fn kronrod_error(difference: f64, size: f64) -> f64 {
    if size <= 0.0 {
        return 0.0;
    }
    let relative = difference.abs() / size;
    let estimate = if relative > 1.0 / 200f64.powi(3) { relative } else { (200.0 * relative).powf(1.5) };
    size * estimate.max(f64::EPSILON)
}

/// The positions of the fewest intervals without which the others have less than half of the tolerated error, given the
/// share of each in it; at most `most`, in ascending order.
pub(super) fn worst(shares: &[f64], most: usize, can_be_halved: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..shares.len()).filter(|&i| shares[i] > 0.0 && can_be_halved(i)).collect();
    order.sort_by(|&a, &b| shares[b].total_cmp(&shares[a]).then(a.cmp(&b)));
    let mut rest: f64 = shares.iter().sum();
    let needed = order.iter().take_while(|&&i| {
        let wanted = rest > 0.5;
        rest -= shares[i];
        wanted
    });
    let mut worst: Vec<usize> = needed.copied().take(most).collect();
    worst.sort_unstable();
    worst
}

/// Removes the entries at these positions, which ascend.
pub(super) fn remove<T>(entries: &mut Vec<T>, positions: &[usize]) {
    let mut position = 0;
    entries.retain(|_| {
        position += 1;
        positions.binary_search(&(position - 1)).is_err()
    });
}
