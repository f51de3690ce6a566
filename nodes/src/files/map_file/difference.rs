//! The table `[difference]` of a map file: what is subtracted.

use density::model::model_name::ModelName;
use density::reliability::{Other, Quantity};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::files::input::{InputError, InputFile};
use crate::methods::{Method, mc};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDifference {
    #[schemars(with = "Option<String>", extend("enum" = [SIMPLER.text()]))]
    model: Option<Spanned<String>>,
    #[schemars(with = "Option<String>", extend("enum" = [SAMPLED]))]
    method: Option<Spanned<String>>,
    #[schemars(with = "Option<usize>")]
    samples: Option<Spanned<usize>>,
    #[schemars(with = "Option<u32>")]
    seed: Option<Spanned<u32>>,
}

/// The model in which the cloud of a scenario in space can be computed for comparison.
const SIMPLER: ModelName = ModelName::Planar;
/// The method by which a quantity can be computed for comparison.
const SAMPLED: &str = <mc::Settings as Method>::NAME;
/// Orbits of a point by Monte Carlo unless set, and the most.
const SAMPLES: usize = 10_000;
const MOST_SAMPLES: usize = 10_000_000;

/// What the table must have.
fn must_have() -> String {
    format!("must have either model = \"{}\" or method = \"{SAMPLED}\"", SIMPLER.text())
}

impl RawDifference {
    /// What is subtracted from a quantity of scenarios that are in space or not.
    ///
    /// # Errors
    /// [`InputError`] with line and key.
    pub(super) fn read(
        &self,
        file: &InputFile,
        table: &Spanned<Self>,
        (quantity, is_in_space): (Quantity, bool),
    ) -> Result<Other, InputError> {
        if !matches!(quantity, Quantity::Reentry { .. } | Quantity::MeanEccentricity { .. }) {
            let problem = "is computed of \"reentry\" and \"mean-e\" alone: a time or a ratio may not be reached in one of the two, and then there is no difference";
            return Err(file.error(table, problem));
        }
        match (&self.model, &self.method) {
            (Some(model), None) => self.in_model(file, model, is_in_space),
            (None, Some(method)) => self.by_method(file, method),
            _ => Err(file.error(table, &must_have())),
        }
    }

    fn in_model(&self, file: &InputFile, model: &Spanned<String>, is_in_space: bool) -> Result<Other, InputError> {
        let given =
            [("samples", self.samples.as_ref().map(|s| s.span())), ("seed", self.seed.as_ref().map(|s| s.span()))];
        if let Some((_, Some(span))) = given.into_iter().find(|(_, span)| span.is_some()) {
            let problem = format!("has no effect on a difference between models; it belongs to method = \"{SAMPLED}\"");
            return Err(file.error(&Spanned::new(span, ()), &problem));
        }
        if ModelName::read(model.get_ref()) != Some(SIMPLER) {
            let (given, right) = (model.get_ref(), SIMPLER.text());
            let problem =
                format!("\"{given}\" is not allowed, it must be \"{right}\", to which a scenario in space is compared");
            return Err(file.error(model, &problem));
        }
        match is_in_space {
            true => Ok(Other::Planar),
            false => Err(file.error(model, "has no effect: the scenario is in the plane already")),
        }
    }

    fn by_method(&self, file: &InputFile, method: &Spanned<String>) -> Result<Other, InputError> {
        if method.get_ref() != SAMPLED {
            let given = method.get_ref();
            let problem = format!("\"{given}\" is not allowed, it must be \"{SAMPLED}\", plain Monte Carlo");
            return Err(file.error(method, &problem));
        }
        let samples = self.samples.as_ref().map_or(SAMPLES, |samples| *samples.get_ref());
        match &self.samples {
            Some(given) if !(100..=MOST_SAMPLES).contains(&samples) => {
                let problem = format!("{samples} is not allowed, it must be at least 100 and at most {MOST_SAMPLES}");
                Err(file.error(given, &problem))
            }
            _ => {
                Ok(Other::MonteCarlo { samples, seed: self.seed.as_ref().map_or(1, |seed| u64::from(*seed.get_ref())) })
            }
        }
    }
}
