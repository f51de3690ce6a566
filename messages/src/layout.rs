//! The headers, byte for byte.
//!
//! Rules, so that every language sees the same bytes: `#[repr(C)]`; 64-bit fields first, then `u32` in pairs; size a
//! multiple of 8; text NUL-padded UTF-8; codes instead of enums and bools; no pointer. The version is part of the type
//! name, which iceoryx2 compares when a topic is opened: nodes of different versions cannot meet. Payloads are slices
//! of `f64`, or of [`RosterEntry`].

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

pub use crate::content::SnapshotHeader;
use crate::content::{kind, treatment};
use crate::describe::{Codes, Described, Field, FieldType, codes, header};
use crate::payload;
use crate::scenario::range;
use crate::text::Label;

/// All codes.
pub const ALL_CODES: [&Codes; 7] = [
    &range::CODES,
    &kind::CODES,
    &treatment::CODES,
    &diagnostic::CODES,
    &comparison::CODES,
    &event::CODES,
    &role::CODES,
];

codes! {
    /// What the numbers of [`DensityHeader::diagnostics`] are.
    pub mod diagnostic {
        /// No diagnostics.
        pub const NONE: u32 = 0;
        /// Of a carried mesh: defect of the invariant measure, probability of flipped elements, probability outside
        /// the mesh, estimate of the total variation by which the triangles and the interpolation misplace the joint
        /// density.
        pub const MESH: u32 = 1;
        /// Of a mixture: disagreement of the unscented and the linear prediction, probability below `e = 0` that is
        /// left out, sum of the weights (the density is computed with weights scaled to the sum 1), share of the
        /// initial Gaussian beyond `e = 1`.
        pub const MIXTURE: u32 = 2;
        /// Of an exact density: error estimates of the moments (in standard deviations), of the resultant vector, of
        /// the probability above the critical eccentricity, and of the joint density in L1.
        pub const NUMERICAL: u32 = 3;
    }
}

header! {
    /// A density estimated from a snapshot, in the space of the scenario. Payload: `quantities` numbers that describe
    /// the cloud (mean and standard deviation of each variable, the covariances of all pairs, the probability that
    /// the re-entry variable exceeds its critical value at this instant, and for each angle its circular mean in
    /// `[0, 2π)` and its mean resultant length); their standard errors, NaN where the method has none; then the
    /// density on every projection of the scenario, first variable outermost. NaN stands for what the method
    /// withholds: any of the quantities, or all densities and with them `mass_on_grid`.
    #[type_name("phasecloud/DensityHeader/4")]
    pub struct DensityHeader {
        /// Names the run.
        pub run_id: u64,
        /// Time of the snapshot \[yr\].
        pub time: f64 [unit "yr"],
        /// CPU time that the propagator spent on the snapshot \[s\].
        pub propagation_seconds: f64 [unit "s"],
        /// CPU time that the estimator spent on it \[s\].
        pub estimation_seconds: f64 [unit "s"],
        /// Probability on the grid of the first projection; the rest, up to 1, lies outside the grid or was lost.
        pub mass_on_grid: f64,
        /// Figures on the reliability of the method, see [`diagnostic`]; NaN where there are none.
        pub diagnostics: [f64; 4],
        /// Carried meshes only: mean relative error of the densities `n` that came with the points, compared with the
        /// densities that follow from the points alone; else NaN.
        pub carried_density_error: f64,
        /// Trajectories that were followed for it; 0 if the method follows none or does not say.
        pub trajectories: u64,
        /// The propagator's own estimate of the largest error of a coordinate of a trajectory; 0 if it does not say.
        pub trajectory_error: f64,
        /// Position of the scenario in the run.
        pub scenario: u32,
        /// Position of the snapshot in the scenario.
        pub index: u32,
        /// Snapshots in the scenario.
        pub count: u32,
        /// Rows of the snapshot.
        pub rows: u32,
        /// Number of quantities that describe the cloud.
        pub quantities: u32,
        /// What the snapshot's columns were, see [`kind`].
        pub kind: u32 [codes kind::CODES],
        /// What `diagnostics` are, see [`diagnostic`].
        pub diagnostic: u32 [codes diagnostic::CODES],
        /// 0.
        pub reserved: u32,
        /// The propagator's label.
        pub label: Label,
    }
}

header! {
    /// The probability that the eccentricity has ever reached its critical value by time `t`. Payload: one row of
    /// [`PASSAGE_COLUMNS`] numbers per time; no rows if the method has no curve. If the shards of a case count their
    /// curves from samples, these counts are added up; otherwise the curve of shard 0 is the curve of the case. Where
    /// the radiation parameter is uncertain, [`GIVEN_COLUMNS`] numbers more may stand in every row.
    #[type_name("phasecloud/PassageHeader/4")]
    pub struct PassageHeader {
        /// Names the run.
        pub run_id: u64,
        /// CPU time spent on it \[s\].
        pub seconds: f64 [unit "s"],
        /// Equally weighted samples from which the curve was counted: each of its probabilities is a count divided by
        /// this number; 0 if the curve was not counted.
        pub samples: u64,
        /// Position of the scenario in the run.
        pub scenario: u32,
        /// Rows of the payload.
        pub rows: u32,
        /// Which shard of the case sent it, from 0.
        pub shard: u32,
        /// Shards of the case; 0 or 1 if the case is not split.
        pub shards: u32,
        /// 1 if the counted samples depend on one another, as pairs of opposites or the points of a sequence do; 0 if
        /// they are independent or nothing was counted. The counts of dependent samples get no interval.
        pub dependent: u32,
        /// 1 if every row goes on with [`GIVEN_COLUMNS`] numbers, else 0.
        pub given: u32,
        /// The propagator's label.
        pub label: Label,
        /// Why there is no curve, if there is none.
        pub reason: [u8; 192],
    }
}

/// Numbers in a row of a first-passage curve: time \[yr\], probability, lower and upper end of its 95 % interval or,
/// for an exact method, of its error estimate; both ends are NaN where a method has neither.
/// `0 <= low <= probability <= high <= 1`, and probabilities do not fall. A probability that is NaN between a lower
/// and an upper end is withheld: the true value lies between the ends.
pub const PASSAGE_COLUMNS: usize = payload::PASSAGE.len();
/// Numbers with which a row of a first-passage curve may go on: mean and standard deviation of an uncertain radiation
/// parameter `C` given re-entry by the time of the row, the standard errors or error estimates of the two, and the same
/// four given none; NaN where nothing is known.
pub const GIVEN_COLUMNS: usize = payload::GIVEN.len();
/// Most numbers in the payload of a first-passage curve.
pub const MOST_PASSAGE: usize = PASSAGE_TIMES * (PASSAGE_COLUMNS + GIVEN_COLUMNS);
/// Times of a first-passage curve.
pub const PASSAGE_TIMES: usize = 65;

codes! {
    /// What a comparison contains.
    pub mod comparison {
        /// Errors of the quantities of the cloud at one snapshot: one row of [`ERROR_COLUMNS`](super::ERROR_COLUMNS)
        /// numbers per quantity, NaN in the rows of quantities that are not compared with this reference. There is
        /// one message per reference that is used.
        pub const MOMENTS: u32 = 1;
        /// Effort over the whole scenario: [`EFFORT_COLUMNS`](super::EFFORT_COLUMNS) numbers.
        pub const EFFORT: u32 = 2;
        /// Distances of the densities at one snapshot: one row of [`DISTANCE_COLUMNS`](super::DISTANCE_COLUMNS)
        /// numbers per projection of the scenario; then, for each of the two densities on the first projection, by
        /// how much its probability falls short of 1.
        pub const DISTANCES: u32 = 3;
        /// Nothing more comes for this scenario.
        pub const END: u32 = 4;
    }
}

/// Numbers in a row of a comparison of moments: value, reference value, absolute error, relative error.
pub const ERROR_COLUMNS: usize = payload::ERRORS.len();
/// Numbers in a row of distances: total variation, L2, Hellinger, Kullback-Leibler, Kolmogorov.
pub const DISTANCE_COLUMNS: usize = payload::DISTANCES.len();
/// Numbers in a comparison of effort: seconds of propagation, of estimation, their sum, and the ratio of this sum to
/// that of the baseline.
pub const EFFORT_COLUMNS: usize = payload::EFFORT.len();

header! {
    /// How a method compares to the reference, see [`comparison`].
    #[type_name("phasecloud/ComparisonHeader/2")]
    pub struct ComparisonHeader {
        /// Names the run.
        pub run_id: u64,
        /// Time of the snapshot \[yr\].
        pub time: f64 [unit "yr"],
        /// Position of the scenario in the run.
        pub scenario: u32,
        /// Position of the snapshot in the scenario.
        pub index: u32,
        /// What the comparison contains, see [`comparison`].
        pub kind: u32 [codes comparison::CODES],
        /// Numbers in the payload.
        pub length: u32,
        /// Label of the case that is compared.
        pub label: Label,
        /// Label of the reference with which it is compared.
        pub reference: Label,
    }
}

codes! {
    /// What a node reports.
    pub mod event {
        /// The node has opened its topics and waits for work.
        pub const READY: u32 = 1;
        /// The node works. The payload has the units of work done and the units in total (0 if the node does not
        /// know).
        pub const PROGRESS: u32 = 2;
        /// The node has finished the scenario.
        pub const DONE: u32 = 3;
        /// The case named by the subject cannot be completed; the text says why.
        pub const FAILED: u32 = 4;
        /// From the scenario node: the scenario named by the subject has been published. The payload is the number of
        /// the request that asked for it, 0 if none did, and the total number of scenarios in the run, 0 if it is not
        /// known.
        pub const ACCEPTED: u32 = 5;
        /// From the scenario node: the scenario named by the subject cannot be published; the text says why. The
        /// payload's first number is that of the request that asked for it, 0 if none did.
        pub const REFUSED: u32 = 6;
        /// The node cannot go on before the case named by the subject has sent what the text says.
        pub const WAITS_FOR: u32 = 7;
        /// From the bridge: the host named by the subject takes part from now on.
        pub const JOINED: u32 = 8;
        /// From the scenario node: the field `scenario` is the total number of scenarios in the run.
        pub const TOTAL: u32 = 9;
    }
}

codes! {
    /// What a process of the run is.
    pub mod role {
        /// The only process of a case; or the case as a whole, where a report is about it.
        pub const CASE: u32 = 0;
        /// One shard of a case.
        pub const SHARD: u32 = 1;
        /// The scenario node.
        pub const SCENARIO: u32 = 2;
        /// The estimator.
        pub const ESTIMATOR: u32 = 3;
        /// The comparator.
        pub const COMPARATOR: u32 = 4;
        /// The recorder.
        pub const RECORDER: u32 = 5;
        /// The bridge.
        pub const BRIDGE: u32 = 6;
    }
}

header! {
    /// A node's report to the launcher. Payload: two numbers, for most events the units of work done and the units in
    /// total.
    #[type_name("phasecloud/StatusHeader/4")]
    pub struct StatusHeader {
        /// Names the run.
        pub run_id: u64,
        /// What has happened, see [`event`].
        pub event: u32 [codes event::CODES],
        /// Position of the scenario in the run.
        pub scenario: u32,
        /// What the node that reports is, see [`role`].
        pub role: u32 [codes role::CODES],
        /// The number of the shard that reports, from 0; 0 for all others.
        pub shard: u32,
        /// For `FAILED`: what the node is that cannot go on, see [`role`]; else 0.
        pub subject_role: u32 [codes role::CODES],
        /// The number of the shard that cannot go on, from 0; 0 for all others.
        pub subject_shard: u32,
        /// Who reports: the label of a case, or the name of a service.
        pub node: Label,
        /// What the report is about: a case or a service, a scenario or a host, depending on the event; else empty.
        pub subject: Label,
        /// What went wrong, or what is waited for; empty where the event has no text.
        pub text: [u8; 1024],
    }
}

header! {
    /// What the launcher reports about all cases of a scenario. Payload: one [`RosterEntry`] per case, in the order
    /// of the launch file.
    #[type_name("phasecloud/RosterHeader/3")]
    pub struct RosterHeader {
        /// Names the run.
        pub run_id: u64,
        /// Position in the run of the scenario that it is about.
        pub scenario: u32,
        /// 0.
        pub reserved: u32,
    }
}

header! {
    /// One case of a run.
    #[type_name("phasecloud/RosterEntry/7")]
    pub struct RosterEntry {
        /// The propagator's label.
        pub label: Label,
        /// 1 once the case has failed in this scenario, so that nothing more is to be waited for; else 0.
        pub failed: u32,
        /// Processes that share the work of the case; 1 if it is not split, 0 if the number is not known.
        pub shards: u32,
        /// The place of the case among the references, with which all cases are compared: 1 for the first, 2 for the
        /// one that takes its place where the first withholds a quantity or has failed, and so on; 0 if it is no
        /// reference.
        pub reference: u32,
        /// 1 if the effort of all cases is given as a multiple of the effort of this one, else 0.
        pub baseline: u32,
        /// Why the case has failed, if it has; a long text is cut.
        pub reason: [u8; 1024],
    }
}

impl payload::Item for RosterEntry {
    const NAME: &'static str = RosterEntry::TYPE_NAME;
    const FIELDS: &'static [Field] = <RosterEntry as Described>::FIELDS;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_multiples_of_eight_and_known_to_other_languages() {
        assert_eq!(size_of::<crate::scenario::ScenarioHeader>(), 2096);
        assert_eq!(size_of::<SnapshotHeader>(), 184);
        assert_eq!(size_of::<DensityHeader>(), 160);
        assert_eq!(size_of::<ComparisonHeader>(), 96);
        assert_eq!(size_of::<PassageHeader>(), 272);
        assert_eq!(size_of::<StatusHeader>(), 1120);
        assert_eq!(size_of::<RosterHeader>(), 16);
        assert_eq!(size_of::<RosterEntry>(), 1072);
    }
}
