//! Rules about what the numbers mean: Hamiltonian, density along characteristics, mass, moments.
//!
//! Snapshots that break no rule of [`super::delivery`] are judged by the estimator's own methods and against the exact
//! answer.

use std::f64::consts::SQRT_2;

use density::angle::nearest;
use density::binning;
use density::exact::{Exact, ExactSettings};
use density::flow::Flow;
use density::model::PlanarHamiltonian;
use density::model::plane::{density_growth, density_growth_without_jacobian};
use kit::assignment::{Assignment, Plane};
use kit::diagnosis;
use kit::kind::{Estimated, Trajectories, groups};
use kit::snapshot_rules::decode;
use messages::content::{Characteristics, Content};
use messages::layout::{DensityHeader, SnapshotHeader};
use nodes::services::estimation::CaseEstimator;
use nodes::services::reading::Reading;

use super::amount::{amount, to_within};
use super::answer::{Answer, Received};
use super::in_space::Right;
use super::moments::{Compared, GENEROUS, SIGMAS, Unit, Worst};
use super::passages;
use super::table::Table;
use super::verdict::{Findings, Rule};

/// Tolerated change of the Hamiltonian, which spans about 0.001 over a cloud, and relative error of a density carried
/// along.
const KEPT: f64 = 1e-6;
/// Tolerated error of other methods' mass on the grid.
const MASS: f64 = 0.01;
/// Most of the probability that lies outside a comparison grid in space.
const OUTSIDE_IN_SPACE: f64 = 2e-3;
/// Tolerated error of the sum of a mixture's weights.
const WEIGHTS: f64 = 1e-6;
/// Names of the moments, in the order of a message.
const MOMENTS: [&str; 6] = ["mean phi", "std phi", "mean e", "std e", "covariance", "probability above critical e"];

/// Judges all snapshots of an answer, up to the first that cannot be decoded.
pub fn judge(findings: &mut Findings, answer: &Answer, redrawn: bool) {
    let assignment = &answer.assignment;
    let tables = tables(answer);
    let Some(first) = tables.first() else { return };
    let right = match assignment.in_space.as_ref().map(|problem| Right::new(problem, assignment)).transpose() {
        Ok(right) => right,
        Err(why) => return findings.take(Rule::Moments, named(assignment, Err(why))),
    };
    if let Some(plane) = &assignment.plane {
        let trajectories = first.trajectories();
        if trajectories == Trajectories::Ordered || (trajectories == Trajectories::Unordered && !redrawn) {
            findings.take(Rule::Hamiltonian, named(assignment, hamiltonian(plane, &tables)));
        }
        if let Content::Characteristics(characteristics) = first.snapshot.content {
            findings.take(Rule::CarriedDensity, named(assignment, carried_density(plane, &characteristics, &tables)));
        }
    }
    let Some(densities) = judge_densities(findings, assignment, &tables, right.as_ref()) else { return };
    for passage in &answer.heard.passages {
        match passages::judge(assignment, passage, &densities) {
            Ok(seen) if seen.is_empty() => {}
            seen => findings.take(Rule::FirstPassage, named(assignment, seen)),
        }
    }
}

/// What was seen, after the name of the scenario.
fn named(assignment: &Assignment, seen: Result<String, String>) -> Result<String, String> {
    let name = |text: String| format!("{}: {text}", assignment.description.name);
    seen.map(name).map_err(name)
}

/// Judges the mass and the moments of the densities that follow from the snapshots, and returns these; `None` if no
/// density can be made of one of them.
fn judge_densities(
    findings: &mut Findings,
    assignment: &Assignment,
    tables: &[Table],
    right: Option<&Right>,
) -> Option<Vec<Reading>> {
    let plane = assignment.plane.as_ref();
    let name = &assignment.description.name;
    let mut case = CaseEstimator::default();
    let mut worst = Worst::default();
    let mut least_mass = f64::INFINITY;
    let mut densities = Vec::new();
    for table in tables {
        let estimated = match case.estimate(&table.snapshot, assignment) {
            Ok(estimated) => estimated,
            Err(why) => {
                let seen = Err(format!("snapshot {}: no density can be made of it: {why}", table.index));
                findings.take(Rule::Mass, named(assignment, seen));
                return None;
            }
        };
        densities.extend(reading(table, &estimated, assignment));
        match mass(table, &estimated, plane.is_some()) {
            Ok(mass) if mass.is_nan() => {
                findings.good(Rule::Mass, format!("{name}, snapshot {}: withheld", table.index));
            }
            Ok(mass) => least_mass = least_mass.min(mass),
            Err(why) => findings.problem(Rule::Mass, format!("{name}, snapshot {}: {why}", table.index)),
        }
        let compared = match (plane, right) {
            (Some(plane), _) => compared(plane, table, &estimated.values[..MOMENTS.len()]),
            (None, Some(right)) => Ok(right.compared(assignment, table, &estimated)),
            (None, None) => Ok(Vec::new()),
        };
        match compared {
            Ok(all) => all.into_iter().for_each(|one| worst.take(one, table.may_withhold())),
            Err(why) => worst.trouble(why),
        }
    }
    if least_mass.is_finite() {
        findings.good(Rule::Mass, format!("{name}: at least {least_mass:.4}"));
    }
    findings.take(Rule::Moments, named(assignment, worst.verdict()));
    Some(densities)
}

/// The snapshots of an answer, up to the first that cannot be decoded.
fn tables(answer: &Answer) -> Vec<Table<'_>> {
    let table = |(index, received)| {
        let Received { header, items }: &Received<SnapshotHeader> = received;
        let snapshot = decode(header, items, &answer.assignment, index).ok()?;
        Some(Table { index, snapshot, columns: items.chunks_exact(header.rows as usize).collect() })
    };
    answer.heard.snapshots.iter().enumerate().map_while(table).collect()
}

/// What a snapshot came to, as the recorder hears of it.
fn reading(table: &Table, estimated: &Estimated, assignment: &Assignment) -> Option<Reading> {
    let (diagnostic, diagnostics) = diagnosis::to_parts(estimated.diagnosis);
    let header = DensityHeader {
        time: table.time(),
        index: table.index as u32,
        quantities: estimated.values.len() as u32,
        diagnostic,
        diagnostics,
        mass_on_grid: estimated.mass_on_grid,
        ..DensityHeader::default()
    };
    Reading::new(header, &estimated.numbers(), assignment).ok()
}

/// The largest change of the Hamiltonian of a row since the first snapshot. Rows that are not told to keep their places
/// are compared in the order of their Hamiltonians: the largest difference of sorted values is never above that of the
/// rows.
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

/// The comparison grid in the plane holds the image of the 4-sigma ellipse, so at most `exp(-8)` of the probability
/// lies outside; in space it encloses a pilot cloud, at most [`OUTSIDE_IN_SPACE`] outside.
fn mass(table: &Table, estimated: &Estimated, is_in_plane: bool) -> Result<f64, String> {
    let outside = if is_in_plane { (-8.0f64).exp() } else { OUTSIDE_IN_SPACE };
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

/// Compares the moments of a snapshot with the exact ones.
///
/// # Errors
/// Why there are no exact ones.
fn compared(plane: &Plane, table: &Table, moments: &[f64]) -> Result<Vec<Compared>, String> {
    let flow = Flow::new(plane.problem.model);
    let exact = Exact::new(&plane.problem, &flow, ExactSettings::default());
    let (time, critical_e) = (table.time(), plane.problem.critical_e);
    let right = exact.moments(time).and_then(|right| Ok((right, exact.probability_above(critical_e, time)?)));
    let (right, above) = right.map_err(|why| format!("the exact moments cannot be computed: {why}"))?;
    let (a, b) = (right.std_phi, right.std_e);
    let right = [right.mean_phi, right.std_phi, right.mean_e, right.std_e, right.cov_phi_e, above.value];
    let (allowed, unit) = match &table.snapshot.content {
        Content::Samples(samples) => {
            let independent = groups(samples).is_none();
            (sample_errors(plane, table, independent, right[5]), Unit::StandardErrors)
        }
        _ => ([a, a, b, b, a * b, 1.0].map(|unit| unit * GENEROUS), Unit::Deviations),
    };
    let one = |k: usize| Compared {
        what: format!("{} at {time} yr", MOMENTS[k]),
        seen: moments[k],
        right: right[k],
        is_angle: k == 0,
        allowed: allowed[k],
        unit,
    };
    Ok((0..MOMENTS.len()).map(one).collect())
}

/// What samples may be off: [`SIGMAS`] standard errors of independent draws, and room for one sample in a count.
/// Opposites in pairs have equal squares, so draws in groups may count for half as many independent ones.
fn sample_errors(plane: &Plane, table: &Table, independent: bool, above: f64) -> [f64; 6] {
    let n = table.rows();
    let sigmas = if independent { SIGMAS } else { SIGMAS * SQRT_2 };
    let (grid, critical_e) = (plane.grids[table.index], plane.problem.critical_e);
    let errors = binning::estimate(table.columns[0], table.columns[1], grid, critical_e).standard_errors;
    let mut allowed = errors.to_array().map(|error| sigmas * error);
    allowed[5] = sigmas * (above * (1.0 - above) / n).sqrt() + 1.0 / n;
    allowed
}
