//! The native part of the Python package `phasecloud`: the science of phasecloud in the process of the interpreter.
//!
//! Everything that a Python user sees is in `python/phasecloud`; here are the functions behind it, which take and
//! return numpy arrays and dictionaries. Computations release the interpreter's lock.
//!
//! | module | what |
//! |---|---|
//! | `scenario` | a scenario that has been checked |
//! | `cases` | a built-in method on a scenario, as the node of a run computes it |
//! | `propagate` | orbits that the caller gives, in any model |
//! | `flow_map` | the flow of a planar scenario as a map |
//! | `launch_file` | launch files, checked before anything is started; tables of Python as TOML |
//! | `errors` | errors as Python's exceptions |
//! | `stop` | Ctrl-C |

#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod cases;
mod errors;
mod flow_map;
mod launch_file;
mod propagate;
mod scenario;
mod stop;

/// The native part of phasecloud.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::cases::{compute, first_passage};
    #[pymodule_export]
    use super::flow_map::FlowMap;
    #[pymodule_export]
    use super::launch_file::{check_launch, json_from_toml, toml_from_json};
    #[pymodule_export]
    use super::propagate::propagate;
    #[pymodule_export]
    use super::scenario::Scenario;
}
