//! The bridge of the home host: waits for the worker hosts, gives each its share, and brings home what they send.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use kit::failure::Failure;
use kit::log::{Format, Line};
use kit::newest::Newest;
use kit::screen::receive;
use kit::session::{ANY_SCENARIO, Session, has_launcher};
use messages::domain::Place;
use messages::report::Event;
use messages::topic::{Passage, Scenario, Snapshot, Status};
use zenoh::Session as Zenoh;

use super::contact::Contact;
use super::greeting::{self, Hello};
use super::landing::{ComesHome, Landing};
use super::log_stream;
use super::pull::pull;
use super::register::Register;
use super::serve::serve;
use super::session;
use super::wire::key;
use crate::endpoint::{Access, End};
use crate::plan::{HOME, HostPlan, Work};

/// Longest time between two looks at the hosts.
const LOOK: Duration = Duration::from_millis(100);

/// Carries messages until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(
    session: &Session,
    place: &Place,
    access: &Access,
    plans: BTreeMap<String, HostPlan>,
) -> Result<(), Failure> {
    let zenoh = session::open(access, End::Listens)?;
    let (joined, joins) = channel();
    let register = Register::of(plans);
    let welcome = move |hello: Hello| {
        let (plan, contact) = register.welcome(&hello)?;
        if let Some(contact) = contact {
            let _ = joined.send((hello.host, plan.clone(), contact));
        }
        Ok(Work::Run(plan))
    };
    let _greetings = greeting::receive(&zenoh, welcome)?;
    session.ready()?;
    let mut home = Home { session, place, zenoh: &zenoh, hosts: BTreeMap::new(), threads: Vec::new() };
    let end = home.look_after(&joins);
    if !has_launcher() {
        return end; // the launcher has died, and the workers are to notice that themselves
    }
    home.hosts.values().for_each(|host| host.contact.stop());
    for (name, host) in &home.hosts {
        tracing::info!(bytes = host.contact.carried(), "brought home from {name}");
    }
    home.threads.drain(..).for_each(|thread| drop(thread.join()));
    end
}

/// A worker host that has joined.
struct Host {
    plan: HostPlan,
    contact: Arc<Contact>,
    is_reported: bool,
}

type Joined = (String, HostPlan, Arc<Contact>);

struct Home<'a> {
    session: &'a Session,
    place: &'a Place,
    zenoh: &'a Zenoh,
    hosts: BTreeMap<String, Host>,
    threads: Vec<JoinHandle<()>>,
}

impl Home<'_> {
    fn look_after(&mut self, joins: &Receiver<Joined>) -> Result<(), Failure> {
        let scenarios = self.session.domain.inlet::<Scenario>()?;
        let mut newest = Newest::default();
        loop {
            if let Ok(joined) = joins.recv_timeout(LOOK) {
                self.take_in(joined)?;
            }
            while let Some(message) = receive(self.session, &scenarios)? {
                if newest.is_news(message.header().scenario) {
                    // A host that is lost is reported again, because its cases fail in this scenario, too.
                    self.hosts.values_mut().for_each(|host| host.is_reported = false);
                }
            }
            self.report_the_lost()?;
            self.session.look_up()?;
        }
    }

    /// Starts the threads that carry a host's messages.
    fn take_in(&mut self, (name, plan, contact): Joined) -> Result<(), Failure> {
        self.bring_home::<Snapshot>(&name, &plan, &contact)?;
        self.bring_home::<Passage>(&name, &plan, &contact)?;
        self.bring_home::<Status>(&name, &plan, &contact)?;
        let (zenoh, from) = (self.zenoh.clone(), key(plan.run_id, &name, log_stream::NAME));
        let (host, shared) = (name.clone(), Arc::clone(&contact));
        self.carry(&name, move || log_stream::pull(&zenoh, &from, &shared, |line| say(&host, line)));
        let (zenoh, to) = (self.zenoh.clone(), key(plan.run_id, HOME, &format!("{name}-scenario")));
        let (place, shared, run_id) = (self.place.clone(), Arc::clone(&contact), plan.run_id);
        self.carry(&name, move || serve::<Scenario>(&zenoh, &to, &place, run_id, &shared));
        self.hosts.insert(name.clone(), Host { plan, contact, is_reported: false });
        self.session.report(0, Event::Joined { host: name })
    }

    fn bring_home<T: ComesHome>(&mut self, name: &str, plan: &HostPlan, contact: &Arc<Contact>) -> Result<(), Failure> {
        let (zenoh, from) = (self.zenoh.clone(), key(plan.run_id, name, T::NAME));
        let (place, shared, host) = (self.place.clone(), Arc::clone(contact), name.to_owned());
        let (members, attempts) = (plan.members.clone(), self.session.attempt);
        self.carry(name, move || {
            let mut landing = Landing::<T>::new(&place, &host, &members, attempts)?;
            pull(&zenoh, &from, &shared, &mut landing)
        });
        Ok(())
    }

    fn carry(&mut self, host: &str, work: impl FnOnce() -> Result<(), Failure> + Send + 'static) {
        let host = host.to_owned();
        self.threads.push(spawn(move || {
            if let Err(failure) = work() {
                tracing::error!("host {host}: {failure}");
            }
        }));
    }

    /// Reports that the cases of hosts that are gone have failed in the scenario under way.
    fn report_the_lost(&mut self) -> Result<(), Failure> {
        for (name, host) in &mut self.hosts {
            if host.is_reported || !host.contact.is_gone() {
                continue;
            }
            host.is_reported = true;
            host.contact.stop();
            let why = match host.contact.has_ended() {
                true => format!("host {name} has left the run"),
                false => {
                    format!("host {name} is lost: nothing heard for {:.1} s", host.contact.silence().as_secs_f64())
                }
            };
            for member in &host.plan.members {
                self.session.case_failed(ANY_SCENARIO, &member.label, &format!("{} was there: {why}", member.name))?;
            }
        }
        Ok(())
    }
}

/// Prints a line of a worker host's log at home.
fn say(host: &str, line: &str) {
    let Ok(mut line) = serde_json::from_str::<Line>(line) else { return };
    line.node = format!("{}@{host}", line.node);
    let _ = writeln!(std::io::stderr(), "{}", line.to_text(Format::Json));
}
