//! Means and deviations, with the paper's Table 3.

use comfy_table::Table;
use results::MomentsRow;
use results::moments::from_text;

use super::printed::{new_table, number, time_heads};

/// Table 3 as printed.
const TABLE_3: &str = include_str!("../paper/table-3.csv");

/// Beginning of the column of the probability that the re-entry variable is above its critical value; the rest is the
/// variable's symbol.
const ABOVE: &str = "prob_above_critical_";

/// The means and deviations of a row with their columns, in order: `mean_phi_rad`.
pub fn shown(row: &MomentsRow) -> Vec<(&str, f64)> {
    row.named().filter(|(column, _)| column.starts_with("mean_") || column.starts_with("std_")).collect()
}

/// The probability that the re-entry variable is above its critical value.
pub fn above(row: &MomentsRow) -> Option<f64> {
    row.named().find(|(column, _)| column.starts_with(ABOVE)).map(|(_, probability)| probability)
}

/// The symbol of the re-entry variable.
pub fn reentry_symbol(row: &MomentsRow) -> Option<&str> {
    row.named().find_map(|(column, _)| column.strip_prefix(ABOVE))
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
pub fn table_3() -> Vec<MomentsRow> {
    from_text(TABLE_3).unwrap_or_default()
}

/// The methods of `rows` in their order.
pub fn methods<'a>(rows: &[&'a MomentsRow]) -> Vec<&'a str> {
    let mut methods: Vec<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    methods
}

/// The snapshot times of the first method \[yr\].
pub fn times(rows: &[&MomentsRow]) -> Vec<f64> {
    let first = rows.first().map(|row| row.method.as_str());
    rows.iter().filter(|row| Some(row.method.as_str()) == first).map(|row| row.t_yr).collect()
}

/// The table, with the paper's values in brackets if these are the paper's cases.
pub fn table(rows: &[&MomentsRow], beside_paper: bool) -> Table {
    let paper = if beside_paper { table_3() } else { Vec::new() };
    let times = times(rows);
    let header = ["method", ""].map(str::to_owned).into_iter().chain(time_heads(&times));
    let mut table = new_table(header.collect(), 2);
    for method in methods(rows) {
        let of_method: Vec<&&MomentsRow> = rows.iter().filter(|row| row.method == method).collect();
        let columns = of_method.first().map_or(Vec::new(), |row| shown(row));
        // What is stated at no time is of a variable that the case's model does not have.
        let is_stated = |(column, _): &&(&str, f64)| of_method.iter().any(|row| !row.number(column).is_nan());
        for (quantity, (column, _)) in columns.iter().filter(is_stated).enumerate() {
            let cells = of_method.iter().map(|row| {
                let ours = number(row.number(column));
                let printed = paper.iter().find(|p| p.method == method && p.t_yr == row.t_yr);
                printed.map_or(ours.clone(), |p| format!("{ours} ({:.5})", p.number(column)))
            });
            let name = if quantity == 0 { method.to_owned() } else { String::new() };
            table.add_row([name, symbol(column)].into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table
}

/// Prints that table.
pub fn print(scenario: &str, rows: &[&MomentsRow], beside_paper: bool) {
    let brackets = if beside_paper { ", the paper's Table 3 in brackets" } else { "" };
    say!("\n{scenario}: mean and standard deviation{brackets}\n{}", table(rows, beside_paper));
}
