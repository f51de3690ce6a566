//! The table `[difference]` of a map file: what is subtracted.

use density::reliability::{Other, Quantity};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::files::input::{InputError, InputFile};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDifference {
    #[schemars(with = "Option<String>", extend("enum" = ["planar"]))]
    model: Option<Spanned<String>>,
    #[schemars(with = "Option<String>", extend("enum" = ["mc"]))]
    method: Option<Spanned<String>>,
    #[schemars(with = "Option<usize>")]
    samples: Option<Spanned<usize>>,
    #[schemars(with = "Option<u32>")]
    seed: Option<Spanned<u32>>,
}

/// Orbits of a point by Monte Carlo unless set, and the most.
const SAMPLES: usize = 10_000;
const MOST_SAMPLES: usize = 10_000_000;

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
            _ => Err(file.error(table, "must have either model = \"planar\" or method = \"mc\"")),
        }
    }

    fn in_model(&self, file: &InputFile, model: &Spanned<String>, is_in_space: bool) -> Result<Other, InputError> {
        let given =
            [("samples", self.samples.as_ref().map(|s| s.span())), ("seed", self.seed.as_ref().map(|s| s.span()))];
        if let Some((_, Some(span))) = given.into_iter().find(|(_, span)| span.is_some()) {
            let problem = "has no effect on a difference between models; it belongs to method = \"mc\"";
            return Err(file.error(&Spanned::new(span, ()), problem));
        }
        match (model.get_ref().as_str(), is_in_space) {
            ("planar", true) => Ok(Other::Planar),
            ("planar", false) => Err(file.error(model, "has no effect: the scenario is in the plane already")),
            (other, _) => {
                let problem = format!(
                    "\"{other}\" is not allowed, it must be \"planar\", to which a scenario in space is compared"
                );
                Err(file.error(model, &problem))
            }
        }
    }

    fn by_method(&self, file: &InputFile, method: &Spanned<String>) -> Result<Other, InputError> {
        if method.get_ref() != "mc" {
            let problem = format!("\"{}\" is not allowed, it must be \"mc\", plain Monte Carlo", method.get_ref());
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
