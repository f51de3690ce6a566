//! The tables in the plane, against the exact joint density.

use std::f64::consts::PI;

use density::distance::between;
use density::estimate::Estimate;
use density::exact::{Exact, ExactSettings};
use density::flow::Flow;
use density::gaussian::Gaussian;
use density::grid::{Grid, comparison_grids};
use density::mixture::adaptive::{AdaptiveMixture, Fineness};
use density::mixture::criterion::Criterion;
use density::mixture::library::Variance;
use density::mixture::plan::Adaptive;
use density::mixture::split::Direction;
use density::mixture::unscented::Unscented;
use density::mixture::{self, MixtureSettings, PlanarComponent, PlanarMixturePropagator, Split};
use density::problem::Problem;

use crate::common::paper;
use crate::{COMPONENTS, cell, head, row};

/// The times \[yr\] of each scenario that are looked at.
const TIMES: [[f64; 2]; 3] = [[1.0, 2.0], [1.0, 3.0], [1.0, 2.0]];

/// One scenario at one time.
pub struct Case {
    pub scenario: usize,
    pub time: f64,
    problem: Problem,
    pub grid: Grid,
    pub exact: Estimate,
    /// The error estimate of the exact density.
    error: f64,
}

/// A split along one direction.
pub struct CriterionSplits {
    pub case: usize,
    pub criterion: Criterion,
    /// Angle of the direction from `phi` towards `e` in standardised coordinates \[rad\].
    pub angle: f64,
    /// For each number of components, the components at the end and the L1 error.
    pub splits: Vec<(Vec<PlanarComponent>, f64)>,
}

/// All that was computed.
pub struct All {
    pub cases: Vec<Case>,
    pub of_criteria: Vec<CriterionSplits>,
}

impl Case {
    fn new(scenario: usize, time: f64) -> Self {
        let problem = paper(scenario, vec![0.0, time]);
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(&problem, &flow, 100, 100).expect("a grid");
        let snapshot = Exact::new(&problem, &flow, ExactSettings::default()).snapshot(&grids, 1).expect("a snapshot");
        Self { scenario, time, problem, grid: grids[1], exact: snapshot.estimate, error: snapshot.joint_error }
    }

    /// The components of a split at the end, and their L1 error.
    fn carried(&self, split: Split) -> (Vec<PlanarComponent>, f64) {
        let flow = Flow::new(self.problem.model);
        let settings = MixtureSettings { split, ..MixtureSettings::default() };
        let mut propagator = PlanarMixturePropagator::new(&self.problem, &flow, &settings).expect("a split");
        propagator.advance_to(self.time).expect("no orbit is lost");
        let components = propagator.mixture().components;
        let l1 = self.l1(&components);
        (components, l1)
    }

    fn along(&self, along: Direction, components: usize) -> (Vec<PlanarComponent>, f64) {
        self.carried(Split::Library { along, components, across: 1, variance: Variance::Kept })
    }

    /// The tree of parts that is split where the flow is not linear, with so many components at most.
    fn tree(&self, components: usize) -> (usize, f64) {
        let initial = Gaussian::from(self.problem.initial);
        let fineness = Fineness { components, ..Fineness::default() };
        let flow = Flow::new(self.problem.model);
        let mut mixture =
            AdaptiveMixture::new(flow, &initial, &[self.time], Unscented::default(), fineness).expect("a tree");
        mixture.advance_to(self.time).expect("no orbit is lost");
        let planar = |c: &mixture::component::Component<2>| PlanarComponent {
            weight: c.weight,
            mean_phi: c.mean[0],
            mean_e: c.mean[1],
            var_phi: c.covariance[0][0],
            cov_phi_e: c.covariance[0][1],
            var_e: c.covariance[1][1],
        };
        let components: Vec<PlanarComponent> = mixture.mixture().iter().map(planar).collect();
        (components.len(), self.l1(&components))
    }

    fn l1(&self, components: &[PlanarComponent]) -> f64 {
        let estimate = mixture::estimate(components, &self.grid, self.problem.critical_e).expect("Gaussians");
        2.0 * between(&estimate.joint, &self.exact.joint, self.grid.bin_area()).total_variation
    }

    fn angle(&self, along: Direction) -> f64 {
        let Direction::OfCriterion(criterion) = along else { return f64::NAN };
        let initial = Gaussian::from(self.problem.initial);
        let flow = Flow::new(self.problem.model);
        let found = mixture::criterion::search(criterion, flow, &initial, &[self.time]).expect("a direction");
        let [phi, e] = initial.point(found.preferred.direction);
        let (u, v) = self.problem.initial.standardise(phi, e);
        v.atan2(u).rem_euclid(PI)
    }
}

/// Prints all tables.
pub fn tables() -> All {
    let cases: Vec<Case> =
        (1..=3).flat_map(|scenario| TIMES[scenario - 1].map(|time| Case::new(scenario, time))).collect();
    let mut of_criteria = Vec::new();
    for (index, pair) in cases.chunks(2).enumerate() {
        println!("\nscenario {}: L1 error of the joint density by number of components\n", pair[0].scenario);
        head(&pair.iter().map(|case| case.time).collect::<Vec<_>>(), true);
        for criterion in Criterion::ALL {
            let rows = pair.iter().enumerate().map(|(k, case)| of_criterion(2 * index + k, case, criterion));
            let rows: Vec<CriterionSplits> = rows.collect();
            print_row(criterion.name(), &rows);
            of_criteria.extend(rows);
        }
        others(pair);
    }
    for scenario in 1..=3 {
        every_snapshot(scenario);
    }
    All { cases, of_criteria }
}

/// One split for all snapshots of a scenario, as a case of a run has: the L1 error at each.
fn every_snapshot(scenario: usize) {
    let steps = if scenario == 2 { 6 } else { 4 };
    let times: Vec<f64> = (1..=steps).map(|k| 0.5 * f64::from(k)).collect();
    println!(
        "\nscenario {scenario}: L1 error at each snapshot with one split for all, 39 components along one direction\n"
    );
    let names: Vec<String> = times.iter().map(|time| format!("{time} yr")).collect();
    row(&[vec!["split".into(), "components".into()], names].concat());
    println!("|{}", "---|".repeat(times.len() + 2));
    let problem = paper(scenario, [vec![0.0], times.clone()].concat());
    let cases: Vec<Case> = times.iter().map(|&time| Case::new(scenario, time)).collect();
    let flow = Flow::new(problem.model);
    let library = |along| Split::Library { along, components: 39, across: 1, variance: Variance::Kept };
    let criterion = |criterion| library(Direction::OfCriterion(criterion));
    for (name, split) in [
        ("eccentricity", library(Direction::Eccentricity)),
        ("strongest-nonlinearity", library(Direction::StrongestNonlinearity)),
        ("usfos", criterion(Criterion::Usfos)),
        ("wussos", criterion(Criterion::Wussos)),
        ("wussolc", criterion(Criterion::Wussolc)),
        ("adaptive", Split::Adaptive(Adaptive { sigma_points: 600, ..Adaptive::default() })),
        ("adaptive", Split::Adaptive(Adaptive::default())),
    ] {
        let settings = MixtureSettings { split, ..MixtureSettings::default() };
        let mut propagator = PlanarMixturePropagator::new(&problem, &flow, &settings).expect("a split");
        let mut cells = vec![format!("`{name}`"), propagator.components().to_string()];
        for case in &cases {
            propagator.advance_to(case.time).expect("no orbit is lost");
            cells.push(cell(case.l1(&propagator.mixture().components)));
        }
        row(&cells);
    }
}

fn of_criterion(index: usize, case: &Case, criterion: Criterion) -> CriterionSplits {
    let angle = case.angle(Direction::OfCriterion(criterion));
    let splits = COMPONENTS.iter().map(|&count| case.along(Direction::Angle(angle), count)).collect();
    CriterionSplits { case: index, criterion, angle, splits }
}

fn print_row(name: &str, rows: &[CriterionSplits]) {
    let mut cells = vec![format!("`{name}`")];
    for of_criteria in rows {
        cells.push(format!("{:.0}°", of_criteria.angle.to_degrees()));
        cells.extend(of_criteria.splits.iter().map(|(_, l1)| cell(*l1)));
    }
    row(&cells);
}

/// The splits that are no criterion of a single direction.
fn others(pair: &[Case]) {
    let line = |name: &str, of: &dyn Fn(&Case, usize) -> String, angle: &str| {
        let mut cells = vec![name.to_string()];
        for case in pair {
            cells.push(angle.to_string());
            cells.extend(COMPONENTS.iter().map(|&count| of(case, count)));
        }
        row(&cells);
    };
    let along = |direction| move |case: &Case, count| cell(case.along(direction, count).1);
    line("`solar-angle`", &along(Direction::SolarAngle), "0°");
    line("`eccentricity`", &along(Direction::Eccentricity), "90°");
    line("`strongest-nonlinearity`", &along(Direction::StrongestNonlinearity), "");
    line("best of 36 angles", &|case, count| best(case, count), "");
    let tree = |case: &Case, count| {
        let (components, l1) = case.tree(count);
        format!("{} ({components})", cell(l1))
    };
    line("tree of parts, at most as many (how many)", &tree, "");
    for count in [39, 99] {
        line(&format!("`wussolc`, {count} times `across`"), &|case, across| across_too(case, count, across), "");
    }
    for case in pair {
        let lattice = |sigma_points| {
            let (components, l1) = case.carried(Split::Adaptive(Adaptive { sigma_points, ..Adaptive::default() }));
            format!("L1 {} with {} components", cell(l1), components.len())
        };
        let single = cell(case.along(Direction::SolarAngle, 1).1);
        println!(
            "\n{} yr: one component {single}; `adaptive` {}; with `sigma_points = 600` {}; the exact density is good to {:.0e}",
            case.time,
            lattice(5000),
            lattice(600),
            case.error
        );
    }
}

/// A split along the direction of WUSSOLC, and across it into a fifth as many as the column says, next odd number.
fn across_too(case: &Case, components: usize, column: usize) -> String {
    let across = (column / 5) | 1;
    let along = Direction::Angle(case.angle(Direction::OfCriterion(Criterion::Wussolc)));
    let l1 = case.carried(Split::Library { along, components, across, variance: Variance::Kept }).1;
    format!("{} (x {across})", cell(l1))
}

/// The least error of a split along any direction, and the direction.
fn best(case: &Case, count: usize) -> String {
    let at = |k: u32| (case.along(Direction::Angle(PI * f64::from(k) / 36.0), count).1, 5 * k);
    let (l1, angle) = (0..36).map(at).min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are angles");
    format!("{} ({angle}°)", cell(l1))
}
