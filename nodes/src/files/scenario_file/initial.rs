//! How well the orbit is known at first, as a scenario file says it.

use density::problem::InitialGaussian;
use density::problem_error::Field;
use density::uncertain::{Distribution, Spread};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::measure::{self, Dimension, Measure};
use super::refusals;
use crate::files::input::{InputError, InputFile};

/// The table `[initial]`: means, either one or two standard deviations of each variable, and their correlation.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Initial {
    #[schemars(with = "Measure")]
    phi: Spanned<Measure>,
    #[schemars(with = "Measure")]
    e: Spanned<Measure>,
    #[schemars(with = "Option<Measure>")]
    delta_phi: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    delta_e: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_phi: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_e: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    correlation: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sigma_radiation: Option<Spanned<Measure>>,
    #[schemars(with = "Option<String>", extend("enum" = ["gaussian", "log-normal"]))]
    radiation_distribution: Option<Spanned<String>>,
}

impl Initial {
    /// The Gaussian that the table says.
    pub(super) fn read(file: &InputFile, table: &Spanned<Self>) -> Result<InitialGaussian, InputError> {
        let Self { phi, e, delta_phi, delta_e, sigma_phi, sigma_e, correlation, .. } = table.get_ref();
        let deviation =
            |name: &str, one: &Option<Spanned<Measure>>, two: &Option<Spanned<Measure>>, dimension| match (one, two) {
                (Some(one), None) => measure::read(file, one, dimension),
                (None, Some(two)) => Ok(0.5 * measure::read(file, two, dimension)?),
                (None, None) => {
                    Err(file
                        .error(table, &format!("must have either sigma_{name} or delta_{name}, which is two of them")))
                }
                (Some(one), Some(_)) => {
                    Err(file
                        .error(one, &format!("stands beside delta_{name}, which says the same; leave out one of them")))
                }
            };
        Ok(InitialGaussian {
            mean_phi: measure::read(file, phi, Dimension::Angle)?,
            mean_e: measure::read(file, e, Dimension::Number)?,
            sigma_phi: deviation("phi", sigma_phi, delta_phi, Dimension::Angle)?,
            sigma_e: deviation("e", sigma_e, delta_e, Dimension::Number)?,
            correlation: correlation.as_ref().map_or(Ok(0.0), |given| measure::read(file, given, Dimension::Number))?,
        })
    }

    /// How uncertain the radiation parameter is, if the table says so.
    pub(super) fn spread(file: &InputFile, table: &Spanned<Self>) -> Result<Option<Spread>, InputError> {
        let Self { sigma_radiation, radiation_distribution, .. } = table.get_ref();
        spread(file, sigma_radiation, radiation_distribution)
    }

    /// The line and key of what is wrong with one of its fields.
    pub(super) fn locate(table: &Spanned<Self>, file: &InputFile, field: Field, problem: &str) -> InputError {
        let Self { phi, e, delta_phi, delta_e, sigma_phi, sigma_e, correlation, sigma_radiation, .. } = table.get_ref();
        let value = match field {
            Field::MeanPhi => Some(phi),
            Field::MeanE => Some(e),
            Field::DeltaPhi => delta_phi.as_ref().or(sigma_phi.as_ref()),
            Field::DeltaE => delta_e.as_ref().or(sigma_e.as_ref()),
            Field::Correlation => correlation.as_ref(),
            Field::SigmaRadiation => sigma_radiation.as_ref(),
            _ => None,
        };
        let problem = match value.map(Spanned::get_ref) {
            Some(Measure::Text(text)) => refusals::of_text(text, problem),
            _ => problem.to_owned(),
        };
        let is_half = matches!(field, Field::DeltaPhi) && delta_phi.is_none()
            || matches!(field, Field::DeltaE) && delta_e.is_none();
        let problem = if is_half { format!("two of it: {problem}") } else { problem };
        value.map_or_else(|| file.error(table, &problem), |value| file.error(value, &problem))
    }
}

/// How uncertain the radiation parameter is, if the file gives its deviation.
pub(super) fn spread(
    file: &InputFile,
    sigma_radiation: &Option<Spanned<Measure>>,
    radiation_distribution: &Option<Spanned<String>>,
) -> Result<Option<Spread>, InputError> {
    let Some(sigma) = sigma_radiation else {
        return match radiation_distribution {
            Some(given) => Err(file.error(given, "has no effect without sigma_radiation")),
            None => Ok(None),
        };
    };
    let distribution = match radiation_distribution.as_ref().map(|given| (given, given.get_ref().as_str())) {
        None | Some((_, "gaussian")) => Distribution::Gaussian,
        Some((_, "log-normal")) => Distribution::LogNormal,
        Some((given, other)) => {
            let problem = format!("\"{other}\" is not allowed, it must be \"gaussian\" or \"log-normal\"");
            return Err(file.error(given, &problem));
        }
    };
    Ok(Some(Spread { relative: measure::read(file, sigma, Dimension::Number)?, distribution }))
}
