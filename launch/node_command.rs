//! `phasecloud node`: one process of a run.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use messages::domain::Place;
use messages::service::Service;
use nodes::builtin::BuiltIn;
use nodes::failure::Failure;
use nodes::input::{InputError, InputFile};
use nodes::log;
use nodes::scenario::Source;
use nodes::session::{ANY_SCENARIO, Session};
use nodes::shard::Shard;
use nodes::{comparator, estimator, player, recorder, scenario};

use crate::BAD_INPUT;
use crate::cli::{Cli, Command, NodeArguments};
use crate::domains;

/// A node as the command line describes it.
enum Kind {
    Propagator(BuiltIn),
    Service(Service),
    Player,
}

/// The node that plays a recorded one.
const PLAYER: &str = "player";

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

/// Whether the words behind `phasecloud node` can start a propagator that comes with phasecloud.
///
/// # Errors
/// What is wrong with them.
pub fn check_words(words: &[String]) -> Result<(), String> {
    let line = ["phasecloud", "node"].into_iter().chain(words.iter().map(String::as_str));
    let cli =
        Cli::try_parse_from(line).map_err(|e| e.to_string().trim_start_matches("error: ").trim_end().to_owned())?;
    match cli.command {
        Some(Command::Node(arguments)) => kind(&arguments).and_then(|_| shard(&arguments)).map(drop),
        _ => Ok(()),
    }
}

fn place(arguments: &NodeArguments) -> Result<Place, String> {
    match &arguments.domain {
        Some(domain) => match domain.rsplit_once(':') {
            Some((root, prefix)) => Ok(Place { root: root.into(), prefix: prefix.into() }),
            None => domains::named(domain).map_err(|problem| format!("--domain: {problem}")),
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
            scenario::run(&session, &scenario::Settings { source, first, bins, most_snapshots })
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
            let post = arguments.post.ok_or_else(|| Failure::Refused("the bridge needs --post FILE".into()))?;
            bridge(&session, place, &post)
        }
    };
    if let Err(failure) = &served
        && !matches!(failure, Failure::Stopped | Failure::Port(_))
    {
        // Another try would fail in the same way.
        let _ = session.failed(ANY_SCENARIO, &session.name, &failure.to_string());
    }
    served
}

#[cfg(feature = "hosts")]
use bridge::run as bridge;

#[cfg(not(feature = "hosts"))]
fn bridge(_: &Session, _: &Place, _: &std::path::Path) -> Result<(), Failure> {
    Err(Failure::Refused(crate::hosts::WITHOUT_HOSTS.into()))
}
