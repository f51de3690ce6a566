//! No message is lost silently: late readers, slow readers, latched topics.
#![allow(missing_docs)]

use std::time::{Duration, Instant};

use messages::domain::{Domain, HeldDomain, Place};
use messages::layout::{RosterEntry, RosterHeader, SnapshotHeader};
use messages::topic::{Capacity, Roster, Snapshot};
use messages::wait::{Awaited, Signals};

const SNAPSHOTS: usize = 4;

/// A domain of the test's own, removed at the end.
struct Bench {
    place: Place,
    held: Option<HeldDomain>,
}

impl Bench {
    fn new(name: &str) -> Self {
        let name = format!("{name}-{}", std::process::id());
        let place = Place { root: std::env::temp_dir().join(&name), prefix: format!("pt{name}-") };
        let held =
            HeldDomain::create(&place, &Capacity { propagators: 1, cases: 1, snapshots: SNAPSHOTS, hosts: 0 }).unwrap();
        Self { place, held: Some(held) }
    }

    fn enter(&self, name: &str) -> Domain {
        Domain::enter(&self.place, name).unwrap()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.held = None;
        self.place.remove().unwrap();
    }
}

fn header(index: u32) -> SnapshotHeader {
    SnapshotHeader { index, ..SnapshotHeader::default() }
}

#[test]
fn a_reader_that_comes_late_gets_everything_in_order() {
    let bench = Bench::new("late");
    let (sender, reader) = (bench.enter("sender"), bench.enter("reader"));
    let outlet = sender.outlet::<Snapshot>(3).unwrap();
    for index in 0..SNAPSHOTS as u32 {
        outlet.send_items(header(index), &[f64::from(index); 3]).unwrap();
    }
    let inlet = reader.inlet::<Snapshot>().unwrap();
    outlet.attend();
    for index in 0..SNAPSHOTS as u32 {
        let message = inlet.receive().unwrap().unwrap();
        assert_eq!((message.header().index, message.items()), (index, [f64::from(index); 3].as_slice()));
    }
    assert!(inlet.receive().unwrap().is_none());
}

#[test]
fn a_reader_that_does_not_read_holds_its_sender_up_for_a_while_and_then_the_sender_fails_by_name() {
    let bench = Bench::new("slow");
    let patience = Duration::from_millis(200);
    let sender = bench.enter("sender").with_patience(patience);
    let reader = bench.enter("reader");
    let outlet = sender.outlet::<Snapshot>(1).unwrap();
    let inlet = reader.inlet::<Snapshot>().unwrap();
    for index in 0..SNAPSHOTS as u32 {
        outlet.send_items(header(index), &[0.0]).unwrap();
    }
    let begun = Instant::now();
    let error = outlet.send_items(header(99), &[0.0]).unwrap_err().to_string();
    assert!(begun.elapsed() >= patience);
    assert!(error.contains("cannot send on phasecloud/snapshot"), "{error}");
    // Everything that had been sent before is there.
    let indices: Vec<u32> = std::iter::from_fn(|| inlet.receive().unwrap()).map(|m| m.header().index).collect();
    assert_eq!(indices, [0, 1, 2, 3]);
}

#[test]
fn of_a_latched_topic_the_latest_message_counts_and_nobody_waits() {
    let bench = Bench::new("latched");
    let (sender, reader) = (bench.enter("sender"), bench.enter("reader"));
    let outlet = sender.outlet::<Roster>(1).unwrap();
    let early = reader.inlet::<Roster>().unwrap();
    for scenario in 0..1000 {
        outlet.send_items(RosterHeader { scenario, ..RosterHeader::default() }, &[RosterEntry::default()]).unwrap();
    }
    let late = reader.inlet::<Roster>().unwrap();
    outlet.attend();
    for inlet in [early, late] {
        let last = std::iter::from_fn(|| inlet.receive().unwrap()).last().unwrap();
        assert_eq!(last.header().scenario, 999);
    }
}

#[test]
fn a_node_that_asks_for_another_layout_is_refused_by_name() {
    let bench = Bench::new("version");
    let error = bench.enter("reader").inlet::<Other>().unwrap_err().to_string();
    assert!(error.contains("phasecloud/snapshot") && error.contains("IncompatibleTypes"), "{error}");
}

/// A topic of another version: the same name, another header.
#[derive(Debug)]
struct Other;

impl messages::topic::Topic for Other {
    type Header = RosterHeader;
    type Item = f64;
    const NAME: &'static str = "phasecloud/snapshot";
    const DOC: &'static [&'static str] = &[];
    const DEPTH: &'static str = "";
    const LATCHED: bool = false;
    fn run_id(header: &Self::Header) -> u64 {
        header.run_id
    }
    fn scenario(header: &Self::Header) -> u32 {
        header.scenario
    }
    fn in_run(header: Self::Header, run_id: u64) -> Self::Header {
        RosterHeader { run_id, ..header }
    }
    fn depth(_: &Capacity) -> usize {
        1
    }
    fn shape(_: &Self::Header) -> messages::payload::Shape {
        messages::payload::rows(&[])
    }
}

#[test]
fn a_wait_ends_with_a_message_and_sleeps_when_there_is_none() {
    let bench = Bench::new("wait");
    let (sender, reader) = (bench.enter("sender"), bench.enter("reader"));
    let (outlet, inlet) = (sender.outlet::<Snapshot>(3).unwrap(), reader.inlet::<Snapshot>().unwrap());
    let other = reader.inlet::<Roster>().unwrap();
    let signals = Signals::catch(&[]).unwrap();
    let nap = Duration::from_millis(20);
    let slept = |ports: &[&dyn Awaited], at_most: Duration| {
        let start = Instant::now();
        signals.wait(ports, at_most).unwrap();
        start.elapsed()
    };
    slept(&[&inlet, &other, &outlet], nap); // takes the events that say that readers have joined
    for index in 0..SNAPSHOTS as u32 {
        outlet.send_items(header(index), &[0.0; 3]).unwrap();
        let watchdog = Duration::from_secs(60);
        assert!(slept(&[&inlet], watchdog) < watchdog, "the message is there");
        assert_eq!(inlet.receive().unwrap().unwrap().header().index, index);
        assert!(slept(&[&inlet], nap) >= nap, "nothing has come since");
    }
    outlet.send_items(header(9), &[0.0; 3]).unwrap();
    assert!(slept(&[&other], nap) >= nap, "it is nothing to this port");
    assert!(slept(&[&other, &inlet], Duration::from_secs(60)) < Duration::from_secs(60), "other ports are watched");
    assert!(slept(&[&other, &outlet], nap) >= nap, "a message does not wake those who send");
    let _late = reader.inlet::<Snapshot>().unwrap();
    assert!(slept(&[&other, &outlet], Duration::from_secs(60)) < Duration::from_secs(60), "a reader that joins does");
}
