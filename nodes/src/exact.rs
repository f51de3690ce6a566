//! The exact density: no samples, no mesh, no mixture, only the flow run backwards and quadrature.

use density::exact::{Exact, ExactSnapshot, Settings as ExactSettings};
use density::first_passage::exact::exact_curve;
use messages::layout::{DENSITY_HEAD, kind};
use serde::{Deserialize, Serialize};

use crate::accuracy::AccuracySetting;
use crate::assignment::Assignment;
use crate::builtin::Misfit;
use crate::failure::Failure;
use crate::kit::{Form, Passage, Propagator};

/// Settings of the exact reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Tolerated error of the moments, in standard deviations.
    pub moment_error: f64,
    /// Tolerated L1 error of the joint density.
    pub joint_error: f64,
    /// Orbits that moments, and likewise the joint density, may take at one snapshot.
    pub most_orbits: usize,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        let ExactSettings { moment_error, joint_error, most_orbits } = ExactSettings::default();
        Self { moment_error, joint_error, most_orbits, accuracy: None }
    }
}

impl Settings {
    /// Whether the settings can be met at all.
    pub(crate) fn check(&self) -> Result<(), Misfit> {
        for (key, tolerance) in [("moment_error", self.moment_error), ("joint_error", self.joint_error)] {
            if !(tolerance.is_finite() && tolerance > 0.0) {
                let problem = format!("{tolerance} is not allowed, it must be a number greater than 0");
                return Err(Misfit::new(key, problem));
            }
        }
        match self.most_orbits {
            0 => Err(Misfit::new("most_orbits", "0 is not allowed, it must be at least 1")),
            _ => Ok(()),
        }
    }
}

/// The exact propagator.
#[derive(Debug)]
pub struct ExactDensity {
    settings: ExactSettings,
    accuracy: Option<AccuracySetting>,
    work: Option<(Assignment, Option<ExactSnapshot>)>,
}

impl ExactDensity {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        let Settings { moment_error, joint_error, most_orbits, accuracy } = settings;
        Self { settings: ExactSettings { moment_error, joint_error, most_orbits }, accuracy, work: None }
    }
}

impl Propagator for ExactDensity {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let most_bins = assignment.grids.iter().map(density::grid::Grid::len).max().unwrap_or(0);
        self.work = Some((assignment.clone(), None));
        Ok(Form { kind: kind::DENSITY, most_rows: DENSITY_HEAD + most_bins, ..Form::default() })
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (assignment, snapshot) = self.work.as_mut().ok_or_else(Failure::no_scenario)?;
        let flow = AccuracySetting::flow(self.accuracy, assignment.problem.force);
        let exact = Exact::new(&assignment.problem, &flow, self.settings).snapshot(&assignment.grids, index)?;
        let rows = DENSITY_HEAD + exact.estimate.joint.len();
        *snapshot = Some(exact);
        Ok(rows)
    }

    fn write(&self, columns: &mut [f64]) {
        let Some((_, Some(exact))) = &self.work else { return };
        let (head, joint) = columns.split_at_mut(DENSITY_HEAD);
        let (moments, rest) = head.split_at_mut(6);
        moments.copy_from_slice(&exact.estimate.moments.to_array());
        let circular = exact.estimate.circular;
        let ExactSnapshot { moment_error, circular_error, probability_error, joint_error, .. } = *exact;
        rest.copy_from_slice(&[
            circular.mean,
            circular.resultant,
            moment_error,
            circular_error,
            probability_error,
            joint_error,
        ]);
        joint.copy_from_slice(&exact.estimate.joint);
    }

    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let (assignment, _) = self.work.as_ref().ok_or_else(Failure::no_scenario)?;
        let curve =
            exact_curve(&assignment.problem, &AccuracySetting::flow(self.accuracy, assignment.problem.force), times)?;
        let row = |(&time, p): (&f64, &density::exact::pullback::Quadrature)| {
            [time, p.value, (p.value - p.error).max(0.0), (p.value + p.error).min(1.0)]
        };
        Ok(Passage::Curve(times.iter().zip(&curve).map(row).collect()))
    }
}
