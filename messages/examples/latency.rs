//! Measures how long a snapshot takes from its sender's last write to its reader's first read, in two processes.
//!
//! `cargo run --release -p phasecloud-messages --example latency [MESSAGES]` prints median and 99th percentile by size. A copy
//! would grow with the size: 240 MB take 20 ms and more to copy once.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use messages::domain::{Domain, HeldDomain, Place};
use messages::layout::SnapshotHeader;
use messages::topic::{Capacity, Snapshot};
use messages::wait::Signals;
use rustix::time::{ClockId, clock_gettime};

/// Numbers in a message: 24 B, a scenario's snapshot of 1e5, of 1e6 and of 1e7 samples with three columns.
const SIZES: [usize; 4] = [3, 300_000, 3_000_000, 30_000_000];
const MESSAGES: usize = 300;
/// Rest between two messages: the machine is idle when one is sent.
const REST: Duration = Duration::from_millis(3);
const ROLE: &str = "LATENCY_SENDER";

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> Outcome {
    match std::env::var(ROLE) {
        Ok(task) => send(&task),
        Err(_) => measure(std::env::args().nth(1).map_or(Ok(MESSAGES), |text| text.parse())?),
    }
}

/// Nanoseconds on a clock that all processes share.
fn now() -> f64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

/// The sender: writes the time into the last number and sends at once.
fn send(task: &str) -> Outcome {
    let place = Place::from_environment().ok_or("no domain")?;
    let (size, messages) = task.split_once(' ').ok_or("no task")?;
    let (size, messages): (usize, usize) = (size.parse()?, messages.parse()?);
    let domain = Domain::enter(&place, "sender")?;
    let outlet = domain.outlet::<Snapshot>(size)?;
    for index in 0..messages {
        std::thread::sleep(REST);
        let mut draft = outlet.draft(size)?;
        let header = SnapshotHeader { index: index as u32, rows: size as u32, ..SnapshotHeader::default() };
        if let Some(last) = draft.items_mut().last_mut() {
            *last = now();
        }
        outlet.send(draft, header)?;
    }
    std::thread::sleep(Duration::from_millis(200)); // messages that are not yet read die with their sender
    Ok(())
}

fn measure(messages: usize) -> Outcome {
    let name = format!("latency-{}", std::process::id());
    let place = Place { root: std::env::temp_dir().join(&name), prefix: format!("{name}-") };
    let held = HeldDomain::create(&place, &Capacity { propagators: 1, cases: 1, snapshots: 5, hosts: 0 })?;
    println!("bytes, median and 99th percentile from last write to first read [us]");
    for size in SIZES {
        let mut delays = receive(&held, &place, size, messages)?;
        delays.sort_by(f64::total_cmp);
        let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize] / 1e3;
        println!("{:11} {:8.1} {:8.1}", 8 * size, at(0.5), at(0.99));
    }
    drop(held);
    Ok(place.remove()?)
}

/// Delays \[ns\] of messages of `size` numbers, without the first few, which touch their memory for the first time.
fn receive(
    held: &HeldDomain,
    place: &Place,
    size: usize,
    messages: usize,
) -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    let signals = Signals::catch(&[])?;
    let inlet = held.domain.inlet::<Snapshot>()?;
    let mut sender = start(place, size, messages)?;
    let mut delays = Vec::new();
    let mut received = 0;
    while received < messages {
        while let Some(message) = inlet.receive()? {
            let sent = message.items().last().copied().unwrap_or(f64::NAN);
            delays.push(now() - sent);
            received += 1;
        }
        signals.wait(&[&inlet], Duration::from_secs(1))?;
        if received < messages && sender.try_wait()?.is_some() {
            return Err("the sender ended early".into());
        }
    }
    sender.wait()?;
    held.domain.clean_up_after_the_dead();
    Ok(delays.split_off(messages.min(10)))
}

fn start(place: &Place, size: usize, messages: usize) -> std::io::Result<Child> {
    Command::new(std::env::current_exe()?)
        .env(ROLE, format!("{size} {messages}"))
        .env(messages::domain::ROOT_VARIABLE, &place.root)
        .env(messages::domain::PREFIX_VARIABLE, &place.prefix)
        .stdin(Stdio::null())
        .spawn()
}
