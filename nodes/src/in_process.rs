//! A case computed in this process alone, without topics: the same propagators and the same estimation as in a run, one
//! after the other.

use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::kind::{Estimated, trajectories_behind};
use kit::passage::{Passage, never_falling};
use kit::session::EffortClock;
use kit::snapshot_rules::decode;
use kit::{Form, Propagator};
use messages::content::Content;
use messages::layout::SnapshotHeader;

use crate::methods::BuiltIn;
use crate::services::estimation::CaseEstimator;

/// What is wanted of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// Whether the density of each snapshot is estimated.
    pub estimates: bool,
    /// Whether the columns of each snapshot are kept.
    pub columns: bool,
    /// Whether the first-passage curve is computed.
    pub passage: bool,
}

impl Wanted {
    /// Everything.
    pub const ALL: Self = Self { estimates: true, columns: true, passage: true };
    /// The first-passage curve alone.
    pub const PASSAGE: Self = Self { estimates: false, columns: false, passage: true };
}

/// A snapshot that has been computed.
#[derive(Debug)]
pub struct Computed {
    /// What its columns are.
    pub content: Content,
    /// Number of rows.
    pub rows: usize,
    /// The columns, one after the other; empty if they are not wanted.
    pub columns: Vec<f64>,
    /// Its density and moments, if they are wanted.
    pub estimated: Option<Estimated>,
    /// Trajectories that were followed for it.
    pub trajectories: u64,
    /// CPU time of propagation and of estimation \[s\].
    pub seconds: [f64; 2],
}

/// A case that has been computed.
#[derive(Debug)]
pub struct Outcome {
    /// Its snapshots, in the order of the scenario's times; none if nothing but the first-passage curve is wanted and
    /// that needs none.
    pub snapshots: Vec<Computed>,
    /// Its first-passage curve, if it is wanted.
    pub passage: Option<Passage>,
}

/// Computes a case. `check_stop` is asked between two parts of the work whether to go on.
///
/// # Errors
/// Settings that do not go together or with the bins, what the method cannot do, or the error of `check_stop`.
pub fn compute(
    case: BuiltIn,
    assignment: &Assignment,
    wanted: Wanted,
    check_stop: &mut dyn FnMut() -> Result<(), Failure>,
) -> Result<Outcome, Failure> {
    let needs_snapshots = wanted.estimates || wanted.columns || case.curve_needs_snapshots();
    let mut propagator = case.propagator();
    let form = propagator.begin(assignment)?;
    let mut work = Work { assignment, form, wanted, estimator: CaseEstimator::default() };
    let mut snapshots = Vec::new();
    for index in (0..assignment.times.len()).filter(|_| needs_snapshots) {
        check_stop()?;
        let clock = EffortClock::start();
        while propagator.approach(index)?.is_some() {
            check_stop()?;
        }
        let rows = propagator.advance(index)?;
        snapshots.push(work.snapshot(&*propagator, index, rows, clock)?);
    }
    check_stop()?;
    let passage = if wanted.passage { Some(passage(&mut *propagator, assignment)?) } else { None };
    Ok(Outcome { snapshots, passage })
}

fn passage(propagator: &mut dyn Propagator, assignment: &Assignment) -> Result<Passage, Failure> {
    let mut passage = propagator.first_passage(&assignment.passage_times())?;
    if let Passage::Curve(rows) | Passage::Counted { rows, .. } = &mut passage {
        never_falling(rows);
    }
    Ok(passage)
}

/// A case under way.
struct Work<'a> {
    assignment: &'a Assignment,
    form: Form,
    wanted: Wanted,
    estimator: CaseEstimator,
}

impl Work<'_> {
    /// The snapshot that has been reached, under the rules for those of any sender.
    fn snapshot(
        &mut self,
        propagator: &dyn Propagator,
        index: usize,
        rows: usize,
        clock: EffortClock,
    ) -> Result<Computed, Failure> {
        let Self { assignment, form, wanted, estimator } = self;
        let (content, variables) = (propagator.content(form.content), assignment.space.variables.len());
        let header = SnapshotHeader {
            run_id: assignment.description.run_id,
            time: assignment.times[index],
            trajectories: propagator.trajectories(),
            trajectory_error: propagator.trajectory_error(),
            scenario: assignment.scenario(),
            index: index as u32,
            count: assignment.times.len() as u32,
            rows: rows as u32,
            most_rows: form.most_rows as u32,
            ..SnapshotHeader::default()
        }
        .with_variables(content, variables);
        let mut columns = Vec::new();
        if wanted.columns || wanted.estimates {
            columns.resize(rows * content.column_count(variables), 0.0);
            propagator.write(&mut columns);
        }
        let propagation = clock.seconds();
        let clock = EffortClock::start();
        let mut estimated = None;
        if wanted.estimates {
            let in_snapshot = |why: String| Failure::Refused(format!("snapshot {index}: {why}"));
            let snapshot =
                decode(&header, &columns, assignment, index).map_err(|breach| in_snapshot(breach.to_string()))?;
            estimated = Some(estimator.estimate(&snapshot, assignment).map_err(in_snapshot)?);
        }
        if !wanted.columns {
            columns = Vec::new();
        }
        let (trajectories, seconds) = (trajectories_behind(&header), [propagation, clock.seconds()]);
        Ok(Computed { content, rows, columns, estimated, trajectories, seconds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::example::assignment;

    fn case(name: &str, settings: &str) -> BuiltIn {
        BuiltIn::from_settings(name, toml::de::Deserializer::parse(settings).unwrap()).unwrap().unwrap()
    }

    #[test]
    fn every_snapshot_is_computed_in_its_order_and_the_rows_are_kept_only_if_they_are_wanted() {
        let assignment = assignment();
        let compute = |wanted| compute(case("mc", "samples = 50"), &assignment, wanted, &mut || Ok(())).unwrap();
        let all = compute(Wanted::ALL);
        assert_eq!(all.snapshots.len(), assignment.times.len());
        assert!(all.snapshots.iter().all(|snapshot| snapshot.rows == 50 && snapshot.columns.len() == 100));
        assert!(matches!(all.passage, Some(Passage::Counted { samples: 50, .. })));
        let few = compute(Wanted { columns: false, ..Wanted::ALL });
        assert!(few.snapshots.iter().all(|snapshot| snapshot.columns.is_empty()));
        let value = |outcome: &Outcome| outcome.snapshots[1].estimated.as_ref().unwrap().values.clone();
        assert_eq!(value(&few), value(&all));
    }

    #[test]
    fn the_exact_curve_alone_needs_no_snapshot() {
        let outcome = compute(case("exact", ""), &assignment(), Wanted::PASSAGE, &mut || Ok(())).unwrap();
        assert!(outcome.snapshots.is_empty() && matches!(outcome.passage, Some(Passage::Curve(_))));
    }

    #[test]
    fn a_case_ends_between_two_snapshots_when_it_is_asked_to() {
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            if asked > 1 { Err(Failure::Stopped) } else { Ok(()) }
        };
        let outcome = compute(case("mc", "samples = 50"), &assignment(), Wanted::ALL, &mut stop);
        assert!(matches!(outcome, Err(Failure::Stopped)));
    }
}
