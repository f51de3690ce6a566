//! The player: takes the part of a node and sends what that node sent in a recorded run.
//!
//! It plays a propagator, the estimator or the comparator, depending on its name. The scenario comes from a running
//! scenario node. A scenario that differs from the recorded one is refused, because the answers would not belong to
//! it.

use std::path::Path;

use messages::describe::Described;
use messages::port::{Inlet, Message, Outlet};
use messages::recording::Recording;
use messages::report::{Event, Report};
use messages::service::Service;
use messages::text::unpack;
use messages::topic::{Comparison, Density, Passage, Scenario, Snapshot, Status, Topic};
use messages::wait::Awaited;

use kit::failure::Failure;
use kit::newest::Newest;
use kit::session::Session;

/// The outlets on which a player has sent in a scenario. They must be kept until the next scenario, because their
/// messages are lost with them.
#[derive(Debug)]
enum Sent {
    Propagator(Box<(Outlet<Passage>, Outlet<Snapshot>)>),
    Estimator(Outlet<Density>),
    Comparator(Outlet<Comparison>),
}

impl Sent {
    /// Its outlets, to which readers may connect late.
    fn ports(&self) -> Vec<&dyn Awaited> {
        match self {
            Self::Propagator(both) => vec![&both.0, &both.1],
            Self::Estimator(outlet) => vec![outlet],
            Self::Comparator(outlet) => vec![outlet],
        }
    }
}

/// Plays the part of the node whose name the session has, scenario after scenario, until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end; anything else has also been reported to the launcher.
pub fn run(session: &Session, file: &Path) -> Result<(), Failure> {
    let recording = Recording::open(file).map_err(|e| Failure::Refused(e.to_string()))?;
    let scenarios = session.domain.inlet::<Scenario>()?;
    // The snapshots are known from the recording, but they must be received.
    let snapshots = session.reporter.is(Service::Estimator).then(|| session.domain.inlet::<Snapshot>()).transpose()?;
    session.ready()?;
    let mut sent: Option<Sent> = None;
    let mut newest = Newest::default();
    loop {
        while let Some(message) = scenarios.receive()? {
            let position = message.header().scenario;
            if !newest.is_news(position) {
                continue;
            }
            let played = check_scenario(&recording, &message);
            drop(message);
            drop(sent.take());
            let played =
                played.and_then(|()| snapshots.iter().try_for_each(|s| await_all(session, &recording, position, s)));
            let played = played.and_then(|()| play(session, &recording, position));
            sent = Some(played.inspect_err(|failure| {
                if !matches!(failure, Failure::Stopped) {
                    let _ = session.failed(position, &failure.to_string());
                }
            })?);
        }
        let mut ports: Vec<&dyn Awaited> = vec![&scenarios];
        ports.extend(sent.iter().flat_map(Sent::ports));
        session.wait(&ports)?;
    }
}

/// Receives all snapshots of a scenario, as the estimator does before it has sent all densities: a node that has all
/// densities can then rely on having everything that was sent before the snapshots.
fn await_all(session: &Session, recording: &Recording, position: u32, inlet: &Inlet<Snapshot>) -> Result<(), Failure> {
    let mut left = recording.messages::<Snapshot>().filter(|(header, _)| header.scenario == position).count();
    loop {
        while inlet.receive()?.is_some() {
            left = left.saturating_sub(1);
        }
        if left == 0 {
            return Ok(());
        }
        session.wait(&[inlet])?;
    }
}

/// Whether the scenario is the one that was recorded, bit by bit.
fn check_scenario(recording: &Recording, message: &Message<Scenario>) -> Result<(), Failure> {
    let header = message.header();
    let recorded = recording.messages::<Scenario>().find(|(recorded, _)| recorded.scenario == header.scenario);
    let Some((recorded, entry)) = recorded else {
        return Err(Failure::Refused(format!("the recording has no scenario number {}", header.scenario)));
    };
    let [ours, theirs] = [*header, Scenario::in_run(recorded, header.run_id)];
    let (ours, theirs) = (bytes(&ours), bytes(&theirs));
    let differs = |field: &&messages::describe::Field| field.value(ours) != field.value(theirs);
    let different = <Scenario as Topic>::Header::FIELDS.iter().find(differs).map(|field| field.name);
    let items = items::<Scenario>(recording, entry)?;
    let same_items = items.iter().map(|x| x.to_bits()).eq(message.items().iter().map(|x| x.to_bits()));
    match (different, same_items) {
        (None, true) => Ok(()),
        (different, _) => {
            let what = different.unwrap_or("the comparison grid");
            Err(Failure::Refused(format!("the scenario is not the one that was recorded: {what} differs")))
        }
    }
}

fn bytes<H: Described>(header: &H) -> &[u8] {
    bytemuck::bytes_of(header)
}

fn items<T: Topic>(recording: &Recording, entry: &messages::recording::Entry) -> Result<Vec<T::Item>, Failure> {
    let mut items = vec![T::Item::default(); entry.items::<T>()];
    recording.read::<T>(entry, &mut items).map_err(|e| Failure::Refused(e.to_string()))?;
    Ok(items)
}

/// Sends what the node sent in the scenario at `position`, and reports how that ended.
fn play(session: &Session, recording: &Recording, position: u32) -> Result<Sent, Failure> {
    let name = session.name.as_str();
    let Session { label: own, shard, .. } = session;
    let mine =
        |scenario: u32, label: &[u8], of: u32| scenario == position && unpack(label) == *own && of == shard.index;
    let sent = match session.reporter.service() {
        Some(Service::Estimator) => Sent::Estimator(send::<Density>(session, recording, |h| h.scenario == position)?),
        Some(Service::Comparator) => {
            Sent::Comparator(send::<Comparison>(session, recording, |h| h.scenario == position)?)
        }
        _ => {
            // In the order in which a propagator sends: its last snapshot means that everything has been sent.
            let passages = send::<Passage>(session, recording, |h| mine(h.scenario, &h.label, h.shard))?;
            let snapshots = send::<Snapshot>(session, recording, |h| mine(h.scenario, &h.label, h.shard))?;
            Sent::Propagator(Box::new((passages, snapshots)))
        }
    };
    let reports = recording.messages::<Status>().filter_map(|(header, _)| Report::from_parts(&header, &[]).ok());
    let mut failed = false;
    for report in reports.filter(|report| report.scenario == position && report.from == session.reporter) {
        if let Event::Failed { .. } = report.event {
            failed = true;
            session.report(position, report.event)?;
        }
    }
    if !failed && let Sent::Propagator(..) = sent {
        let have = recording.messages::<Snapshot>().filter(|(h, _)| mine(h.scenario, &h.label, h.shard)).count();
        check_count(recording, position, name, have)?;
    }
    session.done(position)?;
    Ok(sent)
}

/// Checks that the recording has all snapshots of a propagator; it has `have` of them.
fn check_count(recording: &Recording, position: u32, name: &str, have: usize) -> Result<(), Failure> {
    let scenario = recording.messages::<Scenario>().find(|(header, _)| header.scenario == position);
    let count = scenario.map_or(0, |(header, _)| header.snapshots as usize);
    if have == count {
        return Ok(());
    }
    Err(Failure::Refused(format!("the recording has {have} of the {count} snapshots of {name}")))
}

fn send<T: Topic>(
    session: &Session,
    recording: &Recording,
    belongs: impl Fn(&T::Header) -> bool,
) -> Result<Outlet<T>, Failure> {
    let messages = || recording.messages::<T>().filter(|(header, _)| belongs(header));
    let longest = messages().map(|(_, entry)| entry.items::<T>()).max().unwrap_or(0);
    let outlet = session.domain.outlet::<T>(longest.max(1))?;
    for (header, entry) in messages() {
        session.check_stop()?;
        let mut draft = outlet.draft(entry.items::<T>())?;
        recording.read::<T>(entry, draft.items_mut()).map_err(|e| Failure::Refused(e.to_string()))?;
        outlet.send(draft, T::in_run(header, session.run_id))?;
    }
    Ok(outlet)
}
