//! The key to which a place in a TOML file belongs, with its tables: `orbit.radiation`.

use toml::de::{DeTable, DeValue};

/// The innermost key whose name or value contains byte `offset` of `text`. If the text is not TOML, the key is
/// guessed from the lines.
pub(crate) fn key_at(text: &str, offset: usize) -> String {
    let known = DeTable::parse(text).ok().and_then(|table| in_table(table.get_ref(), offset));
    known.unwrap_or_else(|| by_looks(text, offset))
}

fn in_table(table: &DeTable<'_>, offset: usize) -> Option<String> {
    let mut outer = None;
    for (key, value) in table.iter() {
        let name = if key.get_ref().is_empty() { "\"\"" } else { key.get_ref() };
        if let Some(inner) = in_value(value.get_ref(), offset) {
            return Some(format!("{name}.{inner}"));
        }
        if key.span().contains(&offset) || value.span().contains(&offset) {
            outer = Some(name.to_string());
        }
    }
    outer
}

/// Tables and arrays of tables may continue after other tables, so all are searched.
fn in_value(value: &DeValue<'_>, offset: usize) -> Option<String> {
    match value {
        DeValue::Table(table) => in_table(table, offset),
        DeValue::Array(values) => values.iter().find_map(|value| in_value(value.get_ref(), offset)),
        _ => None,
    }
}

/// For text that is not TOML: the text before `=` on the line, and the last table header before it.
fn by_looks(text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let current = text.lines().nth(before.matches('\n').count()).unwrap_or("").trim();
    let header = before.lines().chain([current]).map(str::trim).rfind(|line| line.starts_with('['));
    let table = header.map_or("", |line| line.split(']').next().unwrap_or(line).trim_start_matches('[').trim());
    let key = match current.split_once('=') {
        Some((key, _)) if !current.starts_with('[') => key.trim(),
        _ => "",
    };
    let dot = if table.is_empty() || key.is_empty() { "" } else { "." };
    format!("{table}{dot}{key}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_is_found_however_the_value_is_written() {
        for (text, mark, key) in [
            ("a = 1\n[b]\nc = [\n  1,\n  -2,\n]\n", "-2", "b.c"),
            ("b = { c = 1, d = -2 }\n", "-2", "b.d"),
            ("b.c.d = -2\n", "-2", "b.c.d"),
            ("a = \"\"\"\n[no]\nx = 1\n\"\"\"\nb = -2\n", "-2", "b"),
            ("[[p]]\nx = 1\n[[p]]\nx = -2\n", "-2", "p.x"),
            ("[t]\nx = -2 3\n", "3", "t.x"),
            ("[t]\nx 4\n", "4", "t"),
            ("[t", "t", "t"),
            ("\"\" = 1", "1", "\"\""),
        ] {
            assert_eq!(key_at(text, text.find(mark).unwrap()), key, "{text}");
        }
    }
}
