//! The JSON Schema of a launch file, generated from the types into which it is read.

use nodes::files::schema::{describe, generator, rows, whole_file};
use nodes::methods::BuiltIn;
use serde_json::{Map, Value, json};

use super::{cases, launch_file};

/// What the page says of every key, as tables.
const PAGE: &str = include_str!("../../docs/launch-files.md");

/// The schema of a launch file.
pub(crate) fn schema() -> Value {
    let mut generator = generator();
    let mut top = launch_file::top_schema(&mut generator);
    let case = cases::case_schema(&mut generator).to_value();
    let commands = variant(&case, &Map::new(), "command", None);
    let settings = |&name: &&str| {
        let settings = BuiltIn::schema(name, &mut generator).map(|schema| schema.to_value()).unwrap_or_default();
        let own = settings.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
        let (section, none) = (format!("## `node = \"{name}\"`"), Vec::new());
        let said = PAGE.split_once(&section).map_or(none, |(_, rest)| rows(rest.split("\n## ").next().unwrap_or("")));
        let mut variant = variant(&case, &own, "node", Some(name));
        describe(&mut variant, &said, "");
        variant
    };
    let variants: Vec<Value> = BuiltIn::NAMES.iter().map(settings).chain([commands]).collect();
    let propagators = json!({ "type": "array", "minItems": 1, "items": { "anyOf": variants } });
    let top_level = top.ensure_object();
    if let Some(properties) = top_level.get_mut("properties").and_then(Value::as_object_mut) {
        properties.insert("propagator".into(), propagators);
    }
    if let Some(required) = top_level.get_mut("required").and_then(Value::as_array_mut) {
        required.push("propagator".into());
    }
    let mut schema = whole_file(generator, top, "a launch file of phasecloud");
    describe(&mut schema, &rows(PAGE), "");
    schema
}

/// The schema of cases of one sort: those that have the key `sort`, with this value if it is given, and these settings
/// of their own.
fn variant(case: &Value, own: &Map<String, Value>, sort: &str, name: Option<&str>) -> Value {
    let mut variant = case.clone();
    if let Some(properties) = variant.get_mut("properties").and_then(Value::as_object_mut) {
        properties.remove(if sort == "node" { "command" } else { "node" });
        properties.extend(own.clone());
        if let Some(name) = name {
            properties.insert(sort.into(), json!({ "const": name, "type": "string" }));
        }
    }
    if let Some(required) = variant.get_mut("required").and_then(Value::as_array_mut) {
        required.push(sort.into());
    }
    variant
}
