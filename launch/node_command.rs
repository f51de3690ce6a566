//! `phasecloud node`: one process of a run.

use std::process::ExitCode;

use messages::domain::Place;
use nodes::builtin::BuiltIn;
use nodes::failure::Failure;
use nodes::log;
use nodes::session::Session;
use nodes::{comparator, estimator, recorder, scenario};

use crate::BAD_INPUT;
use crate::cli::NodeArguments;

/// A node as the command line describes it.
enum Kind {
    Scenario,
    Propagator(BuiltIn),
    Estimator,
    Comparator,
    Recorder,
}

/// Runs a node until it is asked to stop.
pub fn run(arguments: NodeArguments) -> ExitCode {
    let parsed = kind(&arguments).and_then(|kind| Ok((kind, place(&arguments)?)));
    let (kind, place) = match parsed {
        Ok(parsed) => parsed,
        Err(problem) => {
            eprintln!("error: phasecloud node: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let name = arguments.label.clone().unwrap_or_else(|| arguments.kind.clone());
    match serve(kind, &place, &name, arguments) {
        Ok(()) | Err(Failure::Stopped) => ExitCode::SUCCESS,
        Err(failure) => {
            log::end(&failure);
            ExitCode::FAILURE
        }
    }
}

fn kind(arguments: &NodeArguments) -> Result<Kind, String> {
    Ok(match arguments.kind.as_str() {
        "scenario" => Kind::Scenario,
        "estimator" => Kind::Estimator,
        "comparator" => Kind::Comparator,
        "recorder" => Kind::Recorder,
        name => {
            let text = arguments.settings.join("\n");
            let table = toml::Deserializer::parse(&text).map_err(|e| format!("--set: {}", e.message()))?;
            match BuiltIn::from_settings(name, table) {
                Some(settings) => {
                    let settings = settings.map_err(|e| format!("--set: {}", e.message()))?;
                    settings.check().map_err(|problem| format!("--set: {problem}"))?;
                    Kind::Propagator(settings)
                }
                None => {
                    let others = "scenario, estimator, comparator, recorder";
                    return Err(format!(
                        "there is no kind \"{name}\"; there are {}, {others}",
                        BuiltIn::NAMES.join(", ")
                    ));
                }
            }
        }
    })
}

fn place(arguments: &NodeArguments) -> Result<Place, String> {
    match &arguments.domain {
        Some(domain) => {
            let (root, prefix) = domain.rsplit_once(':').ok_or("--domain must be ROOT:PREFIX")?;
            Ok(Place { root: root.into(), prefix: prefix.into() })
        }
        None => Place::from_environment().ok_or_else(|| "which run? Give --domain ROOT:PREFIX".into()),
    }
}

fn serve(kind: Kind, place: &Place, name: &str, arguments: NodeArguments) -> Result<(), Failure> {
    let session = Session::enter(place, name, arguments.run_id)?;
    match kind {
        Kind::Scenario => {
            let [phi, e] = arguments.bins[..] else {
                return Err(Failure::Refused("--bins needs two numbers".into()));
            };
            let bins = (phi, e);
            scenario::run(&session, &scenario::Settings { files: arguments.scenarios, bins })
        }
        Kind::Propagator(settings) => settings.serve(&session),
        Kind::Estimator => estimator::run(&session),
        Kind::Comparator => comparator::run(&session),
        Kind::Recorder => {
            let folder = arguments.out.ok_or_else(|| Failure::Refused("the recorder needs --out DIR".into()))?;
            recorder::run(&session, &folder)
        }
    }
}
