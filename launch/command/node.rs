//! `phasecloud node`: one process of a run.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use kit::failure::Failure;
use kit::log;
use kit::session::Session;
use kit::shard::Shard;
use messages::domain::Place;
use messages::service::Service;
use nodes::files::input::{InputError, InputFile};
use nodes::methods::BuiltIn;
use nodes::services::scenario::Source;
use nodes::services::{comparator, estimator, player, recorder, scenario};

use crate::crew::commands::PLAYER;
use crate::domain;
use crate::exit::BAD_INPUT;

/// The words after `phasecloud node`, as a command line of their own.
#[derive(Debug, Parser)]
#[command(name = "phasecloud node")]
struct Line {
    #[command(flatten)]
    arguments: NodeArguments,
}

/// A node as the command line describes it.
enum Kind {
    Propagator(BuiltIn),
    Service(Service),
    Player,
}

/// Runs a node until it is asked to stop.
pub fn run(arguments: NodeArguments) -> ExitCode {
    let parsed = kind(&arguments).and_then(|kind| Ok((kind, place(&arguments)?, shard(&arguments)?)));
    let (kind, place, shard) = match parsed {
        Ok(parsed) => parsed,
        Err(problem) => {
            remark!("error: phasecloud node: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let name = arguments.label.clone().unwrap_or_else(|| arguments.kind.clone());
    match serve(kind, &place, &name, shard, arguments) {
        Ok(()) | Err(Failure::Stopped) => ExitCode::SUCCESS,
        Err(failure) => {
            log::end(&failure);
            ExitCode::FAILURE
        }
    }
}

fn kind(arguments: &NodeArguments) -> Result<Kind, String> {
    let name = arguments.kind.as_str();
    if let Some(service) = Service::named(name) {
        return Ok(Kind::Service(service));
    }
    Ok(match name {
        PLAYER => Kind::Player,
        name => {
            let lines = InputFile::from_text(Path::new("--set"), &arguments.settings.join("\n"));
            let refused = |e: InputError| format!("--set {}", [e.key, e.problem].join(": ").trim_start_matches(": "));
            let table = lines.table().map_err(refused)?;
            match BuiltIn::from_settings(name, toml::de::Deserializer::from(table)) {
                Some(settings) => {
                    let settings = settings.map_err(|e| refused(lines.toml_error(&e)))?;
                    settings.check().map_err(|problem| format!("--set {problem}"))?;
                    Kind::Propagator(settings)
                }
                None => {
                    let others = Service::ALL.map(Service::name).join(", ");
                    return Err(format!(
                        "there is no kind \"{name}\"; there are {}, {others}, {PLAYER}",
                        BuiltIn::NAMES.join(", ")
                    ));
                }
            }
        }
    })
}

/// Whether the words after `phasecloud node` can start a propagator that comes with phasecloud.
///
/// # Errors
/// What is wrong with them.
pub fn check_words(words: &[String]) -> Result<(), String> {
    let line = ["phasecloud node"].into_iter().chain(words.iter().map(String::as_str));
    let parsed = Line::try_parse_from(line);
    let Line { arguments } = parsed.map_err(|e| e.to_string().trim_start_matches("error: ").trim_end().to_owned())?;
    kind(&arguments).and_then(|_| shard(&arguments)).map(drop)
}

fn place(arguments: &NodeArguments) -> Result<Place, String> {
    match &arguments.domain {
        Some(domain) => match domain.rsplit_once(':') {
            Some((root, prefix)) => Ok(Place { root: root.into(), prefix: prefix.into() }),
            None => domain::named(domain).map_err(|problem| format!("--domain: {problem}")),
        },
        None => Place::from_environment().ok_or_else(|| "which run? Give --domain NAME".into()),
    }
}

fn shard(arguments: &NodeArguments) -> Result<Shard, String> {
    match (arguments.shard, arguments.shards) {
        (Some(index), Some(count)) => Shard::new(index, count),
        _ => Ok(Shard::WHOLE),
    }
}

fn serve(kind: Kind, place: &Place, name: &str, shard: Shard, arguments: NodeArguments) -> Result<(), Failure> {
    let session = Session::enter_as(place, name, shard, arguments.run_id)?;
    let served = match kind {
        Kind::Service(Service::Scenario) => {
            let [phi, e] = arguments.bins[..] else {
                return Err(Failure::Refused("--bins needs two numbers".into()));
            };
            let bins = (phi, e);
            let source = match arguments.sweep {
                Some(file) => Source::Sweep(file),
                None if arguments.requests => Source::Requests,
                None => Source::Files(arguments.scenarios),
            };
            let NodeArguments { first, most_snapshots, .. } = arguments;
            scenario::run(&session, &scenario::ScenarioSettings { source, first, bins, most_snapshots })
        }
        Kind::Propagator(settings) => settings.serve(&session),
        Kind::Service(Service::Estimator) => estimator::run(&session),
        Kind::Service(Service::Comparator) => comparator::run(&session),
        Kind::Service(Service::Recorder) => {
            let folder = arguments.out.ok_or_else(|| Failure::Refused("the recorder needs --out DIR".into()))?;
            std::fs::create_dir_all(&folder).map_err(|e| Failure::file(&folder, e))?;
            recorder::run(&session, &folder, arguments.recording.as_deref(), arguments.tolerance)
        }
        Kind::Player => {
            let file = arguments.recording.ok_or_else(|| Failure::Refused("a player needs --recording FILE".into()))?;
            player::run(&session, &file)
        }
        Kind::Service(Service::Bridge) => {
            let bridge_role =
                arguments.bridge_role.ok_or_else(|| Failure::Refused("the bridge needs --bridge-role FILE".into()))?;
            bridge(&session, place, &bridge_role)
        }
    };
    if let Err(failure) = &served
        && !matches!(failure, Failure::Stopped | Failure::Port(_))
    {
        // Another try would fail in the same way.
        session.last_words(&failure.to_string());
    }
    served
}

#[cfg(feature = "hosts")]
use bridge::run as bridge;
use clap::Args;
use kit::shard::{SHARD_VARIABLE, SHARDS_VARIABLE};
use messages::scenario::MOST_SNAPSHOTS;
use std::path::PathBuf;

/// Arguments of `phasecloud node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, in a domain that `phasecloud domain demo ...` holds:\n  phasecloud node mc --domain demo --set samples=1000"
)]
pub struct NodeArguments {
    /// scenario, mc, qmc, dee, gmm-ut, exact, flow-map, estimator, comparator, recorder, player or bridge
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
    /// A sweep file instead of scenario files, for the scenario node
    #[arg(long, value_name = "FILE", conflicts_with = "scenarios")]
    pub sweep: Option<PathBuf>,
    /// Take scenarios from requests instead of files, for the scenario node
    #[arg(long, conflicts_with_all = ["scenarios", "sweep"])]
    pub requests: bool,
    /// Position of the first scenario to publish, for the scenario node
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub first: u32,
    /// Most snapshots that a scenario may have, for the scenario node
    #[arg(long, value_name = "N", default_value_t = MOST_SNAPSHOTS)]
    pub most_snapshots: usize,
    /// Bins of the comparison grid in phi and e, for the scenario node
    #[arg(long, num_args = 2, value_names = ["PHI", "E"], default_values_t = [100, 100])]
    pub bins: Vec<usize>,
    /// File that the launcher has written, for the bridge
    #[arg(long, value_name = "FILE")]
    pub bridge_role: Option<PathBuf>,
    /// Tolerance against which methods are judged, as a fraction of 1, for the recorder
    #[arg(long, value_name = "SHARE", default_value_t = density::trust::TOLERANCE)]
    pub tolerance: f64,
    /// Folder to write to, for the recorder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// For a player: the recording to play. For the recorder: the recording to continue, which has been begun
    #[arg(long, value_name = "FILE")]
    pub recording: Option<PathBuf>,
}

#[cfg(not(feature = "hosts"))]
fn bridge(_: &Session, _: &Place, _: &std::path::Path) -> Result<(), Failure> {
    Err(Failure::Refused(crate::plan::hosts::WITHOUT_HOSTS.into()))
}
