//! `phasecloud schema`: the JSON Schema of a kind of file, by which editors complete and check.

use std::process::ExitCode;

use clap::{Args, ValueEnum};
use nodes::files::schema as of_nodes;

use crate::plan::schema as of_launch;

/// Arguments of `phasecloud schema`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  phasecloud schema scenario > scenario.schema.json\nand as the first line of the file:\n  #:schema scenario.schema.json\n\n\
    A schema knows keys, types and words. Values that do not go together are found by phasecloud validate."
)]
pub struct SchemaArguments {
    /// The kind of file
    pub kind: Kind,
}

/// A kind of file that has a schema.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Kind {
    /// What is propagated
    Scenario,
    /// Which cases are run on which scenarios
    Launch,
    /// A quantity over one or two numbers of a scenario
    Map,
}

/// Prints the schema.
pub fn run(SchemaArguments { kind }: &SchemaArguments) -> ExitCode {
    let schema = match kind {
        Kind::Scenario => of_nodes::scenario(),
        Kind::Launch => of_launch::schema(),
        Kind::Map => of_nodes::map(),
    };
    say!("{schema:#}");
    ExitCode::SUCCESS
}
