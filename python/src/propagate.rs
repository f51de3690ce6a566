//! Orbits that the caller gives, in any model.

use std::fmt::Display;

use density::flow::{Accuracy, Flow};
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::model::{Coordinates, Kind, Model, Task};
use density::orbits::Orbits;
use density::uncertain::UncertainTask;
use kit::Failure;
use nodes::files::scenario_file::AnyScenario;
use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::errors;
use crate::scenario::Scenario;
use crate::stop::Stop;

/// Moves orbits that start at `t = 0` to each of `times` \[yr\]. `starts` has one row for each variable of the
/// scenario's model and one column for each orbit; so has the result, for each time.
#[pyfunction]
pub(crate) fn propagate<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    starts: PyReadonlyArray2<'py, f64>,
    times: PyReadonlyArray1<'py, f64>,
    accuracy: f64,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let shape = (times.as_array().len(), starts.as_array().nrows(), starts.as_array().ncols());
    let times = checked_times(times.as_array().to_vec())?;
    let accuracy = checked_accuracy(accuracy)?;
    let starts = starts.as_array();
    // Rows that lie together in memory are read where they are.
    let rows: Vec<std::borrow::Cow<'_, [f64]>> =
        starts.rows().into_iter().map(|row| row.to_slice().map_or_else(|| row.to_vec().into(), Into::into)).collect();
    let rows: Vec<&[f64]> = rows.iter().map(AsRef::as_ref).collect();
    let mut stop = Stop::default();
    let moved =
        py.detach(|| Carrying { starts: &rows, times: &times, accuracy, stop: &mut stop }.of(&scenario.content));
    match moved {
        Ok(numbers) => numbers.into_pyarray(py).reshape([shape.0, shape.1, shape.2]),
        Err(Problem::Starts(problem)) => Err(errors::value(problem)),
        Err(Problem::Failed(failure)) => Err(stop.exception(py, &failure)),
    }
}

fn checked_times(times: Vec<f64>) -> PyResult<Vec<f64>> {
    let ascending = times.windows(2).all(|pair| pair[0] <= pair[1]);
    if !times.is_empty() && ascending && times.iter().all(|time| time.is_finite() && *time >= 0.0) {
        return Ok(times);
    }
    Err(errors::value("times: they must be finite numbers of years, ascending from 0 or later, at least one"))
}

/// The accuracy that a largest error names.
pub(crate) fn checked_accuracy(error: f64) -> PyResult<Accuracy> {
    let level = Accuracy::ALL.into_iter().find(|level| level.largest_error() == error);
    level.ok_or_else(|| errors::value(format!("accuracy: {error:e} is not allowed, it must be 1e-6, 1e-9 or 1e-12")))
}

/// Why orbits are not moved.
enum Problem {
    /// They cannot start there.
    Starts(String),
    Failed(Failure),
}

impl<T: Into<Failure>> From<T> for Problem {
    fn from(failure: T) -> Self {
        Self::Failed(failure.into())
    }
}

/// Orbits to be moved in a model that is yet to be found.
struct Carrying<'a> {
    starts: &'a [&'a [f64]],
    times: &'a [f64],
    accuracy: Accuracy,
    stop: &'a mut Stop,
}

type Moved = Result<Vec<f64>, Problem>;

impl Carrying<'_> {
    fn of(self, scenario: &AnyScenario) -> Moved {
        match scenario {
            AnyScenario::InPlane { scenario, .. } => match scenario.uncertain() {
                None => self.moved(scenario.problem.model),
                Some(problem) => problem.perform(self),
            },
            AnyScenario::InSpace(scenario) => {
                let spread = scenario.cloud.as_ref().and_then(|cloud| cloud.spread);
                scenario.model.perform(spread.map(|spread| spread.distribution), self)
            }
        }
    }

    fn moved<M: Model>(self, model: M) -> Moved {
        let Self { starts, times, accuracy, stop } = self;
        check_starts(&model, starts).map_err(Problem::Starts)?;
        let mut orbits = Orbits::from_variables(Flow { model, accuracy }, starts);
        let size = starts.len() * orbits.len();
        let mut numbers = vec![0.0; times.len() * size];
        if orbits.is_empty() {
            return Ok(numbers);
        }
        for (&time, numbers) in times.iter().zip(numbers.chunks_exact_mut(size)) {
            stop.check()?;
            orbits.advance_to(time)?;
            orbits.read_out_columns(&mut numbers.chunks_exact_mut(size / starts.len()).collect::<Vec<_>>());
        }
        Ok(numbers)
    }
}

impl UncertainTask for Carrying<'_> {
    type Output = Moved;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Moved {
        self.moved(model)
    }
}

impl Task for Carrying<'_> {
    type Output = Moved;

    fn with<M: Model>(self, model: &M) -> Moved {
        self.moved(*model)
    }
}

/// Refuses starts that are no orbits of the model.
pub(crate) fn check_starts<M: Model>(model: &M, starts: &[&[f64]]) -> Result<(), String> {
    let variables = M::VARIABLES;
    if starts.len() != variables.len() {
        let symbols: Vec<&str> = variables.iter().map(|variable| variable.symbol).collect();
        let (found, wanted) = (starts.len(), variables.len());
        return Err(format!(
            "starts: they have {found} rows, the model has {wanted} variables, a row each: {}",
            symbols.join(", ")
        ));
    }
    for (variable, values) in variables.iter().zip(starts) {
        let is_allowed = |value: f64| match variable.kind {
            Kind::Circle => value.is_finite(),
            Kind::Interval { low, high } => (low..high).contains(&value),
        };
        if let Some(column) = values.iter().position(|&value| !is_allowed(value)) {
            let right: &dyn Display = match variable.kind {
                Kind::Circle => &"finite",
                Kind::Interval { low, high } => &format!("at least {low} and below {high}"),
            };
            return Err(format!(
                "starts: orbit {column} has {} = {}, it must be {right}",
                variable.symbol, values[column]
            ));
        }
    }
    let is_inside = |column: usize| model.is_inside(model.state(0.0, Coordinates::from_fn(|k| starts[k][column])));
    match (0..starts.first().map_or(0, |row| row.len())).find(|&column| !is_inside(column)) {
        Some(column) => {
            Err(format!("starts: orbit {column} lies outside the domain of the model's equations of motion"))
        }
        None => Ok(()),
    }
}
