//! Checks that several tables of a launch file share.

use nodes::files::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use nodes::files::plain_number::plain;
use toml::Spanned;

/// Longest time that a launch file may give \[s\].
const LONGEST: f64 = 1e9;

pub(crate) fn check_name(file: &InputFile, name: &Spanned<String>) -> Result<(), InputError> {
    if is_plain_name(name.get_ref()) {
        return Ok(());
    }
    Err(file.error(name, &format!("\"{}\" is not allowed, {PLAIN_NAME}", name.get_ref())))
}

pub(crate) fn checked_seconds(file: &InputFile, value: &Spanned<f64>) -> Result<f64, InputError> {
    let seconds = *value.get_ref();
    if seconds > 0.0 && seconds <= LONGEST {
        return Ok(seconds);
    }
    let seconds = plain(seconds);
    let problem =
        format!("{seconds} is not allowed, it must be a number of seconds greater than 0 and at most {LONGEST}");
    Err(file.error(value, &problem))
}
