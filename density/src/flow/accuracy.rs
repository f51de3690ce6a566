//! How accurately orbits are propagated.

/// How accurately orbits are propagated, given as the largest error of `x1` or `x2` after two years in the paper's
/// scenarios. The error grows about linearly with time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// 1e-6: enough for pictures.
    Coarse,
    /// 1e-9: far below any sampling error.
    Medium,
    /// 1e-12; the Hamiltonian is conserved to the same accuracy.
    #[default]
    Fine,
}

impl Accuracy {
    /// All levels, the coarsest first.
    pub const ALL: [Self; 3] = [Self::Coarse, Self::Medium, Self::Fine];

    /// The largest error of `x1` or `x2` after two years.
    pub fn largest_error(self) -> f64 {
        match self {
            Self::Coarse => 1e-6,
            Self::Medium => 1e-9,
            Self::Fine => 1e-12,
        }
    }
}
