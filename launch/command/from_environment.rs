//! Names the environment variable from which a refused option has its value, if the option is not on the command line.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};

use crate::command::cli::Cli;

/// The environment variable whose value the parser of the command line refuses; `None` if the option is one of `words`.
pub fn refused(error: &clap::Error, words: &[String]) -> Option<String> {
    let is_about_a_value = [ErrorKind::ValueValidation, ErrorKind::InvalidValue].contains(&error.kind());
    let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg).filter(|_| is_about_a_value) else {
        return None;
    };
    let option = argument.split([' ', '=']).next()?;
    let is_given =
        |word: &String| word.strip_prefix(option).is_some_and(|rest| rest.is_empty() || rest.starts_with('='));
    if words.iter().any(is_given) {
        return None;
    }
    variable_of(&Cli::command(), option.strip_prefix("--")?)
}

/// The environment variable that gives the value of `option`, whichever command has it.
fn variable_of(command: &Command, option: &str) -> Option<String> {
    let arguments = command.get_subcommands().flat_map(Command::get_arguments);
    let variables = arguments.filter(|argument| argument.get_long() == Some(option)).filter_map(clap::Arg::get_env);
    variables.map(|name| name.to_string_lossy().into_owned()).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_knows_the_variable_that_stands_in_for_it() {
        let variable = |option| variable_of(&Cli::command(), option);
        assert_eq!(variable("log").as_deref(), Some("PHASECLOUD_LOG"));
        assert_eq!(variable("log-format").as_deref(), Some("PHASECLOUD_LOG_FORMAT"));
        assert_eq!(variable("out"), None);
    }
}
