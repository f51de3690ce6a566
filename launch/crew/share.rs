//! A worker host's share of a run: its processes in a domain of their own, and the bridge that joins it to home.

use std::collections::BTreeMap;
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

use bridge::endpoint::Access;
use bridge::greeting::Hello;
use bridge::plan::{BridgeRole, HostPlan, Program, Share};
use kit::session::ANY_SCENARIO;
use kit::shard::Shard;
use messages::domain::{HeldDomain, Place};
use messages::port::{Inlet, Outlet, PortError};
use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::service::Service;
use messages::topic::{Capacity, Scenario, Status};
use messages::wait::Signals;

use crate::crew::commands::{Identity, Part, own_command, own_program};
use crate::crew::log_sink::{LogSink, start_log};
use crate::crew::member::Member;
use crate::crew::processes::{Processes, Sequel};
use crate::crew::report_line::describe;
use crate::crew::shares;
use crate::crew::supervisor::{Ended, Supervisor};
use crate::domain::{self, OwnDomain};
use crate::shown::{Logged, Shown};

/// The processes are looked after at least this often.
const TICK: Duration = Duration::from_millis(500);

/// Why the work has ended.
pub enum Ending {
    /// The run at home has ended.
    Over,
    /// The user asked to stop.
    Interrupted,
}

/// Does the work of `plan` until the run ends.
///
/// # Errors
/// Why it cannot go on.
pub fn work(
    plan: &HostPlan,
    access: &Access,
    hello: &Hello,
    signals: &Signals,
    (shown, logged): (Shown, Logged),
) -> Result<Ending, String> {
    domain::sweep();
    // The domain has a number of its own, because home's domain may be on the same machine.
    let own = OwnDomain::claim(domain::fresh_run_id())?;
    let log = start_log(&own.place.root, plan.run_id, shown, logged)?;
    let (host, process) = (hello.host.clone(), hello.process);
    let bridge_role = BridgeRole::Worker { access: access.clone(), host, process, log: log.path().to_owned() };
    let bridge_role = shares::write(&own.place.root, &bridge_role)?;
    let capacity = Capacity { propagators: plan.propagators, cases: plan.cases, snapshots: plan.snapshots, hosts: 1 };
    let ending = {
        let mut workshop = Workshop::open(plan, &own.place, &capacity, &log, shown).map_err(|e| e.to_string())?;
        workshop.bridge.extend(["--bridge-role".into(), bridge_role.display().to_string()]);
        workshop.work(signals)
    };
    // The results are at home, and home notices if a part of the log has not arrived.
    let _ = log.close();
    ending
}

struct Workshop<'a> {
    plan: &'a HostPlan,
    place: &'a Place,
    bridge: Vec<String>,
    // Processes end before the domain is closed: fields are dropped in this order.
    processes: Processes,
    reports: Inlet<Status>,
    scenarios: Inlet<Scenario>,
    own_reports: Outlet<Status>,
    domain: HeldDomain,
    shown: Shown,
    /// What went wrong last according to a process itself, by its name.
    last_words: BTreeMap<String, String>,
}

impl<'a> Workshop<'a> {
    fn open(
        plan: &'a HostPlan,
        place: &'a Place,
        capacity: &Capacity,
        log: &LogSink,
        shown: Shown,
    ) -> Result<Self, PortError> {
        let domain = HeldDomain::create(place, capacity)?;
        let of_shares = plan.members.iter().map(process);
        let processes = of_shares.chain([Reporter::Service(Service::Bridge)]);
        Ok(Self {
            plan,
            place,
            bridge: Vec::new(),
            processes: Processes::new(
                Supervisor::new(log.clone()),
                processes.map(|who| (who.to_string(), Member::new(who, Instant::now()))).collect(),
                plan.restart,
            ),
            reports: domain.domain.inlet()?,
            scenarios: domain.domain.inlet()?,
            own_reports: domain.domain.outlet(2)?,
            domain,
            shown,
            last_words: BTreeMap::new(),
        })
    }

    fn work(&mut self, signals: &Signals) -> Result<Ending, String> {
        loop {
            self.start_what_is_due()?;
            let due = self.processes.next_due();
            let sleep = due.map_or(TICK, |due| due.saturating_duration_since(Instant::now()).min(TICK));
            let ports: [&dyn messages::wait::Awaited; 3] = [&self.reports, &self.scenarios, &self.own_reports];
            signals.wait(&ports, sleep).map_err(|e| e.to_string())?;
            if signals.stop_requested() {
                return Ok(Ending::Interrupted);
            }
            let ended = self.processes.supervisor.newly_ended();
            // The reports that a process sent before it ended say more than how it ended.
            self.listen().map_err(|e| e.to_string())?;
            for Ended { name, status } in ended {
                if let Some(ending) = self.deal_with_end(&name, status)? {
                    return Ok(ending);
                }
            }
        }
    }

    fn is_bridge(&self, name: &str) -> bool {
        self.processes.members.get(name).is_some_and(|member| member.who.is(Service::Bridge))
    }

    fn start_what_is_due(&mut self) -> Result<(), String> {
        let (plan, place, bridge) = (self.plan, self.place, &self.bridge);
        let start = |name: &str, attempt| command(plan, place, bridge, name, attempt);
        let failed = self.processes.start_what_is_due(|_| true, start);
        failed
            .into_iter()
            .try_for_each(|(name, why)| if self.is_bridge(&name) { Err(why) } else { self.fail(&name, &why) })
    }

    /// Prints what the processes report, and allows them their restarts again when a scenario begins.
    fn listen(&mut self) -> Result<(), PortError> {
        while let Some(report) = self.reports.receive()? {
            let Ok(report) = Report::from_parts(report.header(), report.items()) else { continue };
            if report.event != Event::Ready && !self.shown.quiet {
                remark!("{}", describe(&report));
            }
            if let Event::Failed { why, .. } = report.event {
                self.last_words.insert(report.from.to_string(), why);
            }
        }
        while self.scenarios.receive()?.is_some() {
            self.processes.begin_scenario();
            self.last_words.clear();
        }
        Ok(())
    }

    /// Starts a process that has ended again if that may help, and otherwise tells home. Returns how the work ends if
    /// the process was the bridge.
    fn deal_with_end(&mut self, name: &str, status: ExitStatus) -> Result<Option<Ending>, String> {
        self.processes.clean_up_after(name, &self.domain);
        if self.is_bridge(name) {
            match status.code() {
                Some(0) => return Ok(Some(Ending::Over)),
                Some(_) => return Err("the bridge has ended; its last line above says why".into()),
                None => {} // it was killed, and is started again if restarts are allowed
            }
        }
        match self.processes.after_end(name, status, false) {
            Sequel::Nothing | Sequel::Restart => {}
            Sequel::Loss(why) if self.is_bridge(name) => return Err(format!("the bridge: {why}")),
            // Home may not have read the report of a process that is gone.
            Sequel::Loss(why) => {
                let why = self.last_words.remove(name).unwrap_or(why);
                self.fail(name, &why)?;
            }
        }
        Ok(None)
    }

    /// Tells home that a process cannot do its share.
    fn fail(&self, name: &str, why: &str) -> Result<(), String> {
        tracing::warn!("{name}: {why}");
        let Some(from) = self.processes.members.get(name).map(|member| member.who.clone()) else { return Ok(()) };
        let event = Event::Failed { of: Reporter::case(from.label()), why: why.into() };
        let report = Report { from, scenario: ANY_SCENARIO, event };
        let (header, units) = report.to_parts(self.plan.run_id);
        self.own_reports.send_items(header, &units).map_err(|e| e.to_string())
    }
}

/// The process that does a share.
fn process(share: &Share) -> Reporter {
    let (index, count) = share.shard;
    Shard { index, count }.process_of(&share.label)
}

/// The command that starts the process `name`, which is the bridge unless the plan lists it.
fn command(plan: &HostPlan, place: &Place, bridge: &[String], name: &str, attempt: u32) -> Result<Command, String> {
    let share = plan.members.iter().find(|share| share.name == name);
    let mut command = match share.map(|share| &share.program) {
        Some(Program::BuiltIn { node, settings }) => {
            let mut command = own_command(node)?;
            command.args(settings.iter().flat_map(|line| ["--set", line.as_str()]));
            command
        }
        Some(Program::Command(words)) => {
            let mut command = own_program()?;
            command.args(["guard", "--"]).args(words);
            command
        }
        None => {
            let mut command = own_command(Service::Bridge.name())?;
            command.args(bridge);
            command
        }
    };
    let part = share.map(|Share { label, shard: (index, count), reduce, .. }| Part {
        label,
        shard: Shard { index: *index, count: *count },
        reduce: *reduce,
    });
    Identity { place, run_id: plan.run_id, name, part, attempt }.give(&mut command);
    Ok(command)
}
