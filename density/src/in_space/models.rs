//! The model of a problem in space by its name and parameters, and the simpler models that a case may take in its place.

use super::{SpaceProblemError, refused, wrong};
use crate::model::osculating::Osculating;
use crate::model::parameter::Parameter;
use crate::model::planar::{Force, OBLATENESS, RADIATION};
use crate::model::registry::Planar;
use crate::model::shadow::ShadowedVectorial;
use crate::model::sun_moon::{MOON, SUN, SunMoon};
use crate::model::vectorial::Vectorial;

/// The name of the planar model.
pub const PLANAR: &str = "planar";
/// The name of the averaged model in space.
pub const VECTORIAL: &str = "vectorial";
/// The name of the unaveraged model.
pub const OSCULATING: &str = "osculating";

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
        /// The mean anomaly of all orbits at `t = 0` \[rad\]; where there is none, orbits are spread evenly over the revolution.
        mean_anomaly: Option<f64>,
    },
}

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
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planar => PLANAR,
            Self::Vectorial => VECTORIAL,
            Self::Osculating => OSCULATING,
        }
    }
}

/// A parameter of a model in space as a message states it: its name, its symbol, and its value.
pub type Stated = (&'static str, &'static str, f64);

const OBLIQUITY: (&str, &str) = ("obliquity", "epsilon");
const SUN_LONGITUDE: (&str, &str) = ("sun_longitude", "l_sun");
const MOON_LONGITUDE: (&str, &str) = ("moon_longitude", "l_moon");
const SEMI_MAJOR_AXIS: (&str, &str) = ("semi_major_axis", "a");
const MEAN_ANOMALY: (&str, &str) = ("mean_anomaly", "M");

impl SpaceModel {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vectorial { .. } => VECTORIAL,
            Self::Osculating { .. } => OSCULATING,
        }
    }

    /// The parameters `C`, `W`, `A` and `B`.
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

    /// All parameters.
    pub fn parameters(&self) -> Vec<Stated> {
        let Vectorial { forces, obliquity, sun_longitude } = self.averaged();
        let SunMoon { force, sun, moon } = forces;
        let values = [(RADIATION, force.radiation), (OBLATENESS, force.oblateness), (SUN, sun), (MOON, moon)];
        let mut stated: Vec<Stated> = values.map(|(parameter, value)| (parameter.name, parameter.symbol, value)).into();
        let mut state = |(name, symbol), value: Option<f64>| stated.extend(value.map(|value| (name, symbol, value)));
        state(OBLIQUITY, Some(obliquity));
        state(SUN_LONGITUDE, Some(sun_longitude));
        state(SEMI_MAJOR_AXIS, self.axis());
        if let Self::Osculating { model, mean_anomaly } = *self {
            state(MOON_LONGITUDE, Some(model.moon_longitude));
            state(MEAN_ANOMALY, mean_anomaly);
        }
        stated
    }

    /// The model of this name with these named parameters; `None` if no model in space has this name.
    ///
    /// # Errors
    /// The parameter that is missing or not one of the model's.
    pub fn by_name(name: &str, given: &[(&str, f64)]) -> Option<Result<Self, SpaceProblemError>> {
        match name {
            VECTORIAL | OSCULATING => Some(make(name, given)),
            _ => None,
        }
    }

    /// Whether the parameters are in their ranges.
    pub(super) fn check(&self) -> Result<(), SpaceProblemError> {
        let Vectorial { forces: SunMoon { force, sun, moon }, obliquity, sun_longitude } = self.averaged();
        let values = [(RADIATION, force.radiation), (OBLATENESS, force.oblateness), (SUN, sun), (MOON, moon)];
        for (Parameter { name, low, high, .. }, value) in values {
            if !(low..=high).contains(&value) {
                return Err(refused(&format!("orbit.{name}"), value, &format!("between {low} and {high}")));
            }
        }
        if obliquity.is_nan() || obliquity.abs() > std::f64::consts::FRAC_PI_2 {
            return Err(refused("model.obliquity", obliquity, "an angle in radians between -π/2 and π/2"));
        }
        if !sun_longitude.is_finite() {
            return Err(refused("epoch.sun_longitude", sun_longitude, "an angle in radians"));
        }
        match self.axis() {
            Some(axis) if !(axis > 1.0 && axis <= 100.0) => {
                Err(refused("orbit.semi_major_axis", axis, "above 1 and at most 100 Earth radii"))
            }
            _ => Ok(()),
        }
    }
}

fn make(name: &str, given: &[(&str, f64)]) -> Result<SpaceModel, SpaceProblemError> {
    let value = |wanted: &str| given.iter().find(|(name, _)| *name == wanted).map(|&(_, value)| value);
    let needed = |wanted: &str| {
        value(wanted)
            .ok_or_else(|| wrong("model", format!("the model \"{name}\" has no value for its parameter {wanted}")))
    };
    let force = Force { radiation: needed(RADIATION.name)?, oblateness: needed(OBLATENESS.name)? };
    let forces = SunMoon { force, sun: needed(SUN.name)?, moon: needed(MOON.name)? };
    let (obliquity, sun_longitude) = (needed(OBLIQUITY.0)?, needed(SUN_LONGITUDE.0)?);
    let axis = value(SEMI_MAJOR_AXIS.0);
    let model = if name == VECTORIAL {
        SpaceModel::Vectorial { model: Vectorial { forces, obliquity, sun_longitude }, axis }
    } else {
        let (semi_major_axis, moon_longitude) = (needed(SEMI_MAJOR_AXIS.0)?, needed(MOON_LONGITUDE.0)?);
        let model = Osculating { semi_major_axis, forces, obliquity, sun_longitude, moon_longitude };
        SpaceModel::Osculating { model, mean_anomaly: value(MEAN_ANOMALY.0) }
    };
    let known = model.parameters();
    match given.iter().find(|(name, _)| known.iter().all(|(known, ..)| known != name)) {
        Some((other, _)) => Err(wrong("model", format!("the model \"{name}\" has no parameter \"{other}\""))),
        None => Ok(model),
    }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;

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
            assert!(SpaceModel::by_name(model.name(), &more).unwrap().unwrap_err().problem.contains("\"drag\""));
        }
        assert_eq!(SpaceModel::by_name("planar", &[]), None);
    }
}
