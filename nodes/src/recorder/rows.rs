//! The rows of the tables of a results folder, and how messages become rows.

use messages::layout::{DISTANCE_COLUMNS, DensityHeader, ERROR_COLUMNS, PASSAGE_COLUMNS, diagnostic};
use messages::text::unpack;
use serde::Serialize;

use super::{RecordedComparison, RecordedPassage};
use crate::comparator::QUANTITIES;

/// A row of `moments.csv`. `se_` columns are standard errors, NaN where the method has none.
#[derive(Debug, Default, Serialize)]
pub(super) struct MomentsRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_yr: f64,
    mean_phi_rad: f64,
    std_phi_rad: f64,
    mean_e: f64,
    std_e: f64,
    cov_phi_e: f64,
    prob_above_critical_e: f64,
    se_mean_phi_rad: f64,
    se_std_phi_rad: f64,
    se_mean_e: f64,
    se_std_e: f64,
    se_cov_phi_e: f64,
    se_prob_above_critical_e: f64,
    circular_mean_phi_rad: f64,
    resultant_length: f64,
    mass_on_grid: f64,
}

/// A row of `errors.csv`.
#[derive(Debug, Default, Serialize)]
pub(super) struct ErrorRow<'a> {
    scenario: &'a str,
    method: &'a str,
    reference: String,
    t_yr: f64,
    quantity: &'static str,
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
    density: &'static str,
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

/// A row of `first_passage.csv`: the probability that `e` has ever reached its critical value by `t_yr`, with an interval and what
/// that is, see [`interval_of`]; NaN without one. A probability that is NaN in an interval is withheld.
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

const DENSITIES: [&str; 3] = ["joint", "marginal_phi", "marginal_e"];
const MEASURES: [&str; DISTANCE_COLUMNS] = ["total_variation", "l2", "hellinger", "kullback_leibler", "kolmogorov"];

pub(super) fn moments<'a>(scenario: &'a str, method: &'a str, header: &DensityHeader) -> MomentsRow<'a> {
    let [mean_phi_rad, std_phi_rad, mean_e, std_e, cov_phi_e, prob_above_critical_e] = header.moments;
    let errors = header.standard_errors;
    MomentsRow {
        scenario,
        method,
        t_yr: header.time,
        mean_phi_rad,
        std_phi_rad,
        mean_e,
        std_e,
        cov_phi_e,
        prob_above_critical_e,
        se_mean_phi_rad: errors[0],
        se_std_phi_rad: errors[1],
        se_mean_e: errors[2],
        se_std_e: errors[3],
        se_cov_phi_e: errors[4],
        se_prob_above_critical_e: errors[5],
        circular_mean_phi_rad: header.circular_mean,
        resultant_length: header.resultant,
        mass_on_grid: header.mass_on_grid,
    }
}

pub(super) fn errors<'a>(scenario: &'a str, method: &'a str, recorded: &RecordedComparison) -> Vec<ErrorRow<'a>> {
    let row = |(quantity, row): (&&'static str, &[f64])| ErrorRow {
        scenario,
        method,
        reference: unpack(&recorded.header.reference),
        t_yr: recorded.header.time,
        quantity,
        value: row[0],
        reference_value: row[1],
        abs_error: row[2],
        rel_error: row[3],
    };
    // NaN is what one of the two withholds, or what is compared with another reference.
    let is_compared = |(_, row): &(&&str, &[f64])| !row[2].is_nan();
    QUANTITIES.iter().zip(recorded.values.chunks_exact(ERROR_COLUMNS)).filter(is_compared).map(row).collect()
}

pub(super) fn distances<'a>(scenario: &'a str, method: &'a str, recorded: &RecordedComparison) -> Vec<DistanceRow<'a>> {
    let row = |density, measure, value| DistanceRow {
        scenario,
        method,
        reference: unpack(&recorded.header.reference),
        t_yr: recorded.header.time,
        density,
        measure,
        value,
    };
    let table = DENSITIES.iter().zip(recorded.values.chunks_exact(DISTANCE_COLUMNS));
    let distances = table.flat_map(|(&density, values)| {
        // A joint density has no distribution function to compare.
        let known = MEASURES.iter().zip(values).filter(move |(m, _)| density != "joint" || **m != "kolmogorov");
        known.map(move |(&measure, &value)| row(density, measure, value))
    });
    let missing = recorded.values.get(DENSITIES.len() * DISTANCE_COLUMNS).copied().unwrap_or(f64::NAN);
    distances.chain([row("joint", "mass_outside_grid", missing)]).collect()
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

/// What the interval of a row is: of confidence if `samples` were counted, strict bounds if the probability is withheld, else the
/// method's own estimate of its error.
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
