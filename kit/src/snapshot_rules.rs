//! The rules for a snapshot of any sender.
//!
//! The estimator refuses a snapshot that breaks a rule, the kit does not send one whose numbers break a rule, and
//! `phasecloud check` reports rule by rule.

use messages::layout::SnapshotHeader;
use messages::scenario::Projection;

use crate::assignment::Assignment;
use crate::breach::{Breach, Rule};
use crate::kind::{self, Snapshot};

/// The snapshot that should be number `expected` of the scenario, decoded.
///
/// # Errors
/// The most severe rule that it breaks.
pub fn decode<'a>(
    header: &'a SnapshotHeader,
    items: &'a [f64],
    assignment: &Assignment,
    expected: usize,
) -> Result<Snapshot<'a>, Breach> {
    let (snapshot, breaches) = judge(header, items, assignment, expected);
    match (snapshot, breaches.into_iter().next()) {
        (Ok(snapshot), None) => Ok(snapshot),
        (_, Some(breach)) => Err(breach),
        (Err(what), None) => Err(Breach { rule: Rule::Shape, what }),
    }
}

/// All rules that a snapshot breaks, if it should be number `expected` of the scenario; the most severe comes first.
/// Numbers are checked only if their shape is right.
pub fn breaches(header: &SnapshotHeader, items: &[f64], assignment: &Assignment, expected: usize) -> Vec<Breach> {
    judge(header, items, assignment, expected).1
}

/// The snapshot, if it can be decoded, and all rules that it breaks.
fn judge<'a>(
    header: &'a SnapshotHeader,
    items: &'a [f64],
    assignment: &Assignment,
    expected: usize,
) -> (Result<Snapshot<'a>, String>, Vec<Breach>) {
    let times = &assignment.times;
    let mut found = Vec::new();
    let mut breach = |rule, what| found.push(Breach { rule, what });
    if header.run_id != assignment.description.run_id {
        let what = format!("it belongs to run {:012x}, not to {:012x}", header.run_id, assignment.description.run_id);
        breach(Rule::Identity, what);
    }
    if header.scenario != assignment.scenario() {
        let what = format!("it belongs to scenario {}, not to {}", header.scenario, assignment.scenario());
        breach(Rule::Identity, what);
    }
    if header.count as usize != times.len() {
        breach(Rule::Count, format!("it is one of {} snapshots, the scenario has {}", header.count, times.len()));
    }
    if let Some(what) = out_of_order(header.index, expected, times.len()) {
        breach(Rule::Order, what);
    }
    if let Some(&time) = times.get(header.index as usize)
        && header.time.to_bits() != time.to_bits()
    {
        breach(Rule::Time, format!("its time is {} yr instead of {time} yr", header.time));
    }
    let snapshot = header.content().map(|content| Snapshot { header, content, items });
    match snapshot.as_ref().map_err(Clone::clone).and_then(|snapshot| shape(snapshot, assignment)) {
        Err(what) => breach(Rule::Shape, what),
        Ok(()) => {
            let breach = |s: &Snapshot| kind::of(&s.content).breach(&assignment.space, header.rows as usize, items);
            found.extend(snapshot.iter().find_map(breach));
        }
    }
    (snapshot, found)
}

/// What is wrong with snapshot number `sent` if number `expected` of `count` is due; they are counted from 0.
fn out_of_order(sent: u32, expected: usize, count: usize) -> Option<String> {
    match sent as usize {
        _ if expected >= count => Some(format!("it is one too many, all {count} have been sent")),
        sent if sent == expected => None,
        sent => {
            let last = count - 1;
            Some(format!("it comes out of order: it is number {sent}, but number {expected} is due (from 0 to {last})"))
        }
    }
}

/// Checks that the snapshot holds as many numbers as it says, and can be evaluated on the comparison grid.
fn shape(Snapshot { header, content, items }: &Snapshot, assignment: &Assignment) -> Result<(), String> {
    let column_count = content.column_count(assignment.space.variables.len()) as u32;
    if header.columns != column_count || header.rows == 0 {
        return Err(format!("it has {} rows of {} columns, its kind has {column_count}", header.rows, header.columns));
    }
    if items.len() as u64 != u64::from(header.rows) * u64::from(column_count) {
        return Err(format!("it holds {} numbers instead of {} x {column_count}", items.len(), header.rows));
    }
    let bins = assignment.space.projections.iter().flat_map(Projection::axes).map(|(_, bins)| bins).max();
    kind::of(content).check_grid(bins.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assignment::Plane;
    use crate::example::problem;
    use density::grid::{Axis, Grid};
    use messages::content::{Characteristics, Samples};

    fn assignment() -> Assignment {
        let grids =
            vec![Grid { phi: Axis { low: 1.0, high: 2.0, bins: 10 }, e: Axis { low: 0.0, high: 0.2, bins: 20 } }; 2];
        Assignment::in_plane(7, "s", (1, 2), Plane { problem: problem(), grids })
    }

    fn good() -> SnapshotHeader {
        let unset = SnapshotHeader::default();
        SnapshotHeader { run_id: 7, time: 0.5, scenario: 1, index: 1, count: 2, rows: 2, most_rows: 2, ..unset }
            .with(Samples::INDEPENDENT)
    }

    fn rules(header: SnapshotHeader, items: &[f64]) -> Vec<Rule> {
        breaches(&header, items, &assignment(), 1).into_iter().map(|breach| breach.rule).collect()
    }

    #[test]
    fn every_breach_is_told_under_its_rule() {
        let usual = good();
        let items = [0.1, 0.2, 0.3, 0.4];
        assert_eq!(rules(usual, &items), []);
        assert_eq!(rules(SnapshotHeader { run_id: 8, ..usual }, &items), [Rule::Identity]);
        assert_eq!(rules(SnapshotHeader { scenario: 0, ..usual }, &items), [Rule::Identity]);
        assert_eq!(rules(SnapshotHeader { count: 3, ..usual }, &items), [Rule::Count]);
        assert_eq!(rules(SnapshotHeader { index: 0, time: 0.0, ..usual }, &items), [Rule::Order]);
        assert_eq!(rules(SnapshotHeader { time: 0.5f64.next_up(), ..usual }, &items), [Rule::Time]);
        assert_eq!(rules(SnapshotHeader { kind: 99, ..usual }, &items), [Rule::Shape]);
        assert_eq!(rules(SnapshotHeader { columns: 3, ..usual }, &items), [Rule::Shape]);
        assert_eq!(rules(usual, &items[1..]), [Rule::Shape]);
        let hull = |resolution| good().with(Characteristics::HullMesh { resolution, as_printed: false });
        let columns = [0.1, 0.2, 0.3, 0.4, 1.0, 1.0];
        assert_eq!(
            [19, 20, 20_001].map(|resolution| rules(hull(resolution), &columns)),
            [vec![Rule::Shape], vec![], vec![Rule::Shape]]
        );
        assert_eq!(rules(usual, &[0.1, f64::NAN, 0.3, 0.4]), [Rule::Finite]);
        assert_eq!(rules(usual, &[0.1, 0.2, 0.3, 1.0]), [Rule::Range]);
        assert_eq!(rules(usual, &[0.1, 0.2, -0.3, 0.0]), [Rule::Range]);
        assert_eq!(rules(SnapshotHeader { index: 2, count: 3, ..usual }, &items), [Rule::Count, Rule::Order]);
    }

    #[test]
    fn what_is_out_of_order_is_told_with_what_was_sent_and_one_too_many_as_that() {
        assert_eq!(out_of_order(1, 1, 5), None);
        let swapped = "it comes out of order: it is number 2, but number 1 is due (from 0 to 4)";
        assert_eq!(out_of_order(2, 1, 5).as_deref(), Some(swapped));
        for sent in [0, 4, 5] {
            assert_eq!(out_of_order(sent, 5, 5).as_deref(), Some("it is one too many, all 5 have been sent"));
        }
    }
}
