//! Home's end: questions of worker hosts are answered for as long as a map is computed.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use kit::failure::Failure;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use super::super::greeting::{self, Hello, parse, text};
use super::super::register::Register;
use super::super::session::{self, refused};
use super::{Answer, KEY, Question};
use crate::endpoint::{Access, End};
use crate::plan::{MapPlan, Work};

/// Time between two looks at who is there.
const LOOK: Duration = Duration::from_millis(200);
/// How long home waits for workers to hear that the map has ended; they ask every half second.
const LAST_WORDS: Duration = Duration::from_secs(3);

/// Who decides which worker gets which parts.
pub trait Dealer: Send + Sync {
    /// Takes what a worker has brought, and answers its question.
    fn answer(&self, question: Question) -> Answer;

    /// Is told again and again which processes are there, with the names of their hosts.
    fn attend(&self, present: BTreeMap<u64, String>);

    /// Is told why a host was not let in.
    fn refused(&self, why: &str);
}

/// Worker hosts are welcomed and their questions answered until this ends.
pub struct Dealing {
    register: Arc<Register<MapPlan>>,
    is_over: Arc<AtomicBool>,
    attendant: JoinHandle<()>,
    _greetings: Queryable<()>,
    _questions: Queryable<()>,
    // The session is closed last: fields are dropped in this order.
    _zenoh: Session,
}

impl Dealing {
    /// Listens for the hosts with these names, which contribute to the map of `plan`.
    ///
    /// # Errors
    /// [`Failure::Refused`] if the endpoint cannot be used.
    pub fn open(access: &Access, names: &[String], plan: &MapPlan, dealer: Arc<dyn Dealer>) -> Result<Self, Failure> {
        let zenoh = session::open(access, End::Listens)?;
        let plans: BTreeMap<String, MapPlan> = names.iter().map(|name| (name.clone(), plan.clone())).collect();
        let register = Arc::new(Register::of(plans));
        let questions = receive(&zenoh, plan.map_id, Arc::clone(&register), Arc::clone(&dealer))?;
        let (known, told) = (Arc::clone(&register), Arc::clone(&dealer));
        let welcome = move |hello: Hello| match known.welcome(&hello) {
            Ok((plan, _)) => Ok(Work::Map(plan)),
            Err(why) => {
                told.refused(&why);
                Err(why)
            }
        };
        let greetings = greeting::receive(&zenoh, welcome)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let attendant = attend(Arc::clone(&register), dealer, Arc::clone(&is_over));
        Ok(Self { register, is_over, attendant, _greetings: greetings, _questions: questions, _zenoh: zenoh })
    }

    /// Waits until all workers have left, which they do when they are told that the map has ended, but not for long.
    pub fn end(self) {
        let start = Instant::now();
        while !self.register.alive().is_empty() && start.elapsed() < LAST_WORDS {
            sleep(LOOK / 10);
        }
        self.is_over.store(true, Ordering::Relaxed);
        // The attendant has no say in whether the map is complete.
        let _ = self.attendant.join();
    }
}

/// Answers the questions about the map with this number.
fn receive(
    zenoh: &Session,
    map_id: u64,
    register: Arc<Register<MapPlan>>,
    dealer: Arc<dyn Dealer>,
) -> Result<Queryable<()>, Failure> {
    let answer = move |query: Query| {
        let said = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let answered = parse::<Question>(&said).map(|question| answer(map_id, &register, &*dealer, question));
        let sent = match answered.and_then(|answer| text(&answer)) {
            Ok(answer) => query.reply(KEY, answer).wait(),
            Err(why) => query.reply_err(why.to_string()).wait(),
        };
        if let Err(error) = sent {
            tracing::debug!("a question about the map was not answered: {error}");
        }
    };
    zenoh.declare_queryable(KEY).callback(answer).wait().map_err(|e| refused(&e))
}

fn answer(map_id: u64, register: &Register<MapPlan>, dealer: &dyn Dealer, question: Question) -> Answer {
    let contact = register.contact(question.process).filter(|_| question.map_id == map_id);
    let Some(contact) = contact else { return Answer::Stranger };
    contact.hear();
    let is_leaving = question.is_leaving;
    let answer = dealer.answer(question);
    if is_leaving {
        contact.end();
    }
    answer
}

/// Tells the dealer who is there, until all is over.
fn attend(register: Arc<Register<MapPlan>>, dealer: Arc<dyn Dealer>, is_over: Arc<AtomicBool>) -> JoinHandle<()> {
    spawn(move || {
        while !is_over.load(Ordering::Relaxed) {
            dealer.attend(register.alive());
            sleep(LOOK);
        }
    })
}
