//! `cargo +nightly fuzz run message`: messages as a foreign publisher may send them, given to the code with which nodes
//! read them.
#![no_main]

use bytemuck::{Pod, bytes_of_mut};
use density::model::planar::SrpJ2;
use density::grid::{Axis, Grid};
use density::problem::{InitialGaussian, Problem};
use messages::content::{Characteristics, Content, Density as Ready, Lattice, Mixture, Reduced, Samples};
use messages::layout::{
    ComparisonHeader, DensityHeader, PassageHeader, RosterEntry, RosterHeader, SnapshotHeader,
};
use messages::text::pack;
use messages::topic::{Comparison, Density, Passage, Roster, Scenario};
use kit::assignment::Assignment;
use nodes::services::estimation::CaseEstimator;
use kit::screen::Screened;
use kit::snapshot_rules::decode;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&[topic, kind, rows, changes], rest)) = bytes.split_first_chunk() else { return };
    let (changes, items) = rest.split_at(rest.len().min(2 * usize::from(changes % 16)));
    let items: Vec<f64> = match topic & 8 {
        // Either any bits, or numbers that a cloud could have.
        0 => items.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect(),
        _ => items.iter().map(|&byte| f64::from(byte) / 256.0).collect(),
    };
    match topic % 8 {
        0 => judge::<Density>(DensityHeader::default(), changes, &items),
        1 => judge::<Passage>(PassageHeader { rows: rows.into(), ..PassageHeader::default() }, changes, &items),
        2 => {
            judge::<Comparison>(ComparisonHeader { kind: kind.into(), ..ComparisonHeader::default() }, changes, &items)
        }
        3 => {
            let entry = change(RosterEntry::default(), changes);
            let _ = Roster::check(&change(RosterHeader::default(), changes), &[entry]);
        }
        4 => scenario(changes, &items),
        _ => estimate(kind % 6, u32::from(rows), changes, items),
    }
});

/// Overwrites bytes: pairs of position and value.
fn change<H: Pod>(mut header: H, changes: &[u8]) -> H {
    let bytes = bytes_of_mut(&mut header);
    for pair in changes.chunks_exact(2) {
        bytes[usize::from(pair[0]) % size_of::<H>()] = pair[1];
    }
    header
}

fn judge<T: Screened<Item = f64>>(header: T::Header, changes: &[u8], items: &[f64])
where
    T::Header: Pod,
{
    let _ = T::check(&change(header, changes), items);
}

fn scenario(changes: &[u8], items: &[f64]) {
    let (header, mut good) = assignment().to_parts().expect("it fits");
    for (good, bad) in good.iter_mut().zip(items) {
        *good = *bad;
    }
    let _ = Scenario::check(&change(header, changes), &good);
}

/// The content of a snapshot with the given number of rows.
fn content(kind: u8, rows: u32) -> Content {
    let lattice = (rows.isqrt().pow(2) == rows).then_some(Lattice { side: rows.isqrt(), degree: 1 });
    match kind {
        0 => Samples::INDEPENDENT.into(),
        1 => Mixture::UNJUDGED.into(),
        2 => Ready.into(),
        3 => Reduced.into(),
        4 => Characteristics::CarriedMesh { lattice }.into(),
        _ => Characteristics::HullMesh { resolution: 10, as_printed: false }.into(),
    }
}

/// Estimates a snapshot, if it passes the checks, and requires a finite result.
fn estimate(kind: u8, rows: u32, changes: &[u8], mut items: Vec<f64>) {
    let columns = content(kind, rows).columns().len() as u32;
    let rows = rows.min(items.len() as u32 / columns);
    items.truncate((rows * columns) as usize);
    let content = content(kind, rows);
    let header = SnapshotHeader { run_id: 7, count: 2, rows, label: pack("mine"), ..SnapshotHeader::default() };
    let header = header.with(content);
    let (assignment, mut case) = (assignment(), CaseEstimator::default());
    for header in [header, SnapshotHeader { index: 1, time: 0.5, ..header }] {
        let header = change(header, changes);
        let Ok(snapshot) = decode(&header, &items, &assignment, case.snapshots_done()) else { return };
        let Ok(estimated) = case.estimate(&snapshot, &assignment) else { return };
        let estimate = estimated.estimate;
        assert!(estimate.joint.iter().chain(&estimate.marginal_phi).chain(&estimate.marginal_e).all(|n| n.is_finite()));
        assert!(estimate.moments.to_array().iter().all(|moment| moment.is_finite()));
    }
}

fn assignment() -> Assignment {
    let grid = Grid { phi: Axis { low: 0.0, high: 6.0, bins: 4 }, e: Axis { low: 0.0, high: 0.9, bins: 3 } };
    Assignment {
        run_id: 7,
        name: "scenario-1".into(),
        scenario: 0,
        scenarios: 1,
        problem: Problem {
            model: SrpJ2 { radiation: 0.15, oblateness: 0.4 }.into(),
            initial: InitialGaussian { mean_phi: 2.0, mean_e: 0.1, sigma_phi: 0.1, sigma_e: 0.01, correlation: 0.0 },
            times: vec![0.0, 0.5],
            critical_e: 0.6,
        },
        grids: vec![grid; 2],
    }
}
