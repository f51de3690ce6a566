//! The answers that one looks for first, in sentences: when the satellite re-enters, and which method to trust.

use density::trust::Verdict;
use maud::{Markup, html};

use super::numbers::{plain, probability, seconds};
use crate::scene::{Method, Scene};
use crate::words::reentry;
use results::notes::listed;
use results::rows::{PassageRow, VerdictRow, of_scenario};

/// The probabilities whose dates are named.
const LEVELS: [f64; 5] = [0.01, 0.1, 0.5, 0.9, 0.99];
/// An interval narrower than this is not worth a sentence.
const NARROW: f64 = 1e-5;

/// Both answers for a scenario.
pub fn of(scene: &Scene<'_>) -> Markup {
    html! { p { (when(scene)) } (trust(scene)) }
}

/// The case that says when: the reference, or else the first that has a curve to its end.
fn speaker<'s, 'a>(scene: &'s Scene<'a>) -> Option<(&'s Method<'a>, &'a PassageRow)> {
    let reference = scene.methods.iter().filter(|method| method.label == scene.reference);
    let speaks = |method: &'s Method<'a>| {
        let last = method.passage.last().copied().filter(|row| row.prob_reached_critical_e.is_finite());
        last.map(|last| (method, last))
    };
    reference.chain(&scene.methods).find_map(speaks)
}

fn when(scene: &Scene<'_>) -> Markup {
    let (name, _) = reentry(scene.description);
    // To four digits: it may follow from a height.
    let critical = (scene.description.critical * 1e4).round() / 1e4;
    let Some((method, last)) = speaker(scene) else {
        return html! { "In " (scene.name) " no case says with which probability the " (name) " ever reaches " (critical) "." };
    };
    html! {
        "In " b { (scene.name) } " the " (name) " has reached " (critical) " by " (last.t_yr) " yr with probability "
        b { (probability(last.prob_reached_critical_e)) }
        @if last.high - last.low > NARROW {
            " (" (plain(last.low)) " to " (plain(last.high)) @if !last.interval.is_empty() { ", " (last.interval) } ")"
        }
        ", by " (method.label) ". " (levels(&method.passage))
    }
}

/// When the probability reaches each of the levels, as a sentence.
fn levels(curve: &[&PassageRow]) -> String {
    let percent = |level: f64| format!("{} %", (100.0 * level).round());
    let dates: Vec<(f64, Option<f64>)> = LEVELS.iter().map(|&level| (level, date(curve, level))).collect();
    let reached: Vec<String> =
        dates.iter().filter_map(|&(level, t)| Some(format!("{} by {:.2} yr", percent(level), t?))).collect();
    let missed = dates.iter().find(|(_, t)| t.is_none()).map(|(level, _)| percent(*level));
    match (reached.is_empty(), missed) {
        (true, missed) => missed.map_or(String::new(), |missed| format!("It does not reach {missed}.")),
        (false, None) => format!("It reaches {}.", listed(&reached)),
        (false, Some(missed)) => format!("It reaches {}, and not {missed}.", listed(&reached)),
    }
}

/// When a curve reaches a level, on the straight line between its rows; `None` if it does not, or if the rows there are
/// withheld.
fn date(curve: &[&PassageRow], level: f64) -> Option<f64> {
    let first = curve.iter().position(|row| row.prob_reached_critical_e >= level)?;
    let after = curve[first];
    let Some(before) = first.checked_sub(1).map(|k| curve[k]) else { return Some(after.t_yr) };
    let rise = after.prob_reached_critical_e - before.prob_reached_critical_e;
    let share = (level - before.prob_reached_critical_e) / rise;
    share.is_finite().then_some(before.t_yr + share * (after.t_yr - before.t_yr))
}

/// Which methods are good for what, and the cheapest of the good ones.
fn trust(scene: &Scene<'_>) -> Markup {
    let rows = of_scenario(&scene.results.verdicts, scene.name);
    let Some(tolerance) = rows.first().map(|row| row.tolerance) else { return html! {} };
    let is_good = |row: &&&VerdictRow| row.verdict == Verdict::new(true, true).words();
    let good: Vec<&str> = rows.iter().filter(is_good).map(|row| row.method.as_str()).collect();
    let cost = |label: &str| scene.method(label)?.effort.map(|effort| effort.t_cal_s).filter(|cost| cost.is_finite());
    let cheapest = good.iter().filter_map(|label| Some((label, cost(label)?))).min_by(|a, b| a.1.total_cmp(&b.1));
    let others = rows.iter().filter(|row| !good.contains(&row.method.as_str()));
    html! {
        p {
            "To " (100.0 * tolerance) " %, "
            @if good.is_empty() { "no case can be trusted for moments and density alike" }
            @else { "trust " b { (listed(&good)) } " for moments and density" }
            @if let Some((label, cost)) = cheapest.filter(|_| good.len() > 1) { "; the cheapest of them is " b { (label) } " with " (seconds(cost)) " s of CPU time" }
            "."
            @for row in others { " " b { (row.method) } ": " (row.verdict) "." }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(t_yr: f64, p: f64) -> PassageRow {
        let (scenario, method, interval) = (String::new(), String::new(), String::new());
        PassageRow { scenario, method, t_yr, prob_reached_critical_e: p, low: p, high: p, interval }
    }

    #[test]
    fn dates_lie_on_the_line_between_rows_and_a_level_that_is_not_reached_is_named() {
        let rows = [row(0.0, 0.0), row(1.0, 0.05), row(2.0, 0.25)];
        let curve: Vec<&PassageRow> = rows.iter().collect();
        assert_eq!(levels(&curve), "It reaches 1 % by 0.20 yr and 10 % by 1.25 yr, and not 50 %.");
        assert_eq!(levels(&curve[..1]), "It does not reach 1 %.");
        let whole = [row(0.0, 0.0), row(10.0, 1.0)];
        let whole: Vec<&PassageRow> = whole.iter().collect();
        let words = "It reaches 1 % by 0.10 yr, 10 % by 1.00 yr, 50 % by 5.00 yr, 90 % by 9.00 yr and 99 % by 9.90 yr.";
        assert_eq!(levels(&whole), words);
    }

    #[test]
    fn no_date_is_read_next_to_a_withheld_row() {
        let rows = [row(0.0, 0.0), row(1.0, f64::NAN), row(2.0, 0.25)];
        let curve: Vec<&PassageRow> = rows.iter().collect();
        assert_eq!(date(&curve, 0.1), None);
    }
}
