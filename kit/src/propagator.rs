//! The kit for writing a propagator: implement [`Propagator`], and let `main` return [`main`]'s result.
//!
//! The kit handles the topics, the handshake, the timing, progress, errors, signals and the end. A propagator only
//! turns a scenario into snapshots, each written directly into the shared memory in which the estimator will read it.

use std::process::ExitCode;

use density::first_passage::empirical::EmpiricalCurve;
use density::first_passage::given::Given;
use density::grid::Grid;
use density::sample_sums::{SampleSums, TooFar};
use messages::content::{Content, Reduced};
use messages::layout::{GIVEN_COLUMNS, MOST_PASSAGE, PASSAGE_COLUMNS, PassageHeader, SnapshotHeader};
use messages::port::{Draft, Outlet};
use messages::text::pack;
use messages::topic::{Passage as PassageTopic, Scenario, Snapshot};

use crate::assignment::{Assignment, Plane};
use crate::failure::Failure;
use crate::kind;
use crate::log;
use crate::newest::Newest;
use crate::reduced;
use crate::screen::receive;
use crate::session::{EffortClock, Session};
use crate::shard::Shard;

/// A method that propagates the initial density.
pub trait Propagator {
    /// Called before a scenario begins, if this process is one of several that share the case: from now on every
    /// snapshot has the rows in `shard.range(total)` of the `total` rows of the whole case, see [`Form::total_rows`].
    /// A row must depend only on its number. Not called for a case without shards.
    ///
    /// # Errors
    /// A method that cannot be split refuses; without this function it does.
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        let _ = shard;
        Err(Failure::Refused("this propagator cannot be split into shards; leave out `shards`".into()))
    }

    /// Prepares for a scenario.
    ///
    /// # Errors
    /// Whatever makes the scenario impossible for this method.
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure>;

    /// Moves a part of the way to snapshot `index` and returns how much of that way is behind it; `None` if nothing is left but
    /// [`Propagator::advance`]. A method that takes minutes between snapshots shows its progress in this way.
    ///
    /// # Errors
    /// Whatever makes it impossible to go on.
    fn approach(&mut self, index: usize) -> Result<Option<f64>, Failure> {
        let _ = index;
        Ok(None)
    }

    /// Moves to snapshot `index`, the next after the last one, and returns how many rows it has.
    ///
    /// # Errors
    /// Whatever makes it impossible to go on.
    fn advance(&mut self, index: usize) -> Result<usize, Failure>;

    /// The content of the snapshot that has been reached, if it is not the same for all snapshots; `planned` is the
    /// content that [`Propagator::begin`] returned.
    fn content(&self, planned: Content) -> Content {
        planned
    }

    /// The probability that the eccentricity has ever reached its critical value by each of `times` \[yr\].
    ///
    /// # Errors
    /// Whatever makes it impossible to go on; a method without a curve returns [`Passage::Cannot`].
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let _ = times;
        Ok(Passage::Cannot("this propagator does not compute first passages".into()))
    }

    /// What re-entry, and none, says of an uncertain radiation parameter by each time of the curve that
    /// [`Propagator::first_passage`] has just returned ([`GIVEN_COLUMNS`] numbers each); nothing where the parameter is certain or the method
    /// does not know.
    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        Vec::new()
    }

    /// Trajectories that were followed for the snapshot that has been reached; 0 if there is one per row of samples
    /// or characteristics, or if none is followed.
    fn trajectories(&self) -> u64 {
        0
    }

    /// The propagator's own estimate of the largest error of a coordinate of a trajectory, where trajectories are interpolated; 0 where it makes
    /// none. It stands among the diagnostics of the case.
    fn trajectory_error(&self) -> f64 {
        0.0
    }

    /// The samples of the snapshot that has been reached, reduced to counts and sums on the comparison grid; `None` if what
    /// [`Propagator::write`] writes is to be reduced. Asked for only if the case sends reduced samples. A propagator
    /// that reduces its samples as it makes them needs no memory for them.
    fn reduce(&self, grid: &Grid, critical_e: f64) -> Option<Result<SampleSums, TooFar>> {
        let _ = (grid, critical_e);
        None
    }

    /// Writes the snapshot that [`Propagator::advance`] has reached: the columns of its kind, one after the other.
    fn write(&self, columns: &mut [f64]);
}

/// A method's answer to the question when the eccentricity first reaches its critical value.
#[derive(Debug, Clone, PartialEq)]
pub enum Passage {
    /// One row per time: time \[yr\], probability, lower and upper end of its interval (NaN without one). If the case
    /// has shards, only the curve of the first shard is used, and it must be that of the whole case.
    Curve(Vec<[f64; PASSAGE_COLUMNS]>),
    /// A curve that was counted from equal samples of this process; the counts of shards are added up.
    Counted {
        /// The rows, in the form of the rows of a curve.
        rows: Vec<[f64; PASSAGE_COLUMNS]>,
        /// How many samples there are.
        samples: u64,
        /// Whether they are independent of one another. Only then is the interval of a count known from the count alone.
        independent: bool,
    },
    /// The method has no curve, for the given reason.
    Cannot(String),
}

impl Passage {
    /// The rows of an estimate from a sample of trajectories.
    pub fn rows(curve: &EmpiricalCurve) -> Vec<[f64; PASSAGE_COLUMNS]> {
        let interval = |k: usize| curve.interval.as_ref().map_or((f64::NAN, f64::NAN), |interval| interval[k]);
        let row = |k: usize| [curve.times[k], curve.probability[k], interval(k).0, interval(k).1];
        (0..curve.times.len()).map(row).collect()
    }
}

/// What a propagator's snapshots look like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// Their kind, with the fields of this kind; [`messages::content`] lists the kinds.
    pub content: Content,
    /// The most rows that a snapshot of the scenario can have; for a shard, only its own rows.
    pub most_rows: usize,
    /// Rows that all shards together have in each snapshot.
    pub total_rows: usize,
}

impl Form {
    /// The form of the snapshots of a case that is not split into shards.
    pub fn whole(content: impl Into<Content>, most_rows: usize) -> Self {
        Self { content: content.into(), most_rows, total_rows: most_rows }
    }
}

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
                Err(failure) => session.failed(scenario, &session.name, &failure.to_string())?,
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
        run_id: assignment.said.run_id,
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

/// The units in which the way to a snapshot is reported.
const PARTS: usize = 100;

/// How the snapshots are made from what a propagator writes.
struct Drafting {
    content: Content,
    most_numbers: usize,
    /// The content of the samples, if they are reduced before they are sent.
    reduces: Option<Content>,
}

impl Drafting {
    fn of(session: &Session, form: &Form, assignment: &Assignment) -> Result<Self, Failure> {
        let Form { content, most_rows, .. } = *form;
        if !session.reduce {
            let columns = content.column_count(assignment.space.variables.len());
            return Ok(Self { content, most_numbers: most_rows * columns, reduces: None });
        }
        if !kind::of(&content).may_be_reduced() {
            return Err(Failure::Refused("only independent samples can be reduced; leave out `reduce`".into()));
        }
        let plane = reduced::plane_of(assignment)?;
        let most_bins = plane.grids.iter().map(Grid::len).max().unwrap_or(0);
        let most_numbers = reduced::most_numbers(most_bins);
        Ok(Self { content: Reduced.into(), most_numbers, reduces: Some(content) })
    }

    /// The content of the snapshot that `propagator` has reached.
    fn content(&self, propagator: &impl Propagator) -> Result<Content, Failure> {
        let content = if self.reduces.is_some() { self.content } else { propagator.content(self.content) };
        if content.code() != self.content.code() {
            let planned = self.content;
            return Err(Failure::Refused(format!("a snapshot is {content:?} where {planned:?} was announced")));
        }
        Ok(content)
    }

    /// The message with the snapshot that `propagator` has reached, and its number of rows.
    fn draft(
        &self,
        outlet: &Outlet<Snapshot>,
        propagator: &impl Propagator,
        rows: usize,
        assignment: &Assignment,
        index: usize,
    ) -> Result<(Draft<Snapshot>, usize), Failure> {
        let Some(samples_content) = self.reduces else {
            let mut draft = outlet.draft(rows * self.content.column_count(assignment.space.variables.len()))?;
            propagator.write(draft.items_mut());
            return Ok((draft, rows));
        };
        let refused = |why: &dyn std::fmt::Display| Failure::Refused(format!("snapshot {index}: {why}"));
        let Plane { problem, grids } = assignment.plane()?;
        let sums = match propagator.reduce(&grids[index], problem.critical_e) {
            Some(sums) => sums,
            None => {
                let mut samples = vec![0.0; 2 * rows];
                propagator.write(&mut samples);
                if let Some(breach) = kind::of(&samples_content).breach(&assignment.space, rows, &samples) {
                    return Err(refused(&breach));
                }
                let (phi, e) = samples.split_at(rows);
                SampleSums::reduce(phi, e, &grids[index], problem.critical_e)
            }
        };
        let numbers = reduced::to_numbers(&sums.map_err(|why| refused(&why))?)?;
        let mut draft = outlet.draft(numbers.len())?;
        draft.items_mut().copy_from_slice(&numbers);
        Ok((draft, numbers.len()))
    }
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
        run_id: assignment.said.run_id,
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

/// What a row of a first-passage curve goes on with: the radiation parameter given re-entry, and given none.
pub fn given_row(events: [Given; 2]) -> [f64; GIVEN_COLUMNS] {
    let four = |Given { mean, deviation }: Given| [mean.value, deviation.value, mean.error, deviation.error];
    let mut row = [f64::NAN; GIVEN_COLUMNS];
    row.iter_mut().zip(events.into_iter().flat_map(four)).for_each(|(place, number)| *place = number);
    row
}

/// Raises the rows of a first-passage curve to what they have reached before. The true curve never falls; rounding and quadrature may make an
/// estimate do so.
pub fn never_falling(rows: &mut [[f64; PASSAGE_COLUMNS]]) {
    let mut least = 0.0f64;
    for row in rows.iter_mut().filter(|row| !row[1].is_nan()) {
        least = least.max(row[1]);
        row[1] = least;
        // An estimate that was raised stays within its interval; of a withheld one only the interval is known.
        row[3] = if row[3].is_nan() { row[3] } else { row[3].max(least) };
    }
}
