//! Means and deviations, with the paper's Table 3.

use serde::Deserialize;

use super::{OfScenario, new_table, number, read_text, time_heads};

/// Table 3 as printed.
const TABLE_3: &str = include_str!("../paper/table-3.csv");

/// The quantities of Table 3.
pub const SYMBOLS: [&str; 4] = ["μ_φ, rad", "σ_φ, rad", "μ_e", "σ_e"];

/// A row of a results folder's `moments.csv` or of Table 3.
#[derive(Debug, Deserialize)]
pub struct Row {
    scenario: Option<String>,
    pub method: String,
    pub t_yr: f64,
    mean_phi_rad: f64,
    std_phi_rad: f64,
    mean_e: f64,
    std_e: f64,
    pub prob_above_critical_e: Option<f64>,
}

/// The rows of a table.
pub type Rows = Vec<Row>;

impl OfScenario for Row {
    fn scenario(&self) -> Option<&str> {
        self.scenario.as_deref()
    }
}

impl Row {
    /// The values, in the order of [`SYMBOLS`].
    pub fn values(&self) -> [f64; 4] {
        [self.mean_phi_rad, self.std_phi_rad, self.mean_e, self.std_e]
    }
}

/// Table 3 of the paper.
pub fn table_3() -> Rows {
    read_text(TABLE_3)
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

/// Prints the table, with the paper's values in brackets if these are the paper's cases.
pub fn print(scenario: &str, rows: &[&Row], beside_paper: bool) {
    let paper = if beside_paper { table_3() } else { Rows::new() };
    let brackets = if beside_paper { ", the paper's Table 3 in brackets" } else { "" };
    let times = times(rows);
    let header = ["method", ""].map(str::to_owned).into_iter().chain(time_heads(&times));
    let mut table = new_table(header.collect(), 2);
    for method in methods(rows) {
        for (quantity, symbol) in SYMBOLS.iter().enumerate() {
            let cells = rows.iter().filter(|row| row.method == method).map(|row| {
                let ours = number(row.values()[quantity]);
                let printed = paper.iter().find(|p| p.method == method && p.t_yr == row.t_yr);
                printed.map_or(ours.clone(), |p| format!("{ours} ({:.5})", p.values()[quantity]))
            });
            let name = if quantity == 0 { method } else { "" };
            table.add_row([name, symbol].map(str::to_owned).into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    say!("\n{scenario}: mean and standard deviation{brackets}\n{table}");
}
