//! The comparator: errors of every case against the reference case, and what each cost.

use std::collections::BTreeMap;

use messages::layout::{ComparisonHeader, DensityHeader, EFFORT_COLUMNS, ERROR_COLUMNS, comparison};
use messages::port::Outlet;
use messages::text::{pack, unpack};
use messages::topic::{Comparison, Density, Roster as RosterTopic, Scenario};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::roster::Roster;
use crate::session::Session;

/// The moments that are compared, in the order of a comparison's rows: names, and positions among the moments.
pub const QUANTITIES: [&str; 4] = ["mean_phi", "std_phi", "mean_e", "std_e"];

/// The case that effort is normalised with (Sect. 4.2).
const MONTE_CARLO: &str = "mc";

/// What has arrived of a scenario: the density headers of each case, by snapshot.
#[derive(Debug, Default)]
struct Results {
    cases: BTreeMap<String, BTreeMap<u32, DensityHeader>>,
}

impl Results {
    fn take(&mut self, header: DensityHeader) {
        self.cases.entry(unpack(&header.label)).or_default().insert(header.index, header);
    }

    fn is_complete(&self, label: &str) -> bool {
        self.of(label).is_some()
    }

    /// The results of a case if all its snapshots are there, in order.
    fn of(&self, label: &str) -> Option<Vec<&DensityHeader>> {
        let headers = self.cases.get(label)?;
        let count = headers.values().next()?.count as usize;
        (headers.len() == count).then(|| headers.values().collect())
    }
}

/// Compares until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let densities = session.domain.inlet::<Density>()?;
    let rosters = session.domain.inlet::<RosterTopic>()?;
    let outlet = session.domain.outlet::<Comparison>(QUANTITIES.len() * ERROR_COLUMNS)?;
    session.ready()?;
    let mut roster = Roster::default();
    let mut current: Option<(Assignment, Results)> = None;
    loop {
        roster.update(&rosters)?;
        if current.is_none() {
            current = match scenarios.receive()? {
                Some(message) => Some((Assignment::read(&message)?, Results::default())),
                None => None,
            };
        }
        if let Some((assignment, results)) = &mut current {
            while let Some(message) = densities.receive()? {
                let header = message.header();
                if (header.run_id, header.scenario) == (assignment.run_id, assignment.scenario) {
                    results.take(*header);
                }
            }
            if roster.nothing_more_to_come(|label| results.is_complete(label)) {
                publish(session, &outlet, assignment, results, &roster)?;
                session.done(assignment.scenario)?;
                current = None;
                continue;
            }
        }
        session.wait(&[&scenarios, &densities, &rosters, &outlet])?;
    }
}

fn publish(
    session: &Session,
    outlet: &Outlet<Comparison>,
    assignment: &Assignment,
    results: &Results,
    roster: &Roster,
) -> Result<(), Failure> {
    let header = |kind, label: &str| ComparisonHeader {
        run_id: session.run_id,
        scenario: assignment.scenario,
        kind,
        label: pack(label),
        reference: pack(&roster.reference),
        ..ComparisonHeader::default()
    };
    let mc_seconds = results.of(MONTE_CARLO).map(|headers| total_seconds(&headers));
    let reference = results.of(&roster.reference);
    for (label, _) in &roster.cases {
        let Some(case) = results.of(label) else { continue };
        for (case, reference) in case.iter().zip(reference.iter().flatten()) {
            let rows = errors(case, reference);
            let header = ComparisonHeader {
                time: case.time,
                index: case.index,
                length: rows.len() as u32,
                ..header(comparison::MOMENTS, label)
            };
            outlet.send_items(header, &rows)?;
        }
        let numbers = effort(&case, mc_seconds);
        let header = ComparisonHeader { length: EFFORT_COLUMNS as u32, ..header(comparison::EFFORT, label) };
        outlet.send_items(header, &numbers)?;
    }
    Ok(outlet.send_items(header(comparison::END, ""), &[])?)
}

/// A row a quantity: value, reference value, absolute error, relative error.
fn errors(case: &DensityHeader, reference: &DensityHeader) -> Vec<f64> {
    let row = |quantity: usize| {
        let (value, reference) = (case.moments[quantity], reference.moments[quantity]);
        let difference =
            if quantity == 0 { density::angle::nearest(value - reference, 0.0) } else { value - reference };
        [value, reference, difference.abs(), difference.abs() / reference.abs()]
    };
    (0..QUANTITIES.len()).flat_map(row).collect()
}

fn total_seconds(headers: &[&DensityHeader]) -> f64 {
    headers.iter().map(|h| h.propagation_seconds + h.estimation_seconds).sum()
}

/// Effort as in Table 4: seconds of propagation, of estimation, their sum, its ratio to Monte Carlo's.
fn effort(headers: &[&DensityHeader], mc_seconds: Option<f64>) -> [f64; EFFORT_COLUMNS] {
    let propagation: f64 = headers.iter().map(|h| h.propagation_seconds).sum();
    let estimation: f64 = headers.iter().map(|h| h.estimation_seconds).sum();
    let total = propagation + estimation;
    [propagation, estimation, total, mc_seconds.map_or(f64::NAN, |mc| total / mc)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_an_angle_is_the_short_way_round() {
        let at = |mean_phi| DensityHeader { moments: [mean_phi, 1.0, 1.0, 1.0, 0.0, 0.0], ..DensityHeader::default() };
        let rows = errors(&at(std::f64::consts::TAU - 0.01), &at(0.01));
        assert!((rows[2] - 0.02).abs() < 1e-12, "{rows:?}");
    }

    #[test]
    fn a_case_is_complete_with_its_last_snapshot_only() {
        let mut results = Results::default();
        for index in [1, 0] {
            assert!(!results.is_complete("mc"));
            results.take(DensityHeader { index, count: 2, label: pack("mc"), ..DensityHeader::default() });
        }
        assert_eq!(results.of("mc").unwrap().iter().map(|h| h.index).collect::<Vec<_>>(), [0, 1]);
    }
}
