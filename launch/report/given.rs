//! What re-entry, and none, says of an uncertain radiation parameter.

use results::rows::{GivenRow, RE_ENTRY};

use super::printed::new_table;

/// Prints mean and deviation of the radiation parameter given re-entry by the end and given none, if a method has them.
pub fn print(scenario: &str, rows: &[&GivenRow]) {
    let end = rows.iter().map(|row| row.t_yr).fold(0.0, f64::max);
    let at_end: Vec<&&GivenRow> = rows.iter().filter(|row| row.t_yr == end).collect();
    if at_end.is_empty() {
        return;
    }
    let header = ["method", "given", "mean of C", "deviation of C"].map(str::to_owned);
    let mut table = new_table(header.into(), 2);
    for row in at_end {
        let event = if row.given == RE_ENTRY { "re-entry" } else { "no re-entry" };
        let cells = [told(row.mean_C, row.error_mean_C), told(row.std_C, row.error_std_C)];
        table.add_row([row.method.clone(), event.to_owned()].into_iter().chain(cells));
    }
    say!("\n{scenario}: the radiation parameter C given re-entry by {end} yr, and given none\n{table}");
}

/// A number with its error, in words where nothing is known of it.
fn told(value: f64, error: f64) -> String {
    match (value.is_nan(), error.is_nan()) {
        (true, _) => "too rare".into(),
        (_, true) => format!("{value:.6}"),
        _ => format!("{value:.6} ± {error:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_told_with_its_error_if_that_is_known() {
        assert_eq!(told(0.15, 1.2e-5), "0.150000 ± 1e-5");
        assert_eq!(told(0.15, f64::NAN), "0.150000");
        assert_eq!(told(f64::NAN, f64::NAN), "too rare");
    }
}
