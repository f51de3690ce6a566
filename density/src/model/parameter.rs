//! The parameters of a model, by name.

use crate::problem_error::{Field, ProblemError, check};

/// A parameter of a model, a pure number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Its name in a scenario file: `radiation`.
    pub name: &'static str,
    /// Its symbol in equations: `C`.
    pub symbol: &'static str,
    /// The force whose strength it is: `srp`. Where it is 0 that force does not act.
    pub force: &'static str,
    /// The least that it may be.
    pub low: f64,
    /// The largest permitted value.
    pub high: f64,
}

/// Checks that parameters are in their ranges.
///
/// # Errors
/// [`ProblemError`] with the first that is not.
pub(crate) fn check_ranges(parameters: &[(Parameter, f64)]) -> Result<(), ProblemError> {
    parameters.iter().try_for_each(|&(Parameter { name, low, high, .. }, value)| {
        let right = match low == 0.0 {
            true => format!("0 or greater, at most {high}"),
            false => format!("between {low} and {high}"),
        };
        check(Field::Parameter(name), value, (low..=high).contains(&value), right)
    })
}

/// A model with a name, made from parameters with names.
pub trait Named: Sized {
    /// The model's name in a scenario file.
    const NAME: &'static str;
    /// Its parameters, in the order in which they are given.
    const PARAMETERS: &'static [Parameter];

    /// The model with these values of its parameters; `None` if there are more or fewer.
    fn from_parameters(values: &[f64]) -> Option<Self>;

    /// The model of a satellite: its semi-major axis in Earth radii, its area-to-mass ratio in m²/kg and its
    /// reflectivity.
    ///
    /// # Errors
    /// [`ProblemError`] with the first of these that is not in its range.
    fn of_satellite(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Result<Self, ProblemError>;
}
