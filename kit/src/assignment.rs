//! The scenario message, checked and converted to the types of `density`, and the conversion back.

use std::sync::Arc;

use density::first_passage::curve_times;
use density::grid::{Axis, Grid};
use density::in_space::SpaceProblem;
use density::model::registry::Planar;
use density::problem::Problem;
use density::uncertain::UncertainProblem;
use messages::layout::PASSAGE_TIMES;
use messages::port::Message;
use messages::scenario::{Description, Moment, Projection, ScenarioHeader};
use messages::topic::Scenario;

use crate::failure::Failure;
use crate::limits::MOST_BINS;
use crate::planar_problem::{described, problem};
use crate::problem_key::by_key;
use crate::space::Space;
use crate::space_problem;

/// A scenario to work on.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The decoded message: the model and its parameters by name, the initial Gaussian, and everything else.
    pub description: Description,
    /// The variables of the scenario, and the projections on which densities are compared.
    pub space: Arc<Space>,
    /// The snapshot times \[yr\].
    pub times: Vec<f64>,
    /// The comparison grid of each snapshot: one axis per variable. The axis of a variable that is in no projection
    /// has no bins.
    pub axes: Vec<Vec<Axis>>,
    /// The problem and the grids as types of `density`, if the model is planar and all its parameters are certain.
    pub plane: Option<Plane>,
    /// The same, if the model is planar and its radiation parameter is uncertain.
    pub uncertain: Option<Uncertain>,
    /// The problem, if the model is one in space.
    pub in_space: Option<SpaceProblem>,
}

/// A scenario of a planar model.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// The problem.
    pub problem: Problem<Planar>,
    /// The comparison grid of each snapshot.
    pub grids: Vec<Grid>,
}

/// A scenario of a planar model with an uncertain radiation parameter, which is the cloud's third variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertain {
    /// The problem.
    pub problem: UncertainProblem,
    /// The comparison grid in solar angle and eccentricity of each snapshot.
    pub grids: Vec<Grid>,
}

impl Assignment {
    /// A planar scenario at position `scenario` of the `scenarios` of a run; `scenarios` is 0 if it is not known.
    pub fn in_plane(run_id: u64, name: &str, (scenario, scenarios): (u32, u32), plane: Plane) -> Self {
        let description = described(name, &plane.problem, None, |index| ends(plane.grids.get(index)));
        let description =
            Description { run_id, scenario, scenarios, projections: projections_on(&plane.grids), ..description };
        let axes = plane.grids.iter().map(|grid| vec![grid.phi, grid.e]).collect();
        Self { plane: Some(plane), ..Self::new(description, axes) }
    }

    /// The same for a scenario with an uncertain radiation parameter.
    pub fn with_uncertainty(run_id: u64, name: &str, (scenario, scenarios): (u32, u32), uncertain: Uncertain) -> Self {
        let UncertainProblem { plane, spread } = &uncertain.problem;
        let description = described(name, plane, Some(*spread), |index| ends(uncertain.grids.get(index)));
        let description =
            Description { run_id, scenario, scenarios, projections: projections_on(&uncertain.grids), ..description };
        let axes = uncertain.grids.iter().map(|grid| vec![grid.phi, grid.e, NO_AXIS]).collect();
        Self { uncertain: Some(uncertain), ..Self::new(description, axes) }
    }

    /// The same for a scenario in space, compared on these axes of its variables at each snapshot.
    pub fn in_space(
        run_id: u64,
        name: &str,
        (scenario, scenarios): (u32, u32),
        problem: SpaceProblem,
        axes: Vec<Vec<Axis>>,
    ) -> Self {
        let description =
            Description { run_id, scenario, scenarios, ..space_problem::described(name, &problem, &axes) };
        let compared = description.projections.iter().flat_map(Projection::axes).map(|(variable, _)| variable);
        let compared: Vec<usize> = compared.collect();
        let kept = |(k, axis): (usize, Axis)| if compared.contains(&k) { axis } else { NO_AXIS };
        let axes = axes.into_iter().map(|axes| axes.into_iter().enumerate().map(kept).collect()).collect();
        Self { in_space: Some(problem), ..Self::new(description, axes) }
    }

    fn new(description: Description, axes: Vec<Vec<Axis>>) -> Self {
        let (variables, projections) = (description.variables.clone(), description.projections.clone());
        let space = Arc::new(Space { variables, reentry: description.reentry, projections });
        let times = description.snapshots.iter().map(|moment| moment.time).collect();
        Self { description, space, times, axes, plane: None, uncertain: None, in_space: None }
    }

    /// Largest count of numbers in the payload of a scenario of any of phasecloud's models with `snapshots` snapshots.
    pub const fn numbers(snapshots: usize) -> usize {
        Description::numbers(density::in_space::VARIABLES.len() + 1, AXES_IN_SPACE, snapshots)
    }

    /// Reads a message.
    ///
    /// # Errors
    /// [`Failure::Refused`] says which field is wrong.
    pub fn read(message: &Message<Scenario>) -> Result<Self, Failure> {
        Self::from_parts(message.header(), message.items()).map_err(|why| Failure::Refused(format!("scenario: {why}")))
    }

    /// Position of the scenario in the run.
    pub fn scenario(&self) -> u32 {
        self.description.scenario
    }

    /// The problem and the grids of a planar scenario.
    ///
    /// # Errors
    /// [`Failure::Refused`] if the model is not planar.
    pub fn plane(&self) -> Result<&Plane, Failure> {
        self.plane.as_ref().ok_or_else(|| {
            if self.uncertain.is_some() {
                let why = "the scenario's radiation parameter is uncertain, which this does not take into account";
                return Failure::Refused(why.into());
            }
            let model = self.model_in_words();
            let without = if self.has_shadow() { ", without the shadow" } else { "" };
            Failure::Refused(format!("the scenario's model is {model}, this is for models in the plane alone{without}"))
        })
    }

    fn has_shadow(&self) -> bool {
        self.in_space.as_ref().is_some_and(|problem| problem.shadow)
    }

    /// The scenario's model as its author names it, with the Earth's shadow if there is one.
    pub fn model_in_words(&self) -> String {
        let name =
            self.in_space.as_ref().map_or(self.description.model.as_str(), |problem| problem.model_name().text());
        let shadow = if self.has_shadow() { " with the Earth's shadow" } else { "" };
        format!("\"{name}\"{shadow}")
    }

    /// The axes of a projection at a snapshot.
    pub fn axes_of(&self, projection: &Projection, snapshot: usize) -> Vec<Axis> {
        projection.axes().filter_map(|(variable, _)| self.axes.get(snapshot)?.get(variable).copied()).collect()
    }

    /// The times of its first-passage curves \[yr\].
    pub fn passage_times(&self) -> Vec<f64> {
        curve_times(self.times.last().copied().unwrap_or(0.0), PASSAGE_TIMES)
    }

    /// Reads a header and its items.
    ///
    /// # Errors
    /// Which field is wrong.
    pub fn from_parts(header: &ScenarioHeader, items: &[f64]) -> Result<Self, String> {
        let description = Description::decode(header, items)?;
        check_bins(&description.projections)?;
        let axes: Vec<Vec<Axis>> =
            description.snapshots.iter().map(|moment| axes(&description, moment)).collect::<Result<_, _>>()?;
        let (plane, uncertain) =
            if Planar::has(&description.model) { planar(&description, &axes)? } else { (None, None) };
        let in_space = space_problem::problem(&description).transpose()?;
        Ok(Self { plane, uncertain, in_space, ..Self::new(description, axes) })
    }

    /// The message's header and items.
    ///
    /// # Errors
    /// If there are more entries of one type than a message holds.
    pub fn to_parts(&self) -> Result<(ScenarioHeader, Vec<f64>), Failure> {
        self.description.encode().map_err(Failure::Refused)
    }
}

/// Number of axes of all projections on which densities in space are compared; in the plane there are fewer.
const AXES_IN_SPACE: usize = 8;

/// The axis of a variable that is in no projection.
const NO_AXIS: Axis = Axis { low: 0.0, high: 1.0, bins: 0 };

/// The ends of the axes of all projections in the plane.
fn ends(grid: Option<&Grid>) -> Vec<[f64; 2]> {
    let of = |grid: &Grid| {
        let (phi, e) = ([grid.phi.low, grid.phi.high], [grid.e.low, grid.e.high]);
        vec![phi, e, phi, e]
    };
    grid.map_or(Vec::new(), of)
}

fn projections_on(grids: &[Grid]) -> Vec<Projection> {
    grids.first().map_or(Vec::new(), |grid| projections((grid.phi.bins, grid.e.bins)))
}

/// The projections in the plane: the joint density, and the density of each variable by itself.
fn projections((phi, e): (usize, usize)) -> Vec<Projection> {
    let one = |position, bins| Projection { first: (position, bins), second: None };
    vec![Projection { first: (0, phi), second: Some((1, e)) }, one(0, phi), one(1, e)]
}

fn check_bins(projections: &[Projection]) -> Result<(), String> {
    if projections.is_empty() {
        return Err("projections: there is none, so nothing can be compared".into());
    }
    match projections.iter().flat_map(Projection::axes).find(|(_, bins)| *bins > MOST_BINS) {
        Some((_, bins)) => Err(format!("projections: an axis of {bins} bins, at most {MOST_BINS} are allowed")),
        None => Ok(()),
    }
}

/// The axis of each variable at a snapshot, which must be the same in every projection.
fn axes(description: &Description, Moment { time, ends }: &Moment) -> Result<Vec<Axis>, String> {
    let mut axes: Vec<Option<Axis>> = vec![None; description.variables.len()];
    for ((variable, bins), &[low, high]) in description.projections.iter().flat_map(Projection::axes).zip(ends) {
        let axis = Axis { low, high, bins };
        if *axes[variable].get_or_insert(axis) != axis {
            let symbol = &description.variables[variable].symbol;
            return Err(format!("projections: at {time} yr {symbol} has other bins in one of them than in another"));
        }
    }
    Ok(axes.into_iter().map(|axis| axis.unwrap_or(NO_AXIS)).collect())
}

/// The problem and the grids of a scenario with a planar model, whose radiation parameter is certain or not.
fn planar(description: &Description, axes: &[Vec<Axis>]) -> Result<(Option<Plane>, Option<Uncertain>), String> {
    let (problem, spread) = problem(description)?;
    let grids = grids(description, axes)?;
    match spread {
        None => Ok((Some(Plane { problem, grids }), None)),
        Some(spread) => {
            let problem = UncertainProblem::new(problem, spread).map_err(|error| by_key(&error))?;
            Ok((None, Some(Uncertain { problem, grids })))
        }
    }
}

fn grids(description: &Description, axes: &[Vec<Axis>]) -> Result<Vec<Grid>, String> {
    let grids: Vec<Grid> = axes.iter().map(|axes| Grid { phi: axes[0], e: axes[1] }).collect();
    if description.projections != projections_on(&grids) {
        return Err("projections: a planar model is compared in phi and e together, in phi, and in e".into());
    }
    Ok(grids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::model::planar::SrpJ2;
    use messages::scenario::MOST_SNAPSHOTS;

    fn example() -> Assignment {
        crate::example::assignment()
    }

    fn in_plane(plane: Plane) -> Assignment {
        Assignment::in_plane(7, "scenario-1", (0, 1), plane)
    }

    #[test]
    fn a_scenario_survives_the_way_through_a_message() {
        let (header, items) = example().to_parts().unwrap();
        assert_eq!(Assignment::from_parts(&header, &items), Ok(example()));
        let many = (0..MOST_SNAPSHOTS).map(|k| 0.001 * k as f64).collect();
        let Plane { problem, grids } = example().plane.unwrap();
        let long =
            in_plane(Plane { problem: Problem { times: many, ..problem }, grids: vec![grids[0]; MOST_SNAPSHOTS] });
        let (header, items) = long.to_parts().unwrap();
        assert_eq!(Assignment::from_parts(&header, &items), Ok(long));
    }

    #[test]
    fn a_correlation_survives_it_to_rounding() {
        let Plane { mut problem, grids } = example().plane.unwrap();
        problem.initial.correlation = -0.7;
        let (header, items) = in_plane(Plane { problem, grids }).to_parts().unwrap();
        let initial = Assignment::from_parts(&header, &items).unwrap().plane.unwrap().problem.initial;
        assert!((initial.correlation + 0.7).abs() < 1e-15, "{initial:?}");
    }

    #[test]
    fn another_model_survives_it_too() {
        let force = SrpJ2 { radiation: 0.15, oblateness: 0.4 };
        let model = density::model::sun_moon::SunMoon { force, sun: 4.8e-4, moon: 1e-3 }.into();
        let Plane { problem, grids } = example().plane.unwrap();
        let other = in_plane(Plane { problem: Problem { model, ..problem }, grids });
        let (header, items) = other.to_parts().unwrap();
        assert_eq!(Assignment::from_parts(&header, &items), Ok(other));
    }

    #[test]
    fn a_message_that_cannot_be_right_is_refused() {
        let (header, items) = example().to_parts().unwrap();
        let refused = |change: fn(&mut ScenarioHeader), words: &str| {
            let mut header = header;
            change(&mut header);
            let why = Assignment::from_parts(&header, &items).unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        assert!(Assignment::from_parts(&header, &items[1..]).unwrap_err().contains("snapshots"));
        refused(|header| header.variables[0].range = 7, "variable 0: its range 7 is unknown");
        refused(|header| header.variables[1].high = 2.0, "variables");
        refused(|header| header.projections[1].first_bins = 5, "phi has other bins in one of them than in another");
        refused(|header| header.projections[2].first = 0, "phi has other bins");
        refused(|header| header.variable_count = 9, "variables: it has 9, a message holds 1 to 8");
        refused(|header| header.projections[0].first_bins = 0, "no bins");
        refused(|header| header.projections[0].first_bins = 9000, "at most 2000");
        refused(|header| header.projections[1].first = 7, "there is no variable 7");
        refused(|header| header.projections[0].dimensions = 3, "it must have 1 or 2");
        refused(|header| header.projection_count = 0, "with 0 axes");
        refused(|header| header.scenario = 3, "number 3 of 1");
        let gaussian = 5;
        let axes = 4;
        let rows: Vec<f64> = items[gaussian..].chunks(1 + 2 * axes).rev().flatten().copied().collect();
        let backwards = [&items[..gaussian], &rows].concat();
        assert!(Assignment::from_parts(&header, &backwards).unwrap_err().contains("times.at"));
    }
}
