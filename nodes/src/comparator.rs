//! The comparator: errors of every case against the reference, and what each cost.
//!
//! A quantity that the first reference withholds is compared with the next one that states it (see [`crate::yardstick`]).

use std::collections::BTreeMap;

use density::angle::nearest;
use density::distance::{Distances, between, between_marginals};
use messages::layout::{ComparisonHeader, DISTANCE_COLUMNS, DensityHeader, EFFORT_COLUMNS, ERROR_COLUMNS, comparison};
use messages::port::Outlet;
use messages::text::{pack, unpack};
use messages::topic::{Comparison, Density, Roster as RosterTopic, Scenario};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::newest::Newest;
use crate::roster::Roster;
use crate::screen::receive;
use crate::session::Session;
use crate::yardstick::{Quantity, stand_for, values_of};

/// What is compared, in the order of a comparison's rows: the moments, then the circular ones.
pub const QUANTITIES: [&str; 8] = [
    "mean_phi",
    "std_phi",
    "mean_e",
    "std_e",
    "cov_phi_e",
    "prob_above_critical_e",
    "circular_mean_phi",
    "resultant_length",
];

/// Whether the quantity at this position is an angle, whose error is the short way round.
fn is_angle(quantity: usize) -> bool {
    quantity == 0 || quantity == 6
}

/// The case that effort is normalised with (Sect. 4.2).
const MONTE_CARLO: &str = "mc";

/// What has arrived of a scenario: the densities of each case, by snapshot.
#[derive(Debug, Default)]
pub(crate) struct Results {
    cases: BTreeMap<String, BTreeMap<u32, Published>>,
}

/// A density as it was published.
#[derive(Debug)]
pub(crate) struct Published {
    pub(crate) header: DensityHeader,
    values: Vec<f64>,
}

impl Results {
    pub(crate) fn take(&mut self, header: DensityHeader, values: &[f64]) {
        let published = Published { header, values: values.to_vec() };
        self.cases.entry(unpack(&header.label)).or_default().insert(header.index, published);
    }

    fn is_complete(&self, label: &str) -> bool {
        self.of(label).is_some()
    }

    /// The results of a case if all its snapshots are there, in order.
    pub(crate) fn of(&self, label: &str) -> Option<Vec<&Published>> {
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
    let outlet = session.domain.outlet::<Comparison>(QUANTITIES.len() * ERROR_COLUMNS)?;
    session.ready()?;
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
                if header.scenario == assignment.scenario && header.count as usize == assignment.grids.len() {
                    results.take(*header, message.items());
                }
            }
            if roster.nothing_more_to_come(assignment.scenario, |label| results.is_complete(label)) {
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
    let first = roster.references.first().map_or("", String::as_str);
    let header = |kind, label: &str| ComparisonHeader {
        run_id: session.run_id,
        scenario: assignment.scenario,
        kind,
        label: pack(label),
        reference: pack(first),
        ..ComparisonHeader::default()
    };
    let mc_seconds = results.of(MONTE_CARLO).map(|headers| total_seconds(&headers));
    let references: Vec<(&str, Vec<&Published>)> =
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
        let numbers = effort(&case, mc_seconds);
        let header = ComparisonHeader { length: EFFORT_COLUMNS as u32, ..header(comparison::EFFORT, label) };
        outlet.send_items(header, &numbers)?;
        session.working(assignment.scenario, done + 1, cases)?;
    }
    Ok(outlet.send_items(header(comparison::END, ""), &[])?)
}

/// What is said of one snapshot of a case against one reference.
#[derive(Debug)]
pub(crate) struct Compared<'a> {
    kind: u32,
    reference: &'a str,
    rows: Vec<f64>,
}

/// Compares a snapshot of a case with the references that have it, in their order: each quantity with the first that states it.
pub(crate) fn compare<'a>(case: &Published, references: &[(&'a str, &Published)]) -> Vec<Compared<'a>> {
    let headers = || references.iter().map(|(label, reference)| (*label, &reference.header));
    let mut said = Vec::new();
    for &(reference, published) in references {
        let mut rows = errors(&case.header, &published.header);
        for (quantity, row) in rows.chunks_exact_mut(ERROR_COLUMNS).enumerate() {
            let moment = Quantity::Moment(quantity);
            if stand_for(headers(), moment) != Some(reference) || !moment.is_stated(&case.header) {
                row.fill(f64::NAN);
            }
        }
        if rows.iter().any(|number| !number.is_nan()) {
            said.push(Compared { kind: comparison::MOMENTS, reference, rows });
        }
        let is_it = stand_for(headers(), Quantity::Densities) == Some(reference);
        if is_it && Quantity::Densities.is_stated(&case.header) {
            let rows = distances(case, published);
            said.push(Compared { kind: comparison::DISTANCES, reference, rows });
        }
    }
    said
}

/// A row a quantity: value, reference value, absolute error, relative error.
pub(crate) fn errors(case: &DensityHeader, reference: &DensityHeader) -> Vec<f64> {
    let row = |(quantity, (value, reference)): (usize, (f64, f64))| {
        let difference = if is_angle(quantity) { nearest(value - reference, 0.0) } else { value - reference };
        [value, reference, difference.abs(), difference.abs() / reference.abs()]
    };
    values_of(case).into_iter().zip(values_of(reference)).enumerate().flat_map(row).collect()
}

/// The total variation distance of two joint densities; NaN if their grids differ.
pub(crate) fn distance_of_joints(case: (&DensityHeader, &[f64]), reference: (&DensityHeader, &[f64])) -> f64 {
    let published = |(header, values): (&DensityHeader, &[f64])| Published { header: *header, values: values.to_vec() };
    distances(&published(case), &published(reference))[0]
}

/// A row each for the joint density and both marginals, then the mass that each of the two densities is short of 1.
pub(crate) fn distances(case: &Published, reference: &Published) -> Vec<f64> {
    let row = |d: Distances| [d.total_variation, d.l2, d.hellinger, d.kullback_leibler, d.kolmogorov];
    let missing = [1.0 - case.header.mass_on_grid, 1.0 - reference.header.mass_on_grid];
    let rows = match (parts(case), parts(reference)) {
        (Some(case_parts), Some(reference_parts)) if case.header.grid == reference.header.grid => {
            let [phi_low, phi_high, e_low, e_high] = case.header.grid;
            let (phi_width, e_width) = (
                (phi_high - phi_low) / f64::from(case.header.phi_bins),
                (e_high - e_low) / f64::from(case.header.e_bins),
            );
            [
                row(between(case_parts[0], reference_parts[0], phi_width * e_width)),
                row(between_marginals(case_parts[1], reference_parts[1], phi_width)),
                row(between_marginals(case_parts[2], reference_parts[2], e_width)),
            ]
        }
        _ => [[f64::NAN; DISTANCE_COLUMNS]; 3],
    };
    rows.into_iter().flatten().chain(missing).collect()
}

/// Joint density and both marginals of a message, if it holds what its header says.
fn parts(published: &Published) -> Option<[&[f64]; 3]> {
    let (phi_bins, e_bins) = (published.header.phi_bins as usize, published.header.e_bins as usize);
    let (joint, marginals) = published.values.split_at_checked(phi_bins.checked_mul(e_bins)?)?;
    let (phi, e) = marginals.split_at_checked(phi_bins)?;
    (e.len() == e_bins).then_some([joint, phi, e])
}

fn total_seconds(case: &[&Published]) -> f64 {
    case.iter().map(|p| p.header.propagation_seconds + p.header.estimation_seconds).sum()
}

/// Effort as in Table 4: seconds of propagation, of estimation, their sum, its ratio to Monte Carlo's.
pub(crate) fn effort(case: &[&Published], mc_seconds: Option<f64>) -> [f64; EFFORT_COLUMNS] {
    let propagation: f64 = case.iter().map(|p| p.header.propagation_seconds).sum();
    let estimation: f64 = case.iter().map(|p| p.header.estimation_seconds).sum();
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

    /// A snapshot of a case on a grid of one bin.
    fn published(moments: [f64; 6], density: f64) -> Published {
        let mass_on_grid = density;
        let grid = [0.0, 1.0, 0.0, 1.0];
        let header = DensityHeader { moments, grid, phi_bins: 1, e_bins: 1, mass_on_grid, ..DensityHeader::default() };
        Published { header, values: vec![density; 3] }
    }

    #[test]
    fn what_the_first_reference_withholds_is_compared_with_the_next_and_with_nobody_if_none_states_it() {
        const WITHHELD: f64 = f64::NAN;
        let case = published([1.0, 1.0, 0.5, 0.1, 0.0, 0.2], 0.9);
        let exact = published([1.1, 1.0, 0.5, WITHHELD, WITHHELD, 0.2], WITHHELD);
        let mc = published([1.2, 1.0, 0.5, 0.2, WITHHELD, 0.2], 1.0);
        let said = compare(&case, &[("exact", &exact), ("mc", &mc)]);
        let of = |reference: &str, kind: u32| {
            said.iter().filter(|c| c.reference == reference && c.kind == kind).collect::<Vec<_>>()
        };
        let stated = |rows: &[f64]| rows.chunks_exact(ERROR_COLUMNS).map(|row| !row[2].is_nan()).collect::<Vec<_>>();
        let (with_exact, with_mc) = (of("exact", comparison::MOMENTS), of("mc", comparison::MOMENTS));
        assert_eq!(stated(&with_exact[0].rows), [true, true, true, false, false, true, true, true]);
        assert_eq!(stated(&with_mc[0].rows), [false, false, false, true, false, false, false, false]);
        assert!((with_exact[0].rows[2] - 0.1).abs() < 1e-12 && (with_mc[0].rows[3 * 4 + 2] - 0.1).abs() < 1e-12);
        assert_eq!((of("exact", comparison::DISTANCES).len(), of("mc", comparison::DISTANCES).len()), (0, 1));
        // Nobody is compared in what it withholds itself.
        assert!(compare(&exact, &[("mc", &mc)]).iter().all(|c| c.kind == comparison::MOMENTS));
    }

    #[test]
    fn a_case_is_complete_with_its_last_snapshot_only() {
        let mut results = Results::default();
        for index in [1, 0] {
            assert!(!results.is_complete("mc"));
            results.take(DensityHeader { index, count: 2, label: pack("mc"), ..DensityHeader::default() }, &[]);
        }
        assert_eq!(results.of("mc").unwrap().iter().map(|p| p.header.index).collect::<Vec<_>>(), [0, 1]);
    }
}
