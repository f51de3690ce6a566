//! The topics: which header and which items a message has, and how many messages a topic holds.
//!
//! Three default settings of iceoryx2 lose data silently. Here every reader's buffer holds all messages that a
//! scenario can bring, publishers keep them as history for readers that come late or are restarted, and a publisher
//! that would have to wait waits a bounded time and then fails with an error. Two topics are *latched* instead: only
//! the latest scenario and the latest roster count, so a reader that has missed earlier ones has missed nothing.

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;

use crate::comparison_kind::ComparisonKind;
use crate::content;
use crate::describe::{Described, Field, Value};
use crate::layout::{
    ComparisonHeader, DensityHeader, PassageHeader, RosterEntry, RosterHeader, SnapshotHeader, StatusHeader,
};
use crate::payload::{self, Item, Shape, rows};
use crate::scenario::{self, ScenarioHeader};

/// A topic of the contract.
pub trait Topic: 'static {
    /// The header of every message.
    type Header: Described + ZeroCopySend + Debug + Default + Copy + 'static;
    /// The type of the items of a payload.
    type Item: Item + ZeroCopySend + Debug + Default + Copy + 'static;
    /// Name of the topic's services: publish-subscribe for the messages, event to wake its readers.
    const NAME: &'static str;
    /// Who sends to whom, line by line.
    const DOC: &'static [&'static str];
    /// How [`Topic::depth`] is computed.
    const DEPTH: &'static str;
    /// Whether only the latest message counts: a later reader gets only that one, and a publisher never waits for a
    /// reader.
    const LATCHED: bool;
    /// The run that a message belongs to.
    fn run_id(header: &Self::Header) -> u64;
    /// The scenario that a message belongs to, by its position in the run.
    fn scenario(header: &Self::Header) -> u32;
    /// The same header in run `run_id`.
    fn in_run(header: Self::Header, run_id: u64) -> Self::Header;
    /// Number of messages of one publisher that a reader's buffer holds. Unless the topic is latched, as many are
    /// kept for later readers.
    fn depth(capacity: &Capacity) -> usize;
    /// How the payload forms a table; a topic of entries has none.
    fn shape(header: &Self::Header) -> Shape;
    /// The fields that a header has depending on the value of another field, its kind or the length of a list: their
    /// names, and their offsets from the beginning of the header.
    fn details(_header: &Self::Header) -> Vec<(String, Field)> {
        Vec::new()
    }

    /// All fields of a header by name, also [`Topic::details`], with their values.
    fn values(header: &Self::Header) -> Vec<(String, Field, Value)> {
        let bytes = bytemuck::bytes_of(header);
        let fields = Self::Header::FIELDS.iter().map(|field| (field.name.to_owned(), *field));
        let with_value = |(name, field): (String, Field)| Some((name, field, field.value(bytes)?));
        fields.chain(Self::details(header)).filter_map(with_value).collect()
    }
}

/// The figures of a run that determine the sizes of its topics; the launcher creates the topics accordingly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacity {
    /// Processes that publish snapshots: every shard of a case is one.
    pub propagators: usize,
    /// Cases; a case counts once, however many shards it has.
    pub cases: usize,
    /// Snapshots of the longest scenario.
    pub snapshots: usize,
    /// Other hosts that take part.
    pub hosts: usize,
}

impl Capacity {
    /// Most processes and threads that may open the topics at once: the nodes, the launcher, the threads that carry
    /// the messages of each other host, and a few observers.
    pub fn nodes(&self) -> usize {
        self.propagators + 4 * self.hosts + 16
    }
}

macro_rules! topic {
    (
        $(#[doc = $doc:literal])* $topic:ident, $name:literal, $header:ty, [$item:ty], latched: $latched:literal,
        |$capacity:ident| $depth:expr, |$shaped:ident| $shape:expr $(, details: $details:expr)?
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy)]
        pub struct $topic;

        impl Topic for $topic {
            type Header = $header;
            type Item = $item;
            const NAME: &'static str = $name;
            const DOC: &'static [&'static str] = &[$($doc),*];
            const DEPTH: &'static str = stringify!($depth);
            const LATCHED: bool = $latched;
            fn run_id(header: &Self::Header) -> u64 {
                header.run_id
            }
            fn scenario(header: &Self::Header) -> u32 {
                header.scenario
            }
            fn in_run(header: Self::Header, run_id: u64) -> Self::Header {
                Self::Header { run_id, ..header }
            }
            fn depth($capacity: &Capacity) -> usize {
                $depth
            }
            fn shape($shaped: &Self::Header) -> Shape {
                $shape
            }
            $(fn details(header: &Self::Header) -> Vec<(String, Field)> {
                $details(header)
            })?
        }
    };
}

topic!(
    /// From the scenario node to all others: the problem to work on now.
    Scenario, "phasecloud/scenario", ScenarioHeader, [f64], latched: true,
    |_capacity| 16, |header| scenario::shape(header), details: scenario::fields
);
topic!(
    /// From the propagators to the estimator.
    Snapshot, "phasecloud/snapshot", SnapshotHeader, [f64], latched: false,
    |capacity| capacity.snapshots, |header| of_snapshot(header), details: content::fields
);
topic!(
    /// From the estimator to the comparator and the recorder.
    Density, "phasecloud/density", DensityHeader, [f64], latched: false,
    |capacity| 2 * capacity.snapshots * capacity.cases, |_header| rows(&["quantities, their standard errors, densities"])
);
topic!(
    /// From the propagators to the recorder.
    Passage, "phasecloud/passage", PassageHeader, [f64], latched: false,
    |_capacity| 2, |header| of_passage(header)
);
topic!(
    /// From the comparator to the recorder.
    Comparison, "phasecloud/comparison", ComparisonHeader, [f64], latched: false,
    |capacity| 4 * (capacity.snapshots + 1) * capacity.cases + 1, |header| of_comparison(header)
);
topic!(
    /// From every node to the launcher and the scenario node.
    Status, "phasecloud/status", StatusHeader, [f64], latched: false,
    |_capacity| 256, |_header| rows(&payload::STATUS)
);
topic!(
    /// From the launcher to the comparator and the recorder: which cases take part and which have failed.
    Roster, "phasecloud/roster", RosterHeader, [RosterEntry], latched: true,
    |_capacity| 16, |_header| rows(&[])
);
topic!(
    /// From any process that asks for a scenario to the scenario node of a service, which gives the scenario a
    /// position in the run.
    Request, "phasecloud/request", ScenarioHeader, [f64], latched: false,
    |_capacity| 64, |header| scenario::shape(header), details: scenario::fields
);

/// An operation on a topic that is chosen at run time.
pub trait Visitor {
    /// What the operation returns.
    type Out;
    /// Performs the operation.
    fn visit<T: Topic>(&mut self) -> Self::Out;
}

/// Performs an operation on every topic, in the order in which messages flow.
pub fn for_each<V: Visitor>(visitor: &mut V) -> [V::Out; 8] {
    [
        visitor.visit::<Scenario>(),
        visitor.visit::<Snapshot>(),
        visitor.visit::<Passage>(),
        visitor.visit::<Density>(),
        visitor.visit::<Comparison>(),
        visitor.visit::<Status>(),
        visitor.visit::<Roster>(),
        visitor.visit::<Request>(),
    ]
}

/// A snapshot: the columns of its kind, one after the other.
fn of_snapshot(header: &SnapshotHeader) -> Shape {
    let in_plane = content::table(header.kind).map_or(&[][..], |kind| kind.columns);
    let columns = header.columns as usize;
    if columns == in_plane.len() {
        return payload::table(in_plane, true);
    }
    // The names of the variables of another space are in the scenario message.
    Shape { head: 0, columns: (0..columns.min(64)).map(|k| format!("column {k}")).collect(), by_column: true }
}

/// A first-passage curve, with or without what re-entry says of an uncertain parameter.
fn of_passage(header: &PassageHeader) -> Shape {
    match header.given {
        0 => rows(&payload::PASSAGE),
        _ => rows(&[&payload::PASSAGE[..], &payload::GIVEN].concat()),
    }
}

/// A comparison: its kind decides on the columns.
fn of_comparison(header: &ComparisonHeader) -> Shape {
    rows(match header.content() {
        Some(ComparisonKind::Moments) => &payload::ERRORS,
        Some(ComparisonKind::Distances) => &payload::DISTANCES,
        Some(ComparisonKind::Effort) => &payload::EFFORT,
        Some(ComparisonKind::End) | None => &[],
    })
}
