//! A number with a unit, as a person writes it: `2.2` in the key's own unit, or `"126 deg"`.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::fmt;

use density::model::earth;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Visitor};
use toml::Spanned;

use crate::files::input::{InputError, InputFile};

/// What a key measures, with the units that its value may have. The first one is that of a plain number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    /// An angle.
    Angle,
    /// A distance from the Earth's centre.
    Radius,
    /// A height above the equator.
    Height,
    /// A time.
    Time,
    /// A pure number.
    Number,
}

impl Dimension {
    /// The units with their values in the first of them.
    fn units(self) -> &'static [(&'static str, f64)] {
        const KILOMETRE: f64 = 1_000.0 / earth::RADIUS;
        const DAY: f64 = 86_400.0 / earth::YEAR;
        match self {
            Self::Angle => &[("rad", 1.0), ("deg", TAU / 360.0)],
            Self::Radius => &[("R_E", 1.0), ("km", KILOMETRE)],
            Self::Height => &[("km", 1.0), ("R_E", 1.0 / KILOMETRE)],
            Self::Time => &[("yr", 1.0), ("d", DAY)],
            Self::Number => &[],
        }
    }

    fn example(self) -> &'static str {
        match self {
            Self::Angle => "126 deg",
            Self::Radius => "15945 km",
            Self::Height => "120 km",
            Self::Time => "730 d",
            Self::Number => "0.6",
        }
    }
}

/// A value of a file: a number, or a text that holds a number and a unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Measure {
    Number(f64),
    Text(String),
}

impl JsonSchema for Measure {
    fn schema_name() -> Cow<'static, str> {
        "Measure".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        // The pattern is that of a text: a number and a unit.
        json_schema!({
            "type": ["number", "string"],
            "pattern": r"^\s*[-+]?[0-9._]+([eE][-+]?[0-9]+)?\s*(rad|deg|R_E|km|yr|d)\s*$"
        })
    }
}

impl<'de> Deserialize<'de> for Measure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrText;
        impl Visitor<'_> for NumberOrText {
            type Value = Measure;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or a text with a number and its unit")
            }

            fn visit_f64<E>(self, number: f64) -> Result<Measure, E> {
                Ok(Measure::Number(number))
            }

            fn visit_i64<E>(self, number: i64) -> Result<Measure, E> {
                Ok(Measure::Number(number as f64))
            }

            fn visit_u64<E>(self, number: u64) -> Result<Measure, E> {
                Ok(Measure::Number(number as f64))
            }

            fn visit_str<E>(self, text: &str) -> Result<Measure, E> {
                Ok(Measure::Text(text.into()))
            }
        }
        deserializer.deserialize_any(NumberOrText)
    }
}

/// The value in the unit of a plain number.
///
/// # Errors
/// [`InputError`] if it is no number, or has a unit that the key does not know.
pub(super) fn read(file: &InputFile, value: &Spanned<Measure>, dimension: Dimension) -> Result<f64, InputError> {
    let text = match value.get_ref() {
        Measure::Number(number) => return Ok(*number),
        Measure::Text(text) => text.trim(),
    };
    let units = dimension.units();
    let wrong = || {
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        let right = match names.split_first() {
            None => "a number".to_owned(),
            Some((own, _)) => {
                format!(
                    "a number in {own}, or a text with a number and one of the units {}: \"{}\"",
                    names.join(", "),
                    dimension.example()
                )
            }
        };
        file.error(value, &format!("\"{}\" is not allowed, it must be {right}", text.escape_debug()))
    };
    let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE_".contains(c))).ok_or_else(wrong)?;
    // In `15e3 km` the first space ends the number; in `1R_E` and `3deg` a letter does, which no exponent is.
    let number = text[..end].trim_end_matches(['e', 'E']);
    let unit = text[number.len()..].trim_start().trim_end();
    let unit = if unit.is_empty() { text[end..].trim() } else { unit };
    let (_, size) = units.iter().find(|(name, _)| *name == unit).ok_or_else(wrong)?;
    let number: f64 = number.replace('_', "").parse().map_err(|_| wrong())?;
    let value = number * size;
    match dimension {
        // To 14 digits, so that 1461.025452 days are 4 years.
        Dimension::Time => Ok(format!("{value:.13e}").parse().unwrap_or(value)),
        _ => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn value(text: &str, dimension: Dimension) -> Result<f64, String> {
        #[derive(Debug, serde::Deserialize)]
        struct File {
            x: Spanned<Measure>,
        }
        let file = InputFile::from_text(Path::new("s.toml"), &format!("x = {text}\n"));
        let raw: File = file.parse().map_err(|error| error.to_string())?;
        read(&file, &raw.x, dimension).map_err(|error| error.to_string())
    }

    #[test]
    fn a_plain_number_has_the_keys_own_unit_and_a_text_says_its_own() {
        for (text, dimension, right) in [
            ("2.5", Dimension::Angle, 2.5),
            ("3", Dimension::Radius, 3.0),
            ("\"180 deg\"", Dimension::Angle, std::f64::consts::PI),
            ("\"-90deg\"", Dimension::Angle, -std::f64::consts::FRAC_PI_2),
            ("\"1.5e0 rad\"", Dimension::Angle, 1.5),
            ("\"6378.137 km\"", Dimension::Radius, 1.0),
            ("\"2.5 R_E\"", Dimension::Radius, 2.5),
            ("\"120 km\"", Dimension::Height, 120.0),
            ("\"1 R_E\"", Dimension::Height, 6378.137),
            ("\"730.512726 d\"", Dimension::Time, 2.0),
            ("\"1_000 d\"", Dimension::Time, 1000.0 / 365.256363),
        ] {
            let found = value(text, dimension).unwrap();
            assert!((found - right).abs() < 1e-12 * right.abs().max(1.0), "{text}: {found}");
        }
    }

    #[test]
    fn another_unit_or_none_is_refused_with_those_that_there_are() {
        for text in ["\"126\"", "\"126 grad\"", "\"deg\"", "\"x\"", "\"\"", "\"1e deg\"", "\"--1 deg\"", "\"1 deg 2\""]
        {
            let why = value(text, Dimension::Angle).unwrap_err();
            assert!(why.contains("one of the units rad, deg: \"126 deg\""), "{text}: {why}");
        }
        assert!(value("true", Dimension::Angle).unwrap_err().contains("it must be a number"));
        assert!(value("\"0.6 yr\"", Dimension::Number).unwrap_err().contains("it must be a number"));
    }
}
