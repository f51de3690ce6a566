//! The exact density: no samples, no mesh, no mixture, only the flow run backwards and quadrature.

use density::exact::{Estimated, Exact, ExactSettings, ExactSnapshot, Limits};
use density::first_passage::exact::curve;
use messages::content::{DENSITY_HEAD, Density};
use serde::{Deserialize, Serialize};

use crate::methods::accuracy::AccuracySetting;
use crate::methods::{Method, Misfit};
use kit::assignment::{Assignment, Plane};
use kit::failure::Failure;
use kit::{Form, Passage, Propagator};

/// Settings of the exact reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, bins: (usize, usize)) -> usize {
        bins.0.saturating_mul(bins.1).saturating_add(DENSITY_HEAD)
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
    work: Option<(Plane, Option<ExactSnapshot>)>,
}

impl ExactDensity {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings: settings.science(), accuracy: settings.accuracy, work: None }
    }
}

impl Propagator for ExactDensity {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let plane = assignment.plane()?;
        let most_bins = plane.grids.iter().map(density::grid::Grid::len).max().unwrap_or(0);
        self.work = Some((plane.clone(), None));
        Ok(Form::whole(Density, DENSITY_HEAD + most_bins))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (plane, snapshot) = self.work.as_mut().ok_or_else(Failure::no_scenario)?;
        let flow = AccuracySetting::flow(self.accuracy, plane.problem.model);
        let exact = Exact::new(&plane.problem, &flow, self.settings).snapshot(&plane.grids, index)?;
        let rows = DENSITY_HEAD + exact.estimate.joint.len();
        *snapshot = Some(exact);
        Ok(rows)
    }

    fn write(&self, columns: &mut [f64]) {
        let Some((_, Some(exact))) = &self.work else { return };
        let (head, joint) = Density::parts(columns);
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
        let (plane, _) = self.work.as_ref().ok_or_else(Failure::no_scenario)?;
        let flow = AccuracySetting::flow(self.accuracy, plane.problem.model);
        let ExactSettings { most_orbits, limits, .. } = self.settings;
        let curve = curve(&plane.problem, &flow, times, most_orbits)?;
        // A probability whose error estimate is too large is withheld; its bounds are known nevertheless.
        let row = |(&time, p): (&f64, &Estimated)| {
            let value = if p.error <= limits.probability { p.value } else { f64::NAN };
            [time, value, (p.value - p.error).max(0.0), (p.value + p.error).min(1.0)]
        };
        Ok(Passage::Curve(times.iter().zip(&curve).map(row).collect()))
    }
}
