//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use nodes::log::{FORMAT_VARIABLE, Format, LEVEL_VARIABLE};
use tracing::level_filters::LevelFilter;

/// How the uncertainty of a satellite's orbit evolves over years: competing density propagators over shared memory.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Without a command, `phasecloud` does `phasecloud run`: scenario 1 of Sun et al. (2022) with the paper's four cases and the exact answer.\n\n\
    Exit codes: 0 all cases compared; 1 a case failed, the rest was still compared and written, or \
    a process that all need failed and nothing was; 2 bad input, nothing started; 130 stopped on request."
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the cases of a launch file on its scenarios and compare them
    Run(RunArguments),
    /// Check launch files without starting anything
    #[command(after_help = "Example:\n  phasecloud validate launch/paper.toml my-launch.toml")]
    Validate {
        /// Launch files
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Check that results folders are whole and unchanged, by the checksums in their manifests
    #[command(after_help = "Exit codes: 0 unchanged; 1 a file is changed, missing or too many; 2 no manifest.")]
    Verify {
        /// Results folders
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
    },
    /// Run one node of a run by hand; `phasecloud run` starts them all by itself
    Node(NodeArguments),
}

/// Arguments of `phasecloud run`.
#[derive(Debug, Default, Args)]
#[command(after_help = "Examples:\n  phasecloud run\n  phasecloud run launch/paper.toml --out results/paper\n  \
    phasecloud run --scenario my-scenario.toml")]
pub struct RunArguments {
    /// The launch file [default: scenario 1 with the paper's four cases]
    pub launch_file: Option<PathBuf>,
    /// Run on this scenario file instead of those that the launch file names
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// The results folder, new or empty [default: results/NAME-TIME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Show the log's lines up to this level: error, warn, info, debug or trace; log.jsonl has all up to info in any case
    #[arg(long, value_name = "LEVEL", env = LEVEL_VARIABLE)]
    pub log: Option<LevelFilter>,
    /// Form of the lines shown: compact or json
    #[arg(long, value_name = "FORMAT", env = FORMAT_VARIABLE, default_value = "compact")]
    pub log_format: Format,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `phasecloud node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, inside a live domain:\n  phasecloud node mc --domain /tmp/phasecloud-0/4f2a:pc4f2a- --label mc --set samples=1000"
)]
pub struct NodeArguments {
    /// scenario, mc, dee, gmm-ut, exact, estimator, comparator or recorder
    pub kind: String,
    /// The run's domain as ROOT:PREFIX [default: from PHASECLOUD_ROOT and PHASECLOUD_PREFIX]
    #[arg(long)]
    pub domain: Option<String>,
    /// Label of a propagator [default: its kind]
    #[arg(long, env = "PHASECLOUD_LABEL")]
    pub label: Option<String>,
    /// Number that names the run
    #[arg(long, env = "PHASECLOUD_RUN_ID", default_value_t = 0)]
    pub run_id: u64,
    /// A setting of a propagator, as KEY=VALUE; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Scenario files, for the scenario node
    #[arg(long = "scenario", value_name = "FILE")]
    pub scenarios: Vec<PathBuf>,
    /// Bins of the comparison grid in phi and e, for the scenario node
    #[arg(long, num_args = 2, value_names = ["PHI", "E"], default_values_t = [100, 100])]
    pub bins: Vec<usize>,
    /// Folder to write to, for the recorder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
