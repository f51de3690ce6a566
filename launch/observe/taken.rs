//! A message taken apart: its fields by name, and its payload row by row.

use messages::describe::{Field, FieldKind, Value};
use messages::payload::{Item, Shape};
use messages::topic::Topic;
use serde_json::{Map, json};

/// A message taken apart.
#[derive(Debug)]
pub(crate) struct Taken {
    pub(super) topic: &'static str,
    pub(super) header: Vec<(String, Field, Value)>,
    pub(super) items: usize,
    pub(super) shape: Shape,
    pub(super) rows: Vec<Vec<Value>>,
    /// Number of messages before this one that could not be printed in time.
    pub(super) missed: usize,
}

impl Taken {
    /// A message on the topic `T` with at most so many rows of its payload.
    pub(crate) fn of<T: Topic>(header: &T::Header, items: &[T::Item], most: usize) -> Self {
        let shape = T::shape(header);
        let rows = if T::Item::FIELDS.is_empty() {
            number_rows(bytemuck::cast_slice(bytemuck::cast_slice::<_, u8>(items)), &shape, most)
        } else {
            let fields = |item: &T::Item| {
                T::Item::FIELDS.iter().filter_map(|field| field.value(bytemuck::bytes_of(item))).collect()
            };
            items.iter().take(most).map(fields).collect()
        };
        Self { topic: T::NAME, header: T::values(header), items: items.len(), shape, rows, missed: 0 }
    }

    /// The message as one JSON object.
    pub(crate) fn json(&self) -> serde_json::Value {
        let value = |value: &Value| match value {
            Value::Whole(number) => json!(number),
            Value::Real(numbers) if numbers.len() == 1 => json!(numbers[0]),
            Value::Real(numbers) => json!(numbers),
            Value::Text(text) => json!(text),
        };
        let field = |(name, field, field_value): &(String, Field, Value)| {
            let shown = if is_run(field) { json!(words(field, field_value)) } else { value(field_value) };
            (name.clone(), shown)
        };
        let header: Map<_, _> = self.header.iter().map(field).collect();
        let rows: Vec<Vec<_>> = self.rows.iter().map(|row| row.iter().map(value).collect()).collect();
        let payload = json!({"items": self.items, "columns": self.shape.columns, "rows": rows});
        json!({"topic": self.topic, "header": header, "payload": payload})
    }
}

/// The numbers before the table of a payload, if it has any, as a row of their own, and the first rows of the table.
fn number_rows(numbers: &[f64], shape: &Shape, most: usize) -> Vec<Vec<Value>> {
    let (head, numbers) = numbers.split_at(shape.head.min(numbers.len()));
    let head = (!head.is_empty()).then(|| head.iter().map(|&x| Value::Real(vec![x])).collect());
    let columns = shape.columns.len().max(1);
    let count = numbers.len().div_ceil(columns);
    let at = |row: usize, column: usize| if shape.by_column { column * count + row } else { row * columns + column };
    let row =
        |row| (0..columns).filter_map(|column| numbers.get(at(row, column))).map(|&x| Value::Real(vec![x])).collect();
    head.into_iter().chain((0..count.min(most)).map(row)).collect()
}

/// Whether a field is the number of a run. Runs are named in hexadecimal digits everywhere; all other numbers are
/// decimal.
fn is_run(field: &Field) -> bool {
    field.kind == FieldKind::U64 && field.name == "run_id"
}

/// A value as text.
pub(super) fn words(field: &Field, value: &Value) -> String {
    match value {
        Value::Whole(number) if is_run(field) => format!("{number:012x}"),
        other => plain(other),
    }
}

/// A value as text, whatever its field is.
pub(super) fn plain(value: &Value) -> String {
    match value {
        Value::Whole(number) => number.to_string(),
        Value::Real(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
        Value::Text(text) => text.clone(),
    }
}
