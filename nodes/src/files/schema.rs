//! JSON Schemas of the files that users write, generated from the types into which they are read. The descriptions are
//! those of the pages in `docs/`.

use schemars::generate::SchemaSettings;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};

use super::{map_file, scenario_file};

/// What the pages say of every key, as tables.
const SCENARIO_PAGE: &str = include_str!("../../../docs/scenario-files.md");
const MAP_PAGE: &str = include_str!("../../../docs/maps.md");

/// The schema of a scenario file.
pub fn scenario() -> Value {
    let mut generator = generator();
    let [planar, in_space] = scenario_file::schemas(&mut generator);
    let whole = json_schema!({ "anyOf": [planar, in_space] });
    let mut schema = whole_file(generator, whole, "a scenario file of phasecloud");
    describe(&mut schema, &rows(SCENARIO_PAGE), "");
    schema
}

/// The schema of a map file.
pub fn map() -> Value {
    let mut generator = generator();
    let top = map_file::schema(&mut generator);
    let mut schema = whole_file(generator, top, "a map file of phasecloud");
    describe(&mut schema, &rows(MAP_PAGE), "");
    schema
}

/// Generates schemas whose parts stand where they are used, so that an editor need not look elsewhere.
pub fn generator() -> SchemaGenerator {
    SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true).into_generator()
}

/// A schema with a title.
pub fn whole_file(mut generator: SchemaGenerator, schema: Schema, title: &str) -> Value {
    let mut whole = schema.to_value();
    if let Some(whole) = whole.as_object_mut() {
        whole.insert("$schema".into(), "http://json-schema.org/draft-07/schema#".into());
        whole.insert("title".into(), title.into());
        let definitions = generator.take_definitions(true);
        if !definitions.is_empty() {
            whole.insert("definitions".into(), Value::Object(definitions));
        }
    }
    whole
}

/// What a page says of each key: the cells of the rows of its tables that begin with the key, without the example.
pub fn rows(page: &str) -> Vec<(String, String)> {
    let rows = page.lines().filter(|line| line.starts_with("| `"));
    let read = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let (keys, said) = cells.split_first()?;
        let said: Vec<&str> = said.iter().copied().filter(|cell| !cell.is_empty()).collect();
        let mut table = String::new();
        let key = |key: &str| {
            let key = key.trim().trim_matches('`');
            let Some(name) = key.strip_prefix('.') else {
                table = key.rsplit_once('.').map_or(String::new(), |(table, _)| table.to_owned());
                return key.to_owned();
            };
            format!("{table}.{name}")
        };
        let keys: Vec<String> = keys.split(',').map(key).collect();
        Some(keys.into_iter().map(move |key| (key, without_links(&said.join("; ")))).collect::<Vec<_>>())
    };
    rows.filter_map(read).flatten().collect()
}

/// The text of a page without the addresses of its links, which lead nowhere from an editor.
fn without_links(text: &str) -> String {
    let Some((before, after)) = text.split_once("](") else { return text.to_owned() };
    let (Some((head, words)), Some((_, rest))) = (before.rsplit_once('['), after.split_once(')')) else {
        return text.to_owned();
    };
    format!("{head}{words}{}", without_links(rest))
}

/// Gives every property of a schema that has no description what is said of its key, whose tables are `above`.
pub fn describe(schema: &mut Value, said: &[(String, String)], above: &str) {
    for group in ["anyOf", "allOf", "oneOf"] {
        for part in schema.get_mut(group).and_then(Value::as_array_mut).into_iter().flatten() {
            describe(part, said, above);
        }
    }
    let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) else { return };
    for (name, property) in properties {
        let key = if above.is_empty() { name.clone() } else { format!("{above}.{name}") };
        describe(property, said, &key);
        let known = said.iter().find(|(known, _)| *known == key);
        if let (Some(property), Some((_, text))) = (property.as_object_mut(), known) {
            add_description(property, text);
        }
    }
}

fn add_description(property: &mut Map<String, Value>, text: &str) {
    property.entry("description").or_insert_with(|| text.into());
}
