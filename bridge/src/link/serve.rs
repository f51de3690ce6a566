//! The sender of a stream: answers a reader's questions out of the local domain.
//!
//! One message is held at a time, where it lies in shared memory; the others wait in the topic. A new reader gets all
//! that the publishers still keep, as any reader does that comes late.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::time::{Duration, Instant};

use bytemuck::{bytes_of, cast_slice};
use kit::failure::Failure;
use kit::screen::{Refusal, Screened, screen};
use messages::domain::{Domain, Place};
use messages::port::{Inlet, Message};
use messages::service::Service;
use messages::topic::Topic;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use super::contact::Contact;
use super::session::refused;
use super::wire::{self, Answer, Ask, PIECE, Piece};

/// How long a question waits for a message before it is answered that there is none.
const LONGEST_WAIT: Duration = Duration::from_millis(800);
/// How long the thread waits for a question before it looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(100);
/// How long a sender that ends waits for a question of the reader, so that it can answer that it ends.
const LAST_WORDS: Duration = Duration::from_millis(600);

/// A random number other than 0.
pub(crate) fn draw() -> u64 {
    RandomState::new().hash_one(0) | 1
}

/// The questions that come for `key`.
///
/// # Errors
/// [`Failure::Refused`] if zenoh refuses.
pub(crate) fn questions(zenoh: &Session, key: &str) -> Result<Queryable<FifoChannelHandler<Query>>, Failure> {
    zenoh.declare_queryable(key.to_owned()).with(FifoChannel::new(64)).wait().map_err(|e| refused(&e))
}

/// Answers a question with a piece; a reader that is gone will ask again.
pub(crate) fn answer(query: &Query, piece: Piece, bytes: &[u8]) {
    let reply = query.reply(query.key_expr(), bytes).attachment(bytes_of(&piece));
    if let Err(error) = reply.wait() {
        tracing::debug!("an answer did not get through: {error}");
    }
}

/// Serves the messages of topic `T` in the domain at `place` under `key`, until `contact` is told to stop.
///
/// # Errors
/// [`Failure::Port`] if the topic cannot be read, [`Failure::Refused`] if zenoh refuses.
pub fn serve<T: Screened>(
    zenoh: &Session,
    key: &str,
    place: &Place,
    run_id: u64,
    contact: &Contact,
) -> Result<(), Failure> {
    let questions = questions(zenoh, key)?;
    let mut stream = Stream::<T>::open(Domain::enter(place, Service::Bridge.name())?, run_id)?;
    let mut stopped: Option<Instant> = None;
    loop {
        if contact.is_to_stop() {
            let since = *stopped.get_or_insert_with(Instant::now);
            if since.elapsed() > LAST_WORDS || contact.is_gone() {
                return Ok(());
            }
        }
        let Ok(Some(mut question)) = questions.recv_timeout(LOOK) else { continue };
        while let Ok(Some(newer)) = questions.try_recv() {
            question = newer; // the reader has given up on the older ones
        }
        let Some(ask) = question.payload().and_then(|payload| wire::read::<Ask>(&payload.to_bytes())) else { continue };
        if stopped.is_some() {
            answer(&question, stream.piece(ask, Answer::End), &[]);
            return Ok(());
        }
        stream.answer(&question, ask, || contact.is_to_stop() || !questions.is_empty())?;
    }
}

/// The state of a sender's stream.
struct Stream<T: Topic> {
    domain: Domain,
    inlet: Inlet<T>,
    run_id: u64,
    reader: u64,
    epoch: u64,
    /// Number of the next message to be taken.
    next: u64,
    held: Option<Message<T>>,
}

impl<T: Screened> Stream<T> {
    fn open(domain: Domain, run_id: u64) -> Result<Self, Failure> {
        let inlet = domain.inlet()?;
        Ok(Self { domain, inlet, run_id, reader: 0, epoch: draw(), next: 0, held: None })
    }

    fn piece(&self, ask: Ask, answer: Answer) -> Piece {
        Piece { epoch: self.epoch, sequence: ask.sequence, offset: ask.offset, total: 0, kind: answer.code() }
    }

    /// Answers with the rest of the message asked for, piece by piece; stops when `is_void` becomes true.
    fn answer(&mut self, question: &zenoh::query::Query, ask: Ask, is_void: impl Fn() -> bool) -> Result<(), Failure> {
        let mut ask = ask;
        if !self.continues(ask) {
            self.begin(ask.reader)?;
            ask = Ask { sequence: 0, offset: 0, ..ask };
        }
        if ask.sequence == self.next {
            self.held = None;
            self.held = self.await_message(&is_void)?;
            self.next += u64::from(self.held.is_some());
        }
        let Some(message) = &self.held else {
            answer(question, self.piece(ask, Answer::Nothing), &[]);
            return Ok(());
        };
        let (head, body): (&[u8], &[u8]) = (bytes_of(message.header()), cast_slice(message.items()));
        let total = head.len() + body.len();
        let mut offset = ask.offset as usize;
        while offset < total && !is_void() {
            let bytes = span(head, body, offset);
            let place = Piece { offset: offset as u64, total: total as u64, ..self.piece(ask, Answer::Piece) };
            answer(question, place, &bytes);
            offset += bytes.len();
        }
        Ok(())
    }

    /// Whether a question is from the present reader, in the present epoch, and about the message held or the next one.
    fn continues(&self, ask: Ask) -> bool {
        let holds = self.held.is_some() && ask.sequence + 1 == self.next;
        ask.reader == self.reader && ask.epoch == self.epoch && (holds || ask.sequence == self.next)
    }

    /// Counts anew for a new reader, from the oldest message that is still kept.
    fn begin(&mut self, reader: u64) -> Result<(), Failure> {
        self.held = None;
        self.inlet = self.domain.inlet()?;
        (self.reader, self.epoch, self.next) = (reader, draw(), 0);
        Ok(())
    }

    fn await_message(&self, is_void: impl Fn() -> bool) -> Result<Option<Message<T>>, Failure> {
        let asked = Instant::now();
        loop {
            while let Some(message) = self.inlet.receive()? {
                match screen(self.run_id, &message) {
                    Ok(()) => return Ok(Some(message)),
                    Err(Refusal { sender, why }) => tracing::warn!("{sender}: {why}; it is not sent on"),
                }
            }
            if is_void() || asked.elapsed() > LONGEST_WAIT {
                return Ok(None);
            }
            self.inlet.wait(LOOK)?;
        }
    }
}

/// The piece of head and body together that starts at `offset`.
fn span(head: &[u8], body: &[u8], offset: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PIECE.min(head.len() + body.len() - offset));
    bytes.extend_from_slice(head.get(offset..).unwrap_or(&[]));
    let from = offset.saturating_sub(head.len());
    let until = body.len().min(from + PIECE - bytes.len());
    bytes.extend_from_slice(&body[from..until]);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_from_any_offset_make_the_whole() {
        let (head, body) = (vec![1u8; 112], vec![2u8; PIECE + 1000]);
        let whole = [head.clone(), body.clone()].concat();
        for start in [0, 1, 111, 112, 113, 5000] {
            let mut offset = start;
            while offset < whole.len() {
                let bytes = span(&head, &body, offset);
                assert!((1..=PIECE).contains(&bytes.len()));
                assert_eq!(bytes, whole[offset..offset + bytes.len()]);
                offset += bytes.len();
            }
            assert_eq!(offset, whole.len());
        }
    }
}
