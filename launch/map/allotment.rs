//! Who computes which parts of a map: home takes some, worker hosts ask for others, and all bring them here, where they
//! are kept.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use density::exact::Estimated;
use density::reliability::refinement::Known;

use super::computed::Computed;
use super::parts::{Found, Parts, Place};
use super::progress::Tally;

/// The number of home's process among those of the worker hosts, which draw larger ones.
pub(super) const HOME: u64 = 0;

/// How a map has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Outcome {
    /// It is complete.
    Complete,
    /// It cannot be completed, for this reason.
    Failed(String),
    /// The user has asked to stop.
    Interrupted,
}

/// Which parts nobody has yet, which parts are with whom, and what has been brought.
#[derive(Debug)]
pub(super) struct Allotment {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    kept: Computed,
    /// How many parts are kept.
    count: usize,
    /// How many points a part has.
    points: usize,
    /// Most parts that anybody gets at a time.
    batch: usize,
    /// The parts that are needed now and not known yet.
    missing: BTreeSet<Place>,
    /// Those of them that nobody has.
    open: VecDeque<Place>,
    /// Those of them that somebody has, by the number of the process.
    given: BTreeMap<u64, Vec<Place>>,
    /// What has been found since the parts were laid out.
    found: Known,
    /// The worker hosts that are there, by the number of the process.
    present: BTreeMap<u64, String>,
    outcome: Option<Outcome>,
    tally: Arc<Tally>,
}

impl Allotment {
    /// Nothing is laid out yet; what is brought goes into `kept`.
    pub(super) fn new(kept: Computed, parts: Parts<'_>, tally: Arc<Tally>) -> Self {
        let state = State {
            count: kept.known().len(),
            kept,
            points: parts.points(),
            batch: parts.batch(),
            missing: BTreeSet::new(),
            open: VecDeque::new(),
            given: BTreeMap::new(),
            found: Known::new(),
            present: BTreeMap::new(),
            outcome: None,
            tally,
        };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Lays out the parts that are needed next.
    pub(super) fn lay_out(&self, missing: &[Place]) {
        let mut state = self.state();
        state.missing = missing.iter().copied().collect();
        state.open = missing.iter().copied().collect();
        state.given.clear();
    }

    /// The parts that home is to compute next. If there are none at this moment, it waits for those that others have.
    /// `None` when all have been brought.
    ///
    /// # Errors
    /// Why the map cannot be completed.
    pub(super) fn next_at_home(&self) -> Result<Option<Vec<Place>>, String> {
        let mut state = self.state();
        loop {
            match &state.outcome {
                Some(Outcome::Failed(why)) => return Err(why.clone()),
                Some(Outcome::Interrupted) => return Err("interrupted".into()),
                Some(Outcome::Complete) | None => {}
            }
            if state.missing.is_empty() {
                return Ok(None);
            }
            let places = state.take(HOME);
            if !places.is_empty() {
                return Ok(Some(places));
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes what a process has found for a part, and keeps it. What is there already is taken once.
    pub(super) fn bring(&self, process: u64, place: Place, found: Found) {
        self.state().bring(process, place, found);
        self.changed.notify_all();
    }

    /// Everything that has been found since the parts were laid out.
    pub(super) fn collect(&self) -> Known {
        std::mem::take(&mut self.state().found)
    }

    /// Says how the map has ended.
    pub(super) fn end(&self, outcome: Outcome) {
        self.state().outcome.get_or_insert(outcome);
    }

    /// Ends the map because the user has asked to stop, unless it has ended already; returns whether it is ended by
    /// this. What is brought from now on is still kept.
    pub(super) fn interrupt(&self) -> bool {
        let is_interrupted = *self.state().outcome.get_or_insert(Outcome::Interrupted) == Outcome::Interrupted;
        self.changed.notify_all();
        is_interrupted
    }

    /// Does something with the number of parts that are kept; none is added meanwhile.
    pub(super) fn with_count<T>(&self, act: impl FnOnce(usize) -> T) -> T {
        let state = self.state();
        act(state.count)
    }

    /// Whether a worker host is there.
    pub(super) fn is_shared(&self) -> bool {
        !self.state().present.is_empty()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// For the hosts that ask.
#[cfg_attr(not(any(test, feature = "hosts")), expect(dead_code))]
impl Allotment {
    /// The parts that a worker is to compute: those that it has and has not brought yet, or else new ones.
    pub(super) fn take(&self, process: u64) -> Vec<Place> {
        self.state().take(process)
    }

    /// How the map has ended, if it has.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        self.state().outcome.clone()
    }

    /// Notes which worker hosts are there; parts of those that are gone are given to others. Returns the names of those
    /// that have come and of those that have gone.
    pub(super) fn attend(&self, present: BTreeMap<u64, String>) -> (Vec<String>, Vec<String>) {
        let mut state = self.state();
        let without = |some: &BTreeMap<u64, String>, others: &BTreeMap<u64, String>| -> Vec<String> {
            some.iter().filter(|(process, _)| !others.contains_key(process)).map(|(_, name)| name.clone()).collect()
        };
        let (come, gone) = (without(&present, &state.present), without(&state.present, &present));
        state.tally.hosts_are(1 + present.len());
        state.present = present;
        state.give_up_the_gone();
        drop(state);
        self.changed.notify_all();
        (come, gone)
    }
}

impl State {
    fn take(&mut self, process: u64) -> Vec<Place> {
        let held = self.given.entry(process).or_default();
        held.retain(|place| self.missing.contains(place));
        if held.is_empty() {
            // Towards the end everybody gets less, so that nobody waits long for the last one.
            let share = self.open.len().div_ceil(1 + self.present.len()).min(self.batch);
            held.extend(self.open.drain(..share));
        }
        held.clone()
    }

    fn bring(&mut self, process: u64, place: Place, found: Found) {
        if let Some(held) = self.given.get_mut(&process) {
            held.retain(|&known| known != place);
        }
        if !self.missing.contains(&place) || !matches!(self.outcome, None | Some(Outcome::Interrupted)) {
            return;
        }
        match found.and_then(|numbers| self.keep(process, place, numbers)) {
            Ok(()) => {}
            Err(why) => self.outcome = Some(Outcome::Failed(why)),
        }
    }

    fn keep(&mut self, process: u64, place @ (x, y): Place, numbers: Vec<Estimated>) -> Result<(), String> {
        if numbers.len() != self.points {
            let from = self.present.get(&process).map_or("home", String::as_str);
            let (came, right) = (numbers.len(), self.points);
            return Err(format!(
                "part ({x}, {y}) of the map came from {from} with {came} points, it must have {right}"
            ));
        }
        self.kept.add(place, &numbers)?;
        self.count += 1;
        self.missing.remove(&place);
        self.open.retain(|&open| open != place);
        self.found.insert(place, numbers);
        self.tally.one_more(process != HOME);
        Ok(())
    }

    /// Takes their parts from those that are neither home nor there.
    fn give_up_the_gone(&mut self) {
        let Self { given, present, missing, open, .. } = self;
        given.retain(|process, places| {
            let is_here = *process == HOME || present.contains_key(process);
            if !is_here {
                let back = places.iter().filter(|place| missing.contains(place));
                back.for_each(|&place| open.push_front(place));
            }
            is_here
        });
    }
}

#[cfg(test)]
mod tests;
