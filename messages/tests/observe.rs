//! Observers read along; no publisher waits for them.
#![allow(missing_docs)]

use messages::domain::{HeldDomain, Place};
use messages::layout::StatusHeader;
use messages::observe::{Census, Observer};
use messages::topic::{Capacity, Status, Topic};

/// A place of a test's own, removed at its end.
struct Own(Place, #[expect(dead_code)] tempfile::TempDir);

impl Own {
    fn new(name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let prefix = format!("pc{name}{}-", std::process::id());
        Self(Place { root: folder.path().join("domain"), prefix }, folder)
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        let _ = self.0.remove();
    }
}

const CAPACITY: Capacity = Capacity { propagators: 1, cases: 1, snapshots: 1, hosts: 0 };

#[test]
fn an_observer_that_never_looks_holds_nobody_up_and_readers_still_get_everything() {
    let own = Own::new("obs");
    let held = HeldDomain::create(&own.0, &CAPACITY).unwrap();
    let reader = held.domain.inlet::<Status>().unwrap();
    let observer = Observer::enter(&own.0, "test").unwrap();
    let asleep = observer.inlet::<Status>().unwrap();
    let outlet = held.domain.outlet::<Status>(2).unwrap();
    // A publisher waits only for readers that have connected, and a reader connects when it first looks for messages.
    assert!(asleep.receive().unwrap().is_none());
    let depth = Status::depth(&CAPACITY);
    let many = 4 * depth;
    let started = std::time::Instant::now();
    for number in 0..many {
        outlet.send_items(StatusHeader::default(), &[number as f64, 0.0]).unwrap();
        assert_eq!(reader.receive().unwrap().expect("the reader gets every message").items()[0], number as f64);
    }
    assert!(started.elapsed() < messages::domain::PATIENCE, "nobody waited for the observer");
    let seen = std::iter::from_fn(|| asleep.receive().unwrap()).count();
    assert_eq!(seen, depth, "the observer has what its buffer held and misses the rest");
}

#[test]
fn a_reader_that_never_looks_does_hold_up_its_publisher() {
    let own = Own::new("wait");
    let held = HeldDomain::create(&own.0, &CAPACITY).unwrap();
    let reader = held.domain.inlet::<Status>().unwrap();
    let depth = Status::depth(&CAPACITY);
    std::thread::scope(|scope| {
        let place = &own.0;
        let (sender, sent) = std::sync::mpsc::channel();
        let (connected, go) = std::sync::mpsc::channel();
        scope.spawn(move || {
            let domain = messages::domain::Domain::enter(place, "publisher").unwrap();
            let outlet = domain.outlet::<Status>(2).unwrap();
            sender.send(usize::MAX).unwrap();
            go.recv().unwrap();
            for number in 0..=depth {
                outlet.send_items(StatusHeader::default(), &[number as f64, 0.0]).unwrap();
                sender.send(number).unwrap();
            }
            // The messages die with their publisher.
            while sender.send(usize::MAX).is_ok() {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        });
        assert_eq!(sent.recv().unwrap(), usize::MAX);
        // A publisher waits only for readers that have connected, and a reader connects when it first looks for
        // messages.
        assert!(reader.receive().unwrap().is_none());
        connected.send(()).unwrap();
        for expected in 0..depth {
            assert_eq!(sent.recv().unwrap(), expected);
        }
        let more = sent.recv_timeout(std::time::Duration::from_millis(300));
        assert!(more.is_err(), "the buffer is full and the reader has not looked");
        assert!(reader.receive().unwrap().is_some());
        assert_eq!(sent.recv().unwrap(), depth, "as soon as the reader takes a message there is room");
        drop(sent);
    });
}

#[test]
fn observers_are_counted_apart() {
    let own = Own::new("cens");
    let held = HeldDomain::create(&own.0, &CAPACITY).unwrap();
    let _reader = held.domain.inlet::<Status>().unwrap();
    let observer = Observer::enter(&own.0, "test").unwrap();
    let _inlet = observer.inlet::<Status>().unwrap();
    assert_eq!(observer.census::<Status>().unwrap(), Census { publishers: 0, readers: 1, observers: 1 });
}
