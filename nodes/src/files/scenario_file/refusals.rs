//! What a scenario file is refused for, in words.

use density::problem_error::{Fault, ProblemError};
use toml::Spanned;

use crate::files::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use crate::files::plain_number::plain;

/// Checks the name of a scenario.
pub(super) fn check_name(file: &InputFile, name: &Spanned<String>) -> Result<(), InputError> {
    match is_plain_name(name.get_ref()) {
        true => Ok(()),
        false => Err(file.error(name, &format!("\"{}\" is not allowed, {PLAIN_NAME}", name.get_ref()))),
    }
}

/// What is wrong with a value, and what would be right.
pub(super) fn in_words(error: &ProblemError) -> String {
    match &error.fault {
        Fault::Value { value, right } => format!("{} is not allowed, it must be {right}", plain(*value)),
        Fault::Misfit(problem) => problem.clone(),
    }
}
