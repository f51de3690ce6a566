//! The exact density: no samples, no mesh, no mixture, only the flow run backwards and quadrature.

use density::exact::leaves::{ExactLeaves, LeavesSnapshot};
use density::exact::{Estimated, Exact, ExactSettings, ExactSnapshot, Limits, is_possible};
use density::first_passage::exact::curve;
use density::first_passage::over_leaves;
use density::grid::Grid;
use density::uncertain::ThirdMoments;
use messages::content::Density;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_COLUMNS};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::methods::accuracy::AccuracySetting;
use crate::methods::{Method, Misfit};
use kit::assignment::{Assignment, Plane, Uncertain};
use kit::failure::Failure;
use kit::passage::given_row;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

/// Error estimates in a snapshot.
const ESTIMATES: usize = 4;
/// Most numbers before the joint density, those of three variables.
const MOST_HEAD: usize = 12 + ESTIMATES;

/// Settings of the exact reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Tolerated error of the moments, in standard deviations.
    pub moment_error: f64,
    /// Tolerated L1 error of the joint density.
    pub joint_error: f64,
    /// Most orbits that are used at one snapshot for the moments, for the probability above the critical
    /// eccentricity, for the joint density and for the first-passage curve, each by itself.
    pub most_orbits: usize,
    /// Error estimate of the moments, in standard deviations, above which they are withheld.
    pub largest_moment_error: f64,
    /// Error estimate of a probability above which it is withheld.
    pub largest_probability_error: f64,
    /// Error estimate of the joint density, in L1, above which it is withheld.
    pub largest_joint_error: f64,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        let ExactSettings { moment_error, joint_error, most_orbits, limits } = ExactSettings::default();
        let Limits { moments, probability, joint } = limits;
        Self {
            moment_error,
            joint_error,
            most_orbits,
            largest_moment_error: moments,
            largest_probability_error: probability,
            largest_joint_error: joint,
            accuracy: None,
        }
    }
}

impl Settings {
    fn science(&self) -> ExactSettings {
        let limits = Limits {
            moments: self.largest_moment_error,
            probability: self.largest_probability_error,
            joint: self.largest_joint_error,
        };
        ExactSettings {
            moment_error: self.moment_error,
            joint_error: self.joint_error,
            most_orbits: self.most_orbits,
            limits,
        }
    }
}

impl Method for Settings {
    const NAME: &'static str = "exact";
    type Propagator = ExactDensity;

    fn propagator(self) -> ExactDensity {
        ExactDensity::new(self)
    }

    fn check(&self) -> Result<(), Misfit> {
        for (key, error) in [
            ("moment_error", self.moment_error),
            ("joint_error", self.joint_error),
            ("largest_moment_error", self.largest_moment_error),
            ("largest_probability_error", self.largest_probability_error),
            ("largest_joint_error", self.largest_joint_error),
        ] {
            if !(error.is_finite() && error > 0.0) {
                return Err(Misfit::new(key, format!("{error} is not allowed, it must be a number greater than 0")));
            }
        }
        match self.most_orbits {
            0 => Err(Misfit::new("most_orbits", "0 is not allowed, it must be at least 1")),
            _ => Ok(()),
        }
    }

    fn check_scenario(&self, assignment: &Assignment, _: Shard) -> Result<(), Failure> {
        let model = match &assignment.uncertain {
            Some(Uncertain { problem, .. }) => problem.plane.model,
            None => assignment.plane()?.problem.model,
        };
        Ok(is_possible(&model)?)
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, bins: (usize, usize), _: usize) -> usize {
        bins.0.saturating_mul(bins.1).saturating_add(MOST_HEAD)
    }

    /// The exact curve follows from the initial density, whatever the snapshots are.
    fn curve_needs_snapshots(&self) -> bool {
        false
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Err("the exact density is refined where the whole of it needs that; exact cannot be split".into())
    }
}

/// The exact propagator.
#[derive(Debug)]
pub struct ExactDensity {
    settings: ExactSettings,
    accuracy: Option<AccuracySetting>,
    work: Option<Work>,
    /// The numbers of the snapshot that has been reached.
    numbers: Vec<f64>,
    /// What the last first-passage curve says of an uncertain radiation parameter.
    given: Vec<[f64; GIVEN_COLUMNS]>,
}

/// The scenario under way.
#[derive(Debug)]
enum Work {
    Plane(Plane),
    /// The radiation parameter is uncertain.
    Leaves {
        exact: Box<ExactLeaves>,
        grids: Vec<Grid>,
    },
}

impl ExactDensity {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings: settings.science(),
            accuracy: settings.accuracy,
            work: None,
            numbers: Vec::new(),
            given: Vec::new(),
        }
    }

    fn snapshot(&self, index: usize) -> Result<Vec<f64>, Failure> {
        match self.work.as_ref().ok_or_else(Failure::no_scenario)? {
            Work::Plane(plane) => {
                let flow = AccuracySetting::flow(self.accuracy, plane.problem.model);
                let exact = Exact::new(&plane.problem, &flow, self.settings).snapshot(&plane.grids, index)?;
                Ok(numbers(&exact, None))
            }
            Work::Leaves { exact, grids } => {
                let LeavesSnapshot { plane, third } = exact.snapshot(grids, index)?;
                Ok(numbers(&plane, Some(third)))
            }
        }
    }
}

/// The payload of a snapshot: the quantities of the scenario's space in their order, the error estimates, the joint
/// density.
fn numbers(exact: &ExactSnapshot, third: Option<ThirdMoments>) -> Vec<f64> {
    let ExactSnapshot { estimate, moment_error, circular_error, probability_error, joint_error, .. } = exact;
    let [mean_phi, std_phi, mean_e, std_e, cov_phi_e, above] = estimate.moments.to_array();
    let moments = match third {
        None => vec![mean_phi, std_phi, mean_e, std_e, cov_phi_e],
        Some(ThirdMoments { mean, deviation, with_phi, with_e }) => {
            vec![mean_phi, std_phi, mean_e, std_e, mean, deviation, cov_phi_e, with_phi, with_e]
        }
    };
    let circular = [above, estimate.circular.mean, estimate.circular.resultant];
    let errors = [*moment_error, *circular_error, *probability_error, *joint_error];
    [&moments[..], &circular, &errors, &estimate.joint].concat()
}

/// A row of the first-passage curve. A probability whose error estimate is too large is withheld; its bounds are known
/// nevertheless.
fn row(time: f64, p: Estimated, largest_error: f64) -> [f64; PASSAGE_COLUMNS] {
    let value = if p.error <= largest_error { p.value } else { f64::NAN };
    [time, value, (p.value - p.error).max(0.0), (p.value + p.error).min(1.0)]
}

impl Propagator for ExactDensity {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let grids = match &assignment.uncertain {
            Some(Uncertain { problem, grids }) => {
                let accuracy = self.accuracy.unwrap_or_default().0;
                let exact = Box::new(ExactLeaves::new(problem.clone(), accuracy, self.settings));
                self.work = Some(Work::Leaves { exact, grids: grids.clone() });
                grids
            }
            None => {
                let plane = assignment.plane()?;
                self.work = Some(Work::Plane(plane.clone()));
                &plane.grids
            }
        };
        let most_bins = grids.iter().map(Grid::len).max().unwrap_or(0);
        let head = assignment.space.quantities().len() + ESTIMATES;
        Ok(Form::whole(Density, head + most_bins))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.numbers = self.snapshot(index)?;
        Ok(self.numbers.len())
    }

    fn write(&self, columns: &mut [f64]) {
        columns.copy_from_slice(&self.numbers);
    }

    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        self.given.clear();
        let ExactSettings { most_orbits, limits, .. } = self.settings;
        let probabilities: Vec<Estimated> = match self.work.as_ref().ok_or_else(Failure::no_scenario)? {
            Work::Plane(plane) => {
                let flow = AccuracySetting::flow(self.accuracy, plane.problem.model);
                curve(&plane.problem, &flow, times, most_orbits)?
            }
            Work::Leaves { exact, .. } => {
                let passed = over_leaves::curve(exact, times)?;
                self.given = passed.iter().map(|p| given_row([p.radiation_if_passed, p.radiation_if_not])).collect();
                passed.iter().map(|passed| passed.probability).collect()
            }
        };
        let rows = times.iter().zip(probabilities).map(|(&time, p)| row(time, p, limits.probability));
        Ok(Passage::Curve(rows.collect()))
    }

    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        self.given.clone()
    }
}
