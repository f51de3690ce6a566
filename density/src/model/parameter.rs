//! The parameters of a model, by name.

/// A parameter of a model, a pure number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Its name in a scenario file: `radiation`.
    pub name: &'static str,
    /// Its symbol in equations: `C`.
    pub symbol: &'static str,
    /// The smallest permitted value.
    pub low: f64,
    /// The largest permitted value.
    pub high: f64,
}

/// A model with a name, made from parameters with names.
pub trait Named: Sized {
    /// The model's name in a scenario file.
    const NAME: &'static str;
    /// Its parameters, in the order in which they are given.
    const PARAMETERS: &'static [Parameter];

    /// The model with these values of its parameters; `None` if there are more or fewer.
    fn from_parameters(values: &[f64]) -> Option<Self>;
}
