//! The bridge of a worker host: brings scenarios in and sends out the messages of the propagators.

use std::path::Path;
use std::sync::Arc;
use std::thread::spawn;
use std::time::Duration;

use kit::failure::Failure;
use kit::newest::Newest;
use kit::screen::Screened;
use kit::session::Session;
use messages::domain::{Domain, Place};
use messages::port::{Draft, Outlet};
use messages::scenario::ScenarioHeader;
use messages::service::Service;
use messages::topic::{Passage, Scenario, Snapshot, Status};
use messages::wait::Awaited;
use zenoh::Session as Zenoh;

use super::contact::Contact;
use super::greeting::{Hello, greet};
use super::log_stream;
use super::pull::{Sink, pull};
use super::serve::serve;
use super::session;
use super::wire::key;
use crate::endpoint::{Access, End};
use crate::plan::HOME;

/// Pause between two greetings to home.
const GREETINGS: Duration = Duration::from_millis(500);
/// Time between two looks whether home is still there.
const LOOK: Duration = Duration::from_millis(100);

/// Carries messages of the host that says `hello` until the run at home has ended, or asked to stop. `log` is the file
/// with the host's log.
///
/// # Errors
/// [`Failure::Refused`] if home is lost.
pub fn run(session: &Session, place: &Place, access: &Access, hello: &Hello, log: &Path) -> Result<(), Failure> {
    let zenoh = session::open(access, End::Connects)?;
    let host = hello.host.as_str();
    let contact = Arc::new(Contact::with_home());
    let carrier = Carrier { zenoh: &zenoh, place, run_id: session.run_id, host, contact: &contact };
    let mut threads = vec![carrier.send_out::<Snapshot>(), carrier.send_out::<Passage>(), carrier.send_out::<Status>()];
    let (own, from, log) = (zenoh.clone(), key(session.run_id, host, log_stream::NAME), log.to_owned());
    let shared = Arc::clone(&contact);
    threads.push(spawn(move || log_stream::serve(&own, &from, &log, &shared)));
    let (own, from) = (zenoh.clone(), key(session.run_id, HOME, &format!("{host}-scenario")));
    let (shared, own_place) = (Arc::clone(&contact), place.clone());
    threads.push(spawn(move || pull(&own, &from, &shared, &mut Arrivals::new(&own_place)?)));
    let (own, shared, hello) = (zenoh.clone(), Arc::clone(&contact), hello.clone());
    let greeter = spawn(move || go_on_greeting(&own, &hello, &shared));
    session.ready()?;
    let is_broken = || threads.iter().chain([&greeter]).any(|thread| thread.is_finished());
    let end = look_after(session, &contact, is_broken);
    contact.stop();
    // The greeter may be waiting for an answer; nobody waits for it.
    let last = threads.into_iter().chain([greeter].into_iter().filter(|greeter| greeter.is_finished()));
    let ends: Vec<Result<(), Failure>> = last.filter_map(|thread| thread.join().ok()).collect();
    end.and(ends.into_iter().collect())
}

/// Greets home again and again, because a bridge at home that has been restarted knows no host.
fn go_on_greeting(zenoh: &Zenoh, hello: &Hello, contact: &Contact) -> Result<(), Failure> {
    while !contact.is_to_stop() && !contact.has_ended() {
        if greet(zenoh, hello)?.is_some() {
            contact.hear();
        }
        std::thread::sleep(GREETINGS);
    }
    Ok(())
}

fn look_after(session: &Session, contact: &Contact, is_broken: impl Fn() -> bool) -> Result<(), Failure> {
    loop {
        std::thread::sleep(LOOK);
        if contact.has_ended() {
            return Ok(());
        }
        if contact.is_lost() {
            let seconds = contact.silence().as_secs_f64();
            return Err(Failure::Refused(format!("the home host is lost: nothing heard for {seconds:.1} s")));
        }
        if is_broken() {
            return Ok(()); // the thread returns its failure
        }
        session.look_up()?;
    }
}

struct Carrier<'a> {
    zenoh: &'a Zenoh,
    place: &'a Place,
    run_id: u64,
    host: &'a str,
    contact: &'a Arc<Contact>,
}

impl Carrier<'_> {
    fn send_out<T: Screened>(&self) -> std::thread::JoinHandle<Result<(), Failure>> {
        let (zenoh, place, run_id) = (self.zenoh.clone(), self.place.clone(), self.run_id);
        let (to, contact) = (key(run_id, self.host, T::NAME), Arc::clone(self.contact));
        spawn(move || serve::<T>(&zenoh, &to, &place, run_id, &contact))
    }
}

/// The way into the local domain for scenarios.
struct Arrivals {
    domain: Domain,
    outlet: Option<Outlet<Scenario>>,
    newest: Newest,
}

impl Arrivals {
    fn new(place: &Place) -> Result<Self, Failure> {
        Ok(Self { domain: Domain::enter(place, Service::Bridge.name())?, outlet: None, newest: Newest::default() })
    }
}

impl Sink<Scenario> for Arrivals {
    fn room(&mut self, header: &ScenarioHeader, items: usize) -> Result<Option<Draft<Scenario>>, Failure> {
        if !self.newest.is_news(header.scenario) {
            return Ok(None);
        }
        // Only the last scenario counts, so the outlet is made anew for it.
        drop(self.outlet.take());
        Ok(Some(self.outlet.insert(self.domain.outlet(items)?).draft(items)?))
    }

    fn deliver(&mut self, header: ScenarioHeader, draft: Draft<Scenario>) -> Result<(), Failure> {
        match &self.outlet {
            Some(outlet) => Ok(outlet.send(draft, header)?),
            None => Ok(()),
        }
    }

    fn idle(&mut self) {
        self.outlet.iter().for_each(Awaited::attend);
    }
}
