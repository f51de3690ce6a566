//! The snapshot times, as a scenario file gives them.

use density::problem::MOST_YEARS;
use messages::scenario::MOST_SNAPSHOTS;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;
use toml::value::Datetime;

use super::epoch::Epoch;
use super::measure::{self, Dimension, Measure};
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;

/// The table `[times]`: either the end and a step, or the times themselves.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Times {
    #[schemars(with = "Option<Measure>")]
    end: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    step: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Vec<f64>>")]
    at: Option<Spanned<Vec<f64>>>,
    #[schemars(with = "Option<String>")]
    until: Option<Spanned<Datetime>>,
}

impl Times {
    /// An error at the place of the times that are wrong.
    pub(super) fn locate(table: &Spanned<Self>, file: &InputFile, problem: &str) -> InputError {
        match table.get_ref() {
            Self { at: Some(at), .. } => file.error(at, problem),
            Self { end: Some(end), .. } => file.error(end, problem),
            Self { until: Some(until), .. } => file.error(until, problem),
            _ => file.error(table, problem),
        }
    }
}

fn number(
    file: &InputFile,
    value: &Spanned<Measure>,
    range: &str,
    is_right: impl Fn(f64) -> bool,
) -> Result<f64, InputError> {
    let x = measure::read(file, value, Dimension::Time)?;
    if x.is_finite() && is_right(x) {
        Ok(x)
    } else {
        Err(file.error(value, &format!("{} is not allowed, it must be {range}", plain(x))))
    }
}

/// The times \[yr\] that the table gives.
pub(super) fn read(file: &InputFile, times: &Spanned<Times>, epoch: Option<&Epoch>) -> Result<Vec<f64>, InputError> {
    match times.get_ref() {
        Times { end: Some(end), step: Some(step), at: None, until: None } => stepped_times(file, end, step),
        Times { end: None, step: None, at: Some(at), until: None } => listed_times(file, at),
        Times { end: None, step: Some(step), at: None, until: Some(until) } => {
            let needs = "is a date, which needs the date at t = 0, [epoch] date";
            let epoch = epoch.ok_or_else(|| file.error(until, needs))?;
            times_until(file, (until, epoch.years_until(file, until)?), step)
        }
        _ => Err(file.error(times, "must have either end and step, or at, or until and step")),
    }
}

/// Every step from the start on, and the end, which need not be a whole number of steps away.
fn times_until(
    file: &InputFile,
    (until, end): (&Spanned<Datetime>, f64),
    every: &Spanned<Measure>,
) -> Result<Vec<f64>, InputError> {
    if !(LEAST_GAP..=MOST_YEARS).contains(&end) {
        return Err(
            file.error(until, &format!("is {} yr after the epoch; it must be later, by at most 1000 yr", plain(end)))
        );
    }
    let step =
        number(file, every, "at least 1e-6 yr and at most the time to until", |x| (LEAST_GAP..=end).contains(&x))?;
    let steps = (end / step).floor();
    if steps + 2.0 > MOST_SNAPSHOTS as f64 {
        let least = end / (MOST_SNAPSHOTS as f64 - 2.0);
        let problem = format!("more than {MOST_SNAPSHOTS} snapshots; step must be at least {least}");
        return Err(file.error(every, &problem));
    }
    let before = (0..=steps as u32).map(|k| as_meant(f64::from(k) * step));
    // A step that ends next to the end is the end.
    Ok(before.take_while(|time| end - time > 0.01 * step).chain([end]).collect())
}

/// Whether a scenario may have this number of snapshots: from 2 to as many as a message holds.
pub fn is_right_number_of_times(times: usize) -> bool {
    (2..=MOST_SNAPSHOTS).contains(&times)
}

fn listed_times(file: &InputFile, at: &Spanned<Vec<f64>>) -> Result<Vec<f64>, InputError> {
    if !is_right_number_of_times(at.get_ref().len()) {
        return Err(file.error(at, &format!("must be 2 to {MOST_SNAPSHOTS} times")));
    }
    let list = at.get_ref();
    let is_close = |gap: f64| gap > 0.0 && gap < LEAST_GAP * (1.0 - ROUNDING);
    if let Some(close) = list.windows(2).find(|pair| is_close(pair[1] - pair[0])) {
        let [before, after] = [close[0], close[1]].map(plain);
        return Err(
            file.error(at, &format!("{before} and {after} are too close, times must be at least 1e-6 yr apart"))
        );
    }
    Ok(list.clone())
}

/// Least time between two snapshots \[yr\].
const LEAST_GAP: f64 = 1e-6;
/// Tolerated relative rounding error of `LEAST_GAP`, for times that were written with few digits.
const ROUNDING: f64 = 1e-6;

fn stepped_times(
    file: &InputFile,
    end_at: &Spanned<Measure>,
    every: &Spanned<Measure>,
) -> Result<Vec<f64>, InputError> {
    let end = number(file, end_at, "at least 1e-6 and at most 1000 yr", |x| (LEAST_GAP..=MOST_YEARS).contains(&x))?;
    let step = number(file, every, "at least 1e-6 yr and at most end", |x| (LEAST_GAP..=end).contains(&x))?;
    let steps = (end / step).round();
    if (steps * step - end).abs() > 1e-9 * end {
        let nearest = end / steps;
        return Err(file.error(every, &format!("{step} does not divide end = {end}; {nearest} would")));
    }
    let most = MOST_SNAPSHOTS as f64 - 1.0;
    if steps > most {
        let problem = format!(
            "{} snapshots are more than a message holds, {MOST_SNAPSHOTS}; step must be at least {}",
            steps + 1.0,
            end / most
        );
        return Err(file.error(every, &problem));
    }
    Ok((0..=steps as u32).map(|k| if f64::from(k) == steps { end } else { as_meant(f64::from(k) * step) }).collect())
}

/// A multiple of a step as a person would write it: six times 0.2 is 1.2, not 1.2000000000000002.
fn as_meant(multiple: f64) -> f64 {
    format!("{multiple:.11e}").parse().unwrap_or(multiple)
}
