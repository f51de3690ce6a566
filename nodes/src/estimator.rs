//! The estimator: turns every snapshot, whoever sent it, into a density on the common grid.
//!
//! It trusts no sender: a snapshot with the wrong shape, order or numbers is refused and blamed on its label; the other
//! cases go on.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use messages::layout::{DensityHeader, SnapshotHeader, columns};
use messages::port::{Message, Outlet};
use messages::text::{pack, unpack};
use messages::topic::{Density, Scenario, Snapshot};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::method::{Case, Estimated};
use crate::screen::receive;
use crate::session::{EffortClock, Session};

/// Longest that a snapshot may arrive before the scenario it belongs to.
const HEAD_START: Duration = Duration::from_secs(5);

/// Estimates until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let snapshots = session.domain.inlet::<Snapshot>()?;
    session.ready()?;
    let mut desk: Option<Desk> = None;
    loop {
        while let Some(message) = receive(session, &snapshots)? {
            let is_ahead = |desk: &Option<Desk>| desk.as_ref().is_none_or(|desk| desk.is_behind(message.header()));
            // Scenario and snapshot come from different processes: the answer may be here before the question.
            let deadline = Instant::now() + HEAD_START;
            while is_ahead(&desk) && Instant::now() < deadline {
                match receive(session, &scenarios)? {
                    Some(scenario) => desk = Some(Desk::open(session, Assignment::read(&scenario)?)?),
                    None => session.wait(&[&scenarios])?,
                }
            }
            match &mut desk {
                Some(desk) => desk.handle(session, &message)?,
                None => session.failed(0, &unpack(&message.header().label), "a snapshot before any scenario")?,
            }
        }
        match &desk {
            Some(desk) => session.wait(&[&snapshots, &desk.outlet])?,
            None => session.wait(&[&snapshots])?,
        }
    }
}

/// The scenario under work.
struct Desk {
    assignment: Assignment,
    outlet: Outlet<Density>,
    cases: BTreeMap<String, Case>,
    refused: BTreeSet<String>,
    done: usize,
}

impl Desk {
    fn open(session: &Session, assignment: Assignment) -> Result<Self, Failure> {
        let most_values = assignment.grids.iter().map(|g| g.len() + g.phi.bins + g.e.bins).max().unwrap_or(0);
        let outlet = session.domain.outlet::<Density>(most_values)?;
        Ok(Self { assignment, outlet, cases: BTreeMap::new(), refused: BTreeSet::new(), done: 0 })
    }

    /// Whether the snapshot belongs to a later scenario of the run, and may be of use there.
    fn is_behind(&self, header: &SnapshotHeader) -> bool {
        let later = self.assignment.scenario + 1..self.assignment.scenarios;
        later.contains(&header.scenario) && !self.refused.contains(&unpack(&header.label))
    }

    /// Estimates a snapshot and publishes the density, or refuses the snapshot and its sender.
    fn handle(&mut self, session: &Session, message: &Message<Snapshot>) -> Result<(), Failure> {
        let header = message.header();
        let label = unpack(&header.label);
        if self.refused.contains(&label) {
            return Ok(());
        }
        match self.estimate(header, message.items(), &label) {
            Ok((estimate, seconds)) => {
                publish(&self.outlet, header, &estimate, seconds)?;
                self.done += 1;
                session.working(self.assignment.scenario, self.done, self.done)
            }
            Err(why) => {
                session.failed(self.assignment.scenario, &label, &format!("snapshot {}: {why}", header.index))?;
                self.refused.insert(label);
                Ok(())
            }
        }
    }

    fn estimate(&mut self, header: &SnapshotHeader, items: &[f64], label: &str) -> Result<(Estimated, f64), String> {
        let clock = EffortClock::start();
        let case = self.cases.entry(label.into()).or_default();
        check(header, items, &self.assignment, case.snapshots_done())?;
        let estimate = case.estimate(header, items, &self.assignment)?;
        Ok((estimate, clock.seconds()))
    }
}

/// Whether a snapshot is what its header and the scenario promise.
pub(crate) fn check(
    header: &SnapshotHeader,
    items: &[f64],
    assignment: &Assignment,
    expected: usize,
) -> Result<(), String> {
    let times = &assignment.problem.times;
    let Some(column_count) = columns(header.kind) else {
        return Err(format!("its kind {} is unknown to this version", header.kind));
    };
    if header.run_id != assignment.run_id {
        return Err(format!("it belongs to run {:012x}, not to {:012x}", header.run_id, assignment.run_id));
    }
    if header.scenario != assignment.scenario || header.count as usize != times.len() {
        return Err(format!(
            "it belongs to scenario {} with {} snapshots, not to scenario {} with {}",
            header.scenario,
            header.count,
            assignment.scenario,
            times.len()
        ));
    }
    if header.index as usize != expected || expected >= times.len() {
        return Err(format!("it comes out of order, number {expected} of {} was expected", times.len()));
    }
    if header.time.to_bits() != times[expected].to_bits() {
        return Err(format!("its time is {} yr instead of {} yr", header.time, times[expected]));
    }
    if header.columns != column_count || header.rows == 0 {
        return Err(format!("it has {} rows of {} columns, its kind has {column_count}", header.rows, header.columns));
    }
    if items.len() as u64 != u64::from(header.rows) * u64::from(column_count) {
        return Err(format!("it holds {} numbers instead of {} x {column_count}", items.len(), header.rows));
    }
    let rows = header.rows as usize;
    let value_of = |position: usize| (position / rows, position % rows);
    if let Some(position) = items.iter().position(|value| !value.is_finite()) {
        let (column, row) = value_of(position);
        return Err(format!("row {row} of column {column} is {}", items[position]));
    }
    Ok(())
}

fn publish(
    outlet: &Outlet<Density>,
    snapshot: &SnapshotHeader,
    estimated: &Estimated,
    seconds: f64,
) -> Result<(), Failure> {
    let estimate = &estimated.estimate;
    let grid = estimate.grid;
    let header = DensityHeader {
        run_id: snapshot.run_id,
        time: snapshot.time,
        propagation_seconds: snapshot.seconds,
        estimation_seconds: seconds,
        grid: [grid.phi.low, grid.phi.high, grid.e.low, grid.e.high],
        moments: estimate.moments.to_array(),
        standard_errors: estimate.standard_errors.to_array(),
        circular_mean: estimate.circular.mean,
        resultant: estimate.circular.resultant,
        mass_on_grid: estimate.mass(),
        scenario: snapshot.scenario,
        index: snapshot.index,
        count: snapshot.count,
        rows: snapshot.rows,
        phi_bins: grid.phi.bins as u32,
        e_bins: grid.e.bins as u32,
        kind: snapshot.kind,
        diagnostic: estimated.diagnostic,
        diagnostics: estimated.diagnostics,
        label: pack(&unpack(&snapshot.label)),
    };
    let mut draft = outlet.draft(estimate.joint.len() + estimate.marginal_phi.len() + estimate.marginal_e.len())?;
    let (joint, marginals) = draft.items_mut().split_at_mut(estimate.joint.len());
    let (marginal_phi, marginal_e) = marginals.split_at_mut(estimate.marginal_phi.len());
    joint.copy_from_slice(&estimate.joint);
    marginal_phi.copy_from_slice(&estimate.marginal_phi);
    marginal_e.copy_from_slice(&estimate.marginal_e);
    Ok(outlet.send(draft, header)?)
}
