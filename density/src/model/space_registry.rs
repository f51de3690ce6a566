//! Every model in space by its name.
//!
//! A model is made here from the named numbers of a scenario message, and says here which named numbers state it. The
//! names of the models are in [`ModelName`], those of the forces' parameters in the files of the planar models, and
//! those of all other parameters in this file. The keys of scenario files, most of which have the same names, are
//! declared once more in `nodes/src/files/scenario_file/`.

use std::f64::consts::FRAC_PI_2;

use super::irradiated::WithRadiation;
use super::model_name::ModelName;
use super::osculating::{self, Osculating};
use super::parameter::{Named, Parameter, check_ranges};
use super::planar::{OBLATENESS, RADIATION, SrpJ2};
use super::plane::PlanarHamiltonian;
use super::registry::{ModelError, Planar};
use super::shadow::ShadowedVectorial;
use super::sun_moon::{MOON, SUN, SunMoon};
use super::uncertain_radiation::{Linear, Logarithmic};
use super::vectorial::{self, Vectorial};
use super::{Task, Variable};
use crate::problem_error::{Field, ProblemError, check};
use crate::uncertain::Distribution;

/// A model in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpaceModel {
    /// Averaged.
    Vectorial {
        /// The model.
        model: Vectorial,
        /// The semi-major axis \[Earth radii\], if it is known.
        axis: Option<f64>,
    },
    /// Unaveraged.
    Osculating {
        /// The model.
        model: Osculating,
        /// The mean anomaly of all orbits at `t = 0` \[rad\]; where there is none, orbits are spread evenly over the
        /// revolution.
        mean_anomaly: Option<f64>,
    },
}

/// A parameter of a model in space as a message states it: its name, its symbol, and its value.
pub type Stated = (&'static str, &'static str, f64);

const OBLIQUITY: (&str, &str) = ("obliquity", "epsilon");
const SUN_LONGITUDE: (&str, &str) = ("sun_longitude", "l_sun");
const MOON_LONGITUDE: (&str, &str) = ("moon_longitude", "l_moon");
const SEMI_MAJOR_AXIS: (&str, &str) = ("semi_major_axis", "a");
const MEAN_ANOMALY: (&str, &str) = ("mean_anomaly", "M");

impl SpaceModel {
    /// Which model it is.
    pub fn model_name(&self) -> ModelName {
        match self {
            Self::Vectorial { .. } => ModelName::Vectorial,
            Self::Osculating { .. } => ModelName::Osculating,
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.model_name().text()
    }

    /// Whether it is averaged over the revolutions of the satellite, so that an orbit's place in its revolution is none
    /// of its variables.
    pub fn is_averaged(&self) -> bool {
        self.model_name().is_averaged()
    }

    /// The model itself if it is averaged over the revolutions of the satellite.
    pub fn if_averaged(&self) -> Option<Vectorial> {
        match *self {
            Self::Vectorial { model, .. } => Some(model),
            Self::Osculating { .. } => None,
        }
    }

    /// The variables of an orbit.
    pub fn variables(&self) -> &'static [Variable] {
        match self {
            Self::Vectorial { .. } => &vectorial::VARIABLES,
            Self::Osculating { .. } => &osculating::VARIABLES,
        }
    }

    /// Does a task with the model, in which the radiation parameter is a variable of the orbit if it has a
    /// distribution.
    pub fn perform<T: Task>(&self, distribution: Option<Distribution>, task: T) -> T::Output {
        match (*self, distribution) {
            (Self::Vectorial { model, .. }, None) => task.with(&model),
            (Self::Vectorial { model, .. }, Some(Distribution::Gaussian)) => {
                task.with(&WithRadiation::<_, Linear>::new(model))
            }
            (Self::Vectorial { model, .. }, Some(Distribution::LogNormal)) => {
                task.with(&WithRadiation::<_, Logarithmic>::new(model))
            }
            (Self::Osculating { model, .. }, None) => task.with(&model),
            (Self::Osculating { model, .. }, Some(Distribution::Gaussian)) => {
                task.with(&WithRadiation::<_, Linear>::new(model))
            }
            (Self::Osculating { model, .. }, Some(Distribution::LogNormal)) => {
                task.with(&WithRadiation::<_, Logarithmic>::new(model))
            }
        }
    }

    /// The forces.
    pub fn forces(&self) -> SunMoon {
        self.averaged().forces
    }

    /// The model averaged over the revolutions of the satellite and the Moon.
    pub fn averaged(&self) -> Vectorial {
        match *self {
            Self::Vectorial { model, .. } => model,
            Self::Osculating { model: Osculating { forces, obliquity, sun_longitude, .. }, .. } => {
                Vectorial { forces, obliquity, sun_longitude }
            }
        }
    }

    /// The forces of a planar model, as they act in space.
    ///
    /// # Errors
    /// The parameter of a force that acts in no model in space.
    pub fn forces_of(model: &Planar) -> Result<SunMoon, Parameter> {
        let is_unknown = |(parameter, _): &(Parameter, f64)| !SunMoon::PARAMETERS.contains(parameter);
        if let Some((parameter, _)) = model.parameters().into_iter().find(is_unknown) {
            return Err(parameter);
        }
        let value = |parameter: Parameter| model.value(parameter.name).unwrap_or(0.0);
        let force = SrpJ2 { radiation: value(RADIATION), oblateness: value(OBLATENESS) };
        Ok(SunMoon { force, sun: value(SUN), moon: value(MOON) })
    }

    /// The averaged model with orbit, Sun and Moon in one plane.
    pub fn planar(&self) -> Planar {
        match self.forces() {
            SunMoon { force, sun: 0.0, moon: 0.0 } => force.into(),
            forces => forces.into(),
        }
    }

    /// The averaged model with the Earth's shadow; `None` if the semi-major axis is not known.
    pub fn averaged_with_shadow(&self, reentry_radius: Option<f64>) -> Option<ShadowedVectorial> {
        let model = self.averaged();
        self.axis().map(|semi_major_axis| ShadowedVectorial { model, semi_major_axis, reentry_radius })
    }

    /// The mean anomaly of all orbits at `t = 0` \[rad\], if the model has one and it is given.
    pub fn mean_anomaly(&self) -> Option<f64> {
        match *self {
            Self::Vectorial { .. } => None,
            Self::Osculating { mean_anomaly, .. } => mean_anomaly,
        }
    }

    /// Longitude of the Moon at `t = 0` \[rad\], if the model has one.
    pub fn moon_longitude(&self) -> Option<f64> {
        match self {
            Self::Vectorial { .. } => None,
            Self::Osculating { model, .. } => Some(model.moon_longitude),
        }
    }

    /// The parameters, to be changed.
    pub(crate) fn forces_mut(&mut self) -> &mut SunMoon {
        match self {
            Self::Vectorial { model, .. } => &mut model.forces,
            Self::Osculating { model, .. } => &mut model.forces,
        }
    }

    /// The semi-major axis \[Earth radii\], if it is known.
    pub fn axis(&self) -> Option<f64> {
        match *self {
            Self::Vectorial { axis, .. } => axis,
            Self::Osculating { model, .. } => Some(model.semi_major_axis),
        }
    }

    /// The parameters `C`, `W`, `A` and `B` with their values.
    pub fn force_parameters(&self) -> [(Parameter, f64); 4] {
        let SunMoon { force, sun, moon } = self.forces();
        [(RADIATION, force.radiation), (OBLATENESS, force.oblateness), (SUN, sun), (MOON, moon)]
    }

    /// All parameters.
    pub fn parameters(&self) -> Vec<Stated> {
        let Vectorial { obliquity, sun_longitude, .. } = self.averaged();
        let of_forces = self.force_parameters().map(|(parameter, value)| (parameter.name, parameter.symbol, value));
        let others = [
            (OBLIQUITY, Some(obliquity)),
            (SUN_LONGITUDE, Some(sun_longitude)),
            (SEMI_MAJOR_AXIS, self.axis()),
            (MOON_LONGITUDE, self.moon_longitude()),
            (MEAN_ANOMALY, self.mean_anomaly()),
        ];
        let stated = others.into_iter().filter_map(|((name, symbol), value)| value.map(|value| (name, symbol, value)));
        of_forces.into_iter().chain(stated).collect()
    }

    /// The model of this name with these named parameters; `None` if no model in space has this name.
    ///
    /// # Errors
    /// The parameter that is missing or not one of the model's.
    pub fn by_name(name: &str, given: &[(&str, f64)]) -> Option<Result<Self, ModelError>> {
        let model = ModelName::read(name)?;
        let given = Given { model, values: given };
        let made = match model {
            ModelName::Planar => return None,
            ModelName::Vectorial => given.vectorial(),
            ModelName::Osculating => given.osculating(),
        };
        Some(made.and_then(|made| given.with_nothing_else(made)))
    }

    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    /// [`ProblemError`] with the first that is not.
    pub fn check(&self) -> Result<(), ProblemError> {
        check_ranges(&self.force_parameters())?;
        let Vectorial { obliquity, sun_longitude, .. } = self.averaged();
        let is_right = obliquity.abs() <= FRAC_PI_2;
        check(Field::Obliquity, obliquity, is_right, "an angle in radians between -π/2 and π/2".into())?;
        check(Field::SunLongitude, sun_longitude, true, "an angle in radians".into())?;
        self.axis().map_or(Ok(()), |axis| {
            let is_right = axis > 1.0 && axis <= 100.0;
            check(Field::Parameter(SEMI_MAJOR_AXIS.0), axis, is_right, "above 1 and at most 100 Earth radii".into())
        })
    }
}

/// Named parameters from which a model is made.
struct Given<'a> {
    /// The model, for words about what is missing.
    model: ModelName,
    values: &'a [(&'a str, f64)],
}

impl Given<'_> {
    fn value(&self, wanted: &str) -> Option<f64> {
        self.values.iter().find(|(name, _)| *name == wanted).map(|&(_, value)| value)
    }

    fn needed(&self, wanted: &'static str) -> Result<f64, ModelError> {
        self.value(wanted).ok_or(ModelError::Missing { model: self.model.text(), parameter: wanted })
    }

    /// The averaged model, whose parameters all models in space have.
    fn averaged(&self) -> Result<Vectorial, ModelError> {
        let force = SrpJ2 { radiation: self.needed(RADIATION.name)?, oblateness: self.needed(OBLATENESS.name)? };
        let forces = SunMoon { force, sun: self.needed(SUN.name)?, moon: self.needed(MOON.name)? };
        let (obliquity, sun_longitude) = (self.needed(OBLIQUITY.0)?, self.needed(SUN_LONGITUDE.0)?);
        Ok(Vectorial { forces, obliquity, sun_longitude })
    }

    fn vectorial(&self) -> Result<SpaceModel, ModelError> {
        Ok(SpaceModel::Vectorial { model: self.averaged()?, axis: self.value(SEMI_MAJOR_AXIS.0) })
    }

    fn osculating(&self) -> Result<SpaceModel, ModelError> {
        let Vectorial { forces, obliquity, sun_longitude } = self.averaged()?;
        let (semi_major_axis, moon_longitude) = (self.needed(SEMI_MAJOR_AXIS.0)?, self.needed(MOON_LONGITUDE.0)?);
        let model = Osculating { semi_major_axis, forces, obliquity, sun_longitude, moon_longitude };
        Ok(SpaceModel::Osculating { model, mean_anomaly: self.value(MEAN_ANOMALY.0) })
    }

    /// The model that was made, if it has all the parameters that were given.
    fn with_nothing_else(&self, made: SpaceModel) -> Result<SpaceModel, ModelError> {
        let known: Vec<&'static str> = made.parameters().into_iter().map(|(name, ..)| name).collect();
        match self.values.iter().find(|(name, _)| !known.contains(name)) {
            Some((other, _)) => {
                Err(ModelError::Superfluous { model: self.model.text(), parameter: (*other).into(), known })
            }
            None => Ok(made),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_space::example;

    #[test]
    fn a_model_is_made_of_the_parameters_that_it_states() {
        let vectorial = example::problem().model;
        let Vectorial { forces, obliquity, sun_longitude } = vectorial.averaged();
        let model = Osculating { semi_major_axis: 2.5, forces, obliquity, sun_longitude, moon_longitude: 0.5 };
        for model in [
            vectorial,
            SpaceModel::Osculating { model, mean_anomaly: None },
            SpaceModel::Osculating { model, mean_anomaly: Some(1.0) },
        ] {
            let stated = model.parameters();
            let given: Vec<(&str, f64)> = stated.iter().map(|(name, _, value)| (*name, *value)).collect();
            assert_eq!(SpaceModel::by_name(model.name(), &given), Some(Ok(model)));
            let why = SpaceModel::by_name(model.name(), &given[1..]).unwrap().unwrap_err().to_string();
            assert!(why.contains("has no value for its parameter radiation"), "{why}");
            let more = [&given[..], &[("drag", 1.0)]].concat();
            assert!(SpaceModel::by_name(model.name(), &more).unwrap().unwrap_err().to_string().contains("\"drag\""));
        }
        assert_eq!(SpaceModel::by_name("planar", &[]), None);
    }
}
