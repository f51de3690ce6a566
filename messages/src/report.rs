//! The report of a node on `phasecloud/status`, as a value. Only this file encodes and decodes it.

use crate::layout::{StatusHeader, event};
use crate::reporter::{Reporter, UnknownRole};
use crate::service::Service;
use crate::text::{pack, unpack};

/// A report of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// Who reports.
    pub from: Reporter,
    /// Position in the run of the scenario that it is about.
    pub scenario: u32,
    /// What has happened.
    pub event: Event,
}

/// What has happened to a node or by it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// The node has opened its topics and waits for work.
    Ready,
    /// The scenario node has published a scenario.
    Accepted {
        /// The scenario's name.
        name: String,
        /// Number of scenarios in the run; `None` if it is not known, as in a service.
        of: Option<u32>,
        /// The number of the request that asked for it, if one did.
        request: Option<u32>,
    },
    /// The scenario node cannot publish a scenario.
    Refused {
        /// The scenario's name.
        name: String,
        /// Why.
        why: String,
        /// The number of the request that asked for it, if one did.
        request: Option<u32>,
    },
    /// The node works.
    Progress {
        /// Units of work done.
        done: u64,
        /// Units of work in total; 0 if the node does not know.
        of: u64,
    },
    /// The node cannot go on before a case has sent something.
    WaitsFor {
        /// The label of the case.
        case: String,
        /// What is waited for.
        what: String,
        /// Units of work done.
        done: u64,
    },
    /// The node has finished the scenario.
    Done,
    /// A case, or the work of a process, cannot be completed.
    Failed {
        /// The process that cannot go on, or the case as a whole: the one that reports, or one that it complains of.
        of: Reporter,
        /// Why.
        why: String,
    },
    /// A host takes part from now on.
    Joined {
        /// The host's name.
        host: String,
    },
    /// The scenario before the one that the report names was the last of the run.
    Total,
}

/// A report with a code that this version does not know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum UnknownCode {
    /// Its event is unknown.
    #[error("its event is {0}, which no node reports")]
    Event(u32),
    /// Its sender or its subject is unknown.
    #[error(transparent)]
    Role(#[from] UnknownRole),
}

impl Event {
    /// Its code in [`event`].
    pub fn code(&self) -> u32 {
        match self {
            Self::Ready => event::READY,
            Self::Accepted { .. } => event::ACCEPTED,
            Self::Refused { .. } => event::REFUSED,
            Self::Progress { .. } => event::PROGRESS,
            Self::WaitsFor { .. } => event::WAITS_FOR,
            Self::Done => event::DONE,
            Self::Failed { .. } => event::FAILED,
            Self::Joined { .. } => event::JOINED,
            Self::Total => event::TOTAL,
        }
    }

    /// The subject of the event, and its text; empty where it has none.
    fn words(&self) -> (&str, &str) {
        match self {
            Self::Accepted { name, .. } => (name, ""),
            Self::Refused { name, why, .. } => (name, why),
            Self::WaitsFor { case, what, .. } => (case, what),
            Self::Failed { of, why } => (of.label(), why),
            Self::Joined { host } => (host, ""),
            Self::Ready | Self::Progress { .. } | Self::Done | Self::Total => ("", ""),
        }
    }

    /// The two numbers of the payload: for most events the units of work done and the units in total.
    fn units(&self) -> [f64; 2] {
        match self {
            Self::Progress { done, of } => [*done as f64, *of as f64],
            Self::WaitsFor { done, .. } => [*done as f64; 2],
            Self::Accepted { of, request, .. } => [f64::from(request.unwrap_or(0)), f64::from(of.unwrap_or(0))],
            Self::Refused { request, .. } => [f64::from(request.unwrap_or(0)), 0.0],
            Self::Ready | Self::Done | Self::Failed { .. } | Self::Joined { .. } | Self::Total => [0.0; 2],
        }
    }
}

impl Report {
    /// Whether it says that the recorder has written the scenario, which ends the scenario for all nodes.
    pub fn is_end_of(&self, scenario: u32) -> bool {
        self.event == Event::Done && self.scenario == scenario && self.from.is(Service::Recorder)
    }

    /// The message in the run `run_id`.
    pub fn to_parts(&self, run_id: u64) -> (StatusHeader, [f64; 2]) {
        let (subject, text) = self.event.words();
        let (role, shard) = self.from.codes();
        let (subject_role, subject_shard) = match &self.event {
            Event::Failed { of, .. } => of.codes(),
            _ => (0, 0),
        };
        let header = StatusHeader {
            run_id,
            event: self.event.code(),
            scenario: self.scenario,
            role,
            shard,
            subject_role,
            subject_shard,
            node: pack(self.from.label()),
            subject: pack(subject),
            text: pack(text),
        };
        (header, self.event.units())
    }

    /// Decodes a message; units that are missing count as zero.
    ///
    /// # Errors
    /// [`UnknownCode`].
    pub fn from_parts(header: &StatusHeader, units: &[f64]) -> Result<Self, UnknownCode> {
        // The cast saturates, and makes zero of NaN.
        let unit = |place: usize| units.get(place).map_or(0, |&unit| unit as u64);
        let number = |place: usize| u32::try_from(unit(place)).ok().filter(|&number| number > 0);
        let (subject, text) = (unpack(&header.subject), unpack(&header.text));
        let event = match header.event {
            event::READY => Event::Ready,
            event::ACCEPTED => Event::Accepted { name: subject, of: number(1), request: number(0) },
            event::REFUSED => Event::Refused { name: subject, why: text, request: number(0) },
            event::PROGRESS => Event::Progress { done: unit(0), of: unit(1) },
            event::WAITS_FOR => Event::WaitsFor { case: subject, what: text, done: unit(0) },
            event::DONE => Event::Done,
            event::FAILED => {
                let of = Reporter::from_parts(header.subject_role, header.subject_shard, &header.subject)?;
                Event::Failed { of, why: text }
            }
            event::JOINED => Event::Joined { host: subject },
            event::TOTAL => Event::Total,
            unknown => return Err(UnknownCode::Event(unknown)),
        };
        Ok(Self { from: Self::sender(header)?, scenario: header.scenario, event })
    }

    /// Who sends a message.
    ///
    /// # Errors
    /// [`UnknownRole`].
    pub fn sender(header: &StatusHeader) -> Result<Reporter, UnknownRole> {
        Reporter::from_parts(header.role, header.shard, &header.node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_report_is_read_as_it_was_written() {
        let text = |text: &str| text.to_owned();
        for event in [
            Event::Ready,
            Event::Accepted { name: text("s"), of: Some(3), request: None },
            Event::Accepted { name: text("s"), of: None, request: Some(u32::MAX) },
            Event::Refused { name: text("s"), why: text("no"), request: Some(1) },
            Event::Progress { done: 2, of: 5 },
            Event::WaitsFor { case: text("mc"), what: text("its snapshots"), done: 4 },
            Event::Done,
            Event::Failed { of: Reporter::shard("mc", 1), why: text("lost") },
            Event::Joined { host: text("worker-a") },
            Event::Total,
        ] {
            let report = Report { from: Reporter::Service(Service::Estimator), scenario: 7, event };
            let (header, units) = report.to_parts(1);
            assert_eq!(Report::from_parts(&header, &units), Ok(report));
        }
    }

    #[test]
    fn an_unknown_event_is_an_error_and_units_that_are_no_counts_are_zero() {
        let header = StatusHeader { event: 77, ..StatusHeader::default() };
        assert_eq!(Report::from_parts(&header, &[]), Err(UnknownCode::Event(77)));
        let header = StatusHeader { event: event::DONE, role: 99, ..StatusHeader::default() };
        assert!(matches!(Report::from_parts(&header, &[]), Err(UnknownCode::Role(_))));
        let header = StatusHeader { event: event::PROGRESS, ..StatusHeader::default() };
        for units in [&[][..], &[f64::NAN, -1.0]] {
            assert_eq!(Report::from_parts(&header, units).unwrap().event, Event::Progress { done: 0, of: 0 });
        }
    }
}
