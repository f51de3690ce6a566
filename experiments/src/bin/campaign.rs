//! Tries the methods on random scenarios and compares each with an oracle.
//!
//! `cargo run --release -p phasecloud-experiments --bin campaign -- --scenarios 500 --seed 1`
//!
//! - `--index K`: only scenario `K` of the seed; `--first K`: scenarios from `K` on
//! - `--file FILE`: the scenario in a file instead of random ones
//! - `--methods exact,mc`: a selection of exact, dee-961, dee-1e5, gmm-ut, mc
//! - `--bins N`: bins per axis of the comparison grids; `--threads N`
//! - `--quick`: first with a coarser oracle, then with the finer one if something seems to be silently wrong
//!
//! Every figure that is wrong without a warning is printed with its scenario. The exit code is 1 if a figure of `exact`
//! was.

#[path = "../../../density/tests/campaign_support/mod.rs"]
mod campaign_support;

use std::process::ExitCode;
use std::time::Instant;

use campaign_support::judge::Oracles;
use campaign_support::methods::{Method, run};
use campaign_support::oracle::Effort;
use campaign_support::scenario::{Scenario, draw};
use campaign_support::summary::{Row, table};
use density::flow::Flow;
use density::grid::comparison_grids;

struct Options {
    scenarios: u64,
    first: u64,
    seed: u64,
    file: Option<String>,
    methods: Vec<Method>,
    bins: usize,
    threads: usize,
    effort: Effort,
}

fn options() -> Result<Options, String> {
    let mut options = Options {
        scenarios: 50,
        first: 0,
        seed: 1,
        file: None,
        methods: ["exact", "dee-961", "dee-1e5", "gmm-ut", "mc"].into_iter().filter_map(Method::named).collect(),
        bins: 100,
        threads: 0,
        effort: Effort::THOROUGH,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        if name == "--quick" {
            options.effort = Effort::QUICK;
            continue;
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{name} {value}: a whole number is needed"));
        match name.as_str() {
            "--scenarios" => options.scenarios = number()?,
            "--seed" => options.seed = number()?,
            "--first" => options.first = number()?,
            "--index" => (options.first, options.scenarios) = (number()?, 1),
            "--bins" => options.bins = number()? as usize,
            "--threads" => options.threads = number()? as usize,
            "--file" => options.file = Some(value.clone()),
            "--methods" => {
                let named = |name| Method::named(name).ok_or(format!("there is no method {name}"));
                options.methods = value.split(',').map(named).collect::<Result<_, _>>()?;
            }
            _ => return Err(format!("unknown option {name}; see the head of this file")),
        }
    }
    Ok(options)
}

fn scenarios(options: &Options) -> Result<Vec<Scenario>, String> {
    let Some(file) = &options.file else {
        let indices = options.first..options.first + options.scenarios;
        return Ok(indices.map(|index| draw(options.seed, index)).collect());
    };
    let text = std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
    Ok(vec![Scenario::from_toml(&text).ok_or(format!("{file} is not written as a scenario of the campaign"))?])
}

fn main() -> ExitCode {
    match options().and_then(|options| campaign(&options)) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::from(2)
        }
    }
}

/// Runs the campaign and returns the number of scenarios in which `exact` was silently wrong.
fn campaign(options: &Options) -> Result<usize, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build().map_err(|e| e.to_string())?;
    let mut rows: Vec<(Method, Row)> = options.methods.iter().map(|&method| (method, Row::default())).collect();
    let mut skipped = 0;
    println!("seed {}, from index {}", options.seed, options.first);
    let scenarios = scenarios(options)?;
    for (tried, scenario) in scenarios.iter().enumerate() {
        pool.install(|| skipped += usize::from(!try_scenario(scenario, options, &mut rows)));
        if (tried + 1) % 50 == 0 {
            eprintln!("{} of {} scenarios so far\n{}", tried + 1, scenarios.len(), table(&rows));
        }
    }
    println!("\n{}\n{skipped} scenarios skipped", table(&rows));
    Ok(rows.iter().filter(|(method, _)| *method == Method::Exact).map(|(_, row)| row.silently_wrong()).sum())
}

/// Tries the methods on a scenario. Returns whether the scenario could be tried at all.
fn try_scenario(scenario: &Scenario, options: &Options, rows: &mut [(Method, Row)]) -> bool {
    let (problem, name) = (&scenario.problem, &scenario.name);
    let grids = match comparison_grids(problem, &Flow::new(problem.model), options.bins, options.bins) {
        Ok(grids) => grids,
        Err(why) => {
            println!("{name}: skipped, it has no comparison grid: {why}");
            return false;
        }
    };
    let start = Instant::now();
    let mut oracles = Oracles::new(problem, &grids, &options.effort);
    let (lines, nodes) = oracles.quick.lattice;
    println!("{name}: {scenario}; oracle on {lines} x {nodes} orbits, {:.1} s", start.elapsed().as_secs_f64());
    for contradiction in &oracles.quick.contradictions {
        println!("{name}: the oracle contradicts itself: {contradiction}");
    }
    let mut is_fine = true;
    for (method, row) in rows {
        let answer = run(*method, problem, &grids);
        let verdict = oracles.judge(&answer, *method == Method::Exact);
        row.add(&verdict, answer.seconds);
        for why in verdict.refusals.iter().take(1) {
            println!("{name}: {} refused: {why}", method.name());
        }
        for withheld in &verdict.withheld {
            println!("{name}: {} withholds {withheld}", method.name());
        }
        for figure in &verdict.undecided {
            println!("{name}: {} undecided, the oracle comes closer with more orbits: {figure}", method.name());
        }
        for figure in verdict.silently_wrong() {
            println!("{name}: {} is silently wrong: {}, {}", method.name(), figure.name, figure.detail);
            is_fine = false;
        }
    }
    if !is_fine {
        println!("{}", scenario.to_toml());
    }
    true
}
