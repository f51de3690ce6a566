//! Means and deviations, with the paper's Table 3.

use std::io::Read;

use comfy_table::Table;

use super::{OfScenario, new_table, number, time_heads};

/// Table 3 as printed.
const TABLE_3: &str = include_str!("../paper/table-3.csv");

/// A row of a results folder's `moments.csv` or of Table 3.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    scenario: Option<String>,
    pub method: String,
    pub t_yr: f64,
    /// Means and deviations by their columns, in order: `mean_phi_rad`.
    pub values: Vec<(String, f64)>,
    /// Probability that the re-entry variable is above its critical value.
    pub above: Option<f64>,
}

/// The rows of a table.
pub type Rows = Vec<Row>;

impl OfScenario for Row {
    fn scenario(&self) -> Option<&str> {
        self.scenario.as_deref()
    }
}

/// Reads a table, whose columns follow from the variables of the scenarios' models; what is no row of it is left out.
pub fn read(mut table: csv::Reader<impl Read>) -> Rows {
    let Ok(head) = table.headers().cloned() else { return Rows::new() };
    let of_head = |record: csv::StringRecord| {
        let cells = || head.iter().zip(record.iter());
        let text = |name: &str| cells().find(|(column, _)| *column == name).map(|(_, cell)| cell.to_owned());
        let is_shown = |column: &str| column.starts_with("mean_") || column.starts_with("std_");
        let shown = cells().filter(|(column, _)| is_shown(column));
        let above = cells().find(|(column, _)| column.starts_with("prob_above_critical_"));
        Some(Row {
            scenario: text("scenario"),
            method: text("method")?,
            t_yr: text("t_yr")?.parse().ok()?,
            values: shown.map(|(column, cell)| Some((column.to_owned(), cell.parse().ok()?))).collect::<Option<_>>()?,
            above: above.and_then(|(_, cell)| cell.parse().ok()),
        })
    };
    table.records().flatten().filter_map(of_head).collect()
}

/// How a column's quantity is written: `μ_φ, rad` for `mean_phi_rad`.
pub fn symbol(column: &str) -> String {
    let (letter, variable) = match column.split_once('_') {
        Some(("mean", variable)) => ("μ", variable),
        Some((_, variable)) => ("σ", variable),
        None => return column.into(),
    };
    let (variable, unit) =
        variable.split_once('_').map_or((variable, String::new()), |(v, unit)| (v, format!(", {unit}")));
    format!("{letter}_{}{unit}", if variable == "phi" { "φ" } else { variable })
}

/// Table 3 of the paper.
pub fn table_3() -> Rows {
    read(csv::Reader::from_reader(TABLE_3.as_bytes()))
}

/// The methods of `rows` in their order.
pub fn methods<'a>(rows: &[&'a Row]) -> Vec<&'a str> {
    let mut methods: Vec<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    methods
}

/// The snapshot times of the first method \[yr\].
pub fn times(rows: &[&Row]) -> Vec<f64> {
    let first = rows.first().map(|row| row.method.as_str());
    rows.iter().filter(|row| Some(row.method.as_str()) == first).map(|row| row.t_yr).collect()
}

/// The table, with the paper's values in brackets if these are the paper's cases.
pub fn table(rows: &[&Row], beside_paper: bool) -> Table {
    let paper = if beside_paper { table_3() } else { Rows::new() };
    let times = times(rows);
    let header = ["method", ""].map(str::to_owned).into_iter().chain(time_heads(&times));
    let mut table = new_table(header.collect(), 2);
    for method in methods(rows) {
        let of_method: Vec<&&Row> = rows.iter().filter(|row| row.method == method).collect();
        let columns: Vec<String> = of_method.first().map_or(Vec::new(), |row| names(row));
        for (quantity, column) in columns.iter().enumerate() {
            let cells = of_method.iter().map(|row| {
                let ours = number(row.values[quantity].1);
                let printed = paper.iter().find(|p| p.method == method && p.t_yr == row.t_yr);
                printed.map_or(ours.clone(), |p| format!("{ours} ({:.5})", p.values[quantity].1))
            });
            let name = if quantity == 0 { method.to_owned() } else { String::new() };
            table.add_row([name, symbol(column)].into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table
}

fn names(row: &Row) -> Vec<String> {
    row.values.iter().map(|(column, _)| column.clone()).collect()
}

/// Prints that table.
pub fn print(scenario: &str, rows: &[&Row], beside_paper: bool) {
    let brackets = if beside_paper { ", the paper's Table 3 in brackets" } else { "" };
    say!("\n{scenario}: mean and standard deviation{brackets}\n{}", table(rows, beside_paper));
}
