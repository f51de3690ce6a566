//! What the cases of a launch file would refuse of its scenarios, told before anything is started.
//!
//! A run goes on without a case that cannot do a scenario, and names it. Whoever validates the file wants to know it at
//! once.

use kit::assignment::Assignment;
use kit::reduced;
use kit::shard::Shard;
use nodes::assigning::without_grids;
use nodes::files::input::{InputError, InputFile};

use super::cases::{Case, Runs, label_error};
use super::launch_file::Launch;

/// All that the built-in cases of a launch file refuse, each with the first scenario that it refuses.
pub fn problems(file: &InputFile, launch: &Launch) -> Vec<InputError> {
    let assignments: Vec<Assignment> =
        launch.scenarios.iter().filter_map(|scenario| without_grids(&scenario.content)).collect();
    let problem = |(index, case): (usize, &Case)| {
        let refused = |assignment: &Assignment| Some((assignment.description.name.clone(), refusal(case, assignment)?));
        let (scenario, why) = assignments.iter().find_map(refused)?;
        let problem = format!("the case {} cannot do the scenario {scenario}: {why}", case.label);
        Some(label_error(file, index, &problem))
    };
    launch.cases.iter().enumerate().filter_map(problem).collect()
}

/// Why a case cannot do a scenario, as far as that is known before anything is computed.
fn refusal(case: &Case, assignment: &Assignment) -> Option<String> {
    let Runs::BuiltIn { settings, .. } = &case.runs else { return None };
    let shard = Shard { index: 0, count: case.shards };
    let is_reduced = || if case.reduce { reduced::plane_of(assignment).map(drop) } else { Ok(()) };
    settings.check_scenario(assignment, shard).and_then(|()| is_reduced()).err().map(|why| why.to_string())
}
