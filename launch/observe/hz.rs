//! `phasecloud hz`: how often messages come on a topic, and how many bytes.

use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use messages::domain::Place;
use messages::port::PortError;
use messages::topic::{Topic, Visitor};

use super::{End, HzArguments, follow, with_topic};
use crate::domain::attach;
use crate::output;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(1);

/// Counts messages until the run ends.
pub fn run(arguments: &HzArguments) -> ExitCode {
    let target = attach::find(&arguments.target);
    super::exit(target.and_then(|run| with_topic(&arguments.topic, Hz { place: run.place })))
}

struct Hz {
    place: Place,
}

/// Messages and bytes.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    messages: u64,
    bytes: u64,
}

impl Count {
    fn add(&mut self, bytes: usize) {
        self.messages += 1;
        self.bytes += bytes as u64;
    }

    /// Prints the count as rates over `time`; false if nobody reads it.
    fn print(self, what: &str, time: Duration) -> bool {
        let per_second = |count: u64| count as f64 / time.as_secs_f64().max(1e-9);
        let mut out = std::io::stdout().lock();
        output::note(writeln!(
            out,
            "{what}: {} messages in {:.1} s, {:.2} messages/s, {:.0} bytes/s",
            self.messages,
            time.as_secs_f64(),
            per_second(self.messages),
            per_second(self.bytes)
        ))
    }
}

impl Visitor for Hz {
    type Out = Result<End, PortError>;

    fn visit<T: Topic>(&mut self) -> Self::Out {
        let start = Instant::now();
        let (mut last, mut recent, mut all) = (start, Count::default(), Count::default());
        let outcome = follow::<T>(&self.place, "hz", |message| {
            if let Some(message) = message {
                let bytes = size_of::<T::Header>() + size_of_val(message.items());
                recent.add(bytes);
                all.add(bytes);
            }
            if last.elapsed() < INTERVAL {
                return true;
            }
            let printed = recent.print(T::NAME, last.elapsed());
            (last, recent) = (Instant::now(), Count::default());
            printed
        });
        all.print("in all", start.elapsed());
        outcome
    }
}
