//! The assignment of a scenario: its problem, and the grids on which densities will be compared.

use density::flow::Flow;
use density::grid::{comparison_grids, grids_over_leaves};
use density::in_space::pilot;
use density::uncertain::UncertainProblem;
use kit::assignment::{Assignment, Plane, Uncertain};
use kit::failure::Failure;

use crate::files::scenario_file::{AnyScenario, ScenarioFile, ScenarioInSpace};

/// Makes assignments.
#[derive(Debug, Clone, Copy)]
pub struct Assigning {
    /// The run to which they belong.
    pub run_id: u64,
    /// Position of the scenario in the run, and the number of scenarios in it; 0 if that is not known.
    pub place: (u32, u32),
    /// Bins of the comparison grid, in `phi` and `e`.
    pub bins: (usize, usize),
}

/// The assignment of a scenario without grids, as far as it is known before anything is computed; `None` if it
/// describes an orbit without a cloud.
pub fn without_grids(scenario: &AnyScenario) -> Option<Assignment> {
    let (name, place) = (scenario.name(), (0, 0));
    match scenario {
        AnyScenario::InPlane { scenario, .. } => Some(match scenario.uncertain() {
            Some(problem) => Assignment::with_uncertainty(0, name, place, Uncertain { problem, grids: Vec::new() }),
            None => {
                Assignment::in_plane(0, name, place, Plane { problem: scenario.problem.clone(), grids: Vec::new() })
            }
        }),
        AnyScenario::InSpace(ScenarioInSpace { cloud, .. }) => {
            let problem = cloud.as_deref()?.clone();
            Some(Assignment::in_space(0, name, place, problem, Vec::new()))
        }
    }
}

impl Assigning {
    /// The assignment of a scenario.
    ///
    /// # Errors
    /// If its grids cannot be chosen, or if it describes an orbit without a cloud.
    pub fn assignment(&self, scenario: &AnyScenario) -> Result<Assignment, Failure> {
        match scenario {
            AnyScenario::InPlane { scenario, .. } => self.in_plane(scenario),
            AnyScenario::InSpace(scenario) => self.in_space(scenario),
        }
    }

    fn in_plane(&self, ScenarioFile { name, problem, spread, .. }: &ScenarioFile) -> Result<Assignment, Failure> {
        let (phi_bins, e_bins) = self.bins;
        let problem = problem.clone();
        Ok(match spread {
            None => {
                let grids = comparison_grids(&problem, &Flow::new(problem.model), phi_bins, e_bins)?;
                Assignment::in_plane(self.run_id, name, self.place, Plane { problem, grids })
            }
            Some(spread) => {
                let problem = UncertainProblem { plane: problem, spread: *spread };
                let grids = grids_over_leaves(&problem, phi_bins, e_bins)?;
                Assignment::with_uncertainty(self.run_id, name, self.place, Uncertain { problem, grids })
            }
        })
    }

    /// Inclination and node have as many bins as the eccentricity.
    fn in_space(&self, ScenarioInSpace { name, cloud, .. }: &ScenarioInSpace) -> Result<Assignment, Failure> {
        let Some(problem) = cloud else {
            return Err(Failure::Refused(format!("{name} describes an orbit without a cloud about it")));
        };
        let (phi_bins, others) = self.bins;
        let axes = pilot::axes(problem, &[phi_bins, others, others, others])?;
        Ok(Assignment::in_space(self.run_id, name, self.place, (**problem).clone(), axes))
    }
}
