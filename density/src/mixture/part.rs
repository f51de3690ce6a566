//! A part of a Gaussian with what the flow does to it, and how much of that it may have.

use super::curvature::Curvature;
use super::pieces::Piece;

/// Weight from which on a part may disagree by no more than the tolerance.
const FULL_WEIGHT: f64 = 1e-4;
/// The error of the moments that a part may add, as a share of the cloud's variance.
const MOMENT_SHARE: f64 = 1e-8;
/// A part and what the flow does to it.
#[derive(Debug, Clone)]
pub(super) struct Part<const N: usize> {
    pub piece: Piece<N>,
    /// `D_c` at each time.
    pub disagreements: Vec<f64>,
    /// `E_c` at each time.
    pub moment_errors: Vec<f64>,
    /// The second differences at the times at which `D_c` and `E_c` are largest.
    pub worst: Option<[Curvature<N>; 2]>,
    /// The direction in which the part reaches across a bound.
    pub across: Option<[f64; N]>,
}

/// How much more than allowed a part disagrees and adds to the error of the moments; it must be split if one of them is
/// above 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Excess {
    pub disagreement: f64,
    pub moments: f64,
}

impl Excess {
    pub fn largest(self) -> f64 {
        self.disagreement.max(self.moments)
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

impl<const N: usize> Part<N> {
    pub fn new(piece: Piece<N>, times: usize, across: Option<[f64; N]>) -> Self {
        Self { piece, disagreements: vec![0.0; times], moment_errors: vec![0.0; times], worst: None, across }
    }

    /// Takes what is known of the part at time number `index`; times come in their order.
    pub fn learn(&mut self, index: usize, found: Curvature<N>) {
        let (disagreement, error) = (found.disagreement(), found.moment_error());
        let worst = self.worst.get_or_insert([found; 2]);
        if disagreement > largest(&self.disagreements) {
            worst[0] = found;
        }
        if error > largest(&self.moment_errors) {
            worst[1] = found;
        }
        (self.disagreements[index], self.moment_errors[index]) = (disagreement, error);
    }

    /// The largest `D_c` that the part may have.
    pub fn allowed(&self, tolerance: f64) -> f64 {
        tolerance * (FULL_WEIGHT / self.piece.weight).sqrt().max(1.0)
    }

    pub fn excess(&self, tolerance: f64) -> Excess {
        if self.across.is_some() {
            return Excess { disagreement: f64::INFINITY, moments: f64::INFINITY };
        }
        Excess {
            disagreement: largest(&self.disagreements) / self.allowed(tolerance),
            moments: self.piece.weight * largest(&self.moment_errors) / MOMENT_SHARE,
        }
    }

    /// What decides which parts are split first.
    pub fn priority(&self, tolerance: f64) -> f64 {
        let Excess { disagreement, moments } = self.excess(tolerance);
        moments.max(disagreement * self.piece.weight / FULL_WEIGHT)
    }
}
