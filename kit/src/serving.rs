//! The loop that serves scenario after scenario with a propagator: topics, handshake, timing, progress, errors, signals
//! and the end.

use std::process::ExitCode;

use messages::layout::{MOST_PASSAGE, PassageHeader, SnapshotHeader};
use messages::port::Outlet;
use messages::text::pack;
use messages::topic::{Passage as PassageTopic, Scenario, Snapshot};

use crate::assignment::Assignment;
use crate::drafting::Drafting;
use crate::failure::Failure;
use crate::kind;
use crate::log;
use crate::newest::Newest;
use crate::passage::{Passage, never_falling};
use crate::propagator::{Form, Propagator};
use crate::screen::receive;
use crate::session::{EffortClock, Session};

/// The units in which the way to a snapshot is reported.
const PARTS: usize = 100;

/// The `main` of a propagator: serves the run that started the process until it ends.
pub fn main(propagator: impl Propagator) -> ExitCode {
    let served = Session::from_environment().and_then(|session| serve(&session, propagator));
    match served {
        Ok(()) | Err(Failure::Stopped) => ExitCode::SUCCESS,
        Err(failure) => {
            log::end(&failure);
            ExitCode::FAILURE
        }
    }
}

/// Serves scenario after scenario with `propagator` until asked to stop.
///
/// A scenario that the method cannot do is reported to the launcher as failed; the next one is tried nevertheless.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end, [`Failure::Port`] the only other one.
pub fn serve(session: &Session, mut propagator: impl Propagator) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let passages = session.domain.outlet::<PassageTopic>(MOST_PASSAGE)?;
    session.ready()?;
    let mut way_out = WayOut { passages, snapshots: None };
    let mut newest = Newest::default();
    loop {
        while let Some(message) = receive(session, &scenarios)? {
            let scenario = message.header().scenario;
            if !newest.is_news(scenario) {
                continue;
            }
            let read = Assignment::read(&message);
            drop(message);
            match read.and_then(|assignment| serve_one(session, &mut propagator, &assignment, &mut way_out)) {
                Err(failure @ (Failure::Stopped | Failure::Port(_))) => return Err(failure),
                Err(failure) => session.failed(scenario, &failure.to_string())?,
                Ok(()) => {}
            }
        }
        match &way_out.snapshots {
            Some(snapshots) => session.wait(&[&scenarios, &way_out.passages, snapshots])?,
            None => session.wait(&[&scenarios, &way_out.passages])?,
        }
    }
}

/// The two outlets of a propagator.
struct WayOut {
    passages: Outlet<PassageTopic>,
    snapshots: Option<Outlet<Snapshot>>,
}

/// What the headers of all snapshots of a scenario have in common.
fn common_header(session: &Session, form: &Form, assignment: &Assignment) -> SnapshotHeader {
    let shard = session.shard;
    SnapshotHeader {
        run_id: assignment.description.run_id,
        scenario: assignment.scenario(),
        count: assignment.times.len() as u32,
        attempt: session.attempt,
        total: if shard.is_whole() { 0 } else { form.total_rows as u64 },
        shard: shard.index,
        shards: shard.count,
        most_rows: form.most_rows as u32,
        label: pack(&session.label),
        ..SnapshotHeader::default()
    }
}

fn serve_one(
    session: &Session,
    propagator: &mut impl Propagator,
    assignment: &Assignment,
    way_out: &mut WayOut,
) -> Result<(), Failure> {
    let mut clock = EffortClock::start();
    let shard = session.shard;
    if !shard.is_whole() {
        propagator.take_shard(shard)?;
    }
    let form = propagator.begin(assignment)?;
    let drafting = Drafting::of(session, &form, assignment)?;
    // One outlet per scenario: then no reader can have more unread messages than its buffer holds, not even a reader
    // that has yet to connect, for which iceoryx2 would drop what does not fit. The memory of the previous outlet is
    // freed first.
    drop(way_out.snapshots.take());
    let outlet = way_out.snapshots.insert(session.domain.outlet::<Snapshot>(drafting.most_numbers)?);
    let (count, variables) = (assignment.times.len(), assignment.space.variables.len());
    for (index, &time) in assignment.times.iter().enumerate() {
        session.check_stop()?;
        while let Some(share) = propagator.approach(index)? {
            session.check_stop()?;
            let done = ((index as f64 + share) * PARTS as f64) as usize;
            session.working(assignment.scenario(), done.min(count * PARTS - 1), count * PARTS)?;
        }
        let rows = propagator.advance(index)?;
        let (mut draft, rows) = drafting.draft(outlet, propagator, rows, assignment, index)?;
        let header = SnapshotHeader {
            time,
            seconds: clock.seconds(),
            trajectories: propagator.trajectories(),
            trajectory_error: propagator.trajectory_error(),
            index: index as u32,
            rows: rows as u32,
            ..common_header(session, &form, assignment)
        };
        let content = drafting.content(propagator)?;
        if index + 1 == count {
            // Before the last snapshot, so that a node that has the density of that snapshot can have the passages
            // too.
            send_passage(session, propagator, assignment, &way_out.passages)?;
        }
        if let Some(breach) = kind::of(&content).breach(&assignment.space, rows, draft.items_mut()) {
            return Err(Failure::Refused(format!("snapshot {index}: {breach}")));
        }
        outlet.send(draft, header.with_variables(content, variables))?;
        clock = EffortClock::start();
        session.working(assignment.scenario(), index + 1, count)?;
    }
    session.done(assignment.scenario())
}

fn send_passage(
    session: &Session,
    propagator: &mut impl Propagator,
    assignment: &Assignment,
    outlet: &Outlet<PassageTopic>,
) -> Result<(), Failure> {
    let clock = EffortClock::start();
    let (mut rows, samples, independent, reason) = match propagator.first_passage(&assignment.passage_times())? {
        Passage::Curve(rows) => (rows, 0, true, String::new()),
        Passage::Counted { rows, samples, independent } => (rows, samples, independent, String::new()),
        Passage::Cannot(reason) => (Vec::new(), 0, true, reason),
    };
    never_falling(&mut rows);
    let given = propagator.given_re_entry();
    let given = Some(given).filter(|given| !rows.is_empty() && given.len() == rows.len());
    let header = PassageHeader {
        run_id: assignment.description.run_id,
        seconds: clock.seconds(),
        samples,
        scenario: assignment.scenario(),
        rows: rows.len() as u32,
        shard: session.shard.index,
        shards: session.shard.count,
        dependent: u32::from(!independent),
        given: u32::from(given.is_some()),
        label: pack(&session.label),
        reason: pack(&reason),
    };
    let numbers = match given {
        None => rows.concat(),
        Some(given) => rows.iter().zip(&given).flat_map(|(row, given)| row.iter().chain(given)).copied().collect(),
    };
    Ok(outlet.send_items(header, &numbers)?)
}
