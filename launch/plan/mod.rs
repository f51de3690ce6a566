//! Launch files: what is to run, checked before anything starts.
//!
//! | file | idea |
//! |---|---|
//! | [`launch_file`] | a launch file as a whole |
//! | [`cases`] | its cases: the tables `[[propagator]]` |
//! | [`scenario_inputs`] | its scenarios, read and checked |
//! | `references`, `baseline` | with which cases the others are compared, and in whose effort effort is measured |
//! | [`hosts`] | which other hosts take part |
//! | `checks` | checks that several tables share |
//! | `programs` | whether the programs that it names can be started |
//! | `refusals` | what the cases would refuse of the scenarios |
//! | `preflight` | what must be there before anything is started |
//! | `built_in` | the launch files of this repository, as they are in the program |
//! | `schema` | the JSON Schema of a launch file |

pub(crate) mod baseline;
pub(crate) mod built_in;
pub mod cases;
mod checks;
pub mod hosts;
pub mod launch_file;
pub(crate) mod preflight;
pub(crate) mod programs;
mod references;
pub(crate) mod refusals;
pub mod scenario_inputs;
pub(crate) mod schema;
