//! The values that a sweep gives to one key: a list, or a range with a count.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::{Table, Value};

use crate::files::plain_number::plain;

/// Most scenarios of a sweep.
pub(crate) const MOST_SCENARIOS: usize = 1_000_000;

/// The values that a key takes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Values {
    List(Vec<f64>),
    Range { from: f64, to: f64, count: usize, unit: Option<String> },
}

impl JsonSchema for Values {
    fn schema_name() -> Cow<'static, str> {
        "Values".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [
            { "type": "array", "items": { "type": "number" }, "minItems": 1 },
            {
                "type": "object",
                "properties": {
                    "from": { "type": ["number", "string"] },
                    "to": { "type": ["number", "string"] },
                    "count": { "type": "integer", "minimum": 1, "maximum": MOST_SCENARIOS }
                },
                "required": ["from", "to", "count"],
                "additionalProperties": false
            }
        ] })
    }
}

const FORMS: &str = "a list of numbers, or { from = 0.1, to = 0.2, count = 5 }";
const RANGE: &str =
    "a range has from, to and count, which is how many values it has: { from = 0.1, to = 0.2, count = 5 }";
const RANGE_KEYS: [&str; 3] = ["from", "to", "count"];

impl Values {
    /// Reads the values from a file. Each must make a different scenario, and everything that is written must have an
    /// effect.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    pub(crate) fn read(value: &Value) -> Result<Self, String> {
        let values = match value {
            Value::Array(list) => Self::List(list.iter().map(number_of_list).collect::<Result<_, _>>()?),
            Value::Table(table) => range(table)?,
            other => return Err(format!("{} is not allowed, it must be {FORMS}", shown(other))),
        };
        values.check().map(|()| values)
    }

    pub(crate) fn count(&self) -> usize {
        match self {
            Self::List(values) => values.len(),
            Self::Range { count, .. } => *count,
        }
    }

    pub(crate) fn value(&self, index: usize) -> Option<f64> {
        match self {
            Self::List(values) => values.get(index).copied(),
            Self::Range { from, count: 1, .. } => Some(*from),
            Self::Range { from, to, count, .. } => Some(from + (to - from) * index as f64 / (count - 1) as f64),
        }
    }

    /// The unit of the values, if it is not the key's own.
    pub(crate) fn unit(&self) -> Option<&str> {
        match self {
            Self::List(_) => None,
            Self::Range { unit, .. } => unit.as_deref(),
        }
    }

    fn check(&self) -> Result<(), String> {
        match self {
            Self::List(values) if values.is_empty() => Err("names no value; it must name at least one".into()),
            Self::Range { count: 0, .. } => Err("count = 0 leaves no value; it must be at least 1".into()),
            Self::Range { count, .. } if *count > MOST_SCENARIOS => {
                Err(format!("count = {count} is not allowed, it must be at most {MOST_SCENARIOS}"))
            }
            Self::Range { from, to, .. } if !(to - from).is_finite() => {
                Err(format!("from = {} and to = {} are too far apart", plain(*from), plain(*to)))
            }
            Self::Range { from, to, count: 1, .. } if from != to => Err(format!(
                "to = {} has no effect, as count = 1 takes from = {from} alone; write [{from}], or a count of 2 or more",
                plain(*to),
                from = plain(*from)
            )),
            _ => match self.repeated() {
                Some(value) => Err(format!(
                    "takes the value {} twice, which makes the same scenario twice; values must differ",
                    plain(value)
                )),
                None => Ok(()),
            },
        }
    }

    /// A value that comes twice.
    fn repeated(&self) -> Option<f64> {
        let mut values: Vec<f64> = (0..self.count()).filter_map(|index| self.value(index)).collect();
        values.sort_by(f64::total_cmp);
        values.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
    }
}

fn number_of_list(value: &Value) -> Result<f64, String> {
    finite(value)
        .ok_or_else(|| format!("{} is not allowed in the list, every value must be a finite number", shown(value)))
}

fn range(table: &Table) -> Result<Values, String> {
    if let Some(unknown) = table.keys().find(|key| !RANGE_KEYS.contains(&key.as_str())) {
        return Err(format!("{unknown} is unknown; {RANGE}"));
    }
    if let Some(missing) = RANGE_KEYS.into_iter().find(|key| !table.contains_key(*key)) {
        return Err(format!("{missing} is missing; {RANGE}"));
    }
    let wrong = |key: &str, right: &str| format!("{key} = {} is not allowed, it must be {right}", shown(&table[key]));
    let end = |key: &str| {
        let right = "a finite number, or a text with one and its unit: \"60 deg\"";
        with_unit(&table[key]).ok_or_else(|| wrong(key, right))
    };
    let count = table["count"].as_integer().and_then(|count| usize::try_from(count).ok());
    let count = count.ok_or_else(|| wrong("count", "a whole number, how many values the range has"))?;
    let ((from, unit), (to, of_end)) = (end("from")?, end("to")?);
    if unit != of_end {
        return Err("from and to must have the same unit: { from = \"0 deg\", to = \"60 deg\", count = 5 }".into());
    }
    Ok(Values::Range { from, to, count, unit })
}

/// A number with its unit, if it has one. Whether the key knows the unit is found when a scenario is read.
fn with_unit(value: &Value) -> Option<(f64, Option<String>)> {
    let Some(text) = value.as_str() else { return Some((finite(value)?, None)) };
    let (number, unit) = text.trim().split_once(' ')?;
    let number = number.parse().ok().filter(|number: &f64| number.is_finite())?;
    Some((number, Some(unit.trim().to_owned())))
}

fn finite(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|number| number as f64));
    number.filter(|number| number.is_finite())
}

/// A value as its file may have it.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) => plain(*number),
        Value::Array(_) => "a list".into(),
        Value::Table(_) => "a table".into(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Values, String> {
        Values::read(&toml::from_str::<Table>(&format!("x = {text}")).unwrap()["x"])
    }

    #[test]
    fn a_list_and_a_range_give_their_values() {
        let values = |text: &str| {
            let values = read(text).unwrap();
            (0..values.count()).filter_map(|index| values.value(index)).collect::<Vec<_>>()
        };
        assert_eq!(values("[1, 0.5]"), [1.0, 0.5]);
        assert_eq!(values("{ from = 0, to = 1, count = 3 }"), [0.0, 0.5, 1.0]);
        assert_eq!(values("{ from = 0.1, to = 0.1, count = 1 }"), [0.1]);
        let in_degrees = "{ from = \"10 deg\", to = \"20 deg\", count = 3 }";
        assert_eq!((values(in_degrees), read(in_degrees).unwrap().unit()), (vec![10.0, 15.0, 20.0], Some("deg")));
    }

    #[test]
    fn what_is_missing_or_wrong_is_told_by_name() {
        for (text, words) in [
            ("\"x\"", "\"x\" is not allowed, it must be a list of numbers, or { from = 0.1"),
            ("0.1", "0.1 is not allowed, it must be a list"),
            ("[0.1, \"x\"]", "\"x\" is not allowed in the list, every value must be a finite number"),
            ("[0.1, inf]", "inf is not allowed in the list, every value must be a finite number"),
            ("[[0.1]]", "a list is not allowed in the list"),
            ("{ from = 0.1, to = 0.2 }", "count is missing; a range has from, to and count"),
            ("{ to = 0.2, count = 2 }", "from is missing"),
            (
                "{ from = 0.1, to = 0.2, step = 0.1 }",
                "step is unknown; a range has from, to and count, which is how many",
            ),
            ("{ from = 0.1, to = 0.2, count = 2.5 }", "count = 2.5 is not allowed, it must be a whole number"),
            ("{ from = 0.1, to = 0.2, count = -1 }", "count = -1 is not allowed, it must be a whole number"),
            ("{ from = 0.1, to = 0.2, count = 0 }", "count = 0 leaves no value"),
            (
                "{ from = 0.1, to = 0.2, count = 1_000_000_000_000 }",
                "count = 1000000000000 is not allowed, it must be at most",
            ),
            ("{ from = 0.1, to = inf, count = 3 }", "to = inf is not allowed, it must be a finite number"),
            ("{ from = nan, to = 1, count = 3 }", "from = NaN is not allowed, it must be a finite number"),
            ("{ from = \"a\", to = 1, count = 3 }", "from = \"a\" is not allowed"),
            ("{ from = -1e308, to = 1e308, count = 3 }", "from = -1e308 and to = 1e308 are too far apart"),
            ("{ from = 0.1, to = 0.2, count = 1 }", "to = 0.2 has no effect"),
            ("{ from = 0.1, to = 0.1, count = 3 }", "takes the value 0.1 twice"),
            ("[0.1, 0.2, 0.10]", "takes the value 0.1 twice"),
            ("[0.0, -0.0]", "twice"),
            ("[]", "names no value"),
        ] {
            let problem = read(text).unwrap_err();
            assert!(problem.contains(words), "{problem}");
        }
    }
}
