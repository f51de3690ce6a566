//! GMM-UT: a Gaussian mixture whose components are moved by the unscented transform (Sect. 3.3).

use density::mixture::library::{self, Variance};
use density::mixture::merge::merge;
use density::mixture::plan::Adaptive;
use density::mixture::split::Direction;
use density::mixture::unscented::Unscented;
use density::mixture::{self, Mixture, Split};
use messages::layout::kind;
use serde::{Deserialize, Serialize};

use crate::accuracy::AccuracySetting;
use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::input::{Mode, positive, positive_option};
use crate::kit::{Form, Passage, Propagator};

/// How the initial Gaussian is split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplitChoice {
    /// On a lattice planned for the problem.
    #[default]
    Adaptive,
    /// Along the solar angle, as the paper's text says.
    SolarAngle,
    /// Along the eccentricity, as the paper's numbers say.
    Eccentricity,
    /// Along both: `components` along `e` times `across` along `phi`.
    Both,
    /// Along the direction in which the flow is most nonlinear.
    StrongestNonlinearity,
}

/// Settings of a GMM-UT case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How the initial Gaussian is split; as printed: along the eccentricity unless said otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<SplitChoice>,
    /// Components along the direction of a split that is not adaptive; odd.
    #[serde(deserialize_with = "positive")]
    pub components: usize,
    /// Components across it; odd.
    #[serde(deserialize_with = "positive")]
    pub across: usize,
    /// Whether the splitting library keeps the variance exactly.
    pub keep_variance: bool,
    /// Most sigma points of an adaptive split.
    #[serde(deserialize_with = "positive")]
    pub sigma_points: usize,
    /// Most components that are published: more are merged, keeping mean and covariance (slow).
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub merge_to: Option<usize>,
    /// Corrected, or as the paper printed it.
    pub mode: Mode,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            split: None,
            components: 39,
            across: 1,
            keep_variance: false,
            sigma_points: Adaptive::default().sigma_points,
            merge_to: None,
            mode: Mode::default(),
            accuracy: None,
        }
    }
}

impl Settings {
    /// Whether the settings go together.
    pub(crate) fn check(&self) -> Result<(), String> {
        match [self.components, self.across].into_iter().find(|n| n % 2 == 0 || *n > library::MOST) {
            Some(n) => Err(format!("{n} components are not allowed, it must be an odd number up to {}", library::MOST)),
            None => Ok(()),
        }
    }

    /// The most components that a mixture can have.
    pub fn most_components(&self) -> usize {
        match self.split() {
            SplitChoice::Adaptive => self.sigma_points,
            _ => self.components.saturating_mul(self.across),
        }
    }

    fn split(&self) -> SplitChoice {
        self.split.unwrap_or(match self.mode {
            Mode::Corrected => SplitChoice::Adaptive,
            Mode::AsPrinted => SplitChoice::Eccentricity,
        })
    }

    /// The same in the terms of science.
    fn for_mixture(&self) -> mixture::Settings {
        let variance = if self.keep_variance { Variance::Kept } else { Variance::Free };
        let library = |along, across| Split::Library { along, components: self.components, across, variance };
        let split = match self.split() {
            SplitChoice::Adaptive => {
                Split::Adaptive(Adaptive { sigma_points: self.sigma_points, ..Adaptive::default() })
            }
            SplitChoice::SolarAngle => library(Direction::SolarAngle, self.across),
            SplitChoice::Eccentricity | SplitChoice::Both => library(Direction::Eccentricity, self.across),
            SplitChoice::StrongestNonlinearity => library(Direction::StrongestNonlinearity, self.across),
        };
        let unscented = match self.mode {
            Mode::AsPrinted => Unscented::PAPER,
            Mode::Corrected => Unscented::default(),
        };
        mixture::Settings { split, unscented }
    }
}

/// The GMM-UT propagator.
#[derive(Debug)]
pub struct GaussianMixture {
    settings: Settings,
    course: Option<Course>,
}

/// A mixture on its way.
#[derive(Debug)]
struct Course {
    propagator: mixture::Propagator,
    times: Vec<f64>,
    mixture: Option<Mixture>,
    disagreement: f64,
}

impl GaussianMixture {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, course: None }
    }

    fn mixture(&self) -> Option<&Mixture> {
        self.course.as_ref()?.mixture.as_ref()
    }
}

impl Propagator for GaussianMixture {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let problem = &assignment.problem;
        let flow = AccuracySetting::flow(self.settings.accuracy, problem.force);
        let propagator = mixture::Propagator::new(problem, &flow, &self.settings.for_mixture())?;
        let form = Form { kind: kind::MIXTURE, most_rows: propagator.components(), ..Form::default() };
        self.course = Some(Course { propagator, times: problem.times.clone(), mixture: None, disagreement: f64::NAN });
        Ok(form)
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let course = self.course.as_mut().ok_or_else(Failure::no_scenario)?;
        course.propagator.advance_to(course.times[index])?;
        let mut mixture = course.propagator.mixture();
        course.disagreement = mixture.disagreement(); // of the components as propagated
        if let Some(most) = self.settings.merge_to {
            mixture.components = merge(&mixture.components, most)?;
        }
        let rows = mixture.components.len();
        course.mixture = Some(mixture);
        Ok(rows)
    }

    fn disagreement(&self) -> f64 {
        self.course.as_ref().map_or(f64::NAN, |course| course.disagreement)
    }

    fn first_passage(&mut self, _times: &[f64]) -> Result<Passage, Failure> {
        let reason = "a mixture says where orbits are at a time, not where each has been; take mc, dee or exact";
        Ok(Passage::Cannot(reason.into()))
    }

    fn write(&self, columns: &mut [f64]) {
        let Some(mixture) = self.mixture() else { return };
        let rows = mixture.components.len();
        for (row, component) in mixture.components.iter().enumerate() {
            for (column, value) in component.to_array().into_iter().enumerate() {
                columns[column * rows + row] = value;
            }
        }
    }
}
