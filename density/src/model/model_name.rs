//! The models that a scenario file, or a case that simplifies its scenario, can name.

use super::parameter::Named;
use super::planar::SrpJ2;

/// A model by which orbits of a cloud in space can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelName {
    /// Orbit, Sun and Moon in one plane, averaged over the revolutions of the satellite and the Moon.
    Planar,
    /// In space, averaged over the revolutions of the satellite and the Moon.
    Vectorial,
    /// In space, not averaged.
    Osculating,
}

impl ModelName {
    /// All models that can be named, the simplest first.
    pub const ALL: [Self; 3] = [Self::Planar, Self::Vectorial, Self::Osculating];

    /// The name as it is written in files, messages and tables.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Planar => SrpJ2::NAME,
            Self::Vectorial => "vectorial",
            Self::Osculating => "osculating",
        }
    }

    /// The model that this text names, if it names one.
    pub fn read(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.text() == text)
    }

    /// Whether orbits of the model have an inclination and a node.
    pub const fn is_in_space(self) -> bool {
        match self {
            Self::Planar => false,
            Self::Vectorial | Self::Osculating => true,
        }
    }

    /// Whether the model is averaged over the revolutions of the satellite.
    pub const fn is_averaged(self) -> bool {
        match self {
            Self::Planar | Self::Vectorial => true,
            Self::Osculating => false,
        }
    }

    /// The model that leaves out least of what this one has; `None` for the simplest one.
    pub const fn next_simpler(self) -> Option<Self> {
        match self {
            Self::Planar => None,
            Self::Vectorial => Some(Self::Planar),
            Self::Osculating => Some(Self::Vectorial),
        }
    }

    /// The names of the models of which this is true, in quotation marks, for a sentence.
    pub fn listed(is_meant: impl Fn(Self) -> bool) -> String {
        let names = Self::ALL.into_iter().filter(|name| is_meant(*name));
        names.map(|name| format!("\"{}\"", name.text())).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_name() {
        for name in ModelName::ALL {
            assert_eq!(ModelName::read(name.text()), Some(name));
        }
        assert_eq!(ModelName::read("kepler"), None);
        assert_eq!(ModelName::listed(ModelName::is_averaged), "\"planar\", \"vectorial\"");
    }
}
