//! The table `[epoch]` of a planar scenario: the date at `t = 0`.

use std::time::{Duration, SystemTime};

use density::model::earth;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;
use toml::value::Datetime;

use crate::files::input::{InputError, InputFile};

/// The table `[epoch]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EpochTable {
    #[schemars(with = "String")]
    date: Spanned<Datetime>,
}

/// The date at `t = 0`, at the beginning of the day in universal time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epoch(SystemTime);

impl Epoch {
    /// The epoch of a scenario file.
    pub(super) fn read(file: &InputFile, table: &EpochTable) -> Result<Self, InputError> {
        day(file, &table.date).map(Self)
    }

    /// The date so many years after the epoch, as `2032-03-01`.
    pub fn date_after(&self, years: f64) -> String {
        // To the nearest second, so that the rounding of a number of years does not make the day before of a date.
        let after = Duration::from_secs_f64((years * earth::YEAR).round().max(0.0));
        let text = self.0.checked_add(after).map(|time| humantime::format_rfc3339_seconds(time).to_string());
        text.map_or("beyond all dates".into(), |text| text.chars().take_while(|c| *c != 'T').collect())
    }

    /// The years from the epoch to a date.
    pub(super) fn years_until(&self, file: &InputFile, date: &Spanned<Datetime>) -> Result<f64, InputError> {
        let end = day(file, date)?;
        let past = format!("is not after the epoch, {}", self.date_after(0.0));
        let after = end.duration_since(self.0).map_err(|_| file.error(date, &past))?;
        let years = after.as_secs_f64() / earth::YEAR;
        // A thirtieth of a second is more than enough of a date.
        Ok(format!("{years:.9}").parse().unwrap_or(years))
    }
}

/// The beginning of a day.
fn day(file: &InputFile, date: &Spanned<Datetime>) -> Result<SystemTime, InputError> {
    let given = date.get_ref();
    let wrong = || file.error(date, &format!("{given} is not allowed, it must be a date from 1970 on, as 2027-03-01"));
    if given.date.is_none() || given.time.is_some() || given.offset.is_some() {
        return Err(wrong());
    }
    humantime::parse_rfc3339(&format!("{given}T00:00:00Z")).map_err(|_| wrong())
}
