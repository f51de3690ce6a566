//! Computational effort, with the paper's Table 4.

use serde::Deserialize;

use super::{OfScenario, new_table, read_text};

/// Table 4 as printed.
const TABLE_4: &str = include_str!("../paper/table-4.csv");

/// A row of a results folder's `effort.csv` or of Table 4.
#[derive(Debug, Deserialize)]
pub struct Row {
    scenario: Option<String>,
    method: String,
    t_prop_s: f64,
    t_int_s: f64,
    t_cal_s: f64,
    ratio_to_mc: f64,
}

/// The rows of a table.
pub type Rows = Vec<Row>;

impl OfScenario for Row {
    fn scenario(&self) -> Option<&str> {
        self.scenario.as_deref()
    }
}

impl Row {
    fn values(&self) -> [f64; 4] {
        [self.t_prop_s, self.t_int_s, self.t_cal_s, self.ratio_to_mc]
    }
}

/// Prints the table, with the paper's values in brackets if these are the paper's cases.
pub fn print(scenario: &str, rows: &[&Row], beside_paper: bool) {
    let paper: Rows = if beside_paper { read_text(TABLE_4) } else { Rows::new() };
    let brackets = if beside_paper { ", the paper's Table 4 in brackets" } else { "" };
    let mut table =
        new_table(["method", "t_prop, s", "t_int, s", "t_cal, s", "t_cal / t_cal-MC"].map(Into::into).into(), 1);
    for row in rows {
        let printed = paper.iter().find(|p| p.method == row.method);
        let cells = row.values().into_iter().enumerate().map(|(i, ours)| {
            let ours = format!("{ours:.4}");
            printed.map_or(ours.clone(), |p| format!("{ours} ({})", p.values()[i]))
        });
        table.add_row([row.method.clone()].into_iter().chain(cells).collect::<Vec<_>>());
    }
    say!("\n{scenario}: computational effort (CPU time){brackets}\n{table}");
}
