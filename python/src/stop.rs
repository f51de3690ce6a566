//! Ctrl-C while something is computed without the interpreter's lock.

use kit::Failure;
use pyo3::prelude::*;

/// Remembers the exception of a signal, which is known only where the lock is held.
#[derive(Debug, Default)]
pub(crate) struct Stop(Option<PyErr>);

impl Stop {
    /// Whether to go on.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => Ok(()),
            Err(error) => {
                self.0 = Some(error);
                Err(Failure::Stopped)
            }
        }
    }

    /// The exception for a failure.
    pub(crate) fn exception(self, py: Python<'_>, failure: &Failure) -> PyErr {
        match (self.0, failure) {
            (Some(error), Failure::Stopped) => error,
            _ => crate::errors::failure(py, failure),
        }
    }
}
