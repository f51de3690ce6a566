//! A built-in method on a scenario, as the node of a run computes it.

use std::path::Path;

use kit::assignment::Assignment;
use kit::passage::Passage;
use kit::{Failure, limits::MOST_BINS};
use messages::content::Content;
use nodes::assigning::Assigning;
use nodes::files::input::{InputError, InputFile};
use nodes::in_process::{self, Computed, Outcome, Wanted};
use nodes::methods::BuiltIn;
use nodes::services::recorder::{interval_of, named};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::errors;
use crate::scenario::Scenario;
use crate::stop::Stop;

/// Number of bins where only the first-passage curve is wanted, which does not depend on them.
const ANY_BINS: (usize, usize) = (1, 1);

/// Computes the case of a method: snapshots with their densities, and the first-passage curve.
#[pyfunction]
pub(crate) fn compute<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    method: &str,
    settings: &str,
    bins: (usize, usize),
    keep_rows: bool,
) -> PyResult<Bound<'py, PyDict>> {
    if [bins.0, bins.1].iter().any(|count| !(1..=MOST_BINS).contains(count)) {
        return Err(errors::value(format!("bins: {bins:?} is not allowed, both must be between 1 and {MOST_BINS}")));
    }
    let (assignment, outcome) =
        carry_out(py, scenario, method, settings, bins, Wanted { columns: keep_rows, ..Wanted::ALL })?;
    let Outcome { snapshots, passage } = outcome;
    let table = PyDict::new(py);
    let told = snapshots.into_iter().enumerate().map(|(index, computed)| snapshot(py, &assignment, index, computed));
    table.set_item("snapshots", PyList::new(py, told.collect::<PyResult<Vec<_>>>()?)?)?;
    match passage {
        Some(Passage::Cannot(reason)) => table.set_item("no_passage", reason)?,
        Some(passage) => table.set_item("passage", curve(py, passage)?)?,
        None => {}
    }
    let space = &assignment.space;
    let quantities = space.quantities();
    table.set_item("quantities", quantities.iter().map(|&quantity| space.column(quantity)).collect::<Vec<_>>())?;
    let densities: Vec<(String, Vec<usize>)> = space
        .projections
        .iter()
        .map(|projection| (space.density_name(projection), projection.axes().map(|(variable, _)| variable).collect()))
        .collect();
    table.set_item("densities", densities)?;
    Ok(table)
}

/// Computes the first-passage curve of a method alone.
#[pyfunction]
pub(crate) fn first_passage<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    method: &str,
    settings: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let (_, outcome) = carry_out(py, scenario, method, settings, ANY_BINS, Wanted::PASSAGE)?;
    match outcome.passage {
        Some(passage) => curve(py, passage),
        None => Err(errors::refused(py, "there is no first-passage curve")),
    }
}

fn carry_out(
    py: Python<'_>,
    scenario: &Scenario,
    method: &str,
    settings: &str,
    bins: (usize, usize),
    wanted: Wanted,
) -> PyResult<(Assignment, Outcome)> {
    let case = case(method, settings, bins).map_err(|error| errors::input(py, &error))?;
    let mut stop = Stop::default();
    let computed = py.detach(|| {
        let assignment = Assigning { run_id: 0, place: (0, 1), bins }.assignment(&scenario.content)?;
        let outcome = in_process::compute(case, &assignment, wanted, &mut || stop.check())?;
        Ok((assignment, outcome))
    });
    computed.map_err(|failure: Failure| stop.exception(py, &failure))
}

/// The method with settings that have been checked.
fn case(method: &str, settings: &str, bins: (usize, usize)) -> Result<BuiltIn, InputError> {
    let file = InputFile::from_text(Path::new(&format!("settings of {method}")), settings);
    let of_key = |key: &str, problem: String| InputError { line: 0, ..file.error_in_whole(key, &problem) };
    let table = toml::de::Deserializer::from(file.table()?);
    let case = BuiltIn::from_settings(method, table).ok_or_else(|| {
        of_key("method", format!("\"{method}\" is not allowed, it must be one of {}", BuiltIn::NAMES.join(", ")))
    })?;
    let case = case.map_err(|error| InputError { line: 0, ..file.toml_error(&error) })?;
    case.check().and_then(|()| case.check_bins(bins)).map_err(|misfit| of_key(misfit.key, misfit.problem))?;
    Ok(case)
}

fn snapshot<'py>(
    py: Python<'py>,
    assignment: &Assignment,
    index: usize,
    computed: Computed,
) -> PyResult<Bound<'py, PyDict>> {
    let Computed { content, rows, columns, estimated, trajectories, seconds } = computed;
    let table = PyDict::new(py);
    table.set_item("kind", kind(&content))?;
    table.set_item("trajectories", trajectories)?;
    table.set_item("seconds", seconds)?;
    if !columns.is_empty() && !matches!(content, Content::Density(_)) {
        let count = columns.len() / rows.max(1);
        table.set_item("rows", columns.into_pyarray(py).reshape([count, rows])?)?;
    }
    let Some(estimated) = estimated else { return Ok(table) };
    table.set_item("values", estimated.values.into_pyarray(py))?;
    table.set_item("errors", estimated.errors.into_pyarray(py))?;
    table.set_item("mass_on_grid", estimated.mass_on_grid)?;
    let diagnostics = PyDict::new(py);
    for (name, value) in named(estimated.diagnosis) {
        diagnostics.set_item(name, value)?;
    }
    table.set_item("diagnostics", diagnostics)?;
    let densities = PyList::empty(py);
    for (projection, density) in assignment.space.projections.iter().zip(estimated.densities) {
        let axes = assignment.axes_of(projection, index);
        let shape: Vec<usize> = axes.iter().map(|axis| axis.bins).collect();
        let edges: Vec<_> = axes.iter().map(|axis| axis.edges().into_pyarray(py)).collect();
        densities.append((density.into_pyarray(py).reshape(shape)?, edges))?;
    }
    table.set_item("densities", densities)?;
    Ok(table)
}

fn kind(content: &Content) -> &'static str {
    match content {
        Content::Samples(_) => "samples",
        Content::Characteristics(_) => "characteristics",
        Content::Mixture(_) => "mixture",
        Content::Density(_) => "density",
        Content::Reduced(_) => "reduced",
    }
}

fn curve(py: Python<'_>, passage: Passage) -> PyResult<Bound<'_, PyDict>> {
    let (rows, samples) = match passage {
        Passage::Cannot(reason) => return Err(errors::refused(py, reason)),
        Passage::Curve(rows) => (rows, 0),
        Passage::Counted { rows, samples, .. } => (rows, samples),
    };
    let table = PyDict::new(py);
    for (k, name) in ["times", "probability", "low", "high"].into_iter().enumerate() {
        let column: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        table.set_item(name, column.into_pyarray(py))?;
    }
    table.set_item("interval", rows.iter().map(|row| interval_of(row, samples)).collect::<Vec<_>>())?;
    Ok(table)
}
