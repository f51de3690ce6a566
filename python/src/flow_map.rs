//! The flow of a planar scenario as a map.

use density::flow::{Accuracy, Flow};
use density::flow_map::{self, Settings};
use density::model::registry::Planar;
use density::model::{Coordinates, Model};
use density::orbits::Orbits;
use kit::Failure;
use nodes::files::scenario_file::AnyScenario;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::errors;
use crate::propagate::{check_starts, checked_accuracy};
use crate::scenario::Scenario;

/// Number of variables of the plane.
const VARIABLES: usize = 2;

/// The map from starts at `t = 0` to the snapshot times of a planar scenario.
#[pyclass(frozen, module = "phasecloud._native")]
#[derive(Debug)]
pub(crate) struct FlowMap {
    map: flow_map::FlowMap<Planar, VARIABLES>,
    model: Planar,
    accuracy: Accuracy,
}

#[pymethods]
impl FlowMap {
    /// Makes the map.
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, error: f64, most_orbits: usize, accuracy: f64) -> PyResult<Self> {
        let accuracy = checked_accuracy(accuracy)?;
        if !(1e-11..=1e-3).contains(&error) {
            return Err(errors::value(format!("error: {error} is not allowed, it must be between 1e-11 and 1e-3")));
        }
        let AnyScenario::InPlane { scenario, .. } = &scenario.content else {
            return Err(errors::refused(py, "a flow map is for planar scenarios; take propagate"));
        };
        if scenario.spread.is_some() {
            let why = "the scenario's radiation parameter is uncertain, which this flow map does not take into account; \
                       monte_carlo(..., through=\"flow-map\") does";
            return Err(errors::refused(py, why));
        }
        let problem = &scenario.problem;
        let flow = Flow { model: problem.model, accuracy };
        let settings = Settings { error, most_orbits, ..Settings::default() };
        let map = py.detach(|| {
            flow_map::FlowMap::new(flow, problem.initial.into(), &problem.times, Some(problem.critical_e), &settings)
        });
        let map = map.map_err(|refused| errors::refused(py, refused.to_string()))?;
        Ok(Self { map, model: problem.model, accuracy })
    }

    /// Where orbits with these starts are at snapshot `index`; starts and result have a row for each variable.
    fn at<'py>(
        &self,
        py: Python<'py>,
        starts: PyReadonlyArray2<'py, f64>,
        index: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let snapshots = self.map.times().len();
        if index >= snapshots {
            let last = snapshots - 1;
            return Err(pyo3::exceptions::PyIndexError::new_err(format!(
                "there is no snapshot {index}, the last is {last}"
            )));
        }
        let rows: Vec<Vec<f64>> = starts.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        check_starts(&self.model, &rows).map_err(errors::value)?;
        let count = rows[0].len();
        let moved = py.detach(|| self.moved(&rows, index));
        moved.map_err(|failure| errors::failure(py, &failure))?.into_pyarray(py).reshape([VARIABLES, count])
    }

    /// Snapshot times \[yr\].
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.map.times().to_vec().into_pyarray(py)
    }

    /// Orbits from which the map is made.
    #[getter]
    fn orbits(&self) -> usize {
        self.map.summary().orbits
    }

    /// Cells of the map.
    #[getter]
    fn cells(&self) -> usize {
        self.map.summary().cells
    }

    /// Estimate of the largest error of x1 or x2 at any snapshot.
    #[getter]
    fn error(&self) -> f64 {
        self.map.summary().error
    }

    /// Probability of the starts that the map moves; others are propagated.
    #[getter]
    fn mapped(&self) -> f64 {
        self.map.summary().mapped
    }
}

impl FlowMap {
    /// The variables at a snapshot, one row after the other. Orbits that the map does not know are propagated.
    fn moved(&self, starts: &[&[f64]], index: usize) -> Result<Vec<f64>, Failure> {
        let time = self.map.times()[index];
        let state = |k: usize| self.map.state(&[starts[0][k], starts[1][k]], index);
        let states: Vec<_> = (0..starts[0].len()).into_par_iter().map(state).collect();
        let left: Vec<usize> = (0..states.len()).filter(|&k| states[k].is_none()).collect();
        let direct = self.propagated(starts, &left, time)?;
        let mut moved = vec![0.0; VARIABLES * states.len()];
        for (k, state) in states.iter().enumerate() {
            if let Some(state) = state {
                let variables = self.model.read_out(time, *state);
                (0..VARIABLES).for_each(|variable| moved[variable * states.len() + k] = variables.component(variable));
            }
        }
        for (place, &k) in left.iter().enumerate() {
            (0..VARIABLES).for_each(|variable| moved[variable * states.len() + k] = direct[variable][place]);
        }
        Ok(moved)
    }

    fn propagated(&self, starts: &[&[f64]], numbers: &[usize], time: f64) -> Result<[Vec<f64>; VARIABLES], Failure> {
        let [phi, e] = [0, 1].map(|variable| numbers.iter().map(|&k| starts[variable][k]).collect::<Vec<_>>());
        let mut orbits = Orbits::from_polar(Flow { model: self.model, accuracy: self.accuracy }, &phi, &e);
        orbits.advance_to(time)?;
        let mut moved = [phi, e];
        let [phi, e] = &mut moved;
        orbits.read_out(phi, e);
        Ok(moved)
    }
}
