//! The command line.

use std::path::PathBuf;

use bridge::endpoint::Endpoint;
use clap::{Args, Parser, Subcommand};

use super::ask::AskArguments;
use super::completions::{CompletionsArguments, ManArguments};
use super::domain::DomainArguments;
use super::export::ExportArguments;
use super::fidelity::FidelityArguments;
use super::init::InitArguments;
use super::map::MapArguments;
use super::new::NewArguments;
use super::node::NodeArguments;
use super::orbit::OrbitArguments;
use super::report::ReportArguments;
use super::run::RunArguments;
use super::schema::SchemaArguments;
use super::serve::ServeArguments;
use super::submit::SubmitArguments;
use crate::check::CheckArguments;
use crate::command::replay::ReplayArguments;
use crate::domain::attach::Target;
use crate::observe::HzArguments;
use crate::observe::echo::EchoArguments;
use crate::observe::watch::WatchArguments;
use crate::shown::Logged;

/// How the uncertainty of a satellite's orbit evolves over years: competing density propagators over shared memory.
#[derive(Debug, Parser)]
#[command(
    version = super::version::LONG,
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
    /// Answer how probable re-entry is by when, what it would take, and on what that depends
    Ask(AskArguments),
    /// Draw a quantity of a scenario, such as the probability of re-entry, over one or two of its numbers
    Map(MapArguments),
    /// Print the mean orbit of a scenario, in any model, as CSV
    Orbit(OrbitArguments),
    /// Print how far simpler models, and models without one of their forces, move the figures of a cloud in space
    Fidelity(FidelityArguments),
    /// Keep the processes of a launch file up and take scenario after scenario
    Serve(ServeArguments),
    /// Ask a running service to work on scenarios, and wait until they are done
    Submit(SubmitArguments),
    /// Do this host's share of a run that another host conducts, or compute parts of a map that another host draws
    Join(JoinArguments),
    /// Remove what runs left in shared memory when their launchers were killed; live runs are not touched
    #[command(
        after_help = "Example:\n  phasecloud clean\n\nIt prints what it removed, and the live runs that it left."
    )]
    Clean,
    /// Run again what was recorded, with any part of it replaced
    Replay(ReplayArguments),
    /// Write a recording as an MCAP file, or the tables of a results folder as Parquet files
    Export(ExportArguments),
    /// Attach to a live run and show how far it is
    Watch(WatchArguments),
    /// List the live runs and who takes part in each topic
    #[command(
        after_help = "Example:\n  phasecloud topics     # while `phasecloud run` or `phasecloud serve` is under way"
    )]
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
    /// Check launch files, scenario files, sweep files and map files without starting anything
    #[command(
        after_help = "Examples:\n  phasecloud validate launch/paper.toml my-scenario.toml launch/sweeps/initial-e.toml\n  phasecloud validate paper\n\n\
        Programs that a launch file names must be there and executable; a relative path counts from the current folder.\n\n\
        Exit codes: 0 all good; 2 something is wrong."
    )]
    Validate {
        /// Launch, scenario and sweep files; the keys of a file show of which kind it is
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Check whether a propagator keeps the contract and its numbers are right
    Check(CheckArguments),
    /// Write the skeleton of a propagator of your own
    New(NewArguments),
    /// Write a scenario, a launch file and a page to start from into a new folder
    Init(InitArguments),
    /// Print the script by which a shell completes this command
    Completions(CompletionsArguments),
    /// Print the JSON Schema of a kind of file, by which editors complete and check
    Schema(SchemaArguments),
    /// Print the manual page, or write those of all commands
    Man(ManArguments),
    /// Create and hold a domain for nodes that are started by hand
    Domain(DomainArguments),
    /// Check that results folders are whole and unchanged, by the checksums in their manifests
    #[command(
        after_help = "Example:\n  phasecloud verify results/scenario-1\n\nExit codes: 0 unchanged; 1 a file is changed, missing or too many; 2 no manifest."
    )]
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

/// Arguments of `phasecloud join`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud join --connect tcp/127.0.0.1:7447 --name worker-a\n  \
    phasecloud join --connect tls/home.example:7447 --authority ca.pem --certificate worker.pem --key worker-key.pem\n\n\
    It waits until home, `phasecloud run`, `phasecloud serve` or `phasecloud map` with a file that has a table [hosts], answers, and does what home asks for.\n\n\
    Exit codes: 0 the run at home has ended, or the map is complete; 1 home refused, failed or was lost, or work cannot go on; 2 bad input; \
    130 stopped on request.")]
pub struct JoinArguments {
    /// Where home listens: tcp/HOST:PORT on this machine, tls/HOST:PORT beyond it
    #[arg(long, value_name = "ENDPOINT")]
    pub connect: Endpoint,
    /// The name of this host in home's launch file or map file [default: its host name]
    #[arg(long)]
    pub name: Option<String>,
    /// Certificate of the authority that has signed home's certificate, in PEM
    #[arg(long, value_name = "FILE")]
    pub authority: Option<PathBuf>,
    /// This host's certificate, in PEM, if home asks for one
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
