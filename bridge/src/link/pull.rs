//! The reader of a stream: asks for one message after another, until each is whole.

use std::time::{Duration, Instant};

use bytemuck::{bytes_of, cast_slice_mut};
use kit::failure::Failure;
use messages::port::Draft;
use messages::topic::Topic;
use zenoh::handlers::FifoChannelHandler;
use zenoh::qos::CongestionControl;
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::{Session, Wait};

use super::contact::Contact;
use super::serve::draw;
use super::session::refused;
use super::wire::{self, Answer, Ask, Piece};

/// Longest wait for the next piece before the question is asked again.
pub const PATIENCE: Duration = Duration::from_secs(4);
/// Longest that an answer may take in total; far more than any message needs.
const LONGEST_ANSWER: Duration = Duration::from_secs(3600);
/// Pause before a question is asked again.
const PAUSE: Duration = Duration::from_millis(100);

/// Where pulled messages go.
pub trait Sink<T: Topic> {
    /// Room for a message with `header` and `items` items; `None` if it is not wanted.
    ///
    /// # Errors
    /// [`Failure::Port`] if there is no room.
    fn room(&mut self, header: &T::Header, items: usize) -> Result<Option<Draft<T>>, Failure>;

    /// Takes a message that is whole.
    ///
    /// # Errors
    /// [`Failure::Port`] if it cannot be delivered.
    fn deliver(&mut self, header: T::Header, draft: Draft<T>) -> Result<(), Failure>;

    /// Called between messages.
    fn idle(&mut self) {}
}

/// A message that has arrived in part.
struct Part<T: Topic> {
    header: T::Header,
    draft: Draft<T>,
    begun: Instant,
}

/// Pulls the stream under `key` into `sink` until its sender ends or `contact` is told to stop. A cut link, or a sender
/// that is started again, is no end.
///
/// # Errors
/// What the sink could not do.
pub fn pull<T: Topic>(zenoh: &Session, key: &str, contact: &Contact, sink: &mut impl Sink<T>) -> Result<(), Failure> {
    let mut reader = Reader { ask: Ask { reader: draw(), epoch: 0, sequence: 0, offset: 0 }, part: None::<Part<T>> };
    while !contact.is_to_stop() && !contact.has_ended() {
        sink.idle();
        let asked = Instant::now();
        let question = zenoh.get(key).payload(bytes_of(&reader.ask).to_vec()).timeout(LONGEST_ANSWER);
        let answers = question
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(|e| refused(&e))?;
        let mut heard = false;
        // When the answers end, or pause for too long, the question is asked again.
        while let Some(reply) = await_reply(&answers, contact) {
            contact.hear();
            heard = true;
            if !reader.take(&reply, contact, sink)? || contact.is_to_stop() {
                break;
            }
        }
        if !heard {
            std::thread::sleep(PAUSE.saturating_sub(asked.elapsed()));
        }
    }
    Ok(())
}

/// The next answer, unless it takes too long.
fn await_reply(answers: &FifoChannelHandler<Reply>, contact: &Contact) -> Option<Reply> {
    let asked = Instant::now();
    while asked.elapsed() < PATIENCE && !contact.is_to_stop() {
        match answers.recv_timeout(PAUSE) {
            Ok(None) => {}
            Ok(reply) => return reply,
            Err(_) => return None, // there will be no more
        }
    }
    None
}

/// What a reader has so far.
struct Reader<T: Topic> {
    ask: Ask,
    part: Option<Part<T>>,
}

impl<T: Topic> Reader<T> {
    /// Takes an answer; `false` if the next question is due.
    fn take(&mut self, reply: &Reply, contact: &Contact, sink: &mut impl Sink<T>) -> Result<bool, Failure> {
        let Ok(sample) = reply.result() else { return Ok(false) };
        let piece = sample.attachment().and_then(|bytes| wire::read::<Piece>(&bytes.to_bytes()));
        let Some(piece) = piece else { return Ok(false) };
        if piece.answer() == Some(Answer::End) {
            contact.end();
            return Ok(false);
        }
        if piece.epoch != self.ask.epoch {
            // The sender counts anew: what was begun will come again.
            self.part = None;
            self.ask = Ask { epoch: piece.epoch, sequence: 0, offset: 0, ..self.ask };
        }
        if piece.answer() != Some(Answer::Piece)
            || (piece.sequence, piece.offset) != (self.ask.sequence, self.ask.offset)
        {
            return Ok(false);
        }
        let bytes = sample.payload().to_bytes();
        contact.carry(bytes.len());
        self.take_piece(piece, &bytes, sink)
    }

    fn take_piece(&mut self, piece: Piece, bytes: &[u8], sink: &mut impl Sink<T>) -> Result<bool, Failure> {
        let head = size_of::<T::Header>();
        let bad = |what: &str| Failure::Refused(format!("a message on {}: {what}", T::NAME));
        if piece.offset == 0 {
            let header = bytes.get(..head).and_then(wire::read::<T::Header>).ok_or_else(|| bad("no whole header"))?;
            let items = (piece.total as usize).saturating_sub(head) / size_of::<T::Item>();
            if head + items * size_of::<T::Item>() != piece.total as usize {
                return Err(bad("its items have no whole number"));
            }
            self.part = sink.room(&header, items)?.map(|draft| Part { header, draft, begun: Instant::now() });
        }
        let Some(part) = &mut self.part else { return Ok(self.next()) };
        let body: &mut [u8] = cast_slice_mut(part.draft.items_mut());
        let (from, skipped) =
            ((piece.offset as usize).saturating_sub(head), head.saturating_sub(piece.offset as usize));
        let bytes_of_body = bytes.get(skipped..).unwrap_or(&[]);
        let room = body.get_mut(from..from + bytes_of_body.len()).ok_or_else(|| bad("longer than it said"))?;
        room.copy_from_slice(bytes_of_body);
        self.ask.offset += bytes.len() as u64;
        if self.ask.offset < piece.total {
            return Ok(true);
        }
        if let Some(Part { header, draft, begun }) = self.part.take() {
            let milliseconds = begun.elapsed().as_millis() as u64;
            tracing::debug!(bytes = piece.total, milliseconds, "a message on {} is here", T::NAME);
            sink.deliver(header, draft)?;
        }
        Ok(self.next())
    }

    /// Moves on to the next message; always `false`, because the next question is due.
    fn next(&mut self) -> bool {
        self.ask = Ask { sequence: self.ask.sequence + 1, offset: 0, ..self.ask };
        false
    }
}
