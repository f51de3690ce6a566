//! What every snapshot must be, whoever sent it.
//!
//! The estimator refuses a snapshot that breaks a rule, the kit does not send one whose numbers do, and `phasecloud check`
//! reports rule by rule.

use std::fmt;

use messages::layout::{DENSITY_HEAD, SnapshotHeader, columns, kind, treatment};

use crate::assignment::Assignment;

/// A rule about snapshots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// It belongs to the run and the scenario.
    Identity,
    /// Its scenario has as many snapshots as it says.
    Count,
    /// It is the next one.
    Order,
    /// Its time is the one asked for, to the last bit.
    Time,
    /// Its kind is known, and it holds as many numbers as it says.
    Shape,
    /// All numbers are finite, but for what a density withholds.
    Finite,
    /// All eccentricities of trajectories lie in `0 <= e < 1`.
    Eccentricity,
}

/// A rule that a snapshot breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Breach {
    /// Which rule.
    pub rule: Rule,
    /// What was seen, and what would be right.
    pub what: String,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

/// All rules that a snapshot breaks which should be number `expected` of the scenario; the gravest comes first. Numbers are
/// looked at only if their shape is right.
pub fn breaches(header: &SnapshotHeader, items: &[f64], assignment: &Assignment, expected: usize) -> Vec<Breach> {
    let times = &assignment.problem.times;
    let mut found = Vec::new();
    let mut breach = |rule, what| found.push(Breach { rule, what });
    if header.run_id != assignment.run_id {
        let what = format!("it belongs to run {:012x}, not to {:012x}", header.run_id, assignment.run_id);
        breach(Rule::Identity, what);
    }
    if header.scenario != assignment.scenario {
        let what = format!("it belongs to scenario {}, not to {}", header.scenario, assignment.scenario);
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
    match shape(header, items).and_then(|()| resolution(header, assignment)) {
        Err(what) => breach(Rule::Shape, what),
        Ok(()) => found.extend(in_numbers(header.kind, header.rows as usize, items)),
    }
    found
}

/// What is wrong with number `sent` where number `expected` of so many is due; they are counted from 0.
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

/// Most interpolation points an axis of a hull mesh: four times the paper's. Each triangle may cost as many steps.
pub const MOST_RESOLUTION: usize = 20_000;

fn shape(header: &SnapshotHeader, items: &[f64]) -> Result<(), String> {
    let Some(column_count) = columns(header.kind) else {
        return Err(format!("its kind {} is unknown to this version", header.kind));
    };
    if header.columns != column_count || header.rows == 0 {
        return Err(format!("it has {} rows of {} columns, its kind has {column_count}", header.rows, header.columns));
    }
    if items.len() as u64 != u64::from(header.rows) * u64::from(column_count) {
        return Err(format!("it holds {} numbers instead of {} x {column_count}", items.len(), header.rows));
    }
    if header.resolution as usize > MOST_RESOLUTION {
        return Err(format!("its resolution is {}, at most {MOST_RESOLUTION} are interpolated", header.resolution));
    }
    Ok(())
}

/// A hull mesh that is interpolated more coarsely than the grid is fine would leave bins without any value.
fn resolution(header: &SnapshotHeader, assignment: &Assignment) -> Result<(), String> {
    let is_hull = header.kind == kind::CHARACTERISTICS
        && [treatment::HULL_MESH, treatment::HULL_MESH_AS_PRINTED].contains(&header.treatment);
    let bins = assignment.grids.first().map_or(0, |grid| grid.phi.bins.max(grid.e.bins));
    if is_hull && (header.resolution as usize) < bins {
        return Err(format!(
            "its resolution is {}, less than the {bins} bins of the comparison grid",
            header.resolution
        ));
    }
    Ok(())
}

/// The first number that cannot be right in columns of a kind, `rows` long each.
pub fn in_numbers(kind: u32, rows: usize, items: &[f64]) -> Option<Breach> {
    if kind == kind::DENSITY
        && let Some((head, joint)) = items.split_at_checked(DENSITY_HEAD)
    {
        return in_density(head, joint).map(|what| Breach { rule: Rule::Finite, what });
    }
    if let Some(position) = items.iter().position(|value| !value.is_finite()) {
        let (column, row) = (position / rows, position % rows);
        return Some(Breach {
            rule: Rule::Finite,
            what: format!("row {row} of column {column} is {}", items[position]),
        });
    }
    if kind != kind::SAMPLES && kind != kind::CHARACTERISTICS {
        return None;
    }
    let e = items.get(rows..2 * rows)?;
    let row = e.iter().position(|e| !(0.0..1.0).contains(e))?;
    let what = format!("row {row} has e = {}, outside [0, 1)", e[row]);
    Some(Breach { rule: Rule::Eccentricity, what })
}

/// Numbers before the error estimates in the head of a density.
const STATED: usize = DENSITY_HEAD - 4;

/// A method withholds what it does not stand behind, by NaN, and says how far it came, by its error estimates.
fn in_density(head: &[f64], joint: &[f64]) -> Option<String> {
    let (stated, estimates) = head.split_at(STATED);
    if let Some(row) = stated.iter().position(|value| value.is_infinite()) {
        return Some(format!(
            "row {row} of column 0 is {}; a moment is finite, or NaN where it is withheld",
            stated[row]
        ));
    }
    if let Some(place) = estimates.iter().position(|estimate| estimate.is_nan() || *estimate < 0.0) {
        let (row, estimate) = (STATED + place, estimates[place]);
        return Some(format!(
            "row {row} of column 0 is {estimate}; an error estimate is 0 or more, infinite if unknown"
        ));
    }
    let bad = joint.iter().position(|value| !value.is_finite())?;
    let row = DENSITY_HEAD + bad;
    match joint.iter().find(|value| !value.is_nan()) {
        None => None,
        Some(_) if joint[bad].is_infinite() => Some(format!("row {row} of column 0 is {}", joint[bad])),
        Some(other) => Some(format!(
            "row {row} of column 0 is NaN beside {other}; a joint density is withheld as a whole or not at all"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::dynamics::Force;
    use density::grid::{Axis, Grid};
    use density::problem::{InitialGaussian, Problem};

    fn assignment() -> Assignment {
        Assignment {
            run_id: 7,
            name: "s".into(),
            scenario: 1,
            scenarios: 2,
            problem: Problem {
                model: Force { radiation: 0.15, oblateness: 0.4 },
                initial: InitialGaussian { mean_phi: 2.0, mean_e: 0.1, sigma_phi: 0.1, sigma_e: 0.01 },
                times: vec![0.0, 0.5],
                critical_e: 0.6,
            },
            grids: vec![
                Grid { phi: Axis { low: 1.0, high: 2.0, bins: 10 }, e: Axis { low: 0.0, high: 0.2, bins: 20 } };
                2
            ],
        }
    }

    const GOOD: SnapshotHeader = SnapshotHeader {
        run_id: 7,
        time: 0.5,
        seconds: 0.0,
        disagreement: f64::NAN,
        total: 0,
        scenario: 1,
        index: 1,
        count: 2,
        kind: kind::SAMPLES,
        rows: 2,
        columns: 2,
        treatment: 0,
        resolution: 0,
        lattice: 0,
        degree: 0,
        replicates: 0,
        attempt: 0,
        shard: 0,
        shards: 0,
        most_rows: 2,
        reserved: 0,
        label: [0; 32],
    };

    fn rules(header: SnapshotHeader, items: &[f64]) -> Vec<Rule> {
        breaches(&header, items, &assignment(), 1).into_iter().map(|breach| breach.rule).collect()
    }

    #[test]
    fn every_breach_is_told_under_its_rule() {
        let items = [0.1, 0.2, 0.3, 0.4];
        assert_eq!(rules(GOOD, &items), []);
        assert_eq!(rules(SnapshotHeader { run_id: 8, ..GOOD }, &items), [Rule::Identity]);
        assert_eq!(rules(SnapshotHeader { scenario: 0, ..GOOD }, &items), [Rule::Identity]);
        assert_eq!(rules(SnapshotHeader { count: 3, ..GOOD }, &items), [Rule::Count]);
        assert_eq!(rules(SnapshotHeader { index: 0, time: 0.0, ..GOOD }, &items), [Rule::Order]);
        assert_eq!(rules(SnapshotHeader { time: 0.5f64.next_up(), ..GOOD }, &items), [Rule::Time]);
        assert_eq!(rules(SnapshotHeader { kind: 99, ..GOOD }, &items), [Rule::Shape]);
        assert_eq!(rules(SnapshotHeader { columns: 3, ..GOOD }, &items), [Rule::Shape]);
        assert_eq!(rules(SnapshotHeader { resolution: 20_001, ..GOOD }, &items), [Rule::Shape]);
        assert_eq!(rules(GOOD, &items[1..]), [Rule::Shape]);
        let hull = |resolution| SnapshotHeader {
            kind: kind::CHARACTERISTICS,
            columns: 3,
            treatment: treatment::HULL_MESH,
            resolution,
            ..GOOD
        };
        let columns = [0.1, 0.2, 0.3, 0.4, 1.0, 1.0];
        assert_eq!((rules(hull(19), &columns), rules(hull(20), &columns)), (vec![Rule::Shape], vec![]));
        assert_eq!(rules(GOOD, &[0.1, f64::NAN, 0.3, 0.4]), [Rule::Finite]);
        assert_eq!(rules(GOOD, &[0.1, 0.2, 0.3, 1.0]), [Rule::Eccentricity]);
        assert_eq!(rules(GOOD, &[0.1, 0.2, -0.3, 0.0]), [Rule::Eccentricity]);
        assert_eq!(rules(SnapshotHeader { index: 2, count: 3, ..GOOD }, &items), [Rule::Count, Rule::Order]);
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

    #[test]
    fn a_density_may_withhold_moments_and_the_whole_joint_but_no_part_of_it_and_no_estimate() {
        let density = |changes: &[(usize, f64)]| {
            let mut numbers = [0.5; DENSITY_HEAD + 4];
            changes.iter().for_each(|&(at, value)| numbers[at] = value);
            in_numbers(kind::DENSITY, numbers.len(), &numbers).map(|breach| (breach.rule, breach.what))
        };
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let joint: Vec<(usize, f64)> = (DENSITY_HEAD..DENSITY_HEAD + 4).map(|at| (at, nan)).collect();
        assert_eq!(density(&[]), None);
        assert_eq!(density(&[(0, nan), (5, nan), (7, nan)]), None);
        assert_eq!(density(&joint), None);
        assert_eq!(density(&[(8, infinite), (11, infinite)]), None, "nobody knows how far off it is");
        for (changes, words) in [
            (&[(0, infinite)][..], "row 0 of column 0 is inf; a moment is finite"),
            (&[(8, nan)], "row 8 of column 0 is NaN; an error estimate is 0 or more"),
            (&[(11, -1e-3)], "row 11 of column 0 is -0.001; an error estimate"),
            (&[(13, nan)], "row 13 of column 0 is NaN beside 0.5; a joint density is withheld as a whole"),
            (&[(12, nan), (13, infinite)], "NaN beside"),
            (&[(14, infinite)], "row 14 of column 0 is inf"),
        ] {
            let (rule, what) = density(changes).unwrap();
            assert!(rule == Rule::Finite && what.contains(words), "{what}");
        }
    }
}
