//! Streams between two domains, over a link that is cut.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

use messages::content::Samples;
use messages::domain::{HeldDomain, Place};
use messages::layout::SnapshotHeader;
use messages::port::{Inlet, Outlet};
use messages::text::{pack, unpack};
use messages::topic::{Capacity, Snapshot, Topic};
use messages::wait::Awaited;
use tempfile::TempDir;
use zenoh::Session;

use super::contact::Contact;
use super::landing::Landing;
use super::pull::pull;
use super::serve::serve;
use super::session::open;
use super::wire::key;
use crate::endpoint::{Access, End, Tls};
use crate::plan::{Program, Share};

const RUN: u64 = 7;
/// Far longer than anything here takes.
const WATCHDOG: Duration = Duration::from_secs(120);

/// A domain of its own.
struct Corner {
    held: Option<HeldDomain>,
    place: Place,
    _folder: TempDir,
}

impl Corner {
    fn new(name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let unique = folder.path().file_name().unwrap().to_string_lossy().trim_start_matches('.').to_owned();
        let place = Place { root: folder.path().join("d"), prefix: format!("pcb{name}{unique}-") };
        let held = HeldDomain::create(&place, &Capacity { propagators: 4, cases: 4, snapshots: 40, hosts: 0 }).unwrap();
        Self { held: Some(held), place, _folder: folder }
    }

    fn domain(&self) -> &messages::domain::Domain {
        &self.held.as_ref().unwrap().domain
    }
}

impl Drop for Corner {
    fn drop(&mut self) {
        drop(self.held.take());
        self.place.remove().unwrap();
    }
}

/// A link that can be cut: what is under way is lost, and nobody gets through until it is mended.
struct Link {
    port: u16,
    is_cut: Arc<AtomicBool>,
    streams: Arc<Mutex<Vec<TcpStream>>>,
}

impl Link {
    fn to(target: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let link =
            Self { port: listener.local_addr().unwrap().port(), is_cut: Arc::default(), streams: Arc::default() };
        let (is_cut, streams) = (Arc::clone(&link.is_cut), Arc::clone(&link.streams));
        spawn(move || {
            for near in listener.incoming().flatten() {
                let Ok(far) = TcpStream::connect(("127.0.0.1", target)) else { continue };
                if is_cut.load(Ordering::SeqCst) {
                    continue;
                }
                streams.lock().unwrap().extend([near.try_clone().unwrap(), far.try_clone().unwrap()]);
                for (mut from, mut to) in [(near.try_clone().unwrap(), far.try_clone().unwrap()), (far, near)] {
                    spawn(move || {
                        let mut bytes = vec![0; 1 << 16];
                        while let Ok(count @ 1..) = from.read(&mut bytes) {
                            if to.write_all(&bytes[..count]).is_err() {
                                break;
                            }
                        }
                        let _ = to.shutdown(Shutdown::Both);
                    });
                }
            }
        });
        link
    }

    fn cut(&self) {
        self.is_cut.store(true, Ordering::SeqCst);
        self.streams.lock().unwrap().drain(..).for_each(|stream| drop(stream.shutdown(Shutdown::Both)));
    }

    fn mend(&self) {
        self.is_cut.store(false, Ordering::SeqCst);
    }
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn enter(port: u16, end: End) -> Session {
    let endpoint = format!("tcp/127.0.0.1:{port}").parse().unwrap();
    open(&Access { endpoint, tls: Tls::default(), insecure: false }, end).unwrap()
}

fn share(name: &str) -> Share {
    Share {
        name: name.into(),
        label: name.into(),
        shard: (0, 1),
        reduce: false,
        program: Program::Command(vec!["x".into()]),
    }
}

/// The numbers of a snapshot, from which its index can be read.
fn numbers(index: u32, rows: u32) -> Vec<f64> {
    (0..2 * rows).map(|row| f64::from(index) * 1e7 + f64::from(row)).collect()
}

/// Rows of the messages, from almost none to several pieces.
fn rows(index: u32) -> u32 {
    [1, 50_000, 7, 200_000, 32_768][index as usize % 5]
}

/// Both ends of a stream of snapshots; dropping it stops them.
struct Ends {
    contacts: [Arc<Contact>; 2],
    threads: Vec<JoinHandle<()>>,
}

impl Ends {
    fn of(worker: (&Session, &Place), home: (&Session, &Place), attempts: u32) -> Self {
        let contacts = [Contact::with_home(), Contact::with_worker()].map(Arc::new);
        let key = key(RUN, "worker", Snapshot::NAME);
        let (zenoh, place, contact, to) = (worker.0.clone(), worker.1.clone(), Arc::clone(&contacts[0]), key.clone());
        let sender = spawn(move || serve::<Snapshot>(&zenoh, &to, &place, RUN, &contact).unwrap());
        let (zenoh, place, contact) = (home.0.clone(), home.1.clone(), Arc::clone(&contacts[1]));
        let reader = spawn(move || {
            let mut landing = Landing::<Snapshot>::new(&place, "worker", &[share("mc")], attempts).unwrap();
            pull(&zenoh, &key, &contact, &mut landing).unwrap();
            // The messages that have landed live as long as their publisher.
            while !contact.is_to_stop() {
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Self { contacts, threads: vec![sender, reader] }
    }
}

impl Drop for Ends {
    fn drop(&mut self) {
        self.contacts.iter().for_each(|contact| contact.stop());
        self.threads.drain(..).for_each(|thread| thread.join().unwrap());
    }
}

/// The next `count` snapshots that arrive: attempt and index of each; their numbers are checked. Meanwhile `outlet`
/// serves late readers, as a propagator's does while it waits.
fn arrivals(inlet: &Inlet<Snapshot>, outlet: &Outlet<Snapshot>, count: u32) -> Vec<(u32, u32)> {
    let (start, mut arrived) = (Instant::now(), Vec::new());
    while arrived.len() < count as usize {
        assert!(start.elapsed() < WATCHDOG, "only {arrived:?}");
        outlet.attend();
        inlet.wait(Duration::from_millis(20)).unwrap();
        while let Some(message) = inlet.receive().unwrap() {
            let header = *message.header();
            assert_eq!(unpack(&header.label), "mc");
            assert_eq!(message.items(), numbers(header.index, header.rows));
            arrived.push((header.attempt, header.index));
        }
    }
    arrived
}

fn send(outlet: &Outlet<Snapshot>, label: &str, index: u32) {
    let header = SnapshotHeader {
        run_id: RUN,
        index,
        count: 40,
        rows: rows(index),
        most_rows: 200_000,
        label: pack(label),
        ..SnapshotHeader::default()
    };
    let header = header.with(Samples::INDEPENDENT);
    outlet.send_items(header, &numbers(index, rows(index))).unwrap();
}

#[test]
fn every_message_comes_home_once_and_whole_however_often_the_link_is_cut() {
    let (worker, home) = (Corner::new("w"), Corner::new("h"));
    let port = free_port();
    let at_home = enter(port, End::Listens);
    let link = Link::to(port);
    let at_work = enter(link.port, End::Connects);
    let outlet = worker.domain().outlet::<Snapshot>(400_000).unwrap();
    let inlet = home.domain().inlet::<Snapshot>().unwrap();
    let _ends = Ends::of((&at_work, &worker.place), (&at_home, &home.place), 0);
    let vandal = spawn(move || {
        for pause in [30, 150, 400, 10, 700] {
            std::thread::sleep(Duration::from_millis(pause));
            link.cut();
            std::thread::sleep(Duration::from_millis(pause));
            link.mend();
        }
        link
    });
    for index in 0..20 {
        send(&outlet, "mc", index);
        std::thread::sleep(Duration::from_millis(60));
    }
    assert_eq!(arrivals(&inlet, &outlet, 20), (0..20).map(|index| (0, index)).collect::<Vec<_>>());
    let _link = vandal.join().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(inlet.receive().unwrap().is_none(), "nothing comes twice");
}

#[test]
fn a_new_reader_gets_everything_anew_as_a_later_attempt_and_strangers_are_left_out() {
    let (worker, home) = (Corner::new("w"), Corner::new("h"));
    let port = free_port();
    let (at_home, at_work) = (enter(port, End::Listens), enter(port, End::Connects));
    let outlet = worker.domain().outlet::<Snapshot>(400_000).unwrap();
    let stranger = worker.domain().outlet::<Snapshot>(400_000).unwrap();
    let inlet = home.domain().inlet::<Snapshot>().unwrap();
    let ends = Ends::of((&at_work, &worker.place), (&at_home, &home.place), 0);
    send(&stranger, "not-mine", 0);
    for index in 0..3 {
        send(&outlet, "mc", index);
    }
    assert_eq!(arrivals(&inlet, &outlet, 3), [(0, 0), (0, 1), (0, 2)]);
    drop(ends);
    // The state after a bridge at either side has ended; publishers have kept what they sent.
    let _ends = Ends::of((&at_work, &worker.place), (&at_home, &home.place), 1);
    send(&outlet, "mc", 3);
    assert_eq!(arrivals(&inlet, &outlet, 4), [(1, 0), (1, 1), (1, 2), (1, 3)]);
}
