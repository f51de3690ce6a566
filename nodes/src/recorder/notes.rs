//! What a user should know about a result, in words.

use density::mesh::MeshDiagnostics;
use density::mixture::linearity;
use messages::layout::{DensityHeader, diagnostic};
use messages::text::unpack;
use serde::Serialize;

use super::RecordedPassage;

/// An exact density whose own error estimate is above this, in standard deviations, is told.
const MOMENT_ERROR: f64 = 1e-6;
/// Likewise for the L1 error of its joint density.
const JOINT_ERROR: f64 = 1e-3;

/// A row of `notes.csv`; `t_yr` is NaN if the note is about the whole scenario.
#[derive(Debug, Default, Serialize)]
pub(super) struct Note<'a> {
    scenario: &'a str,
    method: &'a str,
    t_yr: f64,
    note: String,
}

/// A warning if a density's own diagnostics call for one.
pub(super) fn of_density<'a>(scenario: &'a str, method: &'a str, header: &DensityHeader) -> Option<Note<'a>> {
    let [first, .., fourth] = header.diagnostics;
    let note = match header.diagnostic {
        diagnostic::MESH if first > MeshDiagnostics::LARGEST_DEFECT => format!(
            "warning: the mesh is too coarse for the flow here (measure defect {first:.2}, above {}); take more points",
            MeshDiagnostics::LARGEST_DEFECT
        ),
        diagnostic::MIXTURE if first > linearity::DISTRUST => format!(
            "warning: components are too wide for the flow here (disagreement {first:.2}, above {}); \
             do not trust the density, split more finely",
            linearity::DISTRUST
        ),
        diagnostic::NUMERICAL if first > MOMENT_ERROR || fourth > JOINT_ERROR => format!(
            "warning: the exact density reached an error estimate of {first:.1e} standard deviations in the moments \
             and {fourth:.1e} in L1"
        ),
        _ => return None,
    };
    Some(Note { scenario, method, t_yr: header.time, note })
}

/// Why a method has no first-passage curve.
pub(super) fn of_passage<'a>(scenario: &'a str, method: &'a str, passage: &RecordedPassage) -> Option<Note<'a>> {
    let reason = unpack(&passage.header.reason);
    let note = format!("no first-passage curve: {reason}");
    passage.values.is_empty().then_some(Note { scenario, method, t_yr: f64::NAN, note })
}
