//! How accurately orbits are propagated.

/// How accurately orbits are propagated: the largest error of `x1` or `x2` after two years in the paper's scenarios. It
/// grows about linearly with time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// 1e-6: enough for pictures.
    Coarse,
    /// 1e-9: far below any sampling error.
    Medium,
    /// 1e-12; the Hamiltonian is kept as well.
    #[default]
    Fine,
}

impl Accuracy {
    /// All, the coarsest first.
    pub const ALL: [Self; 3] = [Self::Coarse, Self::Medium, Self::Fine];

    /// The largest error.
    pub fn largest_error(self) -> f64 {
        match self {
            Self::Coarse => 1e-6,
            Self::Medium => 1e-9,
            Self::Fine => 1e-12,
        }
    }
}
