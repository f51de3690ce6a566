//! The table of a campaign.

use std::collections::BTreeMap;

use super::judge::{Kind, Verdict};
use super::methods::Method;

/// The counts of one method.
#[derive(Debug, Default)]
pub struct Row {
    scenarios: usize,
    refused: usize,
    reasons: BTreeMap<String, usize>,
    off: BTreeMap<Kind, Vec<f64>>,
    silently_wrong: BTreeMap<Kind, usize>,
    scenarios_silently_wrong: usize,
    wrong_and_warned: usize,
    warned: usize,
    warned_in_vain: usize,
    withheld: usize,
    seconds: f64,
    slowest: f64,
}

impl Row {
    /// Adds the result of one scenario.
    pub fn add(&mut self, verdict: &Verdict, seconds: f64) {
        self.scenarios += 1;
        self.seconds += seconds;
        self.slowest = self.slowest.max(seconds);
        self.refused += usize::from(!verdict.refusals.is_empty());
        if let Some(reason) = verdict.refusals.first() {
            *self.reasons.entry(without_numbers(reason)).or_default() += 1;
        }
        for figure in &verdict.figures {
            if figure.kind != Kind::Impossible {
                self.off.entry(figure.kind).or_default().push(figure.off);
            }
            self.wrong_and_warned += usize::from(figure.wrong && figure.warned);
        }
        for figure in verdict.silently_wrong() {
            *self.silently_wrong.entry(figure.kind).or_default() += 1;
        }
        let is_wrong = verdict.figures.iter().any(|figure| figure.wrong);
        self.scenarios_silently_wrong += usize::from(verdict.silently_wrong().next().is_some());
        self.warned += verdict.warned;
        self.warned_in_vain += if is_wrong { 0 } else { verdict.warned };
        self.withheld += verdict.withheld.len();
    }

    /// Number of scenarios in which something is wrong without a warning.
    pub fn silently_wrong(&self) -> usize {
        self.scenarios_silently_wrong
    }
}

/// A reason without its numbers, so that similar reasons are counted together.
fn without_numbers(reason: &str) -> String {
    let mut text = String::new();
    for word in reason.split_whitespace() {
        let is_number = word.trim_matches([',', ';', '(', ')']).parse::<f64>().is_ok();
        text.push_str(if is_number { "#" } else { word });
        text.push(' ');
    }
    text.chars().take(110).collect()
}

fn median_and_largest(values: Option<&Vec<f64>>) -> String {
    let Some(values) = values.filter(|values| !values.is_empty()) else { return "-".into() };
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    format!("{:.0e} / {:.0e}", sorted[sorted.len() / 2], sorted[sorted.len() - 1])
}

/// The table of all methods, as Markdown.
pub fn table(rows: &[(Method, Row)]) -> String {
    let mut text = String::from(
        "| method | scenarios | refused | moments off, median / most [sd] | p_above | joint density [L1] | p_ever | \
         snapshots warned (in vain) | figures wrong, warned | figures silently wrong: moments, p_above, joint, p_ever, impossible | \
         scenarios silently wrong | figures withheld | CPU [s], of the slowest |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (method, row) in rows {
        let off = |kind| median_and_largest(row.off.get(&kind));
        let wrong: Vec<String> =
            Kind::ALL.iter().map(|kind| row.silently_wrong.get(kind).copied().unwrap_or(0).to_string()).collect();
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} ({}) | {} | {} | {} | {} | {:.1}, {:.1} |\n",
            method.name(),
            row.scenarios,
            row.refused,
            off(Kind::Moment),
            off(Kind::Above),
            off(Kind::Joint),
            off(Kind::Passage),
            row.warned,
            row.warned_in_vain,
            row.wrong_and_warned,
            wrong.join(", "),
            row.scenarios_silently_wrong,
            row.withheld,
            row.seconds,
            row.slowest,
        );
    }
    for (method, row) in rows {
        for (reason, count) in &row.reasons {
            text += &format!("\n{} refused {count}: {reason}", method.name());
        }
    }
    text
}
