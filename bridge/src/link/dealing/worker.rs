//! A worker's end: it asks home.

use std::time::Duration;

use kit::failure::Failure;
use zenoh::{Session, Wait};

use super::super::contact::Contact;
use super::super::greeting::{parse, text};
use super::super::session::refused;
use super::{Answer, Brought, KEY, Question};

/// Longest wait for an answer before a question is asked again.
const PATIENCE: Duration = Duration::from_secs(3);

/// Asks home about a map.
pub struct Asker<'a> {
    zenoh: &'a Session,
    map_id: u64,
    process: u64,
    contact: Contact,
}

impl<'a> Asker<'a> {
    /// Asks over `zenoh` about the map with this number, as the process that has greeted home with this one.
    pub fn new(zenoh: &'a Session, map_id: u64, process: u64) -> Self {
        Self { zenoh, map_id, process, contact: Contact::with_home() }
    }

    /// Brings what has been found, and asks for something to do if the worker `is_free`. `None` if home does not
    /// answer; then the same is to be asked again.
    ///
    /// # Errors
    /// [`Failure::Refused`] if home has not answered for so long that it is lost, or speaks another language.
    pub fn ask(&self, brought: &[Brought], is_free: bool) -> Result<Option<Answer>, Failure> {
        match self.say(brought, is_free, false)? {
            Some(answer) => Ok(Some(answer)),
            None if self.contact.is_lost() => {
                let seconds = self.contact.silence().as_secs_f64();
                Err(Failure::Refused(format!("the home host is lost: nothing heard for {seconds:.1} s")))
            }
            None => Ok(None),
        }
    }

    /// Brings what has been found and says that nothing more will come; home notices by itself if this is lost.
    pub fn leave(&self, brought: &[Brought]) {
        if let Err(failure) = self.say(brought, false, true) {
            tracing::debug!("home was not told that this host leaves: {failure}");
        }
    }

    fn say(&self, brought: &[Brought], is_free: bool, is_leaving: bool) -> Result<Option<Answer>, Failure> {
        let Self { map_id, process, .. } = *self;
        let question = Question { map_id, process, brought: brought.to_vec(), is_free, is_leaving };
        let asked = self.zenoh.get(KEY).payload(text(&question)?).timeout(PATIENCE).wait();
        let answers = asked.map_err(|e| refused(&e))?;
        let Ok(Some(reply)) = answers.recv_timeout(PATIENCE) else { return Ok(None) };
        match reply.result() {
            Ok(sample) => {
                self.contact.hear();
                parse(&sample.payload().to_bytes()).map(Some)
            }
            // zenoh itself gives this answer if no other comes in time.
            Err(error) if error.payload().to_bytes().starts_with(b"Timeout") => Ok(None),
            Err(error) => Err(Failure::Refused(String::from_utf8_lossy(&error.payload().to_bytes()).into_owned())),
        }
    }
}
