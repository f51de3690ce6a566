//! Rules about what the numbers mean: Hamiltonian, density along characteristics, mass, moments.
//!
//! Snapshots that break no rule of [`super::delivery`] are judged by the estimator's own methods and against the exact
//! answer.

use std::f64::consts::SQRT_2;

use density::angle::nearest;
use density::binning;
use density::dynamics::{State, density_growth, density_growth_without_jacobian};
use density::exact::{Exact, ExactSettings};
use density::flow::Flow;
use density::model::PlanarHamiltonian;
use kit::assignment::{Assignment, Plane};
use kit::kind::{self, Estimated, Snapshot, Trajectories, groups};
use kit::snapshot_rules::decode;
use messages::content::{Characteristics, Content};
use messages::layout::{DensityHeader, SnapshotHeader};
use nodes::services::estimation::CaseEstimator;
use nodes::services::reading::Reading;

use super::amount::{amount, to_within};
use super::answer::{Answer, Received};
use super::passages;
use super::verdict::{Findings, Rule};

/// Tolerated change of the Hamiltonian, which spans about 0.001 over a cloud, and relative error of a density carried
/// along.
const KEPT: f64 = 1e-6;
/// Tolerated error of a sample's moment, in standard errors: a larger one has a probability of 6e-7.
const SIGMAS: f64 = 5.0;
/// Tolerated error of other methods' moments, in standard deviations or products of them, and of probabilities.
const GENEROUS: f64 = 0.1;
/// Tolerated error of other methods' mass on the grid.
const MASS: f64 = 0.01;
/// Tolerated error of the sum of a mixture's weights.
const WEIGHTS: f64 = 1e-6;
/// Names of the moments, in the order of a message.
const MOMENTS: [&str; 6] = ["mean phi", "std phi", "mean e", "std e", "covariance", "probability above critical e"];

/// A snapshot with its position and its columns.
struct Table<'a> {
    index: usize,
    snapshot: Snapshot<'a>,
    columns: Vec<&'a [f64]>,
}

impl Table<'_> {
    fn states(&self) -> Vec<State> {
        let pairs = self.columns[0].iter().zip(self.columns[1]);
        pairs.map(|(&phi, &e)| State::from_polar(phi, e)).collect()
    }

    /// Whether NaN in it stands for a figure that its sender withholds.
    fn may_withhold(&self) -> bool {
        kind::of(&self.snapshot.content).may_withhold()
    }

    fn trajectories(&self) -> Trajectories {
        kind::of(&self.snapshot.content).trajectories()
    }

    fn time(&self) -> f64 {
        self.snapshot.header.time
    }

    fn rows(&self) -> f64 {
        f64::from(self.snapshot.header.rows)
    }
}

/// Judges all snapshots of an answer, up to the first that cannot be decoded.
pub fn judge(findings: &mut Findings, answer: &Answer, redrawn: bool) {
    let assignment = &answer.assignment;
    let Some(plane) = &assignment.plane else { return };
    let table = |(index, received)| {
        let Received { header, items }: &Received<SnapshotHeader> = received;
        let snapshot = decode(header, items, assignment, index).ok()?;
        Some(Table { index, snapshot, columns: items.chunks_exact(header.rows as usize).collect() })
    };
    let tables: Vec<Table> = answer.heard.snapshots.iter().enumerate().map_while(table).collect();
    let Some(first) = tables.first() else { return };
    let named = |result: Result<String, String>| {
        let name = |text: String| format!("{}: {text}", assignment.said.name);
        result.map(name).map_err(name)
    };
    let (trajectories, first) = (first.trajectories(), first.snapshot.content);
    if trajectories == Trajectories::Ordered || (trajectories == Trajectories::Unordered && !redrawn) {
        findings.take(Rule::Hamiltonian, named(hamiltonian(plane, &tables)));
    }
    if let Content::Characteristics(characteristics) = first {
        findings.take(Rule::CarriedDensity, named(carried_density(plane, &characteristics, &tables)));
    }
    let mut case = CaseEstimator::default();
    let mut worst = Worst::default();
    let mut least_mass = f64::INFINITY;
    let mut densities = Vec::new();
    for table in &tables {
        let estimated = match case.estimate(&table.snapshot, assignment) {
            Ok(estimated) => {
                densities.extend(reading(table, &estimated, assignment));
                estimated
            }
            Err(why) => {
                let seen = named(Err(format!("snapshot {}: no density can be made of it: {why}", table.index)));
                return findings.take(Rule::Mass, seen);
            }
        };
        match mass(table, &estimated) {
            Ok(mass) if mass.is_nan() => {
                findings.good(Rule::Mass, format!("{}, snapshot {}: withheld", assignment.said.name, table.index));
            }
            Ok(mass) => least_mass = least_mass.min(mass),
            Err(why) => {
                findings.problem(Rule::Mass, format!("{}, snapshot {}: {why}", assignment.said.name, table.index))
            }
        }
        worst.take(plane, table, &estimated.values[..MOMENTS.len()]);
    }
    if least_mass.is_finite() {
        findings.good(Rule::Mass, format!("{}: at least {least_mass:.4}", assignment.said.name));
    }
    findings.take(Rule::Moments, named(worst.verdict()));
    for passage in &answer.heard.passages {
        match passages::judge(assignment, passage, &densities) {
            Ok(seen) if seen.is_empty() => {}
            seen => findings.take(Rule::FirstPassage, named(seen)),
        }
    }
}

/// What a snapshot came to, as the recorder hears of it.
fn reading(table: &Table, estimated: &Estimated, assignment: &Assignment) -> Option<Reading> {
    let header = DensityHeader {
        time: table.time(),
        index: table.index as u32,
        quantities: estimated.values.len() as u32,
        diagnostic: estimated.diagnostic,
        diagnostics: estimated.diagnostics,
        mass_on_grid: estimated.mass_on_grid,
        ..DensityHeader::default()
    };
    Reading::new(header, &estimated.numbers(), assignment).ok()
}

/// The largest change of the Hamiltonian of a row since the first snapshot. Rows that are not told to keep their places are
/// compared in the order of their Hamiltonians: the largest difference of sorted values is never above that of the rows.
fn hamiltonian(plane: &Plane, tables: &[Table]) -> Result<String, String> {
    let keep_places = tables[0].trajectories() == Trajectories::Ordered;
    let values = |table: &Table| {
        let mut values: Vec<f64> =
            table.states().into_iter().map(|state| plane.problem.model.hamiltonian(state)).collect();
        if !keep_places {
            values.sort_by(f64::total_cmp);
        }
        values
    };
    let first = values(&tables[0]);
    let mut worst = (0.0, 0);
    for table in &tables[1..] {
        let now = values(table);
        if now.len() != first.len() {
            let (seen, index) = (now.len(), table.index);
            return Err(format!(
                "snapshot {index} has {seen} rows instead of {}; trajectories do not end",
                first.len()
            ));
        }
        let drift = first.iter().zip(&now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if drift > worst.0 {
            worst = (drift, table.index);
        }
    }
    let (drift, index) = worst;
    if drift <= KEPT {
        return Ok(to_within("kept", drift));
    }
    Err(format!("has changed by {} at snapshot {index}", amount(drift)))
}

/// The largest relative error of the density along characteristics.
fn carried_density(plane: &Plane, first: &Characteristics, tables: &[Table]) -> Result<String, String> {
    let initial = &plane.problem.initial;
    let growth = match first {
        Characteristics::HullMesh { as_printed: true, .. } => density_growth_without_jacobian,
        _ => density_growth,
    };
    let (start, at_start) = (tables[0].states(), tables[0].columns[2]);
    let error = |seen: f64, right: f64| (seen - right).abs() / right.abs().max(f64::MIN_POSITIVE);
    let mut worst = 0.0f64;
    for (state, &n) in start.iter().zip(at_start) {
        let phi = nearest(state.solar_angle(), initial.mean_phi);
        worst = worst.max(error(n, initial.density(phi, state.eccentricity())));
    }
    if worst > KEPT {
        return Err(format!("n is off the initial Gaussian by {} at the start, relatively", amount(worst)));
    }
    for table in &tables[1..] {
        for (row, state) in table.states().into_iter().enumerate() {
            let right = at_start[row] * growth(start[row], state);
            worst = worst.max(error(table.columns[2][row], right));
        }
        if worst > KEPT {
            return Err(format!("n is off by {} at snapshot {}, relatively", amount(worst), table.index));
        }
    }
    Ok(to_within("right", worst))
}

/// The comparison grid holds the image of the 4-sigma ellipse, so at most `exp(-8)` of the probability lies outside.
fn mass(table: &Table, estimated: &Estimated) -> Result<f64, String> {
    let outside = (-8.0f64).exp();
    if let Content::Mixture(_) = table.snapshot.content {
        let sum: f64 = table.columns[0].iter().sum();
        if (sum - 1.0).abs() > WEIGHTS {
            return Err(format!("the weights sum to {sum}"));
        }
    }
    let tolerance = match table.snapshot.content {
        Content::Samples(_) => {
            let n = table.rows();
            SIGMAS * (outside / n).sqrt() + 1.0 / n
        }
        _ => MASS,
    };
    let mass = estimated.mass_on_grid;
    if table.may_withhold() && mass.is_nan() {
        return Ok(mass);
    }
    let allowed = 1.0 - outside - tolerance..=1.0 + MASS;
    if allowed.contains(&mass) { Ok(mass) } else { Err(format!("the grid holds {mass:.4}")) }
}

/// The worst moment of all snapshots.
#[derive(Debug, Default)]
struct Worst {
    good: Option<(f64, String)>,
    problems: Vec<String>,
    withheld: Vec<String>,
}

impl Worst {
    /// Compares the moments of a snapshot with the exact ones.
    fn take(&mut self, plane: &Plane, table: &Table, moments: &[f64]) {
        let flow = Flow::new(plane.problem.model);
        let exact = Exact::new(&plane.problem, &flow, ExactSettings::default());
        let (time, critical_e) = (table.time(), plane.problem.critical_e);
        let right = exact.moments(time).and_then(|right| Ok((right, exact.probability_above(critical_e, time)?)));
        let (right, above) = match right {
            Ok(right) => right,
            Err(why) => return self.problems.push(format!("the exact moments cannot be computed: {why}")),
        };
        let (a, b) = (right.std_phi, right.std_e);
        let right = [right.mean_phi, right.std_phi, right.mean_e, right.std_e, right.cov_phi_e, above.value];
        let (allowed, units, unit) = match &table.snapshot.content {
            Content::Samples(samples) => {
                let independent = groups(samples).is_none();
                (sample_errors(plane, table, independent, right[5]), SIGMAS, "standard errors")
            }
            _ => ([a, a, b, b, a * b, 1.0].map(|unit| unit * GENEROUS), GENEROUS, "standard deviations"),
        };
        let off = |error: f64, difference: f64| match () {
            () if error.is_finite() => format!("off by {} {unit}", amount(error * units)),
            () if difference.is_nan() => "it is no number".into(),
            () => format!("off by {}, and the samples are all alike: no chance explains it", amount(difference.abs())),
        };
        for (k, (seen, right)) in moments.iter().copied().zip(right).enumerate() {
            let difference = if k == 0 { nearest(seen - right, 0.0) } else { seen - right };
            if seen.is_nan() && table.may_withhold() {
                self.withheld.push(format!("{} at {time} yr", MOMENTS[k]));
                continue;
            }
            let error = (difference / allowed[k]).abs();
            let text = format!("{} at {time} yr is {seen:.7}, exact {right:.7}", MOMENTS[k]);
            if error.is_nan() || error > 1.0 {
                self.problems.push(format!("{text}: {}", off(error, difference)));
            } else if self.good.as_ref().is_none_or(|(worst, _)| error > *worst) {
                self.good = Some((error, format!("largest error {} {unit}: {text}", amount(error * units))));
            }
        }
    }

    fn verdict(self) -> Result<String, String> {
        match (self.problems.first(), self.good) {
            (Some(first), _) if self.problems.len() > 1 => {
                Err(format!("{first}; and {} more", self.problems.len() - 1))
            }
            (Some(first), _) => Err(first.clone()),
            (None, good) => {
                let withheld = match &self.withheld[..] {
                    [] => None,
                    all => Some(format!("withheld: {}", all.join(", "))),
                };
                Ok(good.map(|(_, text)| text).into_iter().chain(withheld).collect::<Vec<_>>().join("; "))
            }
        }
    }
}

/// What samples may be off: [`SIGMAS`] standard errors of independent draws, and room for one sample in a count. Opposites in
/// pairs have equal squares, so draws in groups may count for half as many independent ones.
fn sample_errors(plane: &Plane, table: &Table, independent: bool, above: f64) -> [f64; 6] {
    let n = table.rows();
    let sigmas = if independent { SIGMAS } else { SIGMAS * SQRT_2 };
    let (grid, critical_e) = (plane.grids[table.index], plane.problem.critical_e);
    let errors = binning::estimate(table.columns[0], table.columns[1], grid, critical_e).standard_errors;
    let mut allowed = errors.to_array().map(|error| sigmas * error);
    allowed[5] = sigmas * (above * (1.0 - above) / n).sqrt() + 1.0 / n;
    allowed
}
