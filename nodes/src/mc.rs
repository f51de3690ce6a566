//! Monte Carlo: random draws from the initial Gaussian, each propagated on its own (Sect. 3.1).

use density::flow::Flow;
use density::orbits::Orbits;
use density::sampling;
use messages::layout::kind;
use serde::{Deserialize, Serialize};

use crate::assignment::Assignment;
use crate::course::Course;
use crate::failure::Failure;
use crate::input::positive;
use crate::kit::{Form, Propagator};

/// Settings of a Monte Carlo case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Number of samples.
    #[serde(deserialize_with = "positive")]
    pub samples: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { samples: 100_000, seed: 1 }
    }
}

/// The Monte Carlo propagator.
#[derive(Debug)]
pub struct MonteCarlo {
    settings: Settings,
    course: Option<Course>,
}

impl MonteCarlo {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, course: None }
    }
}

impl Propagator for MonteCarlo {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let problem = &assignment.problem;
        let Settings { samples, seed } = self.settings;
        let (x1, x2) = sampling::draw(&problem.initial, seed, samples);
        self.course = Some(Course::new(Orbits::new(Flow::new(problem.force), x1, x2), problem));
        Ok(Form { kind: kind::SAMPLES, most_rows: samples, ..Form::default() })
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.course.as_mut().ok_or_else(Failure::no_scenario)?.advance(index)
    }

    fn write(&self, columns: &mut [f64]) {
        if let Some(course) = &self.course {
            let (phi, e) = columns.split_at_mut(course.orbits.len());
            course.orbits.read_out(phi, e);
        }
    }
}
