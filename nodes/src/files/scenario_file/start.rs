//! The table `[initial]` of a scenario in space: the orbit at `t = 0`, and how well it is known.

use std::f64::consts::PI;

use density::in_space::{FROM_PI, InitialInSpace, PAIR_NAMES};
use density::uncertain::Spread;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::angle::{refused, turn, within_a_turn};
use super::initial;
use super::measure::{self, Dimension, Measure};
use crate::files::input::{InputError, InputFile};

/// The table `[initial]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Start {
    #[schemars(with = "Option<Measure>")]
    phi: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    argument_of_pericentre: Option<Spanned<Measure>>,
    #[schemars(with = "Measure")]
    e: Spanned<Measure>,
    #[schemars(with = "Measure")]
    inclination: Spanned<Measure>,
    #[schemars(with = "Measure")]
    node: Spanned<Measure>,
    #[schemars(with = "Option<Measure>")]
    pub(super) mean_anomaly: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_phi: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_e: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_inclination: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_node: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_radiation: Option<Spanned<Measure>>,
    #[schemars(with = "Option<String>", extend("enum" = ["gaussian", "log-normal"]))]
    radiation_distribution: Option<Spanned<String>>,
    #[schemars(with = "Option<Correlation>")]
    correlation: Option<Spanned<Correlation>>,
}

/// The table `[initial.correlation]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Correlation {
    #[schemars(with = "Option<Measure>")]
    phi_e: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    phi_inclination: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    phi_node: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    e_inclination: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    e_node: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    inclination_node: Option<Spanned<Measure>>,
}

impl Correlation {
    /// The correlations in the order of their names.
    fn values(&self) -> [&Option<Spanned<Measure>>; 6] {
        let Self { phi_e, phi_inclination, phi_node, e_inclination, e_node, inclination_node } = self;
        [phi_e, phi_inclination, phi_node, e_inclination, e_node, inclination_node]
    }
}

impl Start {
    /// Solar angle, eccentricity, inclination and node.
    pub(super) fn variables(
        &self,
        file: &InputFile,
        table: &Spanned<Self>,
        sun_longitude: f64,
    ) -> Result<[f64; 4], InputError> {
        let e = measure::read(file, &self.e, Dimension::Number)?;
        if !(0.0..1.0).contains(&e) {
            return Err(refused(file, &self.e, e, "at least 0 and below 1"));
        }
        let inclination = measure::read(file, &self.inclination, Dimension::Angle)?;
        if !(0.0..PI - FROM_PI).contains(&inclination) {
            let right = format!(
                "an angle in radians, at least 0 and below π - {FROM_PI} (179.94 degrees): next to π (180 degrees) the solar angle is singular"
            );
            return Err(refused(file, &self.inclination, inclination, &right));
        }
        let node = turn(file, &self.node)?;
        let phi = match (&self.phi, &self.argument_of_pericentre) {
            (Some(phi), None) => turn(file, phi)?,
            (None, Some(argument)) => within_a_turn(node + turn(file, argument)? - sun_longitude),
            (None, None) => return Err(file.error(table, "must have either phi or argument_of_pericentre")),
            (Some(phi), Some(_)) => {
                let problem = "stands beside argument_of_pericentre, which says the same; leave out one of them";
                return Err(file.error(phi, problem));
            }
        };
        Ok([phi, e, inclination, node])
    }

    /// Whether the table says how well the orbit is known.
    pub(super) fn has_uncertainty(&self) -> bool {
        let sigmas = [&self.sigma_phi, &self.sigma_e, &self.sigma_inclination, &self.sigma_node, &self.sigma_radiation];
        sigmas.into_iter().any(Option::is_some) || self.correlation.is_some() || self.radiation_distribution.is_some()
    }

    /// The Gaussian about the given means.
    pub(super) fn gaussian(
        &self,
        file: &InputFile,
        table: &Spanned<Self>,
        mean: [f64; 4],
    ) -> Result<InitialInSpace, InputError> {
        let needed = |sigma: &Option<Spanned<Measure>>, name: &str, dimension| match sigma {
            Some(sigma) => measure::read(file, sigma, dimension),
            None => Err(file.error(
                table,
                &format!("must have {name}: a cloud has a standard deviation in solar angle and in eccentricity"),
            )),
        };
        let certain = |sigma: &Option<Spanned<Measure>>| {
            sigma.as_ref().map_or(Ok(0.0), |sigma| measure::read(file, sigma, Dimension::Angle))
        };
        let sigma = [
            needed(&self.sigma_phi, "sigma_phi", Dimension::Angle)?,
            needed(&self.sigma_e, "sigma_e", Dimension::Number)?,
            certain(&self.sigma_inclination)?,
            certain(&self.sigma_node)?,
        ];
        let mut correlation = [0.0; 6];
        if let Some(given) = &self.correlation {
            for (place, value) in correlation.iter_mut().zip(given.get_ref().values()) {
                *place = value.as_ref().map_or(Ok(0.0), |value| measure::read(file, value, Dimension::Number))?;
            }
        }
        Ok(InitialInSpace { mean, sigma, correlation })
    }

    /// How uncertain the radiation parameter is, if the table says so.
    pub(super) fn spread(&self, file: &InputFile) -> Result<Option<Spread>, InputError> {
        initial::spread(file, &self.sigma_radiation, &self.radiation_distribution)
    }

    /// The line and key of what is wrong with one of its keys; with the table as a whole if it does not have the key.
    pub(super) fn locate(table: &Spanned<Self>, file: &InputFile, key: &str, problem: &str) -> InputError {
        let own = table.get_ref();
        let correlation = own.correlation.as_ref();
        if let Some(pair) = PAIR_NAMES.iter().position(|name| key == format!("correlation.{name}")) {
            let value = correlation.and_then(|given| given.get_ref().values()[pair].as_ref());
            return value.map_or_else(|| file.error(table, problem), |value| file.error(value, problem));
        }
        let value = match key {
            "phi" => own.phi.as_ref().or(own.argument_of_pericentre.as_ref()),
            "e" => Some(&own.e),
            "inclination" => Some(&own.inclination),
            "node" => Some(&own.node),
            "sigma_phi" => own.sigma_phi.as_ref(),
            "sigma_e" => own.sigma_e.as_ref(),
            "sigma_inclination" => own.sigma_inclination.as_ref(),
            "sigma_node" => own.sigma_node.as_ref(),
            "sigma_radiation" => own.sigma_radiation.as_ref(),
            _ => None,
        };
        match (value, correlation) {
            (Some(value), _) => file.error(value, problem),
            (None, Some(given)) if key == "correlation" => file.error(given, problem),
            _ => file.error(table, problem),
        }
    }
}
