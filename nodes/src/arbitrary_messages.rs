//! Gives messages with arbitrary bytes to all code that reads headers: none may panic, or accept what is invalid.

use bytemuck::{Pod, bytes_of_mut, cast_slice_mut};
use messages::comparison_kind::ComparisonKind;
use messages::content::{
    Characteristics, Content, DENSITY_HEAD, Density as Ready, Lattice, Mixture, Reduced, Samples, kind,
};
use messages::layout::{ComparisonHeader, DensityHeader, PassageHeader, RosterEntry, RosterHeader, SnapshotHeader};
use messages::scenario::ScenarioHeader;
use messages::text::pack;
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use crate::services::comparator::{self, Results};
use crate::services::estimation::CaseEstimator;
use crate::services::gathering::Gathering;
use crate::services::reading::Reading;
use crate::services::recorder::{Recording, write};
use crate::services::roster::Roster;
use kit::assignment::Assignment;
use kit::example::assignment;
use kit::screen::Screened;
use kit::snapshot_rules::{breaches, decode};

/// Words that break assumptions: ends of ranges, and the upper halves of infinity and NaN.
const WORDS: [u32; 14] = [0, 1, 2, 3, 7, 63, 64, 65, 2001, 1 << 31, u32::MAX, 0x7ff0_0000, 0x7ff8_0000, 0xfff0_0000];

/// Overwrites that turn a good header into a bad one.
type Changes = Vec<(Index, u32)>;

fn changes() -> impl Strategy<Value = Changes> {
    vec((any::<Index>(), prop_oneof![3 => select(&WORDS[..]), 1 => any::<u32>()]), 0..5)
}

fn change<H: Pod>(mut header: H, changes: &Changes) -> H {
    let words: &mut [u32] = cast_slice_mut(bytes_of_mut(&mut header));
    for (at, word) in changes {
        words[at.index(words.len())] = *word;
    }
    header
}

fn arbitrary_header<H: Pod + std::fmt::Debug>() -> impl Strategy<Value = H> {
    vec(any::<u8>(), size_of::<H>()).prop_map(|bytes| bytemuck::pod_read_unaligned(&bytes))
}

/// Any number, and more often one that a cloud could have.
fn number() -> impl Strategy<Value = f64> {
    const EXTREMES: [f64; 10] = [0.0, -0.0, 1.0, -1.0, 1e308, -1e308, 1e-308, 1e16, f64::NAN, f64::INFINITY];
    prop_oneof![12 => 0.0..0.99f64, 1 => -10.0..10.0f64, 1 => select(&EXTREMES[..]), 1 => any::<u64>().prop_map(f64::from_bits)]
}

fn density_header() -> DensityHeader {
    DensityHeader {
        run_id: 7,
        count: 2,
        quantities: 8,
        kind: kind::SAMPLES,
        rows: 5,
        label: pack("mc"),
        ..DensityHeader::default()
    }
}

/// A snapshot of one of the kinds with a correct header and arbitrary numbers.
fn snapshot() -> impl Strategy<Value = (SnapshotHeader, Vec<f64>)> {
    let shape = (0u32..7, 1u32..40, 0u32..4);
    shape.prop_flat_map(|(kind, rows, small)| {
        let is_lattice = rows.isqrt().pow(2) == rows && small % 2 == 0;
        let lattice = is_lattice.then_some(Lattice { side: rows.isqrt(), degree: small });
        let hull = |as_printed| Characteristics::HullMesh { resolution: 10 * small, as_printed };
        let content: Content = match kind {
            0 => Samples { replicates: small }.into(),
            1 => Mixture { disagreement: f64::from(small) }.into(),
            2 => Ready.into(),
            3 => Reduced.into(),
            4 => Characteristics::CarriedMesh { lattice }.into(),
            5 => hull(false).into(),
            _ => hull(true).into(),
        };
        let rows = if kind == 2 { DENSITY_HEAD as u32 + 12 } else { rows };
        let header = SnapshotHeader { run_id: 7, count: 2, rows, label: pack("mine"), ..SnapshotHeader::default() };
        let header = header.with(content);
        (Just(header), vec(number(), (rows * header.columns) as usize))
    })
}

/// Gives two snapshots to the estimator, and returns how many of them it has accepted.
fn estimate(headers: [SnapshotHeader; 2], items: &[f64]) -> usize {
    let (assignment, mut case) = (assignment(), CaseEstimator::default());
    for header in headers {
        let Ok(snapshot) = decode(&header, items, &assignment, case.snapshots_done()) else { break };
        let Ok(estimated) = case.estimate(&snapshot, &assignment) else { break };
        // Only densities that the propagator itself has computed may be withheld, and only as a whole.
        let is_withheld = header.kind == kind::DENSITY && estimated.densities[0].iter().all(|n| n.is_nan());
        let is_finite = estimated.densities.iter().flatten().all(|n| n.is_finite());
        assert!(is_withheld || is_finite, "{header:?} {items:?}");
        let may_be = |value: &f64| value.is_finite() || (header.kind == kind::DENSITY && value.is_nan());
        assert!(estimated.values.iter().all(may_be), "{header:?} {items:?}");
    }
    case.snapshots_done()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_snapshot_is_estimated_or_refused((header, items) in snapshot(), first in changes(), second in changes()) {
        let next = SnapshotHeader { index: 1, time: 0.5, ..header };
        estimate([change(header, &first), change(next, &second)], &items);
    }

    #[test]
    fn snapshots_of_good_headers_and_any_numbers_are_estimated_or_refused((header, items) in snapshot()) {
        estimate([header, SnapshotHeader { index: 1, time: 0.5, ..header }], &items);
    }

    #[test]
    fn arbitrary_headers_are_judged_without_a_panic(
        scenario in arbitrary_header::<ScenarioHeader>(),
        snapshot in arbitrary_header::<SnapshotHeader>(),
        density in arbitrary_header::<DensityHeader>(),
        passage in arbitrary_header::<PassageHeader>(),
        compared in arbitrary_header::<ComparisonHeader>(),
        roster in arbitrary_header::<RosterHeader>(),
        entry in arbitrary_header::<RosterEntry>(),
        items in vec(number(), 0..40),
    ) {
        let assignment = assignment();
        assert!(Scenario::check(&scenario, &items).is_err());
        assert!(!breaches(&snapshot, &items, &assignment, 0).is_empty());
        assert!(Gathering::default().take(&snapshot, &items, &assignment).is_err());
        assert!(Density::check(&density, &items).is_err());
        assert!(Passage::check(&passage, &items).is_err());
        assert!(Comparison::check(&compared, &items).is_err());
        assert!(RosterTopic::check(&roster, &[entry]).is_err());
    }

    #[test]
    fn a_scenario_that_passes_is_one_that_can_be_worked_on(changed in changes(), item in any::<Index>(), value in number()) {
        let (header, mut items) = assignment().to_parts().unwrap();
        let at = item.index(items.len());
        items[at] = value;
        let header = change(header, &changed);
        if Scenario::check(&header, &items).is_ok() {
            let assignment = Assignment::from_parts(&header, &items).unwrap();
            assert!(assignment.axes.iter().flatten().all(|axis| axis.bins <= 2_000));
            assert_eq!(assignment.axes.len(), assignment.times.len());
        }
    }

    #[test]
    fn whatever_passes_the_screen_is_compared_and_recorded(
        headers in vec(changes(), 1..6),
        values in vec(number(), 35),
        compared in vec((1u32..6, changes()), 1..6),
        passages in vec((0u32..66, changes()), 1..3),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let (mut recording, mut results) = (Recording::new(assignment()), Results::default());
        for (index, changed) in headers.iter().enumerate() {
            let header = change(DensityHeader { index: index as u32 % 2, ..density_header() }, changed);
            if Density::check(&header, &values).is_ok() {
                if let Ok(reading) = Reading::new(header, &values, &assignment()) {
                    results.take(reading);
                }
                recording.take_density(header, &values);
            }
        }
        for (kind, changed) in &compared {
            let header = ComparisonHeader { run_id: 7, kind: *kind, label: pack("mc"), ..ComparisonHeader::default() };
            let length = match header.content() {
                Some(ComparisonKind::Moments) => 8 * 4,
                Some(ComparisonKind::Distances) => 17,
                Some(ComparisonKind::Effort) => 4,
                Some(ComparisonKind::End) | None => 0,
            };
            let header = ComparisonHeader { length: length as u32, ..header };
            let header = change(header, changed);
            if Comparison::check(&header, &vec![values[0]; length]).is_ok() {
                recording.take_comparison(header, &vec![values[0]; length]);
            }
        }
        for (rows, changed) in &passages {
            let header = change(PassageHeader { rows: *rows, label: pack("mc"), ..PassageHeader::default() }, changed);
            let items = vec![values[1]; *rows as usize * 4];
            if Passage::check(&header, &items).is_ok() {
                recording.take_passage(header, &items);
            }
        }
        if let Some(case) = results.of("mc") {
            for reading in &case {
                comparator::errors(reading, case[0]);
                comparator::distances(reading, case[0]);
            }
            comparator::effort(&case, None);
        }
        recording.is_complete();
        let roster = Roster { scenario: 0, references: vec!["mc".into()], cases: vec![("mc".into(), false)], ..Roster::default() };
        write(&recording, &roster, &folder.path().join("part"), 0.01).unwrap();
    }
}

#[test]
fn good_snapshots_of_every_kind_pass() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let passed = std::cell::RefCell::new(std::collections::BTreeSet::new());
    runner
        .run(&snapshot(), |(header, items)| {
            if estimate([header, SnapshotHeader { index: 1, time: 0.5, ..header }], &items) == 2 {
                passed.borrow_mut().insert(header.kind);
            }
            Ok(())
        })
        .unwrap();
    let passed = passed.into_inner();
    assert!(passed.contains(&kind::SAMPLES) && passed.contains(&kind::DENSITY), "{passed:?}");
}
