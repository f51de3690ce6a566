//! How tables, numbers and times are printed.

use comfy_table::{CellAlignment, Table, presets};

/// A table whose first `names` columns are words and the others numbers.
pub fn new_table(header: Vec<String>, names: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    let columns = header.len();
    table.set_header(header);
    for column in names..columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// A number with five decimals; NaN stands for a figure that a method withholds.
pub(super) fn number(value: f64) -> String {
    if value.is_nan() { "withheld".into() } else { format!("{value:.5}") }
}

/// Column heads for snapshot times \[yr\].
pub(super) fn time_heads(times: &[f64]) -> impl Iterator<Item = String> + '_ {
    times.iter().map(|t| format!("t = {t} yr"))
}
