//! The table `[epoch]`: the date at `t = 0`, and in space where the Sun and the Moon are then.

use std::time::{Duration, SystemTime};

use density::model::earth;
use density::model::ecliptic::mean_longitudes;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;
use toml::value::Datetime;

use super::angle::{turn, within_a_turn};
use super::measure::Measure;
use crate::files::input::{InputError, InputFile};

/// The table `[epoch]` of a scenario in the plane.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EpochTable {
    #[schemars(with = "String")]
    date: Spanned<Datetime>,
}

/// The table `[epoch]` of a scenario in space: a date, or where the Sun and the Moon are, or both.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EpochInSpace {
    #[schemars(with = "Option<String>")]
    date: Option<Spanned<Datetime>>,
    #[schemars(with = "Option<Measure>")]
    sun_longitude: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    pub(super) moon_longitude: Option<Spanned<Measure>>,
}

impl EpochInSpace {
    /// The date, if there is one.
    pub(super) fn read(&self, file: &InputFile) -> Result<Option<Epoch>, InputError> {
        self.date.as_ref().map(|date| day(file, date).map(Epoch)).transpose()
    }

    /// The Sun's longitude \[rad\]: that which is given, or that of the date.
    pub(super) fn sun(table: &Spanned<Self>, file: &InputFile, date: Option<Epoch>) -> Result<f64, InputError> {
        let needed = "must have sun_longitude, or a date, from which it follows";
        match (&table.get_ref().sun_longitude, date) {
            (Some(longitude), _) => turn(file, longitude),
            (None, Some(date)) => Ok(date.mean_longitudes()[0]),
            (None, None) => Err(file.error(table, needed)),
        }
    }

    /// The Moon's longitude \[rad\], which is needed if and only if the Moon acts.
    pub(super) fn moon(
        table: &Spanned<Self>,
        file: &InputFile,
        date: Option<Epoch>,
        acts: bool,
    ) -> Result<f64, InputError> {
        let needed = "must have moon_longitude, or a date, from which it follows: the force \"moon\" acts";
        let useless = "has no effect: the force \"moon\" is not in model.forces; add it there, or leave this out";
        match (&table.get_ref().moon_longitude, acts) {
            (Some(longitude), true) => turn(file, longitude),
            (Some(longitude), false) => Err(file.error(longitude, useless)),
            (None, true) => date.map(|date| date.mean_longitudes()[1]).ok_or_else(|| file.error(table, needed)),
            (None, false) => Ok(0.0),
        }
    }
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
        let text = self.after(after).map(|time| humantime::format_rfc3339_seconds(time).to_string());
        text.map_or("after the year 9999".into(), |text| text.chars().take_while(|c| *c != 'T').collect())
    }

    /// Date and time so many years after the epoch, as `2032-03-01T12:00:00.000000`; `None` after the year 9999.
    pub fn instant_after(&self, years: f64) -> Option<String> {
        // Half a microsecond more, since the rest is cut off.
        let after = Duration::from_secs_f64((years * earth::YEAR + 5e-7).max(0.0));
        let text = humantime::format_rfc3339_micros(self.after(after)?).to_string();
        Some(text.trim_end_matches('Z').to_owned())
    }

    /// The time so long after the epoch; `None` after the year 9999, the last one that has dates.
    fn after(&self, duration: Duration) -> Option<SystemTime> {
        /// The beginning of the year 10000, in seconds from that of 1970.
        const END: u64 = 253_402_300_800;
        let time = self.0.checked_add(duration)?;
        (time.duration_since(SystemTime::UNIX_EPOCH).ok()?.as_secs() < END).then_some(time)
    }

    /// Mean longitudes of the Sun and of the Moon at the epoch \[rad\], between -2π and 2π. The minute or two between
    /// universal and terrestrial time, in which the Moon moves by 0.01°, is left out.
    fn mean_longitudes(&self) -> [f64; 2] {
        let days = self.0.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64() / DAY;
        let longitudes = mean_longitudes((days - DAYS_TO_J2000) / DAYS_OF_CENTURY);
        longitudes.map(|degrees| within_a_turn(degrees.to_radians()))
    }

    /// The years from the epoch to a date.
    pub(super) fn years_until(&self, file: &InputFile, date: &Spanned<Datetime>) -> Result<f64, InputError> {
        let end = day(file, date)?;
        let past = format!("is not after the epoch, {}", self.date_after(0.0));
        let after = end.duration_since(self.0).map_err(|_| file.error(date, &past))?;
        let years = after.as_secs_f64() / earth::YEAR;
        // Without the rounding of the division, to less than a microsecond.
        Ok(format!("{years:.14}").parse().unwrap_or(years))
    }
}

/// A day \[s\].
const DAY: f64 = 86_400.0;
/// Days from the beginning of 1970 to J2000.0.
const DAYS_TO_J2000: f64 = 10_957.5;
const DAYS_OF_CENTURY: f64 = 36_525.0;

/// The beginning of a day.
fn day(file: &InputFile, date: &Spanned<Datetime>) -> Result<SystemTime, InputError> {
    let given = date.get_ref();
    let wrong = || file.error(date, &format!("{given} is not allowed, it must be a date from 1970 on, as 2027-03-01"));
    if given.date.is_none() || given.time.is_some() || given.offset.is_some() {
        return Err(wrong());
    }
    humantime::parse_rfc3339(&format!("{given}T00:00:00Z")).map_err(|_| wrong())
}
