//! The key `reference` of a launch file: a label, or several, of cases that there are.

use std::borrow::Cow;
use std::collections::BTreeSet;

use nodes::files::input::{InputError, InputFile};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use toml::Spanned;

use super::cases::Case;

/// `reference = "exact"`, or `reference = ["exact", "mc"]`.
#[derive(Debug)]
pub(super) struct References(Vec<String>);

impl<'de> Deserialize<'de> for References {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = References;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the label of a case, or a list of labels")
            }

            fn visit_str<E: serde::de::Error>(self, label: &str) -> Result<References, E> {
                Ok(References(vec![label.into()]))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<References, A::Error> {
                let mut labels = Vec::new();
                while let Some(label) = list.next_element()? {
                    labels.push(label);
                }
                Ok(References(labels))
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for References {
    fn schema_name() -> Cow<'static, str> {
        "Labels".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" }, "minItems": 1 }] })
    }
}

/// The labels of the references, each of which a case has.
pub(super) fn checked_references(
    file: &InputFile,
    reference: &Spanned<References>,
    cases: &[Case],
) -> Result<Vec<String>, InputError> {
    let References(labels) = reference.get_ref();
    if labels.is_empty() {
        return Err(file.error(reference, "names no case; it must name at least one"));
    }
    if labels.iter().collect::<BTreeSet<_>>().len() < labels.len() {
        return Err(file.error(reference, &format!("\"{}\" names a case twice", labels.join("\", \""))));
    }
    labels.iter().map(|label| checked_label(file, reference, label, cases)).collect()
}

/// A label that a case has.
pub(super) fn checked_label<T>(
    file: &InputFile,
    place: &Spanned<T>,
    label: &str,
    cases: &[Case],
) -> Result<String, InputError> {
    if cases.iter().any(|case| case.label == label) {
        return Ok(label.into());
    }
    let there: Vec<_> = cases.iter().map(|case| case.label.as_str()).collect();
    let problem = format!("no propagator has the label \"{label}\"; there are {}", there.join(", "));
    Err(file.error(place, &problem))
}
