//! `phasecloud fidelity`: how far simpler models, and models without one of their forces, move the figures of a cloud
//! in space.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use density::in_space::fidelity::{Figures, QUANTITIES, REPLICATES, Shift, Variant, comparisons, figures};
use density::in_space::{SpaceProblem, VARIABLES};
use density::model::model_name::ModelName;
use nodes::files::input::InputFile;
use nodes::files::scenario_file::{self, AnyScenario};

use crate::exit::BAD_INPUT;
use crate::report::new_table;

/// Arguments of `phasecloud fidelity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud fidelity launch/scenarios/three-dimensional.toml\n  phasecloud fidelity --orbits 16 launch/scenarios/unaveraged.toml\n\n\
    Each row is a figure of a simpler model: its value, and how much larger it is than in the fuller model that the row names, with two standard \
    errors of the difference. All models move the same orbits, in 16 independent replicates of a scrambled Sobol sequence.\n\n\
    A thousand unaveraged orbits take about 45 s of CPU time a year.\n\n\
    Exit codes: 0 printed; 1 an orbit cannot be followed to the end; 2 bad input."
)]
pub struct FidelityArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Orbits in each of the 16 replicates, a power of two [default: 512 in averaged models, 16 where orbits are
    /// unaveraged]
    #[arg(long, value_name = "N")]
    pub orbits: Option<usize>,
    /// Seed of the draws
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print CSV with all digits
    #[arg(long)]
    pub csv: bool,
}

/// Most orbits in a replicate.
const MOST_ORBITS: usize = 1 << 20;

/// Prints the table.
pub fn run(arguments: &FidelityArguments) -> ExitCode {
    let FidelityArguments { scenario: path, orbits, seed, csv } = arguments;
    let problem = match load(path) {
        Ok(problem) => problem,
        Err(problem) => return refuse(&problem),
    };
    let orbits = orbits.unwrap_or(if problem.model.is_averaged() { 512 } else { 16 });
    if !orbits.is_power_of_two() || !(2..=MOST_ORBITS).contains(&orbits) {
        return refuse(&format!(
            "--orbits: {orbits} is not allowed, it must be a power of two from 2 to {MOST_ORBITS}"
        ));
    }
    match compare(&problem, orbits, *seed) {
        Ok(rows) if *csv => print_csv(&problem, &rows),
        Ok(rows) => print(&problem, &rows),
        Err(problem) => {
            remark!("error: {}: {problem}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn load(path: &Path) -> Result<SpaceProblem, String> {
    let file = InputFile::read(path).map_err(|e| e.to_string())?;
    match scenario_file::check_cloud(&file).map_err(|e| e.to_string())? {
        AnyScenario::InSpace(scenario) => scenario.cloud.map(|cloud| *cloud).ok_or_else(|| "there is no cloud".into()),
        AnyScenario::InPlane { .. } => {
            let (simplest, others) = (ModelName::Planar.text(), ModelName::listed(ModelName::is_in_space));
            let problem = format!("\"{simplest}\" is the simplest model, there is none to compare it with");
            Err(format!("{}: model.name: {problem}; write the scenario in one of {others}", path.display()))
        }
    }
}

fn refuse(problem: &str) -> ExitCode {
    remark!("error: {problem}");
    ExitCode::from(BAD_INPUT)
}

/// A simpler model, the fuller one with which it is compared, and how far its figures are off at each snapshot.
struct Row {
    simpler: String,
    /// Whether the simpler model is one in space.
    is_in_space: bool,
    fuller: String,
    shifts: Vec<[Shift; QUANTITIES]>,
}

fn compare(problem: &SpaceProblem, orbits: usize, seed: u64) -> Result<Vec<Row>, String> {
    let mut done: Vec<(Variant, Vec<Figures>)> = Vec::new();
    let mut rows = Vec::new();
    for (fuller, simpler) in comparisons(problem) {
        for variant in [fuller, simpler] {
            if done.iter().all(|(known, _)| *known != variant) {
                let found = of(problem, variant, orbits, seed)?;
                done.push((variant, found));
            }
        }
        let find = |variant: Variant| done.iter().find(|(known, _)| *known == variant).map(|(_, found)| found);
        let (Some(own), Some(other)) = (find(simpler), find(fuller)) else { continue };
        let shifts = own.iter().zip(other).map(|(own, other)| own.against(other)).collect();
        let is_in_space = simpler.model(problem).is_in_space();
        rows.push(Row { simpler: name(problem, simpler), is_in_space, fuller: name(problem, fuller), shifts });
    }
    Ok(rows)
}

/// The figures of a variant. Those that take long say how far they are.
fn of(problem: &SpaceProblem, variant: Variant, orbits: usize, seed: u64) -> Result<Vec<Figures>, String> {
    let (name, end) = (name(problem, variant), problem.times.last().copied().unwrap_or(0.0));
    let takes_long = !variant.model(problem).is_averaged();
    let tenth = std::cell::Cell::new(0);
    let progress = |time: f64| {
        let tenths = (10.0 * time / end) as u32;
        if takes_long && tenths > tenth.replace(tenths) {
            remark!("{name}: {} % done", 10 * tenths);
        }
    };
    figures(problem, variant, orbits, seed, &progress).map_err(|why| format!("{name}: {why}"))
}

/// What a variant is called.
fn name(problem: &SpaceProblem, variant: Variant) -> String {
    let model = variant.model(problem).text();
    variant.without.map_or(model.to_owned(), |force| format!("{model} without {force}"))
}

/// The name and the unit of a figure.
fn quantity(q: usize) -> (String, &'static str) {
    match VARIABLES.get(q / 2) {
        Some(variable) if q.is_multiple_of(2) => (format!("mean_{}", variable.symbol), variable.unit),
        Some(variable) => (format!("std_{}", variable.symbol), variable.unit),
        None if q.is_multiple_of(2) => ("prob_above_critical_e".into(), ""),
        None => ("prob_ever_above_critical_e".into(), ""),
    }
}

fn print(problem: &SpaceProblem, rows: &[Row]) {
    let times = &problem.times;
    for Row { simpler, fuller, shifts, .. } in rows {
        let heads = times.iter().map(|t| format!("t = {t} yr"));
        let mut table = new_table([String::new()].into_iter().chain(heads).collect(), 1);
        for q in 0..QUANTITIES {
            let (name, unit) = quantity(q);
            // The planar model says nothing of inclination and node.
            if shifts.iter().all(|shifts| shifts[q].shift.is_nan()) {
                continue;
            }
            let cell = |shifts: &[Shift; QUANTITIES]| format!("{:+.5} ± {:.5}", shifts[q].shift, 2.0 * shifts[q].error);
            let label = if unit.is_empty() { name } else { format!("{name}, {unit}") };
            table.add_row([label].into_iter().chain(shifts.iter().map(cell)).collect::<Vec<_>>());
        }
        say!("\n{simpler} less {fuller}, and two standard errors\n{table}");
    }
    if rows.iter().any(|row| !row.is_in_space) {
        say!("\nThe planar model has no inclination and no node.");
    }
    say!("{REPLICATES} replicates; e_cri = {}", problem.critical_e);
}

fn print_csv(problem: &SpaceProblem, rows: &[Row]) {
    say!("model,against,t_yr,quantity,value,shift,se_shift");
    for Row { simpler, fuller, shifts, .. } in rows {
        for (time, shifts) in problem.times.iter().zip(shifts) {
            for (q, Shift { value, shift, error }) in shifts.iter().enumerate().filter(|(_, s)| !s.shift.is_nan()) {
                say!("{simpler},{fuller},{time},{},{value},{shift},{error}", quantity(q).0);
            }
        }
    }
}
