//! Whether and when the orbits of a cell first reach the critical value of the re-entry variable.
//!
//! The time of the first passage is a smooth function of the start only among orbits that pass: at the edge of their
//! set, where orbits just touch the critical value, it has the slope of a square root, and beyond there is none. So it
//! is interpolated only in cells in which all orbits pass, and known to be none only where none passes. Which is the
//! case follows from how near each orbit of the lattice comes ([`Flow::carry_approaching`](crate::flow::Flow)), its
//! margin: a cell is decided only where every margin is larger than the difference of the margins of any two neighbours
//! on the lattice, so that no orbit between them can be on the other side. Other cells are halved, and in the end their
//! orbits are propagated directly.

use super::chebyshev::{Basis, Polynomial};

/// When the orbits of a cell pass.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Passing<const N: usize> {
    /// Nobody has asked.
    Unasked,
    /// None passes before the last snapshot.
    Never,
    /// At the time of the polynomial \[yr\].
    At(Polynomial<N>),
}

/// What is known of the passages of a cell.
#[derive(Debug)]
pub(super) enum Decision<const N: usize> {
    /// When the orbits pass, with an estimate of the error of the time \[yr\].
    Known(Passing<N>, f64),
    /// The cell must be halved along this axis.
    Halve(usize),
}

/// Largest error of an interpolated passage time \[yr\].
pub(super) const TIME_ERROR: f64 = 1e-7;

/// The orbits of a cell: those at the nodes, then those by which the polynomial is checked.
pub(super) struct Orbits<'a, const N: usize> {
    /// When each passes \[yr\]; infinite for one that does not.
    pub times: &'a [f64],
    /// The least clearance of each.
    pub lowest: &'a [f64],
    /// The clearance at which they pass.
    pub critical: f64,
    /// Where the further orbits start, in local coordinates.
    pub checks: &'a [[f64; N]],
}

impl<const N: usize> Orbits<'_, N> {
    /// Whether and when all orbits of the cell pass.
    pub fn decide(&self, basis: &Basis) -> Decision<N> {
        let nodes = basis.len::<N>();
        let margin = |i: usize| self.lowest[i] - self.critical;
        let (steps, axis) = steepest::<N>(basis, &self.lowest[..nodes]);
        let all = |condition: &dyn Fn(f64) -> bool| (0..self.lowest.len()).all(|i| condition(margin(i)));
        if all(&|margin| margin > steps) {
            return Decision::Known(Passing::Never, 0.0);
        }
        // An orbit that starts beyond the critical value passes at the start, whatever its neighbours do: a kink.
        let at_start = self.times.iter().filter(|time| **time == 0.0).count();
        let is_whole = at_start == 0 || at_start == self.times.len();
        if !is_whole || !all(&|margin| margin < -steps) || self.times.iter().any(|time| !time.is_finite()) {
            return Decision::Halve(axis);
        }
        let mut coefficients = self.times[..nodes].to_vec();
        basis.transform::<N>(&mut coefficients);
        let polynomial = Polynomial::new(basis, &coefficients, 0.01 * TIME_ERROR / basis.count as f64);
        let off = |(check, time): (&[f64; N], &f64)| (polynomial.at(check) - time).abs();
        let checked = self.checks.iter().zip(&self.times[nodes..]).map(off).fold(0.0, f64::max);
        let tails = basis.tails::<N>(&coefficients);
        let error = tails.iter().map(|tail| tail.next).sum::<f64>().max(checked);
        if error <= TIME_ERROR {
            return Decision::Known(Passing::At(polynomial), error);
        }
        Decision::Halve((0..N).max_by(|&a, &b| tails[a].last.total_cmp(&tails[b].last)).unwrap_or(0))
    }
}

/// The largest difference of neighbours on the lattice, and the axis along which it is found.
fn steepest<const N: usize>(basis: &Basis, values: &[f64]) -> (f64, usize) {
    let along = |axis: usize| {
        let stride = basis.count.pow((N - 1 - axis) as u32);
        let is_last = |i: usize| i / stride % basis.count + 1 == basis.count;
        let steps = (0..values.len()).filter(|&i| !is_last(i)).map(|i| (values[i + stride] - values[i]).abs());
        steps.fold(0.0, |most: f64, step| if step.is_nan() { f64::INFINITY } else { most.max(step) })
    };
    (0..N).map(|axis| (along(axis), axis)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
}
