//! A made-up run: an exact case and a Monte Carlo case whose clouds and probabilities a test chooses.

use std::collections::BTreeMap;

use density::grid::Axis;
use density::model::planar::SrpJ2;
use density::model::registry::Planar;
use density::problem::{InitialGaussian, Problem};
use figures::atlas;
use figures::densities::{Densities, Density, Grid};
use figures::scene::{Scenario, Scene};
use results::description::{Description, Projection, Quantity, Statistic, Variable};
use results::rows::PassageRow;
use results::{Manifest, MomentsRow, Results};

pub const BINS: usize = 40;
pub const NAN: f64 = f64::NAN;
pub const ABOVE: &str = "prob_above_critical_e";

/// A run of `exact` (the reference) and `mc` whose clouds and probabilities are made up.
pub struct Run {
    pub scenario: Scenario,
    pub results: Results,
    pub densities: Densities,
}

pub fn manifest() -> Manifest {
    let text = r#"{"run_id": "1", "started": "2026-01-01T00:00:00Z", "versions": {}, "scenarios": {}, "reference": "exact",
        "cases": {"exact": {"runs": ["exact"], "settings": []}, "mc": {"runs": ["mc"], "settings": []}}, "failures": {}}"#;
    serde_json::from_str(text).unwrap()
}

/// A density that is 1 where `cloud(phi, e)` is true and 0 elsewhere.
pub fn density(grid: Grid, cloud: impl Fn(f64, f64) -> bool) -> Density {
    let middle = |axis: &Axis, i: usize| axis.edge(i) + 0.5 * axis.width();
    let bin = |k: usize| f64::from(u8::from(cloud(middle(&grid.x, k / BINS), middle(&grid.y, k % BINS))));
    let joint: Vec<f64> = (0..BINS * BINS).map(bin).collect();
    let marginal_x = joint.chunks(BINS).map(|row| row.iter().sum()).collect();
    let marginal_y = (0..BINS).map(|j| joint.iter().skip(j).step_by(BINS).sum()).collect();
    Density { grid, joint, marginal_x, marginal_y }
}

pub fn withheld(grid: Grid) -> Density {
    Density { grid, joint: vec![NAN; BINS * BINS], marginal_x: vec![NAN; BINS], marginal_y: vec![NAN; BINS] }
}

pub fn grid() -> Grid {
    let (x, y) = (Axis { low: 1.0, high: 5.0, bins: BINS }, Axis { low: 0.1, high: 0.7, bins: BINS });
    Grid { x, y, is_circle: true }
}

/// A ring: nothing is in its middle.
pub fn ring() -> Density {
    density(grid(), |phi, e| (0.75..1.0).contains(&((phi - 3.0) / 2.0).hypot((e - 0.4) / 0.3)))
}

pub fn row(method: &str, t_yr: f64, above: f64) -> MomentsRow {
    let se = if method == "mc" { 0.01 } else { NAN };
    let numbers = [
        ("mean_phi_rad", 3.0),
        ("std_phi_rad", 0.5),
        ("mean_e", 0.4),
        ("std_e", 0.1),
        (ABOVE, above),
        ("se_mean_phi_rad", se),
        ("se_std_phi_rad", se),
        ("se_mean_e", se),
        ("se_std_e", se),
    ];
    MomentsRow {
        scenario: "made-up".into(),
        method: method.into(),
        t_yr,
        columns: numbers.iter().map(|(column, _)| (*column).to_owned()).collect(),
        numbers: numbers.iter().map(|(_, number)| *number).collect(),
    }
}

/// The description of a scenario in the plane.
fn description(problem: &Problem<Planar>) -> Description {
    let variable = |name: &str, symbol: &str, unit: &str, bounds| Variable {
        name: name.into(),
        symbol: symbol.into(),
        unit: unit.into(),
        bounds,
    };
    let quantity = |statistic, variable: usize, name: &str, column: &str| Quantity {
        statistic,
        variables: vec![variable],
        name: name.into(),
        column: column.into(),
    };
    let projection =
        |density: &str, variables: &[usize]| Projection { density: density.into(), variables: variables.to_vec() };
    Description {
        name: "made-up".into(),
        model: "planar".into(),
        variables: vec![
            variable("solar angle", "phi", "rad", None),
            variable("eccentricity", "e", "", Some([0.0, 1.0])),
        ],
        reentry: 1,
        critical: problem.critical_e,
        times: problem.times.clone(),
        quantities: vec![
            quantity(Statistic::Mean, 0, "mean_phi", "mean_phi_rad"),
            quantity(Statistic::Deviation, 0, "std_phi", "std_phi_rad"),
            quantity(Statistic::Mean, 1, "mean_e", "mean_e"),
            quantity(Statistic::Deviation, 1, "std_e", "std_e"),
            quantity(Statistic::AboveCritical, 1, ABOVE, ABOVE),
        ],
        projections: vec![
            projection("joint", &[0, 1]),
            projection("marginal_phi", &[0]),
            projection("marginal_e", &[1]),
        ],
        ..Description::default()
    }
}

impl Run {
    /// `count` snapshots of a ring.
    pub fn new(count: usize) -> Self {
        let times: Vec<f64> = (0..count).map(|k| 0.25 * k as f64).collect();
        let mut densities = Densities::new();
        let of = densities.entry(("made-up".into(), 0)).or_default();
        for method in ["exact", "mc"] {
            of.insert(method.into(), vec![ring(); count]);
        }
        let rows = |method: &'static str| times.iter().map(move |&t| row(method, t, 0.5)).collect::<Vec<_>>();
        let moments = [rows("exact"), rows("mc")].concat();
        let problem = Problem {
            model: SrpJ2 { radiation: 0.15, oblateness: 0.40921 }.into(),
            initial: InitialGaussian { mean_phi: 2.2, mean_e: 0.2, sigma_phi: 0.2, sigma_e: 0.02, correlation: 0.0 },
            times,
            critical_e: 0.6,
        };
        let results = Results { manifest: manifest(), moments, ..Results::default() };
        Self { scenario: Scenario { description: description(&problem), plane: Some(problem) }, results, densities }
    }

    /// Changes a number in the moments.
    pub fn set(&mut self, row: usize, column: &str, number: f64) {
        let row = &mut self.results.moments[row];
        let place = row.columns.iter().position(|name| name == column).unwrap();
        row.numbers[place] = number;
    }

    pub fn of(mut self, radiation: f64, oblateness: f64) -> Self {
        self.scenario.plane.as_mut().unwrap().model = SrpJ2 { radiation, oblateness }.into();
        self
    }

    pub fn density(&mut self, method: &str, index: usize) -> &mut Density {
        &mut self.densities.get_mut(&("made-up".into(), 0)).unwrap().get_mut(method).unwrap()[index]
    }

    /// Adds a first-passage curve, with one value per snapshot.
    pub fn passages(&mut self, method: &str, values: &[f64]) {
        for (&p, &t_yr) in values.iter().zip(&self.scenario.description.times) {
            let [scenario, method] = ["made-up", method].map(str::to_owned);
            self.results.passages.push(PassageRow {
                scenario,
                method,
                t_yr,
                prob_reached_critical_e: p,
                low: p,
                high: p,
                interval: "error estimate".into(),
            });
        }
    }

    /// All figures as files, by name.
    pub fn figures(&self) -> BTreeMap<String, String> {
        let groups = atlas::of_scene(&Scene::new(&self.scenario, &self.results, &self.densities, 0, false));
        let missing: Vec<&String> = groups.iter().flat_map(|group| &group.missing).collect();
        assert!(missing.is_empty(), "{missing:?}");
        let figures = groups.iter().flat_map(|group| &group.figures);
        figures.map(|figure| (figure.name.clone(), figure.to_file())).collect()
    }

    /// The figure with this name as a file.
    pub fn figure(&self, name: &str) -> String {
        self.figures().remove(name).unwrap_or_else(|| panic!("no {name}"))
    }
}

/// The middle of a small cloud that goes round with time, at the `index`-th of `count` snapshots.
pub fn spot_middle(index: usize, count: usize) -> (f64, f64) {
    let turn = 5.6 * index as f64 / count as f64;
    (3.0 + 1.6 * turn.cos(), 0.4 + 0.23 * turn.sin())
}

/// Half widths of the small cloud.
pub const SPOT: (f64, f64) = (0.15, 0.025);

/// A run of small clouds, each at its own place.
pub fn spots(count: usize) -> Run {
    let mut run = Run::new(count);
    for index in 0..count {
        let middle = spot_middle(index, count);
        let spot = || density(grid(), |phi, e| ((phi - middle.0) / SPOT.0).hypot((e - middle.1) / SPOT.1) < 1.0);
        *run.density("exact", index) = spot();
        *run.density("mc", index) = spot();
    }
    run
}
