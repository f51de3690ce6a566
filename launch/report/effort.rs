//! Computational effort, with the paper's Table 4.

use results::rows::EffortRow;
use results::table::from_text;

use super::printed::new_table;

/// Table 4 as printed.
const TABLE_4: &str = include_str!("../paper/table-4.csv");

fn values(row: &EffortRow) -> [f64; 4] {
    [row.t_prop_s, row.t_int_s, row.t_cal_s, row.ratio_to_baseline]
}

/// Prints the table, whose last column is relative to the case `baseline` if it took part, with the paper's values in
/// brackets if these are the paper's cases.
pub fn print(scenario: &str, rows: &[&EffortRow], baseline: Option<&str>, beside_paper: bool) {
    let paper: Vec<EffortRow> = if beside_paper { from_text(TABLE_4).unwrap_or_default() } else { Vec::new() };
    let brackets = if beside_paper { ", the paper's Table 4 in brackets" } else { "" };
    let ratio = format!("t_cal / t_cal-{}", baseline.unwrap_or("baseline").to_uppercase());
    let heads = ["method", "t_prop, s", "t_int, s", "t_cal, s", &ratio];
    let shown = if rows.iter().any(|row| row.ratio_to_baseline.is_finite()) { heads.len() } else { heads.len() - 1 };
    let mut table = new_table(heads[..shown].iter().map(|head| (*head).into()).collect(), 1);
    for row in rows {
        let printed = paper.iter().find(|p| p.method == row.method);
        let cells = values(row).into_iter().take(shown - 1).enumerate().map(|(i, ours)| {
            let ours = format!("{ours:.4}");
            printed.map_or(ours.clone(), |p| format!("{ours} ({})", values(p)[i]))
        });
        table.add_row([row.method.clone()].into_iter().chain(cells).collect::<Vec<_>>());
    }
    say!("\n{scenario}: computational effort (CPU time){brackets}\n{table}");
}
