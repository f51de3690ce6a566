//! What a disposal designer asks: the probability that the re-entry variable exceeds its critical value, or ever has.

use results::MomentsRow;
use results::rows::PassageRow;

use super::moments;
use super::printed::{new_table, number, time_heads};

/// Prints the probability of being above the critical value at each snapshot, and of ever having reached it by
/// the end.
pub fn print(scenario: &str, critical: f64, rows: &[&MomentsRow], passages: &[&PassageRow]) {
    let times = moments::times(rows);
    let end = times.last().copied().unwrap_or(0.0);
    let heads = [format!("ever by {end} yr"), "interval".into()];
    let header = ["method".to_owned()].into_iter().chain(time_heads(&times)).chain(heads);
    let mut table = new_table(header.collect(), 1);
    for method in moments::methods(rows) {
        let now = rows.iter().filter(|row| row.method == method);
        let cells = now.map(|row| moments::above(row).map_or(String::new(), probability));
        let last = passages.iter().rfind(|row| row.method == method && row.t_yr == end);
        let ever = last.map_or("-".into(), |row| probability(row.prob_reached_critical_e));
        let interval = match last {
            // An interval as narrow as rounding would show nothing in five digits.
            Some(row) if row.high - row.low > 1e-6 => format!("{:.5} to {:.5} ({})", row.low, row.high, row.interval),
            _ => String::new(),
        };
        table.add_row([method.to_owned()].into_iter().chain(cells).chain([ever, interval]).collect::<Vec<_>>());
    }
    let symbol = rows.first().and_then(|row| moments::reentry_symbol(row)).unwrap_or("the re-entry variable");
    say!("\n{scenario}: probability that {symbol} exceeds {critical}, at each time and ever\n{table}");
}

fn probability(p: f64) -> String {
    if p.is_nan() || p == 0.0 || p >= 1e-5 { number(p) } else { format!("{p:.0e}") }
}
