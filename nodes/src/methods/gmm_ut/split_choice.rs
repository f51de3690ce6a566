//! How the initial Gaussian is split, by the words of a launch file.

use density::mixture::criterion::Criterion;
use density::mixture::split::Direction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the initial Gaussian is split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SplitChoice {
    /// On a lattice planned for the problem.
    #[default]
    Adaptive,
    /// Along the solar angle, as the paper's text says.
    SolarAngle,
    /// Along the eccentricity, as the paper's numbers say.
    Eccentricity,
    /// Along both: `components` along `e` times `across` along `phi`.
    Both,
    /// Along the direction in which the flow is most nonlinear.
    StrongestNonlinearity,
    /// Along the direction of the largest uncertainty-scaled first-order stretching.
    Usfos,
    /// Along the direction of the largest whitened uncertainty-scaled second-order linearisation change.
    Wussolc,
}

impl SplitChoice {
    /// The direction along which a splitting library splits; `None` where there is no single one.
    pub(super) fn direction(self) -> Option<Direction> {
        match self {
            Self::Adaptive => None,
            Self::SolarAngle => Some(Direction::SolarAngle),
            Self::Eccentricity | Self::Both => Some(Direction::Eccentricity),
            Self::StrongestNonlinearity => Some(Direction::StrongestNonlinearity),
            Self::Usfos => Some(Direction::OfCriterion(Criterion::Usfos)),
            Self::Wussolc => Some(Direction::OfCriterion(Criterion::Wussolc)),
        }
    }
}
