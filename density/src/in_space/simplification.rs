//! The simpler models that a case may take in the place of its scenario's.

use crate::model::space_registry::{OSCULATING, PLANAR, VECTORIAL};

/// The model in which a case moves its orbits, if it is not the scenario's: a simpler one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simplification {
    /// Orbit, Sun and Moon in one plane, averaged over the revolutions.
    Planar,
    /// Averaged over the revolutions of the satellite and the Moon.
    Vectorial,
    /// Not averaged.
    Osculating,
}

impl Simplification {
    /// All there are.
    pub const ALL: [Self; 3] = [Self::Planar, Self::Vectorial, Self::Osculating];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Planar => PLANAR,
            Self::Vectorial => VECTORIAL,
            Self::Osculating => OSCULATING,
        }
    }

    /// The one of this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }
}
