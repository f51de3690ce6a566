//! Errors as the exceptions of `phasecloud.errors`.

use kit::Failure;
use nodes::files::input::InputError;
use pyo3::prelude::*;

/// The exception for something wrong in a file or in settings.
pub(crate) fn input(py: Python<'_>, error: &InputError) -> PyErr {
    let file = error.file.to_string_lossy().into_owned();
    let line = (error.line > 0).then_some(error.line);
    raised(py, "InputError", (error.to_string(), file, line, error.key.clone(), error.problem.clone()))
}

/// The exception for a value that is not allowed, in words.
pub(crate) fn value(problem: impl Into<String>) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(problem.into())
}

/// The exception for what cannot be computed.
pub(crate) fn refused(py: Python<'_>, why: impl Into<String>) -> PyErr {
    raised(py, "Refused", (why.into(),))
}

/// The exception for an orbit that cannot be followed.
pub(crate) fn lost_orbit(py: Python<'_>, why: impl Into<String>) -> PyErr {
    raised(py, "LostOrbit", (why.into(),))
}

/// The exception for the failure of a method. A computation that was stopped has an exception of its own already: that
/// of the signal.
pub(crate) fn failure(py: Python<'_>, failure: &Failure) -> PyErr {
    match failure {
        Failure::Stopped => pyo3::exceptions::PyKeyboardInterrupt::new_err("stopped on request"),
        Failure::LostOrbit(_) | Failure::Escaped(_) => lost_orbit(py, failure.to_string()),
        other => refused(py, other.to_string()),
    }
}

fn raised<'py, A: pyo3::call::PyCallArgs<'py>>(py: Python<'py>, name: &str, arguments: A) -> PyErr {
    let class = py.import("phasecloud.errors").and_then(|module| module.getattr(name));
    match class.and_then(|class| class.call1(arguments)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}
