//! A scenario that has been checked.

use std::path::{Path, PathBuf};

use density::in_space::SpaceProblem;
use density::model::Variable;
use kit::planar_problem;
use kit::space_problem;
use messages::scenario::{Description, Range};
use nodes::files::input::InputFile;
use nodes::files::scenario_file::{self, AnyScenario, ScenarioFile};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

/// A scenario that has been checked.
#[pyclass(frozen, module = "phasecloud._native")]
#[derive(Debug)]
pub(crate) struct Scenario {
    pub(crate) content: AnyScenario,
    text: String,
    file: PathBuf,
}

/// Name, symbol, unit, and lowest and highest value of a variable; an angle on the full circle has no bounds.
type VariableParts = (String, String, String, Option<(f64, f64)>);

#[pymethods]
impl Scenario {
    /// The scenario that a file states.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::check(py, InputFile::read(&path).map_err(|error| errors::input(py, &error))?)
    }

    /// The scenario that a text states, as if it stood in the file of that name.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str, file: &str) -> PyResult<Self> {
        Self::check(py, InputFile::from_text(Path::new(file), text))
    }

    #[getter]
    fn name(&self) -> &str {
        self.content.name()
    }

    /// The text of the file.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn file(&self) -> String {
        self.file.to_string_lossy().into_owned()
    }

    /// Snapshot times \[yr\].
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.content.times().to_vec().into_pyarray(py)
    }

    /// Critical eccentricity, if the scenario has one.
    #[getter]
    fn critical(&self) -> Option<f64> {
        self.content.critical_e()
    }

    /// What the scenario says of its cloud: model, parameters, variables, mean and covariance of the initial Gaussian.
    /// `None` where it has no cloud.
    fn described<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(said) = self.description() else { return Ok(None) };
        let (table, parameters) = (PyDict::new(py), PyDict::new(py));
        for parameter in &said.parameters {
            parameters.set_item(&parameter.name, parameter.value)?;
        }
        let variables: Vec<VariableParts> = said.variables.iter().map(stated).collect();
        table.set_item("model", said.model)?;
        table.set_item("parameters", parameters)?;
        table.set_item("variables", variables)?;
        table.set_item("mean", said.mean.into_pyarray(py))?;
        table.set_item("upper_covariance", said.covariance.into_pyarray(py))?;
        Ok(Some(table))
    }

    /// The variables of a single orbit in the scenario's model, those that `propagate` takes and returns.
    #[getter]
    fn orbit_variables(&self) -> Vec<VariableParts> {
        self.of_orbit().iter().map(|variable| stated(&as_message(variable))).collect()
    }
}

impl Scenario {
    fn check(py: Python<'_>, file: InputFile) -> PyResult<Self> {
        let content = scenario_file::check_any(&file).map_err(|error| errors::input(py, &error))?;
        Ok(Self { content, text: file.text().into(), file: file.path().into() })
    }

    fn description(&self) -> Option<Description> {
        match &self.content {
            AnyScenario::InPlane { scenario: ScenarioFile { name, problem, spread, .. }, .. } => {
                Some(planar_problem::described(name, problem, *spread, |_| Vec::new()))
            }
            AnyScenario::InSpace(scenario) => {
                let problem: &SpaceProblem = scenario.cloud.as_deref()?;
                Some(space_problem::described(&scenario.name, problem, &[]))
            }
        }
    }

    /// The variables of an orbit. Where the radiation parameter is uncertain it is the last of them.
    fn of_orbit(&self) -> Vec<Variable> {
        let (own, spread): (&[Variable], _) = match &self.content {
            AnyScenario::InPlane { scenario, .. } => (&density::model::plane::VARIABLES, scenario.spread),
            AnyScenario::InSpace(scenario) => {
                (scenario.model.variables(), scenario.cloud.as_ref().and_then(|cloud| cloud.spread))
            }
        };
        own.iter().copied().chain(spread.map(|spread| spread.distribution.variable())).collect()
    }
}

fn as_message(variable: &Variable) -> messages::scenario::Variable {
    let range = match variable.kind {
        density::model::Kind::Circle => Range::Circle,
        density::model::Kind::Interval { low, high } => Range::Interval { low, high },
    };
    messages::scenario::Variable {
        name: variable.name.into(),
        symbol: variable.symbol.into(),
        unit: variable.unit.into(),
        range,
    }
}

fn stated(variable: &messages::scenario::Variable) -> VariableParts {
    let bounds = match variable.range {
        Range::Circle => None,
        Range::Interval { low, high } => Some((low, high)),
    };
    (variable.name.clone(), variable.symbol.clone(), variable.unit.clone(), bounds)
}
