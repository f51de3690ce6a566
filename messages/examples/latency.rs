//! Measures how long a snapshot takes from its sender's last write to its reader's first read, in two processes.
//!
//! For comparison it also measures the shortest time in which this machine wakes a process.
//!
//! `cargo run --release -p phasecloud-messages --example latency [MESSAGES]` prints median and 99th percentile. The
//! time of a copy would grow with the size: to copy 240 MB once takes 20 ms and more.

use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use messages::domain::{Domain, HeldDomain, PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use messages::layout::SnapshotHeader;
use messages::topic::{Capacity, Snapshot};
use messages::wait::Signals;
use rustix::time::{ClockId, clock_gettime};

/// Numbers in a message: 24 bytes, and snapshots of 1e5, 1e6 and 1e7 samples with three columns.
const SIZES: [usize; 4] = [3, 300_000, 3_000_000, 30_000_000];
const MESSAGES: usize = 300;
/// Rest between two messages: after the long one the machine sleeps, after the short one it is still awake.
const RESTS: [Duration; 2] = [Duration::from_millis(3), Duration::ZERO];
const TASK: &str = "LATENCY_TASK";

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome {
    match std::env::var(TASK) {
        Ok(task) => send(&task),
        Err(_) => measure(std::env::args().nth(1).map_or(Ok(MESSAGES), |text| text.parse())?),
    }
}

/// Nanoseconds on a clock that all processes share.
fn now() -> f64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

fn measure(messages: usize) -> Outcome {
    let name = format!("latency-{}", std::process::id());
    let place = Place { root: std::env::temp_dir().join(&name), prefix: format!("{name}-") };
    let held = HeldDomain::create(&place, &Capacity { propagators: 1, cases: 1, snapshots: 5, hosts: 0 })?;
    let signals = Signals::catch(&[])?;
    println!("  rest [us]      way        bytes  from last write to first read [us]: median, 99th percentile");
    for rest in RESTS {
        report(&place, Task { way: "pipe", size: 1, rest, messages }, &mut |sender| {
            let mut bytes = [0; 8];
            sender.stdout.as_mut().ok_or("no pipe")?.read_exact(&mut bytes)?;
            Ok(Some(f64::from_ne_bytes(bytes)))
        })?;
        for size in SIZES {
            let bare = Bare::open(&place)?;
            let (subscriber, listener) =
                (bare.messages.subscriber_builder().create()?, bare.events.listener_builder().create()?);
            report(&place, Task { way: "iceoryx2", size, rest, messages }, &mut |_| {
                listener.blocking_wait(|_| ())?;
                Ok(subscriber.receive()?.and_then(|sample| sample.payload().last().copied()))
            })?;
            let inlet = held.domain.inlet::<Snapshot>()?;
            report(&place, Task { way: "ports", size, rest, messages }, &mut |_| {
                signals.wait(&[&inlet], Duration::from_secs(1))?;
                Ok(inlet.receive()?.and_then(|message| message.items().last().copied()))
            })?;
            held.domain.clean_up_after_the_dead();
        }
    }
    drop(held);
    Ok(place.remove()?)
}

/// The task of a sender.
#[derive(Debug, Clone, Copy)]
struct Task {
    way: &'static str,
    size: usize,
    rest: Duration,
    messages: usize,
}

/// Starts a sender, asks it for message after message, and prints how long they took. `read` waits for something to
/// arrive, and returns the time that is in it, if it is a message.
fn report(place: &Place, task: Task, read: &mut dyn FnMut(&mut Child) -> Outcome<Option<f64>>) -> Outcome {
    let Task { way, size, rest, messages } = task;
    let mut sender = Command::new(std::env::current_exe()?)
        .env(TASK, format!("{way} {size} {}", rest.as_micros()))
        .env(ROOT_VARIABLE, &place.root)
        .env(PREFIX_VARIABLE, &place.prefix)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let mut ask = sender.stdin.take().ok_or("no pipe")?;
    let mut delays = Vec::new();
    for _ in 0..messages {
        ask.write_all(&[0])?;
        delays.push(loop {
            if let Some(sent) = read(&mut sender)? {
                break now() - sent;
            }
        });
    }
    drop(ask);
    sender.wait()?;
    // The first few messages are slow because they use their memory for the first time.
    let mut delays = delays.split_off(messages.min(10));
    delays.sort_by(f64::total_cmp);
    let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize] / 1e3;
    println!("{:11} {way:>8} {:12} {:8.1} {:8.1}", rest.as_micros(), 8 * size, at(0.5), at(0.99));
    Ok(())
}

/// The sender: each time it is asked, it rests, writes the time into the last number, and sends at once.
fn send(task: &str) -> Outcome {
    let [way, size, rest] = task.split(' ').collect::<Vec<_>>()[..] else { return Err("no task".into()) };
    let (size, rest): (usize, u64) = (size.parse()?, rest.parse()?);
    let place = Place::from_environment().ok_or("no domain")?;
    let asked = || {
        let is_asked = matches!(std::io::stdin().read(&mut [0]), Ok(1));
        std::thread::sleep(Duration::from_micros(rest));
        is_asked
    };
    match way {
        "pipe" => {
            let mut pipe = std::io::stdout();
            while asked() {
                pipe.write_all(&now().to_ne_bytes())?;
                pipe.flush()?;
            }
        }
        "iceoryx2" => {
            let bare = Bare::open(&place)?;
            let publisher = bare.messages.publisher_builder().initial_max_slice_len(size).create()?;
            let notifier = bare.events.notifier_builder().create()?;
            while asked() {
                let mut sample = publisher.loan_slice(size)?;
                if let Some(last) = sample.payload_mut().last_mut() {
                    *last = now();
                }
                sample.send()?;
                notifier.notify()?;
            }
        }
        _ => {
            let domain = Domain::enter(&place, "sender")?;
            let outlet = domain.outlet::<Snapshot>(size)?;
            while asked() {
                let mut draft = outlet.draft(size)?;
                if let Some(last) = draft.items_mut().last_mut() {
                    *last = now();
                }
                outlet.send(draft, SnapshotHeader { rows: size as u32, ..SnapshotHeader::default() })?;
            }
        }
    }
    Ok(())
}

/// iceoryx2 with an event and nothing else.
struct Bare {
    messages: publish_subscribe::PortFactory<ipc::Service, [f64], ()>,
    events: event::PortFactory<ipc::Service>,
}

impl Bare {
    fn open(place: &Place) -> Outcome<Self> {
        let mut config = Config::default();
        config.global.set_root_path(&iceoryx2::prelude::Path::new(place.root.to_string_lossy().as_bytes())?);
        config.global.prefix = FileName::new(place.prefix.as_bytes())?;
        let node = NodeBuilder::new().config(&config).create::<ipc::Service>()?;
        let service = node.service_builder(&"bare".try_into()?);
        let messages = service.clone().publish_subscribe::<[f64]>().open_or_create()?;
        Ok(Self { messages, events: service.event().open_or_create()? })
    }
}
