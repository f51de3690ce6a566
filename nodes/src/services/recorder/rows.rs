//! The rows of the tables of a results folder, and how messages become rows.

use messages::layout::{DISTANCE_COLUMNS, DensityHeader, ERROR_COLUMNS, PASSAGE_COLUMNS, diagnostic};
use messages::text::unpack;
use serde::Serialize;

use super::{RecordedComparison, RecordedPassage};
use crate::services::reading::Reading;
use kit::space::{Quantity, Space};

/// The columns of `moments.csv`, which follow from the space. `se_` columns are standard errors, NaN where the method has none.
pub(super) fn moments_head(space: &Space) -> Vec<String> {
    let moments = space.moments();
    let of_angles = space.quantities().split_off(moments.len());
    let column = |quantity: &Quantity| space.column(*quantity);
    ["scenario", "method", "t_yr"]
        .map(String::from)
        .into_iter()
        .chain(moments.iter().map(column))
        .chain(moments.iter().map(|quantity| format!("se_{}", column(quantity))))
        .chain(of_angles.iter().map(column))
        .chain(["mass_on_grid".into()])
        .collect()
}

/// A row of `moments.csv`.
pub(super) fn moments<'a>(scenario: &'a str, method: &'a str, reading: &Reading) -> (&'a str, &'a str, f64, Vec<f64>) {
    let (moments, of_angles) = reading.values().split_at(reading.space.moments().len());
    let numbers = [moments, &reading.errors()[..moments.len()], of_angles, &[reading.header.mass_on_grid]].concat();
    (scenario, method, reading.header.time, numbers)
}

/// A row of `errors.csv`.
#[derive(Debug, Default, Serialize)]
pub(super) struct ErrorRow<'a> {
    scenario: &'a str,
    method: &'a str,
    reference: String,
    t_yr: f64,
    quantity: String,
    value: f64,
    reference_value: f64,
    abs_error: f64,
    rel_error: f64,
}

/// A row of `distances.csv`.
#[derive(Debug, Default, Serialize)]
pub(super) struct DistanceRow<'a> {
    scenario: &'a str,
    method: &'a str,
    reference: String,
    t_yr: f64,
    density: String,
    measure: &'static str,
    value: f64,
}

/// A row of `effort.csv`.
#[derive(Debug, Default, Serialize)]
pub(super) struct EffortRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_prop_s: f64,
    t_int_s: f64,
    t_cal_s: f64,
    ratio_to_mc: f64,
    trajectories: f64,
}

/// A row of `first_passage.csv`: the probability that `e` has ever reached its critical value by `t_yr`, with an
/// interval (NaN if there is none) and the type of this interval, see [`interval_of`]. A probability that is NaN
/// between two ends is withheld.
#[derive(Debug, Default, Serialize)]
pub(super) struct PassageRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_yr: f64,
    prob_reached_critical_e: f64,
    low: f64,
    high: f64,
    interval: &'static str,
}

/// A row of `diagnostics.csv`.
#[derive(Debug, Default, Serialize)]
pub(super) struct DiagnosticRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_yr: f64,
    diagnostic: &'static str,
    value: f64,
}

const MEASURES: [&str; DISTANCE_COLUMNS] = ["total_variation", "l2", "hellinger", "kullback_leibler", "kolmogorov"];

pub(super) fn errors<'a>(
    scenario: &'a str,
    method: &'a str,
    recorded: &RecordedComparison,
    space: &Space,
) -> Vec<ErrorRow<'a>> {
    let row = |(quantity, row): (Quantity, &[f64])| ErrorRow {
        scenario,
        method,
        reference: unpack(&recorded.header.reference),
        t_yr: recorded.header.time,
        quantity: space.name(quantity),
        value: row[0],
        reference_value: row[1],
        abs_error: row[2],
        rel_error: row[3],
    };
    // NaN means that one of the two withholds the quantity, or that it is compared with another reference.
    let is_compared = |(_, row): &(Quantity, &[f64])| !row[2].is_nan();
    let rows = space.quantities().into_iter().zip(recorded.values.chunks_exact(ERROR_COLUMNS));
    rows.filter(is_compared).map(row).collect()
}

pub(super) fn distances<'a>(
    scenario: &'a str,
    method: &'a str,
    recorded: &RecordedComparison,
    space: &Space,
) -> Vec<DistanceRow<'a>> {
    let row = |density: &str, measure, value| DistanceRow {
        scenario,
        method,
        reference: unpack(&recorded.header.reference),
        t_yr: recorded.header.time,
        density: density.into(),
        measure,
        value,
    };
    let table = space.projections.iter().zip(recorded.values.chunks_exact(DISTANCE_COLUMNS));
    let distances = table.flat_map(|(projection, values)| {
        let density = space.density_name(projection);
        // A density of two variables has no distribution function to compare.
        let is_known = |measure: &str| projection.second.is_none() || measure != "kolmogorov";
        let known = MEASURES.iter().zip(values).filter(|(measure, _)| is_known(measure));
        known.map(|(&measure, &value)| row(&density, measure, value)).collect::<Vec<_>>()
    });
    let missing = recorded.values.get(space.projections.len() * DISTANCE_COLUMNS).copied().unwrap_or(f64::NAN);
    let first = space.projections.first().map_or(String::new(), |projection| space.density_name(projection));
    distances.chain([row(&first, "mass_outside_grid", missing)]).collect()
}

pub(super) fn effort<'a>(
    scenario: &'a str,
    method: &'a str,
    recorded: &RecordedComparison,
    trajectories: f64,
) -> Vec<EffortRow<'a>> {
    match recorded.values[..] {
        [t_prop_s, t_int_s, t_cal_s, ratio_to_mc] => {
            vec![EffortRow { scenario, method, t_prop_s, t_int_s, t_cal_s, ratio_to_mc, trajectories }]
        }
        _ => Vec::new(),
    }
}

pub(super) fn passages<'a>(scenario: &'a str, method: &'a str, recorded: &RecordedPassage) -> Vec<PassageRow<'a>> {
    let row = |row: &[f64]| PassageRow {
        scenario,
        method,
        t_yr: row[0],
        prob_reached_critical_e: row[1],
        low: row[2],
        high: row[3],
        interval: interval_of(row, recorded.header.samples),
    };
    recorded.values.chunks_exact(PASSAGE_COLUMNS).map(row).collect()
}

/// The type of the interval of a row: a confidence interval if the curve was counted from `samples` samples, strict
/// bounds if the probability is withheld, else the method's own estimate of its error.
fn interval_of(row: &[f64], samples: u64) -> &'static str {
    match (row[2].is_nan(), row[1].is_nan(), samples) {
        (true, ..) => "",
        (_, true, _) => "bounds",
        (_, _, 0) => "error estimate",
        _ => "95 %",
    }
}

/// Names of a message's diagnostics.
fn diagnostic_names(kind: u32) -> &'static [&'static str] {
    match kind {
        diagnostic::MESH => &["measure_defect", "flipped_mass", "truncated_mass"],
        diagnostic::MIXTURE => &["disagreement"],
        diagnostic::NUMERICAL => {
            &["moment_error_sigmas", "resultant_vector_error", "prob_above_critical_e_error", "joint_l1_error"]
        }
        _ => &[],
    }
}

pub(super) fn diagnostics<'a>(scenario: &'a str, method: &'a str, header: &DensityHeader) -> Vec<DiagnosticRow<'a>> {
    let carried = Some((&"carried_density_error", header.carried_density_error)).filter(|(_, error)| error.is_finite());
    let carried = carried.filter(|_| header.diagnostic == diagnostic::MESH);
    let names = diagnostic_names(header.diagnostic).iter().zip(header.diagnostics).chain(carried);
    names.map(|(&diagnostic, value)| DiagnosticRow { scenario, method, t_yr: header.time, diagnostic, value }).collect()
}
