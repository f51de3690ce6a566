//! The comparator: computes the errors of every case against the reference, and the effort of every case.
//!
//! A figure that the first reference withholds is compared with the next one that states it (see
//! [`crate::services::yardstick`]).

use std::collections::BTreeMap;

use density::angle::nearest;
use density::distance::{Distances, between, between_marginals};
use messages::comparison_kind::ComparisonKind;
use messages::layout::{ComparisonHeader, DISTANCE_COLUMNS, DensityHeader, EFFORT_COLUMNS, ERROR_COLUMNS};
use messages::port::Outlet;
use messages::text::{pack, unpack};
use messages::topic::{Comparison, Density, Roster as RosterTopic, Scenario};

use crate::services::reading::Reading;
use crate::services::roomy::Roomy;
use crate::services::roster::Roster;
use crate::services::yardstick::{Figure, stand_for};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::newest::Newest;
use kit::screen::{receive, refuse};
use kit::session::Session;
use kit::space::{Quantity, Space};

/// The densities of a scenario that have arrived, by case and snapshot.
#[derive(Debug, Default)]
pub(crate) struct Results {
    cases: BTreeMap<String, BTreeMap<u32, Reading>>,
}

impl Results {
    pub(crate) fn take(&mut self, reading: Reading) {
        self.cases.entry(unpack(&reading.header.label)).or_default().insert(reading.header.index, reading);
    }

    fn is_complete(&self, label: &str) -> bool {
        self.of(label).is_some()
    }

    /// The results of a case if all its snapshots are there, in order.
    pub(crate) fn of(&self, label: &str) -> Option<Vec<&Reading>> {
        let snapshots = self.cases.get(label)?;
        let count = snapshots.values().next()?.header.count as usize;
        (snapshots.len() == count).then(|| snapshots.values().collect())
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
    session.ready()?;
    let mut outlet: Option<Roomy<Comparison>> = None;
    let mut roster = Roster::default();
    let mut newest = Newest::default();
    let mut current: Option<(Assignment, Results)> = None;
    loop {
        roster.update(session, &rosters)?;
        while let Some(message) = receive(session, &scenarios)? {
            if newest.is_news(message.header().scenario) {
                current = Some((Assignment::read(&message)?, Results::default()));
            }
        }
        if let Some((assignment, results)) = &mut current {
            while let Some(message) = receive(session, &densities)? {
                let header = message.header();
                if header.scenario == assignment.scenario() && header.count as usize == assignment.times.len() {
                    match Reading::new(*header, message.items(), assignment) {
                        Ok(reading) => results.take(reading),
                        Err(why) => refuse::<Density>(session, header.scenario, &unpack(&header.label), &why)?,
                    }
                }
            }
            if roster.nothing_more_to_come(assignment.scenario(), |label| results.is_complete(label)) {
                let outlet = Roomy::with_room(&mut outlet, &session.domain, most_numbers(assignment))?;
                publish(session, outlet, assignment, results, &roster)?;
                session.done(assignment.scenario())?;
                current = None;
                continue;
            }
        }
        match &outlet {
            Some(outlet) => session.wait(&[&scenarios, &densities, &rosters, &outlet.outlet])?,
            None => session.wait(&[&scenarios, &densities, &rosters])?,
        }
    }
}

/// The most numbers in a comparison of a scenario.
fn most_numbers(assignment: &Assignment) -> usize {
    let space = &assignment.space;
    let of_densities = space.projections.len() * DISTANCE_COLUMNS + 2;
    (space.quantities().len() * ERROR_COLUMNS).max(of_densities).max(EFFORT_COLUMNS)
}

fn publish(
    session: &Session,
    outlet: &Outlet<Comparison>,
    assignment: &Assignment,
    results: &Results,
    roster: &Roster,
) -> Result<(), Failure> {
    let first = roster.references.first().map_or("", String::as_str);
    let header = |kind: ComparisonKind, label: &str| ComparisonHeader {
        run_id: session.run_id,
        scenario: assignment.scenario(),
        kind: kind.code(),
        label: pack(label),
        reference: pack(first),
        ..ComparisonHeader::default()
    };
    let baseline = roster.baseline.as_ref().and_then(|label| results.of(label));
    let baseline = baseline.map(|readings| total_seconds(&readings));
    let references: Vec<(&str, Vec<&Reading>)> =
        roster.standing_references().filter_map(|label| Some((label, results.of(label)?))).collect();
    let cases = roster.cases.len();
    for (done, (label, _)) in roster.cases.iter().enumerate().filter(|(_, (_, failed))| !failed) {
        let Some(case) = results.of(label) else { continue };
        for (snapshot, case) in case.iter().enumerate() {
            let there = references.iter().filter_map(|(label, all)| Some((*label, *all.get(snapshot)?)));
            for Compared { kind, reference, rows } in compare(case, &there.collect::<Vec<_>>()) {
                let DensityHeader { time, index, .. } = case.header;
                let (length, reference) = (rows.len() as u32, pack(reference));
                let header = ComparisonHeader { time, index, length, reference, ..header(kind, label) };
                outlet.send_items(header, &rows)?;
            }
        }
        let numbers = effort(&case, baseline);
        let header = ComparisonHeader { length: EFFORT_COLUMNS as u32, ..header(ComparisonKind::Effort, label) };
        outlet.send_items(header, &numbers)?;
        session.working(assignment.scenario(), done + 1, cases)?;
    }
    Ok(outlet.send_items(header(ComparisonKind::End, ""), &[])?)
}

/// A comparison of one snapshot of a case with one reference.
#[derive(Debug)]
pub(crate) struct Compared<'a> {
    kind: ComparisonKind,
    reference: &'a str,
    rows: Vec<f64>,
}

/// Compares a snapshot of a case with the references that have this snapshot, in their order: each figure with the
/// first reference that states it.
pub(crate) fn compare<'a>(case: &Reading, references: &[(&'a str, &Reading)]) -> Vec<Compared<'a>> {
    let quantities = case.space.quantities();
    let mut said = Vec::new();
    for &(reference, reading) in references {
        let mut rows = errors(case, reading);
        for (quantity, row) in quantities.iter().zip(rows.chunks_exact_mut(ERROR_COLUMNS)) {
            let figure = Figure::Quantity(*quantity);
            if stand_for(references.iter().copied(), figure) != Some(reference) || !figure.is_stated(case) {
                row.fill(f64::NAN);
            }
        }
        if rows.iter().any(|number| !number.is_nan()) {
            said.push(Compared { kind: ComparisonKind::Moments, reference, rows });
        }
        let is_it = stand_for(references.iter().copied(), Figure::Densities) == Some(reference);
        if is_it && Figure::Densities.is_stated(case) {
            said.push(Compared { kind: ComparisonKind::Distances, reference, rows: distances(case, reading) });
        }
    }
    said
}

/// One row per quantity: value, reference value, absolute error, relative error.
pub(crate) fn errors(case: &Reading, reference: &Reading) -> Vec<f64> {
    let row = |quantity: Quantity| {
        let (value, reference) = (case.value(quantity), reference.value(quantity));
        let difference = difference(&case.space, quantity, value, reference);
        [value, reference, difference.abs(), difference.abs() / reference.abs()]
    };
    case.space.quantities().into_iter().flat_map(row).collect()
}

/// Difference of a quantity from its reference value; for an angle, the short way round.
pub(crate) fn difference(space: &Space, quantity: Quantity, value: f64, reference: f64) -> f64 {
    if space.is_angle(quantity) { nearest(value - reference, 0.0) } else { value - reference }
}

/// One row per projection, NaN where one of the two says nothing of it; then, for each of the two densities on the
/// first projection, by how much its mass falls short of 1.
pub(crate) fn distances(case: &Reading, reference: &Reading) -> Vec<f64> {
    let row = |place: usize| {
        if [case, reference].iter().any(|reading| reading.density(place).iter().any(|density| density.is_nan())) {
            return [f64::NAN; DISTANCE_COLUMNS];
        }
        let d = distances_on(case, reference, place);
        [d.total_variation, d.l2, d.hellinger, d.kullback_leibler, d.kolmogorov]
    };
    let missing = [1.0 - case.header.mass_on_grid, 1.0 - reference.header.mass_on_grid];
    (0..case.space.projections.len()).flat_map(row).chain(missing).collect()
}

/// The distances of the densities on a projection.
pub(crate) fn distances_on(case: &Reading, reference: &Reading, projection: usize) -> Distances {
    let (p, q, cell) = (case.density(projection), reference.density(projection), case.cell(projection));
    match case.space.projections[projection].second {
        Some(_) => between(p, q, cell),
        None => between_marginals(p, q, cell),
    }
}

fn total_seconds(case: &[&Reading]) -> f64 {
    case.iter().map(|p| p.header.propagation_seconds + p.header.estimation_seconds).sum()
}

/// Effort as in Table 4: seconds of propagation, of estimation, their sum, and the ratio of this sum to that of the
/// run's baseline.
pub(crate) fn effort(case: &[&Reading], baseline: Option<f64>) -> [f64; EFFORT_COLUMNS] {
    let propagation: f64 = case.iter().map(|p| p.header.propagation_seconds).sum();
    let estimation: f64 = case.iter().map(|p| p.header.estimation_seconds).sum();
    let total = propagation + estimation;
    [propagation, estimation, total, baseline.map_or(f64::NAN, |baseline| total / baseline)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A snapshot of a case whose densities are the same everywhere.
    fn reading(index: u32, moments: [f64; 6], density: f64) -> Reading {
        let assignment = kit::example::assignment();
        let quantities = assignment.space.quantities().len();
        let mut numbers = vec![density; Reading::numbers_of(&assignment)];
        numbers[..6].copy_from_slice(&moments);
        numbers[6..8].copy_from_slice(&[1.0, 0.9]);
        let header = DensityHeader {
            index,
            count: 2,
            quantities: quantities as u32,
            mass_on_grid: density,
            ..DensityHeader::default()
        };
        Reading::new(DensityHeader { label: pack("mc"), ..header }, &numbers, &assignment).unwrap()
    }

    #[test]
    fn the_error_of_an_angle_is_the_short_way_round() {
        let at = |mean_phi| reading(0, [mean_phi, 1.0, 1.0, 1.0, 0.0, 0.0], 1.0);
        let rows = errors(&at(std::f64::consts::TAU - 0.01), &at(0.01));
        assert!((rows[2] - 0.02).abs() < 1e-12, "{rows:?}");
    }

    #[test]
    fn what_the_first_reference_withholds_is_compared_with_the_next_and_with_nobody_if_none_states_it() {
        const WITHHELD: f64 = f64::NAN;
        let case = reading(0, [1.0, 1.0, 0.5, 0.1, 0.0, 0.2], 0.9);
        let exact = reading(0, [1.1, 1.0, 0.5, WITHHELD, WITHHELD, 0.2], WITHHELD);
        let mc = reading(0, [1.2, 1.0, 0.5, 0.2, WITHHELD, 0.2], 1.0);
        let said = compare(&case, &[("exact", &exact), ("mc", &mc)]);
        let of = |reference: &str, kind: ComparisonKind| {
            said.iter().filter(|c| c.reference == reference && c.kind == kind).collect::<Vec<_>>()
        };
        let stated = |rows: &[f64]| rows.chunks_exact(ERROR_COLUMNS).map(|row| !row[2].is_nan()).collect::<Vec<_>>();
        let (with_exact, with_mc) = (of("exact", ComparisonKind::Moments), of("mc", ComparisonKind::Moments));
        assert_eq!(stated(&with_exact[0].rows), [true, true, true, false, false, true, true, true]);
        assert_eq!(stated(&with_mc[0].rows), [false, false, false, true, false, false, false, false]);
        assert!((with_exact[0].rows[2] - 0.1).abs() < 1e-12 && (with_mc[0].rows[3 * 4 + 2] - 0.1).abs() < 1e-12);
        assert_eq!((of("exact", ComparisonKind::Distances).len(), of("mc", ComparisonKind::Distances).len()), (0, 1));
        // A case is not compared in figures that it withholds itself.
        assert!(compare(&exact, &[("mc", &mc)]).iter().all(|c| c.kind == ComparisonKind::Moments));
    }

    #[test]
    fn a_case_is_complete_with_its_last_snapshot_only() {
        let mut results = Results::default();
        for index in [1, 0] {
            assert!(!results.is_complete("mc"));
            results.take(reading(index, [1.0; 6], 1.0));
        }
        assert_eq!(results.of("mc").unwrap().iter().map(|p| p.header.index).collect::<Vec<_>>(), [0, 1]);
    }
}
