//! Names and units of the numbers of a payload, in order.

use crate::describe::Field;

/// The type of the items of a payload.
pub trait Item: bytemuck::Pod {
    /// Its name.
    const NAME: &'static str;
    /// Its fields; none for a plain number.
    const FIELDS: &'static [Field];
}

impl Item for f64 {
    const NAME: &'static str = "f64";
    const FIELDS: &'static [Field] = &[];
}

/// How the numbers of a payload form a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Numbers before the table.
    pub head: usize,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// Whether the numbers lie column by column, instead of row by row.
    pub by_column: bool,
}

/// A table with these columns that lies row by row.
pub fn rows(columns: &[&str]) -> Shape {
    table(columns, false)
}

/// A table of these columns.
pub(crate) fn table(columns: &[&str], by_column: bool) -> Shape {
    Shape { head: 0, columns: columns.iter().map(|&column| column.to_owned()).collect(), by_column }
}

/// A first-passage curve: one row per time.
pub const PASSAGE: [&str; 4] = ["time [yr]", "probability", "low", "high"];
/// With what a row of a first-passage curve may go on: what re-entry, or none, says of an uncertain radiation
/// parameter.
pub const GIVEN: [&str; 8] = [
    "mean of C given re-entry",
    "deviation of C given re-entry",
    "error of that mean",
    "error of that deviation",
    "mean of C given none",
    "deviation of C given none",
    "error of that mean",
    "error of that deviation",
];
/// Errors of the moments: one row per quantity.
pub const ERRORS: [&str; 4] = ["value", "reference value", "absolute error", "relative error"];
/// Distances of densities: one row per projection.
pub const DISTANCES: [&str; 5] = ["total variation", "L2", "Hellinger", "Kullback-Leibler", "Kolmogorov"];
/// Effort: one row.
pub const EFFORT: [&str; 4] = ["propagation [s]", "estimation [s]", "sum [s]", "ratio to the baseline"];
/// A status: one row.
pub const STATUS: [&str; 2] = ["units done", "units in all"];
