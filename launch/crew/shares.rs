//! What the launcher tells the bridge: which process runs on which host.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bridge::plan::{BridgeRole, HostPlan, Program, Share};

use crate::plan::cases::{Case, Runs};
use crate::plan::hosts::Hosts;
use crate::plan::launch_file::{Launch, Restart};

/// Name of the file that tells the bridge what to do, in the domain's folder.
const FILE: &str = "bridge.json";

/// Writes what the bridge of a run over several hosts needs to know into the domain's folder.
///
/// # Errors
/// What cannot run on another host, or why the file cannot be written.
pub fn write_bridge_role(
    launch: &Launch,
    folder: &Path,
    run_id: u64,
    snapshots: usize,
) -> Result<Option<PathBuf>, String> {
    let Some(hosts) = &launch.hosts else { return Ok(None) };
    write(folder, &at_home(launch, hosts, run_id, snapshots)?).map(Some)
}

fn at_home(launch: &Launch, hosts: &Hosts, run_id: u64, snapshots: usize) -> Result<BridgeRole, String> {
    let plan = |host: &String| {
        let members = launch.cases.iter().map(|case| shares(case, host)).collect::<Result<Vec<_>, _>>()?.concat();
        let plan = HostPlan {
            run_id,
            name: launch.name.clone(),
            propagators: launch.propagators(),
            cases: launch.cases.len(),
            snapshots,
            restart: launch.restart == Restart::OnFailure,
            members,
        };
        Ok((host.clone(), plan))
    };
    let plans = hosts.names.iter().map(plan).collect::<Result<BTreeMap<_, _>, String>>()?;
    Ok(BridgeRole::Home { access: hosts.access.clone(), plans })
}

/// The processes of a case that run on `host`.
fn shares(case: &Case, host: &str) -> Result<Vec<Share>, String> {
    let members = case.members().filter(|(_, shard)| case.host_of(*shard) == host);
    let share = |(name, shard): (String, kit::shard::Shard)| {
        let program = program(&case.runs).map_err(|why| format!("{name} on {host}: {why}"))?;
        Ok(Share { name, label: case.label.clone(), shard: (shard.index, shard.count), reduce: case.reduce, program })
    };
    members.map(share).collect()
}

fn program(runs: &Runs) -> Result<Program, String> {
    match runs {
        Runs::BuiltIn { node, settings } => {
            let settings = settings.to_lines().map_err(|e| e.to_string())?;
            Ok(Program::BuiltIn { node: node.clone(), settings: settings.into_iter().collect() })
        }
        Runs::Command(words) => Ok(Program::Command(words.clone())),
        Runs::Recorded(_) => Err("a recording is played at home".into()),
    }
}

/// Writes the file for the bridge into the domain's folder, which nobody else can enter.
///
/// # Errors
/// If it cannot be written.
pub fn write(folder: &Path, bridge_role: &BridgeRole) -> Result<PathBuf, String> {
    let path = folder.join(FILE);
    let text = serde_json::to_string(bridge_role).map_err(|e| e.to_string())?;
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(path)
}
