//! A propagator that has gone wrong: it publishes headers of random bytes on every topic, some of them with the right
//! run.
//!
//! For tests, as a case of a launch file: `command = ["target/debug/examples/babbler", "7"]`; the number is the seed.

use std::process::ExitCode;

use bytemuck::{Pod, bytes_of_mut};
use kit::failure::Failure;
use kit::session::Session;
use messages::content::Samples;
use messages::domain::{Domain, Place};
use messages::layout::{ComparisonHeader, DensityHeader, SnapshotHeader, StatusHeader, comparison, event, role};
use messages::text::pack;
use messages::topic::{Comparison, Density, Passage, Roster, Scenario, Snapshot, Status, Topic};

/// Number of messages on each topic.
const MESSAGES: usize = 200;

/// A sequence of random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn header<H: Pod + Default>(&mut self) -> H {
        let mut header = H::default();
        bytes_of_mut(&mut header).chunks_mut(8).for_each(|chunk| {
            let bytes = self.next().to_ne_bytes();
            chunk.copy_from_slice(&bytes[..chunk.len()]);
        });
        header
    }
}

fn main() -> ExitCode {
    match babble() {
        Ok(()) | Err(Failure::Stopped) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("babbler: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn babble() -> Result<(), Failure> {
    let session = Session::from_environment()?;
    let place = Place::from_environment().ok_or_else(Failure::no_scenario)?;
    let mut random = Random(std::env::args().nth(1).and_then(|seed| seed.parse().ok()).unwrap_or(1));
    session.ready()?;
    let domain = Domain::enter(&place, "babbler")?;
    lie(&domain, session.run_id, &session.label);
    on::<Scenario>(&domain, &mut random, session.run_id)?;
    on::<Snapshot>(&domain, &mut random, session.run_id)?;
    on::<Density>(&domain, &mut random, session.run_id)?;
    on::<Passage>(&domain, &mut random, session.run_id)?;
    on::<Comparison>(&domain, &mut random, session.run_id)?;
    on::<Roster>(&domain, &mut random, session.run_id)?;
    on::<Status>(&domain, &mut random, session.run_id)?;
    loop {
        session.wait(&[])?;
    }
}

/// Publishes headers of random bytes; every other one names the right run, in its first eight bytes.
fn on<T: Topic<Header: Pod>>(domain: &Domain, random: &mut Random, run_id: u64) -> Result<(), Failure> {
    let outlet = domain.outlet::<T>(16)?;
    for count in 0..MESSAGES {
        let mut header: T::Header = random.header();
        if count % 2 == 0 {
            bytes_of_mut(&mut header)[..8].copy_from_slice(&run_id.to_ne_bytes());
        }
        let items = vec![T::Item::default(); random.next() as usize % 16];
        let _ = outlet.send_items(header, &items); // there may be no reader
    }
    Ok(())
}

/// Sends, in good form, messages that only other nodes may send.
fn lie(domain: &Domain, run_id: u64, label: &str) {
    let said = || -> Result<(), messages::port::PortError> {
        let status = domain.outlet::<Status>(2)?;
        for (role, node, event) in [
            (role::RECORDER, "recorder", event::DONE),
            (role::ESTIMATOR, "estimator", event::FAILED),
            (role::CASE, "mc", event::FAILED),
            // Under the label of the babbler itself, which is told by its role alone.
            (role::RECORDER, label, event::DONE),
        ] {
            let header = StatusHeader {
                run_id,
                event,
                role,
                subject_role: role,
                node: pack(node),
                subject: pack(node),
                ..StatusHeader::default()
            };
            status.send_items(header, &[0.0; 2])?;
        }
        let label = pack("mc");
        let snapshot = SnapshotHeader { run_id, count: 5, rows: 1, label, ..SnapshotHeader::default() };
        let snapshot = snapshot.with(Samples::INDEPENDENT);
        domain.outlet::<Snapshot>(2)?.send_items(snapshot, &[1.0, 0.5])?;
        let density = DensityHeader { run_id, count: 5, quantities: 1, label, ..DensityHeader::default() };
        domain.outlet::<Density>(3)?.send_items(density, &[1.0; 3])?;
        let end = ComparisonHeader { run_id, kind: comparison::END, ..ComparisonHeader::default() };
        domain.outlet::<Comparison>(1)?.send_items(end, &[])
    };
    let _ = said();
}
