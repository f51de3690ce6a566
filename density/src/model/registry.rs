//! Every planar model by its name.
//!
//! A model is made here from the named numbers of a scenario. Its name and the names, symbols and ranges of its
//! parameters are stated in the model's own file alone ([`Named`]), and this file lists the models. The keys by which
//! scenario files give the parameters are declared once more in `nodes/src/files/scenario_file/orbit.rs`.

use super::Task;
use super::parameter::{Named, Parameter};
use super::planar::SrpJ2;
use super::plane::{PlanarHamiltonian, State};
use super::quantity::Quantity;
use super::sun_moon::SunMoon;
use crate::flow::FromEquations;
use crate::flow::carry::{Carry, Loss};
use crate::problem_error::ProblemError;

/// The registry: a planar model is registered by its place in this list, which is handed to the macro that is named.
macro_rules! registered {
    ($to:ident) => {
        $to!(SrpJ2, SunMoon);
    };
}
pub(crate) use registered;

/// An enumeration of models that is itself a model.
macro_rules! planar_models {
    ($($variant:ident),+ $(,)?) => {
        /// Any planar model of the registry.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Planar {
            $(#[doc = concat!("See [`", stringify!($variant), "`].")] $variant($variant)),+
        }

        $(impl From<$variant> for Planar {
            fn from(model: $variant) -> Self {
                Self::$variant(model)
            }
        })+

        impl Planar {
            /// The names of all models, each with its parameters.
            pub const ALL: &'static [(&'static str, &'static [Parameter])] =
                &[$((<$variant as Named>::NAME, <$variant as Named>::PARAMETERS)),+];

            /// The model `name` of a satellite, see [`Named::of_satellite`]; `None` if there is no such model.
            pub fn of_satellite(
                name: &str,
                semi_major_axis: f64,
                area_to_mass: f64,
                reflectivity: f64,
            ) -> Option<Result<Self, ProblemError>> {
                $(if name == <$variant as Named>::NAME {
                    let made = <$variant as Named>::of_satellite(semi_major_axis, area_to_mass, reflectivity);
                    return Some(made.map(Self::$variant));
                })+
                None
            }

            fn make(name: &str, values: &[f64]) -> Option<Self> {
                $(if name == <$variant as Named>::NAME {
                    return <$variant as Named>::from_parameters(values).map(Self::$variant);
                })+
                None
            }

            /// The model's name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => <$variant as Named>::NAME),+ }
            }
        }

        impl PlanarHamiltonian for Planar {
            type Series<const P: usize> = FromEquations<Self, P>;

            fn motion<T: Quantity>(&self, state: State<T>) -> State<T> {
                match self { $(Self::$variant(model) => model.motion(state)),+ }
            }

            fn hamiltonian(&self, state: State) -> f64 {
                match self { $(Self::$variant(model) => model.hamiltonian(state)),+ }
            }

            fn hamiltonian_range(&self, phi: (f64, f64), e: (f64, f64)) -> (f64, f64) {
                match self { $(Self::$variant(model) => model.hamiltonian_range(phi, e)),+ }
            }

            fn parameters(&self) -> Vec<(Parameter, f64)> {
                match self { $(Self::$variant(model) => model.parameters()),+ }
            }

            fn pull(&self) -> f64 {
                match self { $(Self::$variant(model) => model.pull()),+ }
            }

            fn turning_rate(&self, state: State) -> f64 {
                match self { $(Self::$variant(model) => model.turning_rate(state)),+ }
            }

            fn eccentricity_follows_x1(&self) -> bool {
                match self { $(Self::$variant(model) => model.eccentricity_follows_x1()),+ }
            }

            fn pace(&self, state: State) -> f64 {
                match self { $(Self::$variant(model) => model.pace(state)),+ }
            }

            fn slope_on_axis(&self, q: f64) -> f64 {
                match self { $(Self::$variant(model) => model.slope_on_axis(q)),+ }
            }

            fn stationary_points_off_axis(&self) -> Vec<State> {
                match self { $(Self::$variant(model) => model.stationary_points_off_axis()),+ }
            }

            fn polar_rates(&self, phi: f64, e: f64) -> (f64, f64) {
                match self { $(Self::$variant(model) => model.polar_rates(phi, e)),+ }
            }

            fn eccentricity_squared_rates(&self, state: State) -> [f64; 2] {
                match self { $(Self::$variant(model) => model.eccentricity_squared_rates(state)),+ }
            }

            /// Hands the task to the model that this one stands for, so that no choice between models is made within
            /// it.
            fn perform_in_plane<T: Task>(&self, task: T) -> T::Output {
                match self { $(Self::$variant(model) => model.perform_in_plane(task)),+ }
            }

            fn carry_in_plane(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
                match self { $(Self::$variant(model) => model.carry_in_plane(orbits)),+ }
            }
        }
    };
}

registered!(planar_models);

/// Why no model can be made of a name and parameters.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// No model has this name.
    #[error("there is no planar model \"{name}\"; there are {}", names())]
    Unknown {
        /// The name that was asked for.
        name: String,
    },
    /// A parameter is missing.
    #[error("the model \"{model}\" has no value for its parameter {parameter}")]
    Missing {
        /// The model.
        model: &'static str,
        /// The parameter's name.
        parameter: &'static str,
    },
    /// A parameter that the model does not have.
    #[error("the model \"{model}\" has no parameter \"{parameter}\"; it has {}", .known.join(", "))]
    Superfluous {
        /// The model.
        model: &'static str,
        /// The parameter that was given.
        parameter: String,
        /// The parameters that the model has.
        known: Vec<&'static str>,
    },
}

fn names() -> String {
    Planar::ALL.iter().map(|&(name, _)| name).collect::<Vec<_>>().join(", ")
}

/// A model of this name with these parameters that was given another one.
fn superfluous(model: &'static str, parameters: &[Parameter], other: &str) -> ModelError {
    let known = parameters.iter().map(|parameter| parameter.name).collect();
    ModelError::Superfluous { model, parameter: other.into(), known }
}

/// The name of the planar model in which these forces act and as few others as can be; `None` if there is no such
/// model.
pub fn with_forces(forces: &[&str]) -> Option<&'static str> {
    let acts = |parameters: &[Parameter], force: &str| parameters.iter().any(|parameter| parameter.force == force);
    let fitting = Planar::ALL.iter().filter(|(_, parameters)| forces.iter().all(|force| acts(parameters, force)));
    fitting.min_by_key(|(_, parameters)| parameters.len()).map(|(name, _)| *name)
}

/// The forces of all models, each once, in the order in which models name them.
pub fn forces() -> Vec<&'static str> {
    let mut forces = Vec::new();
    for parameter in Planar::ALL.iter().flat_map(|(_, parameters)| *parameters) {
        if !forces.contains(&parameter.force) {
            forces.push(parameter.force);
        }
    }
    forces
}

/// The forces that act where a scenario names none: those of the paper.
pub const DEFAULT_FORCES: [&str; 2] = ["srp", "j2"];

/// The parameters of the model `name`; none if there is no such model.
pub fn parameters(name: &str) -> &'static [Parameter] {
    Planar::ALL.iter().find(|(known, _)| *known == name).map_or(&[], |(_, parameters)| parameters)
}

impl Planar {
    /// Whether there is a planar model of this name.
    pub fn has(name: &str) -> bool {
        Self::ALL.iter().any(|(known, _)| *known == name)
    }

    /// The model `name` with these named parameters, in any order. Whether their values are right is checked with the
    /// problem ([`crate::problem::Problem::new`]).
    ///
    /// # Errors
    /// [`ModelError`] says which name is wrong and which would be right.
    pub fn by_name(name: &str, given: &[(&str, f64)]) -> Result<Self, ModelError> {
        let unknown = || ModelError::Unknown { name: name.into() };
        let &(model, parameters) = Self::ALL.iter().find(|(known, _)| *known == name).ok_or_else(unknown)?;
        if let Some((parameter, _)) =
            given.iter().find(|(given, _)| parameters.iter().all(|known| known.name != *given))
        {
            return Err(superfluous(model, parameters, parameter));
        }
        let value = |parameter: &Parameter| {
            let found = given.iter().find(|(name, _)| *name == parameter.name);
            found.map(|&(_, value)| value).ok_or(ModelError::Missing { model, parameter: parameter.name })
        };
        let values: Vec<f64> = parameters.iter().map(value).collect::<Result<_, _>>()?;
        Self::make(name, &values).ok_or_else(unknown)
    }
}

impl Planar {
    /// The value of a parameter, by its name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters().into_iter().find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
    }

    /// The same model with another value of a parameter.
    ///
    /// # Errors
    /// [`ModelError::Superfluous`] if it has no such parameter.
    pub fn with(&self, name: &str, value: f64) -> Result<Self, ModelError> {
        let values: Vec<(&str, f64)> = self
            .parameters()
            .into_iter()
            .map(|(parameter, old)| (parameter.name, if parameter.name == name { value } else { old }))
            .collect();
        match self.value(name) {
            Some(_) => Self::by_name(self.name(), &values),
            None => Err(superfluous(self.name(), parameters(self.name()), name)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_made_from_its_name_and_the_names_of_its_parameters() {
        let made = Planar::by_name("planar", &[("oblateness", 0.4), ("radiation", 0.15)]).unwrap();
        assert_eq!(made, Planar::SrpJ2(SrpJ2 { radiation: 0.15, oblateness: 0.4 }));
        let parameters: Vec<_> =
            made.parameters().into_iter().map(|(parameter, value)| (parameter.name, value)).collect();
        assert_eq!((made.name(), parameters), ("planar", vec![("radiation", 0.15), ("oblateness", 0.4)]));
    }

    #[test]
    fn a_wrong_name_is_told_with_those_that_would_be_right() {
        let told = |name: &str, given: &[(&str, f64)]| Planar::by_name(name, given).unwrap_err().to_string();
        assert!(told("kepler", &[]).contains("there are planar"));
        assert!(told("planar", &[("radiation", 0.1)]).contains("oblateness"));
        assert!(told("planar", &[("drag", 0.1)]).contains("it has radiation, oblateness"));
    }

    #[test]
    fn a_registered_model_moves_orbits_as_it_does_by_itself() {
        let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
        let start = State::from_polar(2.2, 0.145);
        let end = crate::flow::Flow::new(force).advance_one(start, 2.0).unwrap();
        assert_eq!(crate::flow::Flow::new(Planar::from(force)).advance_one(start, 2.0).unwrap(), end);
    }
}
