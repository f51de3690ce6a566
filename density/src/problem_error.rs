//! Errors of a problem: the field that is wrong, its value, and which values are allowed.

use std::f64::consts::TAU;
use std::fmt;

/// A field of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// A parameter of the model, or a parameter of the orbit from which those of the model follow, by its name.
    Parameter(&'static str),
    /// Mean solar angle.
    MeanPhi,
    /// Mean eccentricity.
    MeanE,
    /// Two standard deviations of the solar angle, the paper's `Δphi`.
    DeltaPhi,
    /// Two standard deviations of the eccentricity, the paper's `Δe`.
    DeltaE,
    /// Correlation of the solar angle and the eccentricity.
    Correlation,
    /// Relative standard deviation of the radiation parameter.
    SigmaRadiation,
    /// The snapshot times.
    Times,
    /// The eccentricity at which the satellite re-enters.
    CriticalE,
    /// Mean inclination.
    MeanInclination,
    /// Mean longitude of the ascending node.
    MeanNode,
    /// Standard deviation of a variable in space, by its name in a scenario file.
    Sigma(&'static str),
    /// Correlation of two variables in space, by its name in a scenario file.
    CorrelationOf(&'static str),
    /// The correlations in space together.
    Correlations,
    /// The obliquity of the ecliptic.
    Obliquity,
    /// The longitude of the Sun at the start.
    SunLongitude,
    /// The model.
    Model,
    /// The Earth's shadow.
    Shadow,
    /// The height at which the satellite re-enters.
    ReentryAltitude,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Parameter(name) => name,
            Self::MeanPhi => "the mean solar angle",
            Self::MeanE => "the mean eccentricity",
            Self::DeltaPhi => "delta_phi, two standard deviations of the solar angle,",
            Self::DeltaE => "delta_e, two standard deviations of the eccentricity,",
            Self::Correlation => "the correlation of the solar angle and the eccentricity",
            Self::SigmaRadiation => "the relative standard deviation of the radiation parameter",
            Self::Times => "a snapshot time",
            Self::CriticalE => "the critical eccentricity",
            Self::MeanInclination => "the mean inclination",
            Self::MeanNode => "the mean longitude of the ascending node",
            Self::Sigma(variable) => return write!(f, "the standard deviation of {variable}"),
            Self::CorrelationOf(pair) => return write!(f, "the correlation {pair}"),
            Self::Correlations => "the correlations",
            Self::Obliquity => "the obliquity of the ecliptic",
            Self::SunLongitude => "the longitude of the Sun",
            Self::Model => "the model",
            Self::Shadow => "the Earth's shadow",
            Self::ReentryAltitude => "the height of re-entry",
        })
    }
}

/// A problem that cannot be solved as it stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {}", self.problem())]
pub struct ProblemError {
    /// The field that is wrong.
    pub field: Field,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// A value that is not allowed.
    Value {
        /// The value.
        value: f64,
        /// Which values are allowed: `between 0 and 1, both excluded`.
        right: String,
    },
    /// It does not fit the rest of the problem, or what is asked of it: why, and what would be right.
    Misfit(String),
}

impl ProblemError {
    /// A field that does not fit the rest of the problem.
    pub(crate) fn misfit(field: Field, problem: impl Into<String>) -> Self {
        Self { field, fault: Fault::Misfit(problem.into()) }
    }

    /// The text without the name of the field, for callers that name the field themselves.
    pub fn problem(&self) -> String {
        match &self.fault {
            Fault::Value { value, right } => format!("{value} is not allowed, it must be {right}"),
            Fault::Misfit(problem) => problem.clone(),
        }
    }
}

/// Refuses a value that is not right or not finite.
pub(crate) fn check(field: Field, value: f64, is_right: bool, right: String) -> Result<(), ProblemError> {
    match value.is_finite() && is_right {
        true => Ok(()),
        false => Err(ProblemError { field, fault: Fault::Value { value, right } }),
    }
}

/// A full turn \[rad\], with a margin for a turn that was written with six digits.
const TURN: f64 = TAU + 1e-5;

/// Refuses an angle that is not between `low` and a full turn. If it is larger, the message suggests that degrees may
/// be meant.
pub(crate) fn check_angle(field: Field, value: f64, low: f64, range: &str) -> Result<(), ProblemError> {
    let is_right = |angle: f64| (low.max(-TURN)..=TURN).contains(&angle);
    let hint = match value.to_radians() {
        radians if value.abs() > TURN && is_right(radians) => {
            format!("; if {value} degrees are meant, write {radians:.7}")
        }
        _ => String::new(),
    };
    check(field, value, is_right(value), format!("an angle in radians, {range}{hint}"))
}
