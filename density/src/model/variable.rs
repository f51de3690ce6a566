//! The name of a model's variable and the values that it takes.

use std::fmt;

/// A variable in which orbits are given and read out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// Its name: `solar angle`.
    pub name: &'static str,
    /// Its symbol in columns and messages: `phi`.
    pub symbol: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// Which values it takes.
    pub kind: Kind,
}

/// Which values a variable takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// An angle without a natural start \[rad\]: values a turn apart are the same.
    Circle,
    /// Numbers between two bounds, both excluded.
    Interval {
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
    },
}

impl Variable {
    /// Whether it is an angle without a natural start.
    pub fn is_circle(&self) -> bool {
        self.kind == Kind::Circle
    }

    /// Whether a value is one that the variable takes.
    pub fn allows(&self, value: f64) -> bool {
        match self.kind {
            Kind::Circle => value.is_finite(),
            Kind::Interval { low, high } => low < value && value < high,
        }
    }
}

/// Largest number of variables of a model: the elements of an orbit and its radiation parameter.
pub const MOST_VARIABLES: usize = 7;

/// The place of an orbit in the variables of its model: `phi = 2.2 rad, e = 0.1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The variables.
    pub variables: &'static [Variable],
    /// Their values; those after the last variable mean nothing.
    pub values: [f64; MOST_VARIABLES],
}

impl Place {
    /// From the values of all variables.
    pub fn new(variables: &'static [Variable], value: impl Fn(usize) -> f64) -> Self {
        let values = std::array::from_fn(|k| if k < variables.len() { value(k) } else { 0.0 });
        Self { variables, values }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, (Variable { symbol, unit, .. }, value)) in self.variables.iter().zip(self.values).enumerate() {
            let (comma, space) = (if k > 0 { ", " } else { "" }, if unit.is_empty() { "" } else { " " });
            write!(f, "{comma}{symbol} = {value}{space}{unit}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_told_in_the_models_symbols_and_units() {
        const VARIABLES: [Variable; 2] = [
            Variable { name: "solar angle", symbol: "phi", unit: "rad", kind: Kind::Circle },
            Variable { name: "eccentricity", symbol: "e", unit: "", kind: Kind::Interval { low: 0.0, high: 1.0 } },
        ];
        assert_eq!(Place::new(&VARIABLES, |k| [0.5, 0.25][k]).to_string(), "phi = 0.5 rad, e = 0.25");
    }
}
