//! What the processes report: signs of life, work done, failures, and the end of a scenario.

use std::time::Instant;

use kit::screen::{Refusal, screen};
use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::service::Service;
use messages::text::unpack;
use messages::topic::{Status, Topic};

use super::{Abort, Run};

impl Run<'_> {
    /// Takes in the reports that have arrived.
    pub(super) fn take_reports(&mut self) -> Result<(), Abort> {
        while let Some(report) = self.topics.reports.receive()? {
            if let Err(Refusal { sender, why }) = screen(self.commands.run_id, &report) {
                drop(report);
                self.blame(&sender, why)?;
                continue;
            }
            let sender = unpack(&report.header().node);
            let decoded = Report::from_parts(report.header(), report.items());
            drop(report);
            match decoded {
                Ok(report) => self.take_report(report)?,
                Err(why) => self.blame(&sender, format!("a message on {}: {why}", Status::NAME))?,
            }
        }
        Ok(())
    }

    pub(super) fn take_report(&mut self, report: Report) -> Result<(), Abort> {
        if self.course.is_early(&report) {
            self.course.keep_early(report);
            return Ok(());
        }
        let is_current = report.scenario == self.course.scenario;
        self.note_sign_of_life(&report, is_current);
        if !matches!(report.event, Event::Failed { .. }) {
            self.view.report(&report, false);
        }
        let Report { from, scenario, event } = report;
        match (event, from.service()) {
            (Event::Joined { host }, Some(Service::Bridge)) => self.take_in(&host),
            (Event::Ready, _) => self.note_when_all_are_ready(),
            (Event::WaitsFor { case, what, .. }, Some(service)) if is_current && self.is_case(&case) => {
                self.course.awaited.insert(service.name().to_owned(), (case, what));
            }
            (Event::Progress { done, .. }, Some(Service::Estimator)) if is_current => self.course.estimated = done,
            (Event::Done, Some(Service::Comparator)) if is_current => self.course.compared = true,
            (Event::Done, Some(Service::Recorder)) if is_current => self.begin_next_scenario()?,
            (Event::Total, Some(Service::Scenario)) => self.course.in_all = Some(scenario),
            (Event::Refused { name, why, .. }, Some(Service::Scenario)) => self.name_stranger(name, why),
            (Event::Failed { of, why }, _) => self.take_failure(&from, scenario, &of, why)?,
            _ => {}
        }
        Ok(())
    }

    /// Notes that a process lives, and whether it owes work.
    fn note_sign_of_life(&mut self, report: &Report, is_current: bool) {
        let Some(member) = self.processes.members.get_mut(&report.from.to_string()) else { return };
        member.heard = Instant::now();
        match report.event {
            Event::Ready | Event::Joined { .. } => member.ready = true,
            Event::Progress { done, of } if is_current => member.is_at_work(done < of),
            Event::WaitsFor { .. } | Event::Done if is_current => member.is_at_work(false),
            _ => {}
        }
    }

    /// Deals with a report that a case cannot be completed, from the case itself or from another node.
    fn take_failure(&mut self, from: &Reporter, scenario: u32, of: &Reporter, why: String) -> Result<(), Abort> {
        let speaks_of_itself = from == of;
        let is_of_a_case = self.is_case(from.label());
        if scenario < self.course.scenario {
            // What was wrong with a case in a scenario that is already recorded does not matter.
            let matters = !speaks_of_itself && !is_of_a_case && !self.is_case(of.label());
            return if matters { self.blame(&of.to_string(), why) } else { Ok(()) };
        }
        // A case can report only its own failure.
        if speaks_of_itself || is_of_a_case {
            self.fail(&from.to_string(), why)
        } else {
            self.blame(&of.to_string(), why)
        }
    }
}
