//! The estimator: turns every snapshot of every propagator into a density on the comparison grid.
//!
//! It checks all messages: a snapshot with the wrong shape, order or numbers is refused and its label reported as
//! failed; the other cases go on. A propagator that was restarted sends the scenario anew, which replaces its earlier
//! snapshots. An estimator that was restarted receives the snapshots that the propagators have kept.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use messages::content::SnapshotKind;
use messages::layout::{DensityHeader, SnapshotHeader};
use messages::patience::Watch;
use messages::port::{Inlet, Message, Outlet};
use messages::text::{pack, unpack};
use messages::topic::{Density, Roster as RosterTopic, Scenario, Snapshot};

use crate::services::estimation::{CaseEstimator, Estimated};
use crate::services::gathering::Gathering;
use crate::services::reading::Reading;
use crate::services::roomy::Roomy;
use crate::services::roster::Roster;
use kit::assignment::Assignment;
use kit::diagnosis;
use kit::failure::Failure;
use kit::kind::trajectories_behind;
use kit::newest::Newest;
use kit::screen::receive;
use kit::session::{ANY_SCENARIO, EffortClock, Session};
use kit::snapshot_rules::decode;

/// Longest time by which a snapshot may arrive before the scenario to which it belongs.
const HEAD_START: Duration = Duration::from_secs(5);

/// Estimates until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session) -> Result<(), Failure> {
    let mut estimator = Estimator::new(session)?;
    session.ready()?;
    loop {
        estimator.look_around()?;
        while estimator.can_work()
            && let Some(message) = receive(session, &estimator.snapshots)?
        {
            estimator.handle(&message)?;
        }
        estimator.tell_awaited()?;
        estimator.sleep()?;
    }
}

struct Estimator<'a> {
    session: &'a Session,
    scenarios: Inlet<Scenario>,
    snapshots: Inlet<Snapshot>,
    rosters: Inlet<RosterTopic>,
    newest: Newest,
    roster: Roster,
    strangers: BTreeSet<String>,
    densities: Option<Roomy<Density>>,
    work: Option<ScenarioWork>,
}

/// The scenario under work.
struct ScenarioWork {
    assignment: Assignment,
    cases: BTreeMap<String, Attempt>,
    refused: BTreeSet<String>,
    done: usize,
    awaited: Option<String>,
}

/// The state of a case in the scenario under way.
#[derive(Default)]
struct Attempt {
    /// How often its propagator was restarted. The restarts of shards are counted in `gathering` instead.
    number: u32,
    case: CaseEstimator,
    gathering: Gathering,
    /// CPU time spent on shards of the next snapshot \[s\].
    gathering_seconds: f64,
}

/// A density, and the header of the snapshot from which it was estimated.
struct Answer {
    snapshot: SnapshotHeader,
    estimated: Estimated,
    seconds: f64,
}

impl<'a> Estimator<'a> {
    fn new(session: &'a Session) -> Result<Self, Failure> {
        Ok(Self {
            session,
            scenarios: session.domain.inlet()?,
            snapshots: session.domain.inlet()?,
            rosters: session.domain.inlet()?,
            newest: Newest::default(),
            roster: Roster::default(),
            strangers: BTreeSet::new(),
            densities: None,
            work: None,
        })
    }

    /// Receives new rosters and scenarios.
    fn look_around(&mut self) -> Result<(), Failure> {
        self.roster.update(self.session, &self.rosters)?;
        while let Some(message) = receive(self.session, &self.scenarios)? {
            if self.newest.is_news(message.header().scenario) {
                let assignment = Assignment::read(&message)?;
                // One outlet per scenario, as in a propagator.
                self.densities = None;
                let (cases, refused) = (BTreeMap::new(), BTreeSet::new());
                self.work = Some(ScenarioWork { assignment, cases, refused, done: 0, awaited: None });
            }
        }
        Ok(())
    }

    fn can_work(&self) -> bool {
        self.work.is_some() && self.roster.is_known()
    }

    fn sleep(&self) -> Result<(), Failure> {
        match &self.densities {
            Some(densities) => self.session.wait(&[&self.scenarios, &self.snapshots, &self.rosters, &densities.outlet]),
            None => self.session.wait(&[&self.scenarios, &self.snapshots, &self.rosters]),
        }
    }

    /// Handles a snapshot of any sender and scenario.
    fn handle(&mut self, message: &Message<Snapshot>) -> Result<(), Failure> {
        let header = message.header();
        let label = unpack(&header.label);
        if !self.roster.takes_part(&label) {
            return self.ignore_stranger(&label);
        }
        if self.work.as_ref().is_some_and(|work| header.scenario > work.assignment.scenario()) {
            self.await_scenario(header.scenario)?;
        }
        self.roster.update(self.session, &self.rosters)?;
        let Some(work) = &mut self.work else { return Ok(()) };
        // Nobody waits any more for what a case that has failed had still sent.
        let has_failed = self.roster.scenario == work.assignment.scenario() && self.roster.has_failed(&label);
        if header.scenario < work.assignment.scenario() || work.refused.contains(&label) || has_failed {
            return Ok(());
        }
        let shards = self.roster.shards(&label);
        match work.estimate(header, message.items(), &label, shards) {
            Ok(Some(answer)) => {
                let room = Reading::numbers_of(&work.assignment);
                let outlet = Roomy::with_room(&mut self.densities, &self.session.domain, room)?;
                publish(outlet, &answer)?;
                work.done += 1;
                self.session.working(work.assignment.scenario(), work.done, work.done)
            }
            Ok(None) => Ok(()),
            Err(why) => {
                let why = format!("snapshot {}: {why}", header.index);
                work.refused.insert(label.clone());
                self.session.case_failed(work.assignment.scenario(), &label, &why)
            }
        }
    }

    /// Reports the case whose snapshots are waited for: the launcher cannot know which case has sent too few.
    fn tell_awaited(&mut self) -> Result<(), Failure> {
        let Some(work) = &mut self.work else { return Ok(()) };
        let alive = self.roster.cases.iter().filter(|(label, failed)| !failed && !work.refused.contains(label));
        let awaited =
            alive.map(|(label, _)| label).find(|label| work.snapshots_of(label) < work.assignment.times.len());
        if let Some(label) = awaited.filter(|label| work.awaited.as_ref() != Some(label)) {
            self.session.waits_for(work.assignment.scenario(), label, "its snapshots", work.done)?;
        }
        work.awaited = awaited.cloned();
        Ok(())
    }

    /// Waits for the scenario of a snapshot. The two come from different processes, so the snapshot may arrive first.
    fn await_scenario(&mut self, scenario: u32) -> Result<(), Failure> {
        let mut watch = Watch::start();
        while self.work.as_ref().is_none_or(|work| work.assignment.scenario() < scenario)
            && watch.elapsed() < HEAD_START
        {
            self.session.wait(&[&self.scenarios])?;
            self.look_around()?;
        }
        Ok(())
    }

    fn ignore_stranger(&mut self, label: &str) -> Result<(), Failure> {
        if self.strangers.insert(label.into()) {
            let scenario = self.work.as_ref().map_or(ANY_SCENARIO, |work| work.assignment.scenario());
            self.session.case_failed(
                scenario,
                label,
                "its snapshots are ignored: no case of this run has that label",
            )?;
        }
        Ok(())
    }
}

impl ScenarioWork {
    fn snapshots_of(&self, label: &str) -> usize {
        self.cases.get(label).map_or(0, |attempt| attempt.case.snapshots_done())
    }

    /// Estimates a snapshot of a case that has `shards` shards, if this number is known. Returns `None` if the
    /// snapshot is that of one shard and those of others are missing, or if a later attempt of the same case has
    /// replaced it.
    ///
    /// # Errors
    /// What is wrong with it.
    fn estimate(
        &mut self,
        header: &SnapshotHeader,
        items: &[f64],
        label: &str,
        shards: Option<u32>,
    ) -> Result<Option<Answer>, String> {
        let clock = EffortClock::start();
        let attempt = self.cases.entry(label.into()).or_default();
        if let Some(shards) = shards.filter(|shards| *shards != header.shards.max(1)) {
            let whose = format!("it says that it is shard {} of {}", header.shard, header.shards.max(1));
            return Err(format!("{whose}, but the case has {shards}"));
        }
        if header.shards > 1 {
            return attempt.gather(header, items, &self.assignment, clock);
        }
        if header.attempt < attempt.number {
            return Ok(None);
        }
        if header.attempt > attempt.number {
            *attempt = Attempt { number: header.attempt, ..Attempt::default() };
        }
        let due = attempt.case.snapshots_done();
        let snapshot = decode(header, items, &self.assignment, due).map_err(|breach| breach.to_string())?;
        let estimated = attempt.case.estimate(&snapshot, &self.assignment)?;
        Ok(Some(Answer { snapshot: *header, estimated, seconds: clock.seconds() }))
    }
}

impl Attempt {
    /// Adds the snapshot of a shard, and estimates the whole snapshot if no other part is missing.
    fn gather(
        &mut self,
        header: &SnapshotHeader,
        items: &[f64],
        assignment: &Assignment,
        clock: EffortClock,
    ) -> Result<Option<Answer>, String> {
        let Some(whole) = self.gathering.take(header, items, assignment)? else {
            self.gathering_seconds += clock.seconds();
            return Ok(None);
        };
        let estimated = self.case.estimate(&whole.as_snapshot(), assignment)?;
        let seconds = std::mem::take(&mut self.gathering_seconds) + clock.seconds();
        Ok(Some(Answer { snapshot: whole.header, estimated, seconds }))
    }
}

fn publish(outlet: &Outlet<Density>, Answer { snapshot, estimated, seconds }: &Answer) -> Result<(), Failure> {
    let Estimated { values, mass_on_grid, .. } = estimated;
    let (diagnostic, diagnostics) = diagnosis::to_parts(estimated.diagnosis);
    let header = DensityHeader {
        run_id: snapshot.run_id,
        time: snapshot.time,
        propagation_seconds: snapshot.seconds,
        estimation_seconds: *seconds,
        mass_on_grid: *mass_on_grid,
        // Each sample that was reduced is one trajectory.
        trajectories: estimated.reduced.map_or_else(|| trajectories_behind(snapshot), u64::from),
        trajectory_error: snapshot.trajectory_error,
        scenario: snapshot.scenario,
        index: snapshot.index,
        count: snapshot.count,
        rows: estimated.reduced.unwrap_or(snapshot.rows),
        quantities: values.len() as u32,
        // The kind of the result does not depend on where the samples were reduced.
        kind: if estimated.reduced.is_some() { SnapshotKind::Samples.code() } else { snapshot.kind },
        diagnostic,
        diagnostics,
        carried_density_error: estimated.carried_density_error,
        reserved: 0,
        label: pack(&unpack(&snapshot.label)),
    };
    Ok(outlet.send_items(header, &estimated.numbers())?)
}
