//! The table `[quantity]` of a map file: what is shown.

use density::reliability::Quantity;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawQuantity {
    #[schemars(with = "String", extend("enum" = ["reentry", "time-of-reentry", "required-area-to-mass", "required-radiation", "mean-e"]))]
    pub(super) name: Spanned<String>,
    #[schemars(with = "Option<f64>")]
    within: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    after: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    probability: Option<Spanned<f64>>,
}

/// What is shown, with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The quantity itself.
    Itself,
    /// The factor on the radiation parameter, times that parameter.
    Radiation,
    /// The factor on the radiation parameter, times the area-to-mass ratio \[m²/kg\].
    AreaToMass,
}

const NAMES: &str = "\"reentry\", \"time-of-reentry\", \"required-area-to-mass\", \"required-radiation\", \"mean-e\"";

impl RawQuantity {
    pub(super) fn read(&self, file: &InputFile, table: &Spanned<Self>) -> Result<(Quantity, Shown), InputError> {
        let name = self.name.get_ref().as_str();
        let uses: &[&str] = match name {
            "reentry" => &["within"],
            "time-of-reentry" | "required-area-to-mass" | "required-radiation" => &["within", "probability"],
            "mean-e" => &["after"],
            _ => return Err(file.error(&self.name, &format!("\"{name}\" is no quantity, there are {NAMES}"))),
        };
        let given = [("within", &self.within), ("after", &self.after), ("probability", &self.probability)];
        for (key, value) in given {
            match value {
                Some(value) if !uses.contains(&key) => {
                    let right = uses.join(" and ");
                    return Err(file.error(value, &format!("has no effect on \"{name}\", which has {right}")));
                }
                None if uses.contains(&key) => {
                    return Err(file.error(table, &format!("must have {key} for \"{name}\"")));
                }
                _ => {}
            }
        }
        let years = |value: &Option<Spanned<f64>>| ranged(file, value.as_ref(), (0.0, MOST_YEARS), "a number of years");
        let (within, after) = (years(&self.within)?, years(&self.after)?);
        let probability = ranged(file, self.probability.as_ref(), (0.0, 1.0), "a probability")?;
        let required = Quantity::RequiredFactor { probability, within };
        Ok(match name {
            "reentry" => (Quantity::Reentry { within }, Shown::Itself),
            "time-of-reentry" => (Quantity::TimeOfReentry { probability, within }, Shown::Itself),
            "required-area-to-mass" => (required, Shown::AreaToMass),
            "required-radiation" => (required, Shown::Radiation),
            _ => (Quantity::MeanEccentricity { after }, Shown::Itself),
        })
    }
}

/// Most years of a quantity.
const MOST_YEARS: f64 = 1000.0;

/// A number between two others, both excluded; 0 if it is not given.
fn ranged(
    file: &InputFile,
    value: Option<&Spanned<f64>>,
    (low, high): (f64, f64),
    what: &str,
) -> Result<f64, InputError> {
    let Some(value) = value else { return Ok(0.0) };
    let number = *value.get_ref();
    if number > low && number < high {
        return Ok(number);
    }
    let problem = format!(
        "{} is not allowed, it must be {what} between {} and {}, both excluded",
        plain(number),
        plain(low),
        plain(high)
    );
    Err(file.error(value, &problem))
}

impl Shown {
    /// The name of what is shown of a quantity, with its unit.
    pub(super) fn label(self, quantity: Quantity) -> String {
        let percent = |p: f64| plain((1e9 * p).round() / 1e7);
        match quantity {
            Quantity::Reentry { within } => format!("probability of re-entry within {} yr", plain(within)),
            Quantity::TimeOfReentry { probability, .. } => {
                format!("time by which re-entry is {} % probable [yr]", percent(probability))
            }
            Quantity::RequiredFactor { probability, within } => {
                let what = if self == Self::AreaToMass { "area-to-mass ratio" } else { "radiation parameter C" };
                let unit = if self == Self::AreaToMass { " [m²/kg]" } else { "" };
                format!("{what} for {} % within {} yr{unit}", percent(probability), plain(within))
            }
            Quantity::MeanEccentricity { after } => format!("mean eccentricity after {} yr", plain(after)),
        }
    }
}
