//! The options by which a command says how much it shows.

use clap::Args;
use kit::log::{FORMAT_VARIABLE, Format, LEVEL_VARIABLE};
use tracing::level_filters::LevelFilter;

/// How much of the log is shown, and how.
#[derive(Debug, Clone, Copy, Args)]
pub struct Logged {
    /// Show the log's lines up to this level: error, warn, info, debug or trace; log.jsonl has all up to info in any
    /// case
    #[arg(long, value_name = "LEVEL", env = LEVEL_VARIABLE)]
    pub log: Option<LevelFilter>,
    /// Form of the lines shown: compact or json
    #[arg(long, value_name = "FORMAT", env = FORMAT_VARIABLE, default_value = "compact")]
    pub log_format: Format,
}

impl Default for Logged {
    fn default() -> Self {
        Self { log: None, log_format: Format::Compact }
    }
}

/// How much a run prints.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Shown {
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object per line: events as they happen, and the results at the end
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}
