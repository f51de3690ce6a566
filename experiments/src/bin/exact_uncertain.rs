//! What the exact answer costs where the radiation parameter is uncertain, beside what it costs where it is certain.
//!
//! `cargo run --release -p phasecloud-experiments --bin exact_uncertain` prints, for the paper's scenarios over two
//! years and deviations of 1, 5 and 10 % of the radiation parameter, CPU seconds of all snapshots (moments and the
//! joint density on 100 x 100 bins) and of the first-passage curve at 65 times, the same with a certain parameter, the
//! ratio of the sums, and the largest L1 error estimate. `--scenario N` does one scenario, `--sigma S` one deviation,
//! `--years Y` another horizon.

mod common;

use std::error::Error;

use common::{cpu_of, paper};
use density::exact::leaves::ExactLeaves;
use density::exact::{Exact, ExactSettings};
use density::first_passage::exact::exact_curve;
use density::first_passage::{curve_times, over_leaves};
use density::flow::{Accuracy, Flow};
use density::grid::{comparison_grids, grids_over_leaves};
use density::problem::Problem;
use density::uncertain::{Distribution, Spread, UncertainProblem};

const BINS: usize = 100;
const CURVE: usize = 65;

/// CPU seconds of snapshots and curve.
struct Cost {
    snapshots: f64,
    curve: f64,
}

fn certain(problem: &Problem, times: &[f64]) -> Result<Cost, Box<dyn Error>> {
    let flow = Flow::new(problem.model);
    let grids = comparison_grids(problem, &flow, BINS, BINS)?;
    let exact = Exact::new(problem, &flow, ExactSettings::default());
    let (snapshots, found) = cpu_of(|| (0..grids.len()).try_for_each(|index| exact.snapshot(&grids, index).map(drop)));
    found?;
    let (curve, found) = cpu_of(|| exact_curve(problem, &flow, times));
    found?;
    Ok(Cost { snapshots, curve })
}

/// The same where the parameter is uncertain, and the largest L1 error estimate.
fn uncertain(problem: &UncertainProblem, times: &[f64]) -> Result<(Cost, f64), Box<dyn Error>> {
    let grids = grids_over_leaves(problem, BINS, BINS)?;
    let exact = ExactLeaves::new(problem.clone(), Accuracy::Medium, ExactSettings::default());
    let (mut each, mut snapshots, mut worst) = (Vec::new(), 0.0, 0.0_f64);
    for index in 0..grids.len() {
        let (seconds, found) = cpu_of(|| exact.snapshot(&grids, index));
        let error = found?.plane.joint_error;
        each.push(format!("{seconds:.2} ({error:.1e})"));
        (snapshots, worst) = (snapshots + seconds, worst.max(error));
    }
    eprintln!("snapshots: {}", each.join(", "));
    let (curve, found) = cpu_of(|| over_leaves::curve(&exact, times));
    found?;
    Ok((Cost { snapshots, curve }, worst))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut scenarios, mut deviations, mut years) = (vec![1, 2, 3], vec![0.01, 0.05, 0.1], 2.0);
    let mut arguments = std::env::args().skip(1);
    while let Some(key) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{key} needs a value"))?;
        match key.as_str() {
            "--scenario" => scenarios = vec![value.parse()?],
            "--sigma" => deviations = vec![value.parse()?],
            "--years" => years = value.parse()?,
            _ => return Err(format!("{key} is unknown; --scenario, --sigma and --years are known").into()),
        }
    }
    println!(
        "| scenario | deviation of C | snapshots, s | certain, s | curve, s | certain, s | ratio | L1 error estimate |\n|---|---|---|---|---|---|---|---|"
    );
    for number in scenarios {
        let plane = paper(number, (0..5).map(|k| 0.25 * years * f64::from(k)).collect());
        let times = curve_times(years, CURVE);
        let one = certain(&plane, &times)?;
        for &relative in &deviations {
            let Problem { model, initial, times: snapshots, critical_e } = plane.clone();
            let plane = Problem { model: model.into(), initial, times: snapshots, critical_e };
            let problem = UncertainProblem::new(plane, Spread { relative, distribution: Distribution::Gaussian })?;
            let (all, error) = uncertain(&problem, &times)?;
            println!(
                "| {number} | {relative} | {:.2} | {:.3} | {:.2} | {:.3} | {:.1} | {:.1e} |",
                all.snapshots,
                one.snapshots,
                all.curve,
                one.curve,
                (all.snapshots + all.curve) / (one.snapshots + one.curve),
                error
            );
        }
    }
    Ok(())
}
