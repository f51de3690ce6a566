//! What each method is good for.

use results::rows::VerdictRow;

use super::printed::new_table;

/// Prints the table.
pub fn print(scenario: &str, tolerance: f64, rows: &[&VerdictRow]) {
    if rows.is_empty() {
        return;
    }
    let mut table = new_table(["method", "verdict", "worst moment", "worst density"].map(Into::into).into(), 4);
    for row in rows {
        let quantity = format!(" in {}", row.moments_quantity);
        let moments = worst(row.moments_error, row.moments_noise, &quantity, row.moments_t_yr, &row.moments_judged_by);
        let density = worst(row.density_error, row.density_noise, "", row.density_t_yr, &row.density_judged_by);
        table.add_row([row.method.clone(), row.verdict.clone(), moments, density]);
    }
    say!("\n{scenario}: what each method is good for, to {} %\n{table}", percent(tolerance));
}

/// The worst error of a method: how large it is, in which quantity, at which time, and by whom it is judged.
fn worst(error: f64, noise: f64, quantity: &str, time: f64, by: &str) -> String {
    let place = format!("{quantity} at {time} yr");
    match (error.is_nan(), noise > 0.0) {
        _ if by == "withheld" => format!("withheld{place}"),
        (true, true) => format!("± {} %{place}, by {by}", percent(noise)),
        (true, false) => format!("not measured, by {by}"),
        (false, true) => format!("{} % ± {} %{place}, by {by}", percent(error), percent(noise)),
        (false, false) => format!("{} %{place}, by {by}", percent(error)),
    }
}

/// A fraction in per cent, with two decimals, or with one significant digit below 0.01 %.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 0.01 {
        format!("{}", (percent * 100.0).round() / 100.0)
    } else {
        format!("{percent:.0e}")
    }
}
