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

/// Between a value and what it must be.
const NOT_ALLOWED: &str = " is not allowed, it must be ";

/// What is wrong with a value that was written with its unit, from the words about its number: with the value as it
/// was written, and without the hint that it may be meant in degrees.
pub(super) fn of_text(text: &str, problem: &str) -> String {
    let Some((_, right)) = problem.split_once(NOT_ALLOWED) else { return problem.into() };
    let right = right.split("; if ").next().unwrap_or(right);
    format!("\"{}\"{NOT_ALLOWED}{right}", text.escape_debug())
}

/// What is wrong with a value, and what would be right.
pub(super) fn in_words(error: &ProblemError) -> String {
    match &error.fault {
        Fault::Value { value, right } => format!("{}{NOT_ALLOWED}{right}", plain(*value)),
        Fault::Misfit(problem) => problem.clone(),
    }
}
