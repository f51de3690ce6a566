//! Compares all first-passage curves with that of the reference, whether or not their errors are known.
//!
//! A curve does not fall, so the reference's bounds hold between its own times too: at any time the probability is at
//! least that at the reference's last time before, and at most that at its next time.

use super::agreement::{CaseResults, Contradiction};
use crate::services::passage_rules::{Row, allowance, rows};
use crate::services::roster::Roster;

/// A curve to compare with, or to be compared.
struct Curve<'a> {
    label: &'a str,
    rows: Vec<Row>,
    samples: u64,
}

/// For each case whose curve lies outside the bounds of the reference's curve by more than both may be off: the row
/// at which it is farthest outside.
pub(super) fn off_the_reference(cases: &[CaseResults<'_>], roster: &Roster) -> Vec<Contradiction> {
    let curves =
        || cases.iter().map(|case| Curve { label: case.label, rows: rows(&case.passage), samples: case.counted });
    let states = |curve: &Curve<'_>| curve.rows.iter().any(|row| !row.is_withheld());
    let find = |label: &str| curves().find(|curve| curve.label == label && states(curve));
    let Some(reference) = roster.standing_references().find_map(find) else { return Vec::new() };
    curves().filter(|curve| curve.label != reference.label).filter_map(|curve| farthest(&curve, &reference)).collect()
}

fn farthest(curve: &Curve<'_>, reference: &Curve<'_>) -> Option<Contradiction> {
    let claimed = curve.rows.iter().filter(|row| !row.is_withheld());
    let excess = |row: &Row| {
        let bounds = bounds(reference, row.time);
        // Counting noise is an error of the probability itself, that of an interval one of its ends.
        let (low, high) = if curve.samples > 0 { (row.probability, row.probability) } else { row.ends() };
        let below = bounds.low - bounds.low_allowance - high;
        let above = low - bounds.high - bounds.high_allowance;
        let distance = below.max(above) - allowance(row.probability, curve.samples, row.width());
        (distance > 0.0).then_some((distance, *row, bounds))
    };
    let (_, row, Bounds { low, high, .. }) = claimed.filter_map(excess).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let what = format!(
        "its first-passage curve has {:.5} by {} yr, {} between {low:.5} and {high:.5}",
        row.probability, row.time, reference.label
    );
    Some(Contradiction { label: curve.label.into(), time: row.time, what })
}

/// The probabilities between which a curve lies at a time, and the tolerated error of each.
struct Bounds {
    low: f64,
    low_allowance: f64,
    high: f64,
    high_allowance: f64,
}

fn bounds(reference: &Curve<'_>, time: f64) -> Bounds {
    let mut bounds = Bounds { low: 0.0, low_allowance: 0.0, high: 1.0, high_allowance: 0.0 };
    let rounding = 1e-12 * time.abs();
    for row in &reference.rows {
        let (low, high) = row.ends();
        let allowed = |end: f64| allowance(end, reference.samples, row.width());
        if row.time <= time + rounding && low >= bounds.low {
            (bounds.low, bounds.low_allowance) = (low, allowed(low));
        }
        if row.time >= time - rounding && high < bounds.high {
            (bounds.high, bounds.high_allowance) = (high, allowed(high));
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f64 = f64::NAN;

    fn said<'a>(label: &'a str, counted: u64, rows: &[[f64; 4]]) -> CaseResults<'a> {
        CaseResults { label, snapshots: Vec::new(), passage: rows.concat(), counted }
    }

    fn words(cases: &[CaseResults<'_>]) -> Vec<String> {
        let labels = cases.iter().map(|case| (case.label.to_owned(), false)).collect();
        let roster = Roster { references: vec![cases[0].label.into()], cases: labels, ..Roster::default() };
        off_the_reference(cases, &roster).into_iter().map(|found| format!("{}: {}", found.label, found.what)).collect()
    }

    #[test]
    fn a_curve_that_is_possible_but_not_the_references_is_told_once_where_it_is_farthest() {
        let exact = said("exact", 0, &[[0.0, 0.0, 0.0, 0.0], [1.0, 0.2, 0.2, 0.2], [2.0, 0.3, 0.3, 0.3]]);
        let eager = said("eager", 0, &[[0.0, 0.0, NAN, NAN], [0.5, 0.9, NAN, NAN], [2.0, 0.95, NAN, NAN]]);
        let lazy = said("lazy", 1000, &[[0.0, 0.0, 0.0, 0.01], [1.0, 0.0, 0.0, 0.01], [2.0, 0.0, 0.0, 0.01]]);
        let sure = said("sure", 0, &[[0.0, 0.9, 0.85, 0.95], [1.0, 0.9, 0.85, 0.95], [2.0, 0.9, 0.85, 0.95]]);
        let fine = said("fine", 0, &[[0.5, 0.2, NAN, NAN], [1.5, 0.21, NAN, NAN]]);
        assert_eq!(
            words(&[exact, eager, lazy, sure, fine]),
            [
                "eager: its first-passage curve has 0.90000 by 0.5 yr, exact between 0.00000 and 0.20000",
                "lazy: its first-passage curve has 0.00000 by 2 yr, exact between 0.30000 and 0.30000",
                "sure: its first-passage curve has 0.90000 by 0 yr, exact between 0.00000 and 0.00000",
            ]
        );
    }

    #[test]
    fn what_the_reference_withholds_or_has_counted_is_no_more_certain_than_its_bounds() {
        let withheld = said("exact", 0, &[[0.0, 0.0, 0.0, 0.0], [1.0, NAN, 0.1, 0.9]]);
        assert!(words(&[withheld, said("mine", 0, &[[1.0, 0.85, NAN, NAN]])]).is_empty());
        let counted = || said("mc", 1000, &[[1.0, 0.5, 0.47, 0.53]]);
        assert!(words(&[counted(), said("mine", 0, &[[1.0, 0.58, NAN, NAN]])]).is_empty());
        assert_eq!(words(&[counted(), said("mine", 0, &[[1.0, 0.0, NAN, NAN]])]).len(), 1);
    }
}
