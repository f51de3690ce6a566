//! Brings the log of a worker host home.
//!
//! The worker's launcher writes it to a file; pieces of the file are pulled like pieces of one endless message.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::time::{Duration, Instant};

use bytemuck::bytes_of;
use kit::failure::Failure;
use zenoh::qos::CongestionControl;
use zenoh::query::ConsolidationMode;
use zenoh::{Session, Wait};

use super::contact::Contact;
use super::serve::{answer, questions};
use super::session::refused;
use super::wire::{self, Answer, Ask, PIECE, Piece};

/// The name of the log's stream, beside the streams of the topics.
pub const NAME: &str = "log";
/// Time between two looks at the log.
const PERIOD: Duration = Duration::from_millis(500);
/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// Serves the file at `path` until `contact` is told to stop, and a little longer, because the log ends last.
///
/// # Errors
/// [`Failure::Refused`] if zenoh refuses.
pub fn serve(zenoh: &Session, key: &str, path: &Path, contact: &Contact) -> Result<(), Failure> {
    let questions = questions(zenoh, key)?;
    let mut stopped: Option<Instant> = None;
    loop {
        if contact.is_to_stop() && stopped.get_or_insert_with(Instant::now).elapsed() > PERIOD {
            return Ok(());
        }
        let Ok(Some(question)) = questions.recv_timeout(PERIOD / 5) else { continue };
        let Some(ask) = question.payload().and_then(|payload| wire::read::<Ask>(&payload.to_bytes())) else { continue };
        let bytes = read(path, ask.offset).unwrap_or_default();
        let what = if bytes.is_empty() { Answer::Nothing } else { Answer::Piece };
        answer(&question, Piece { epoch: 0, sequence: 0, offset: ask.offset, total: 0, kind: what.code() }, &bytes);
    }
}

fn read(path: &Path, offset: u64) -> std::io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(offset))?;
    let mut bytes = Vec::new();
    file.take(PIECE as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Pulls the log under `key` and passes each line to `say`, until its sender ends or `contact` is told to stop.
///
/// # Errors
/// [`Failure::Refused`] if zenoh refuses.
pub fn pull(zenoh: &Session, key: &str, contact: &Contact, say: impl Fn(&str)) -> Result<(), Failure> {
    let mut ask = Ask { reader: 0, epoch: 0, sequence: 0, offset: 0 };
    let mut rest: Vec<u8> = Vec::new();
    loop {
        // After the end one more question is asked, for the last lines.
        let is_last = contact.is_to_stop() || contact.has_ended();
        let patience = if is_last { PERIOD } else { PATIENCE };
        let bytes = piece(zenoh, key, ask, patience)?;
        ask.offset += bytes.len() as u64;
        rest.extend_from_slice(&bytes);
        if let Some(end) = rest.iter().rposition(|&byte| byte == b'\n') {
            let unfinished = rest.split_off(end + 1);
            String::from_utf8_lossy(&rest).lines().for_each(&say);
            rest = unfinished;
        }
        match bytes.is_empty() {
            true if is_last => return Ok(()),
            true => std::thread::sleep(PERIOD),
            false => {}
        }
    }
}

/// The bytes from `ask.offset` on; empty if there are no more yet.
fn piece(zenoh: &Session, key: &str, ask: Ask, patience: Duration) -> Result<Vec<u8>, Failure> {
    let question = zenoh.get(key).payload(bytes_of(&ask).to_vec()).timeout(patience);
    let answers = question
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Block)
        .wait()
        .map_err(|e| refused(&e))?;
    let Ok(Some(reply)) = answers.recv_timeout(patience) else { return Ok(Vec::new()) };
    let Ok(sample) = reply.result() else { return Ok(Vec::new()) };
    let piece = sample.attachment().and_then(|bytes| wire::read::<Piece>(&bytes.to_bytes()));
    let fits = piece.is_some_and(|piece| piece.answer() == Some(Answer::Piece) && piece.offset == ask.offset);
    Ok(if fits { sample.payload().to_bytes().into_owned() } else { Vec::new() })
}
