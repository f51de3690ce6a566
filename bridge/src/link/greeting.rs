//! A worker host introduces itself at home and is told its share of the run or of the map, or why it has none.

use std::time::Duration;

use kit::failure::Failure;
use messages::contract::names;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use zenoh::query::Query;
use zenoh::{Session, Wait};

use super::session::refused;
use super::wire;
use crate::plan::Work;

/// Where home listens for greetings.
const KEY: &str = "phasecloud/greeting";
/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// What a worker host says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Its name.
    pub host: String,
    /// The names, and so the versions, of all messages that it knows, and the version of the wire.
    pub contract: String,
    /// The version of its program.
    pub version: String,
    /// A number drawn by the process that speaks: while it lives, no other process may take its host's name.
    pub process: u64,
}

impl Hello {
    /// What this program says as `host`.
    pub fn of(host: &str, process: u64) -> Self {
        Self { host: host.into(), contract: contract(), version: env!("CARGO_PKG_VERSION").into(), process }
    }

    /// Whether the two programs understand each other.
    ///
    /// # Errors
    /// What differs, with the host's name.
    pub fn check(&self) -> Result<(), String> {
        if self.contract == contract() {
            return Ok(());
        }
        let theirs: Vec<&str> = self.contract.split(' ').collect();
        let missing: Vec<String> =
            contract().split(' ').filter(|name| !theirs.contains(name)).map(str::to_owned).collect();
        Err(format!(
            "host {} (phasecloud {}) speaks another version of the messages: it lacks {}; install phasecloud {} there",
            self.host,
            self.version,
            missing.join(", "),
            env!("CARGO_PKG_VERSION")
        ))
    }
}

fn contract() -> String {
    format!("{} wire/{}", names().join(" "), wire::VERSION)
}

/// Asks home what there is to do; `None` if home does not answer.
///
/// # Errors
/// [`Failure::Refused`] if home refuses, with its reason.
pub fn greet(zenoh: &Session, hello: &Hello) -> Result<Option<Work>, Failure> {
    let answers = zenoh.get(KEY).payload(text(hello)?).timeout(PATIENCE).wait().map_err(|e| refused(&e))?;
    let Ok(Some(reply)) = answers.recv_timeout(PATIENCE) else { return Ok(None) };
    match reply.result() {
        Ok(sample) => parse(&sample.payload().to_bytes()).map(Some),
        // zenoh itself gives this answer if no other comes in time.
        Err(error) if error.payload().to_bytes().starts_with(b"Timeout") => Ok(None),
        Err(error) => Err(Failure::Refused(String::from_utf8_lossy(&error.payload().to_bytes()).into_owned())),
    }
}

/// Answers greetings with `work_of`, which may refuse, for as long as the result lives.
///
/// # Errors
/// [`Failure::Refused`] if zenoh refuses.
pub(crate) fn receive(
    zenoh: &Session,
    work_of: impl Fn(Hello) -> Result<Work, String> + Send + Sync + 'static,
) -> Result<zenoh::query::Queryable<()>, Failure> {
    let answer = move |query: Query| {
        let said = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let work = parse::<Hello>(&said).map_err(|e| e.to_string()).and_then(&work_of);
        let work = work.and_then(|work| text(&work).map_err(|e| e.to_string()));
        let sent = match work {
            Ok(work) => query.reply(KEY, work).wait(),
            Err(why) => query.reply_err(why).wait(),
        };
        if let Err(error) = sent {
            tracing::debug!("a greeting was not answered: {error}");
        }
    };
    zenoh.declare_queryable(KEY).callback(answer).wait().map_err(|e| refused(&e))
}

/// A value as it is sent.
pub(super) fn text(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(|e| Failure::Refused(e.to_string()))
}

/// A value that another host has sent.
pub(super) fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Failure> {
    serde_json::from_slice(bytes).map_err(|e| Failure::Refused(format!("the other host speaks another language: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_version_of_the_messages_is_refused_by_name() {
        Hello::of("a", 1).check().unwrap();
        let old = contract().replace("SnapshotHeader/", "SnapshotHeader/0");
        let error = Hello { contract: old, version: "0.0.9".into(), ..Hello::of("worker-a", 1) }.check().unwrap_err();
        assert!(error.contains("worker-a") && error.contains("0.0.9") && error.contains("SnapshotHeader/"), "{error}");
    }
}
