//! How messages become rows of the tables of a results folder.

use std::sync::Arc;

use messages::layout::{DISTANCE_COLUMNS, DensityHeader, ERROR_COLUMNS, PASSAGE_COLUMNS};
use messages::payload;
use messages::text::unpack;
use results::MomentsRow;
use results::diagnostic_names::{OF_A_MESH, OF_A_MIXTURE, OF_A_STATED_DENSITY};
use results::moments::standard_error;
use results::rows::{DiagnosticRow, DistanceRow, EffortRow, ErrorRow, PassageRow};

use super::{RecordedComparison, RecordedPassage};
use crate::services::reading::Reading;
use density::trust::Diagnosis;
use kit::diagnosis;
use kit::space::{Quantity, Space};

/// The columns of numbers of `moments.csv`, which follow from the space, the standard errors among them.
pub(super) fn moments_columns(space: &Space) -> Arc<[String]> {
    let moments = space.moments();
    let of_angles = space.quantities().split_off(moments.len());
    let column = |quantity: &Quantity| space.column(*quantity);
    moments
        .iter()
        .map(column)
        .chain(moments.iter().map(|quantity| standard_error(&column(quantity))))
        .chain(of_angles.iter().map(column))
        .chain(["mass_on_grid".into()])
        .collect()
}

pub(super) fn moments(scenario: &str, method: &str, columns: &Arc<[String]>, reading: &Reading) -> MomentsRow {
    let (moments, of_angles) = reading.values().split_at(reading.space.moments().len());
    let numbers = [moments, &reading.errors()[..moments.len()], of_angles, &[reading.header.mass_on_grid]].concat();
    MomentsRow {
        scenario: scenario.into(),
        method: method.into(),
        t_yr: reading.header.time,
        columns: columns.clone(),
        numbers,
    }
}

const MEASURES: [&str; DISTANCE_COLUMNS] = ["total_variation", "l2", "hellinger", "kullback_leibler", "kolmogorov"];

pub(super) fn errors(scenario: &str, method: &str, recorded: &RecordedComparison, space: &Space) -> Vec<ErrorRow> {
    let row = |(quantity, row): (Quantity, &[f64])| ErrorRow {
        scenario: scenario.into(),
        method: method.into(),
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

pub(super) fn distances(
    scenario: &str,
    method: &str,
    recorded: &RecordedComparison,
    space: &Space,
) -> Vec<DistanceRow> {
    let row = |density: &str, measure: &str, value| DistanceRow {
        scenario: scenario.into(),
        method: method.into(),
        reference: unpack(&recorded.header.reference),
        t_yr: recorded.header.time,
        density: density.into(),
        measure: measure.into(),
        value,
    };
    let table = space.projections.iter().zip(recorded.values.chunks_exact(DISTANCE_COLUMNS));
    let distances = table.flat_map(|(projection, values)| {
        let density = space.density_name(projection);
        // A density of two variables has no distribution function to compare.
        let is_known = |measure: &str| projection.second.is_none() || measure != "kolmogorov";
        // A density that one of the two says nothing of has no distance.
        let is_stated = values.iter().any(|value| !value.is_nan());
        let known = MEASURES.iter().zip(values).filter(|(measure, _)| is_stated && is_known(measure));
        known.map(|(&measure, &value)| row(&density, measure, value)).collect::<Vec<_>>()
    });
    let missing = recorded.values.get(space.projections.len() * DISTANCE_COLUMNS).copied().unwrap_or(f64::NAN);
    let first = space.projections.first().map_or(String::new(), |projection| space.density_name(projection));
    distances.chain([row(&first, "mass_outside_grid", missing)]).collect()
}

pub(super) fn effort(scenario: &str, method: &str, recorded: &RecordedComparison, trajectories: f64) -> Vec<EffortRow> {
    const COLUMNS: usize = payload::EFFORT.len();
    let Some(&values) = recorded.values.first_chunk::<COLUMNS>() else { return Vec::new() };
    let [t_prop_s, t_int_s, t_cal_s, ratio_to_baseline] = values;
    let (scenario, method) = (scenario.into(), method.into());
    vec![EffortRow { scenario, method, t_prop_s, t_int_s, t_cal_s, ratio_to_baseline, trajectories }]
}

pub(super) fn passages(scenario: &str, method: &str, recorded: &RecordedPassage) -> Vec<PassageRow> {
    let row = |row: &[f64]| PassageRow {
        scenario: scenario.into(),
        method: method.into(),
        t_yr: row[0],
        prob_reached_critical_e: row[1],
        low: row[2],
        high: row[3],
        interval: interval_of(row, recorded.header.samples).into(),
    };
    recorded.values.chunks_exact(PASSAGE_COLUMNS).map(row).collect()
}

/// The type of the interval of a row: a confidence interval if the curve was counted from `samples` samples, strict
/// bounds if the probability is withheld, else the method's own estimate of its error.
pub fn interval_of(row: &[f64], samples: u64) -> &'static str {
    match (row[2].is_nan(), row[1].is_nan(), samples) {
        (true, ..) => "",
        (_, true, _) => "bounds",
        (_, _, 0) => "error estimate",
        _ => "95 %",
    }
}

/// What a method says of its own reliability, number by number with its name.
pub fn named(diagnosis: Diagnosis) -> Vec<(&'static str, f64)> {
    let (names, values): (&[&str], _) = match diagnosis {
        Diagnosis::None => return Vec::new(),
        Diagnosis::Mesh { measure_defect, flipped_mass, truncated_mass, misplaced_mass } => {
            (&OF_A_MESH, vec![measure_defect, flipped_mass, truncated_mass, misplaced_mass])
        }
        Diagnosis::Mixture { disagreement, .. } => (&OF_A_MIXTURE, vec![disagreement]),
        Diagnosis::Stated { moments, resultant, probability, joint } => {
            (&OF_A_STATED_DENSITY, vec![moments, resultant, probability, joint])
        }
    };
    names.iter().copied().zip(values).collect()
}

pub(super) fn diagnostics(scenario: &str, method: &str, header: &DensityHeader) -> Vec<DiagnosticRow> {
    let diagnosis = diagnosis::of(header);
    let carried = Some(("carried_density_error", header.carried_density_error)).filter(|(_, error)| error.is_finite());
    let carried = carried.filter(|_| matches!(diagnosis, Diagnosis::Mesh { .. }));
    let interpolated = Some(("trajectory_error", header.trajectory_error)).filter(|(_, error)| *error > 0.0);
    let row = |(name, value): (&str, f64)| DiagnosticRow {
        scenario: scenario.into(),
        method: method.into(),
        t_yr: header.time,
        diagnostic: name.into(),
        value,
    };
    named(diagnosis).into_iter().chain(carried).chain(interpolated).map(row).collect()
}
