//! The command line.

use std::path::PathBuf;
use std::str::FromStr;

use bridge::endpoint::Endpoint;
use clap::{Args, Parser, Subcommand};
use messages::layout::MOST_SNAPSHOTS;
use nodes::input::{PLAIN_NAME, is_plain_name};
use nodes::log::{FORMAT_VARIABLE, Format, LEVEL_VARIABLE};
use nodes::shard::{MOST_SHARDS, SHARD_VARIABLE, SHARDS_VARIABLE};
use tracing::level_filters::LevelFilter;

use crate::attach::Target;
use crate::observe::HzArguments;
use crate::observe::echo::EchoArguments;
use crate::observe::watch::WatchArguments;
use crate::replay_command::ReplayArguments;

/// How the uncertainty of a satellite's orbit evolves over years: competing density propagators over shared memory.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Without a command, `phasecloud` does `phasecloud run`: scenario 1 of Sun et al. (2022) with the paper's four cases and the exact answer.\n\n\
    Exit codes: 0 all cases compared; 1 a case failed, the rest was still compared and written, or \
    a process that all need failed and nothing was; 2 bad input, nothing started; 130 stopped on request, what was finished is kept (a second Ctrl-C discards it)."
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
    /// Keep the processes of a launch file up and take scenario after scenario
    Serve(ServeArguments),
    /// Ask a running service to work on scenarios, and wait until it has
    Submit(SubmitArguments),
    /// Do a share of the run that another host conducts, as its launch file says
    Join(JoinArguments),
    /// Remove what runs whose launcher was killed have left in shared memory; live runs are not touched
    Clean,
    /// Run again what was recorded, with any part of it replaced
    Replay(ReplayArguments),
    /// Attach to a live run and show how far it is
    Watch(WatchArguments),
    /// List the live runs and who takes part in each topic
    Topics(Target),
    /// Print the messages of a topic of a live run
    Echo(EchoArguments),
    /// Print how often messages come on a topic of a live run
    Hz(HzArguments),
    /// Print who sends what to whom as a Mermaid flowchart
    #[command(after_help = "Example:\n  phasecloud graph launch/paper.toml")]
    Graph {
        /// The launch file [default: that of `phasecloud run`]
        launch_file: Option<PathBuf>,
    },
    /// Make the report and the figures of a results folder anew, or lay several runs side by side
    Report(ReportArguments),
    /// Check launch files, scenario files and sweep files without starting anything
    #[command(
        after_help = "Example:\n  phasecloud validate launch/paper.toml my-scenario.toml launch/sweeps/initial-e.toml\n\n\
        Programs that a launch file names must be there and executable; a relative path counts from the current folder.\n\n\
        Exit codes: 0 all good; 2 something is wrong."
    )]
    Validate {
        /// Launch, scenario and sweep files; which of them a file is follows from its keys
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Check whether a propagator keeps the contract and its numbers are right
    Check(CheckArguments),
    /// Write the skeleton of a propagator of your own
    New(NewArguments),
    /// Create and hold a domain for nodes that are started by hand
    Domain(DomainArguments),
    /// Check that results folders are whole and unchanged, by the checksums in their manifests
    #[command(after_help = "Exit codes: 0 unchanged; 1 a file is changed, missing or too many; 2 no manifest.")]
    Verify {
        /// Results folders
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
    },
    /// Run one node of a run by hand; `phasecloud run` starts them all by itself
    Node(NodeArguments),
    /// Run a program and end it, with all it has started, when the launcher dies
    #[command(hide = true)]
    Guard {
        /// The program and its arguments
        #[arg(last = true)]
        words: Vec<String>,
    },
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
    /// The results folder, new or empty [default: results/NAME-TIME, after the scenario; after the launch file if there are several]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Keep every message of the run in this new file, for `phasecloud replay`
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write tables only, neither report.html nor figures; `phasecloud report DIR` makes them later
    #[arg(long)]
    pub no_report: bool,
    #[command(flatten)]
    pub shown: Shown,
    /// Start all processes at random times that follow from this seed, to show that the order does not matter
    #[arg(long, value_name = "SEED", hide = true)]
    pub start_order: Option<u64>,
    #[command(flatten)]
    pub logged: Logged,
    /// Let hosts talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
}

/// Arguments of `phasecloud join`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud join --connect tcp/127.0.0.1:7447 --name worker-a\n  \
    phasecloud join --connect tls/home.example:7447 --authority ca.pem --certificate worker.pem --key worker-key.pem\n\n\
    Exit codes: 0 the run at home has ended; 1 home refused or was lost, or work cannot go on; 2 bad input; 130 stopped on request.")]
pub struct JoinArguments {
    /// Where home listens: tcp/HOST:PORT on this machine, tls/HOST:PORT beyond it
    #[arg(long, value_name = "ENDPOINT")]
    pub connect: Endpoint,
    /// The name of this host in the launch file [default: its host name]
    #[arg(long)]
    pub name: Option<String>,
    /// Certificate of the authority that has signed home's, in PEM
    #[arg(long, value_name = "FILE")]
    pub authority: Option<PathBuf>,
    /// This host's certificate, in PEM, where home asks for one
    #[arg(long, value_name = "FILE")]
    pub certificate: Option<PathBuf>,
    /// The private key of the certificate, in PEM
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
    /// Let home start programs of its choice here, not only phasecloud's own propagators
    #[arg(long)]
    pub allow_commands: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    #[command(flatten)]
    pub logged: Logged,
}

/// How much of the log is shown, and how.
#[derive(Debug, Clone, Copy, Args)]
pub struct Logged {
    /// Show the log's lines up to this level: error, warn, info, debug or trace; log.jsonl has all up to info in any case
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

/// How much a run says of itself.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Shown {
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object a line: events as they happen, at last the results
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

/// Arguments of `phasecloud check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud check -- python3 my_propagator.py --samples 500\n  \
    phasecloud check mc --set samples=2000\n\n\
    Exit codes: 0 all rules are kept; 1 a rule is broken; 2 the command cannot be started, or what a built-in \
    propagator is given is not allowed; 130 stopped on request.")]
pub struct CheckArguments {
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Seconds without any sign of life after which the propagator is given up
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub patience: f64,
    /// Seconds that it may take to end after SIGTERM; `phasecloud run` kills after 1.5
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0)]
    pub grace: f64,
    /// Its samples are drawn anew for every snapshot: do not expect them to keep their Hamiltonian
    #[arg(long)]
    pub redrawn: bool,
    /// The propagator: a program and its arguments, or a built-in one's name and arguments of `phasecloud node`
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub command: Vec<String>,
}

/// Arguments of `phasecloud serve`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud serve launch/sweep.toml --sweep launch/sweeps/initial-e.toml --out results/sweep\n  \
    phasecloud serve launch/scenario-1.toml &\n  phasecloud submit launch/scenarios/scenario-2.toml\n\n\
    Every scenario becomes a results folder of its own as soon as it is done; a sweep ends with tables of all of them, sweep.csv \
    and report.html. The launch file says which cases are run; its own scenarios are not.\n\n\
    Exit codes: 0 all was done, or a service was asked to end; 1 a case failed or a combination is impossible, it is named and \
    the rest was done; 2 bad input, nothing started; 130 a sweep was stopped on request."
)]
pub struct ServeArguments {
    /// The launch file [default: the paper's four cases and the exact answer]
    pub launch_file: Option<PathBuf>,
    /// Work on the scenarios of this sweep file, and end; else on requests, until Ctrl-C
    #[arg(long, value_name = "FILE")]
    pub sweep: Option<PathBuf>,
    /// The folder for the results folders, new or empty [default: results/NAME-TIME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Most snapshots that a scenario may have; one with more is refused [default: 16, of a sweep what it needs]
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(2..=64))]
    pub most_snapshots: Option<usize>,
    /// Let hosts talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
    #[command(flatten)]
    pub shown: Shown,
    #[command(flatten)]
    pub logged: Logged,
}

/// Arguments of `phasecloud submit`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud submit launch/scenarios/scenario-1.toml my-scenario.toml\n\n\
    Returns when the results folders are there, whole.\n\n\
    Exit codes: 0 all cases compared; 1 a scenario was refused or a case failed, it is named; 2 bad input, or no service that \
    does anything; 130 stopped on request.")]
pub struct SubmitArguments {
    /// Scenario files
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub target: Target,
}

/// Arguments of `phasecloud new`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud new my-method\n  phasecloud new my-method --python")]
pub struct NewArguments {
    /// The folder to write, which does not exist yet; its last part is the propagator's name
    #[arg(value_name = "NAME")]
    pub folder: PathBuf,
    /// In Python instead of Rust
    #[arg(long)]
    pub python: bool,
}

/// Arguments of `phasecloud domain`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud domain demo exact mc --scenario launch/scenarios/scenario-1.toml\n\n\
    Then start every node in a terminal of its own: phasecloud node estimator --domain demo, and so on.")]
pub struct DomainArguments {
    /// Its name: letters and digits
    pub name: String,
    /// Labels of the cases that will take part; LABEL/N if N processes share a case's work
    #[arg(required = true, value_name = "LABEL")]
    pub labels: Vec<HandCase>,
    /// Label of the case that all are compared with [default: the first]; may be repeated: the next stands in for what the
    /// one before withholds
    #[arg(long = "reference", value_name = "LABEL")]
    pub references: Vec<String>,
    /// Scenario files that the scenario node will publish
    #[arg(long = "scenario", value_name = "FILE", required = true)]
    pub scenarios: Vec<PathBuf>,
}

/// A case of a run by hand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HandCase {
    /// Its label.
    pub label: String,
    /// How many processes share its work.
    pub shards: u32,
}

impl FromStr for HandCase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (label, shards) = match text.split_once('/') {
            Some((label, shards)) => (label, shards.parse().ok().filter(|n| (1..=MOST_SHARDS).contains(n))),
            None => (text, Some(1)),
        };
        match shards {
            Some(shards) if is_plain_name(label) => Ok(Self { label: label.into(), shards }),
            Some(_) => Err(format!("the label \"{label}\" is not allowed, {PLAIN_NAME}")),
            None => Err(format!("{text} is not allowed, a case has 1 to {MOST_SHARDS} shards")),
        }
    }
}

/// Arguments of `phasecloud report`.
#[derive(Debug, Args)]
#[command(after_help = "One folder: writes DIR/report.html and DIR/figures/*.svg, or only one page with --out.\n\
    Several folders: writes one page with a column a run to --out, or to report.html in the current folder.\n\n\
    Examples:\n  phasecloud report results/paper\n  phasecloud report results/before results/after --out compared.html")]
pub struct ReportArguments {
    /// Results folders
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// The page to write
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `phasecloud node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, in a domain that `phasecloud domain demo ...` holds:\n  phasecloud node mc --domain demo --set samples=1000"
)]
pub struct NodeArguments {
    /// scenario, mc, dee, gmm-ut, exact, estimator, comparator, recorder, player or bridge
    pub kind: String,
    /// The run's domain: its name, or ROOT:PREFIX [default: from PHASECLOUD_ROOT and PHASECLOUD_PREFIX]
    #[arg(long)]
    pub domain: Option<String>,
    /// Label of a propagator [default: its kind]
    #[arg(long, env = "PHASECLOUD_LABEL")]
    pub label: Option<String>,
    /// Which shard of its case a propagator is, from 0; goes with --shards
    #[arg(long, value_name = "K", env = SHARD_VARIABLE, requires = "shards")]
    pub shard: Option<u32>,
    /// How many shards the case has
    #[arg(long, value_name = "N", env = SHARDS_VARIABLE, requires = "shard")]
    pub shards: Option<u32>,
    /// Number that names the run
    #[arg(long, env = "PHASECLOUD_RUN_ID", default_value_t = 0)]
    pub run_id: u64,
    /// A setting of a propagator, as KEY=VALUE; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Scenario files, for the scenario node
    #[arg(long = "scenario", value_name = "FILE")]
    pub scenarios: Vec<PathBuf>,
    /// A sweep file instead, for the scenario node
    #[arg(long, value_name = "FILE", conflicts_with = "scenarios")]
    pub sweep: Option<PathBuf>,
    /// Requests instead, for the scenario node
    #[arg(long, conflicts_with_all = ["scenarios", "sweep"])]
    pub requests: bool,
    /// Position of the first scenario to publish, for the scenario node
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub first: u32,
    /// Most snapshots of a scenario, for the scenario node
    #[arg(long, value_name = "N", default_value_t = MOST_SNAPSHOTS)]
    pub most_snapshots: usize,
    /// Bins of the comparison grid in phi and e, for the scenario node
    #[arg(long, num_args = 2, value_names = ["PHI", "E"], default_values_t = [100, 100])]
    pub bins: Vec<usize>,
    /// File that the launcher has written, for the bridge
    #[arg(long, value_name = "FILE")]
    pub post: Option<PathBuf>,
    /// What methods are judged against, for the recorder: a share of one
    #[arg(long, value_name = "SHARE", default_value_t = density::trust::TOLERANCE)]
    pub tolerance: f64,
    /// Folder to write to, for the recorder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// For a player: the recording to play. For the recorder: one that has been begun, to go on with
    #[arg(long, value_name = "FILE")]
    pub recording: Option<PathBuf>,
}
