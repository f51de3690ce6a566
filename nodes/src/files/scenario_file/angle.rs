//! Angles and other values of a scenario file that have a range.

use std::f64::consts::TAU;

use toml::Spanned;

use super::measure::{self, Dimension, Measure};
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;

/// An angle of at most a turn either way.
pub(super) fn turn(file: &InputFile, value: &Spanned<Measure>) -> Result<f64, InputError> {
    // With a margin for a turn that was written with six digits.
    angle(file, value, -TAU - 1e-5, TAU + 1e-5, "between -2π and 2π")
}

/// An angle between two bounds, which `range` says in words.
pub(super) fn angle(
    file: &InputFile,
    value: &Spanned<Measure>,
    low: f64,
    high: f64,
    range: &str,
) -> Result<f64, InputError> {
    let angle = measure::read(file, value, Dimension::Angle)?;
    let is_right = |angle: f64| (low..=high).contains(&angle);
    if is_right(angle) {
        return Ok(angle);
    }
    if let Measure::Text(text) = value.get_ref() {
        return Err(file.error(value, &format!("\"{text}\" is not allowed, it must be an angle {range}")));
    }
    let hint = match is_right(angle.to_radians()) {
        true => format!("; if {angle} degrees are meant, write \"{angle} deg\""),
        false => String::new(),
    };
    Err(refused(file, value, angle, &format!("an angle in radians, {range}{hint}")))
}

/// The error about a value that is not allowed.
pub(super) fn refused(file: &InputFile, value: &Spanned<Measure>, found: f64, right: &str) -> InputError {
    file.error(value, &format!("{} is not allowed, it must be {right}", plain(found)))
}

/// The same angle between -2π and 2π.
pub(super) fn within_a_turn(angle: f64) -> f64 {
    if angle.abs() <= TAU { angle } else { angle.rem_euclid(TAU) }
}
