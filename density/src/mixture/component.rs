//! A component of a mixture over the variables of any model.

/// One Gaussian of a mixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component<const N: usize> {
    /// Share of the probability.
    pub weight: f64,
    /// Mean.
    pub mean: [f64; N],
    /// Covariance.
    pub covariance: [[f64; N]; N],
}
