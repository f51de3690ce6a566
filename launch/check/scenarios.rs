//! The problems that a propagator is checked on.
//!
//! The clouds are so small that even one Gaussian carried by the linearised flow has all moments right to 0.1 standard
//! deviations; no method is judged by how it copes with a bent cloud. Times are uneven, and forces, clouds and numbers
//! of snapshots differ, so that no answer can be right because it is built into the propagator.

use std::f64::consts::TAU;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use density::flow::Flow;
use density::grid::{Axis, Grid, comparison_grids};
use density::in_space::{InitialInSpace, SpaceProblem, pilot};
use density::model::model_name::ModelName;
use density::model::planar::SrpJ2;
use density::model::registry::Planar;
use density::model::space_registry::SpaceModel;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::orbits::LostOrbit;
use density::problem::{InitialGaussian, Problem};
use kit::assignment::{Assignment, Plane};

/// Bins of the comparison grids, in `phi` and `e`.
const BINS: (usize, usize) = (40, 30);

/// A problem with a name, and where it is compared.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its name.
    pub name: &'static str,
    posed: Posed,
}

#[derive(Debug, Clone)]
enum Posed {
    /// With its comparison grids.
    InPlane(Plane),
    /// With the axes of all variables at each snapshot.
    InSpace(Box<SpaceProblem>, Vec<Vec<Axis>>),
}

impl Scenario {
    /// The assignment of the scenario at a place among the scenarios of a run.
    pub fn assignment(self, run_id: u64, place: (u32, u32)) -> Assignment {
        match self.posed {
            Posed::InPlane(plane) => Assignment::in_plane(run_id, self.name, place, plane),
            Posed::InSpace(problem, axes) => Assignment::in_space(run_id, self.name, place, *problem, axes),
        }
    }
}

/// The model of the problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TrialModel {
    /// The averaged model in the plane.
    #[default]
    Planar,
    /// The averaged model in space.
    Vectorial,
}

impl ValueEnum for TrialModel {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Planar, Self::Vectorial]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Self::Planar => (ModelName::Planar, "The averaged model in the plane"),
            Self::Vectorial => (ModelName::Vectorial, "The averaged model in space"),
        };
        Some(PossibleValue::new(name.text()).help(help))
    }
}

/// Two problems whose right answers are known. Variables are correlated in the second one, in space in both.
pub fn known(model: TrialModel) -> [Result<Scenario, LostOrbit>; 2] {
    let paper = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
    let other = SrpJ2 { radiation: 0.25, oblateness: 0.2 };
    let correlated = InitialGaussian { correlation: 0.6, ..cloud(0.9, 0.3, 0.005, 0.001) };
    match model {
        TrialModel::Planar => [
            bounded("check-1", paper, cloud(2.2069, 0.145, 0.005, 0.0008), vec![0.0, 0.3, 0.8, 1.3, 2.0]),
            bounded("check-2", other, correlated, vec![0.0, 0.6, 1.0]),
        ],
        TrialModel::Vectorial => [in_space("check-1", first_in_space()), in_space("check-2", second_in_space())],
    }
}

/// Snapshots of the longest scenario.
pub const LONGEST: usize = 64;

/// The first scenario with far more snapshots.
pub fn long(model: TrialModel) -> Result<Scenario, LostOrbit> {
    let times = |step: f64| (0..LONGEST as u32).map(|k| step * f64::from(k)).collect();
    match model {
        TrialModel::Planar => {
            let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
            bounded("check-long", force, cloud(2.2069, 0.145, 0.005, 0.0008), times(0.5))
        }
        // Orbits in space take ten times as long.
        TrialModel::Vectorial => in_space("check-long", SpaceProblem { times: times(0.1), ..first_in_space() }),
    }
}

/// Without oblateness the flow turns `(e cos phi, e sin phi, sqrt(1 - e²))` about an axis `atan(C)` away from the last
/// coordinate's, once in `1/sqrt(1 + C²)` yr. Here that is 71.6 degrees and 0.32 yr: the whole cloud leaves `e < 1`. In
/// space the Sun and the orbits then lie in the equator, where the motion is the same.
pub fn impossible(model: TrialModel) -> Result<Scenario, LostOrbit> {
    let force = SrpJ2 { radiation: 3.0, oblateness: 0.0 };
    let (times, critical_e) = (vec![0.0, 0.2, 0.4], 0.6);
    let (phi, e) = (Axis { low: 0.0, high: TAU, bins: BINS.0 }, Axis { low: 0.0, high: 1.0, bins: BINS.1 });
    let posed = match model {
        TrialModel::Planar => {
            let problem = Problem { model: force.into(), initial: cloud(0.5, 0.1, 0.01, 0.002), times, critical_e };
            Posed::InPlane(Plane { grids: vec![Grid { phi, e }; problem.times.len()], problem })
        }
        TrialModel::Vectorial => {
            let forces = SunMoon { force, sun: 0.0, moon: 0.0 };
            let model = SpaceModel::Vectorial {
                model: Vectorial { forces, obliquity: 0.0, sun_longitude: 0.3 },
                axis: Some(2.5),
            };
            let initial =
                InitialInSpace { mean: [0.5, 0.1, 0.0, 0.0], sigma: [0.01, 0.002, 0.0, 0.0], correlation: [0.0; 6] };
            let problem =
                SpaceProblem { model, initial, spread: None, times, critical_e, shadow: false, reentry_altitude: None };
            let axes = vec![phi, e, Axis { high: 0.1, ..e }, phi];
            Posed::InSpace(Box::new(problem.clone()), vec![axes; problem.times.len()])
        }
    };
    Ok(Scenario { name: "check-impossible", posed })
}

/// An inclined orbit, with solar angle and node correlated.
fn first_in_space() -> SpaceProblem {
    let initial = InitialInSpace {
        mean: [2.2069, 0.145, 0.5, 1.0],
        sigma: [0.005, 0.0008, 0.002, 0.004],
        correlation: [0.0, 0.0, 0.5, -0.4, 0.0, 0.0],
    };
    let forces = SunMoon { force: SrpJ2 { radiation: 0.1, oblateness: 0.40921 }, sun: 4.8e-4, moon: 1.04e-3 };
    let model = Vectorial { forces, obliquity: 0.409, sun_longitude: 1.0 };
    posed_in_space(model, initial, vec![0.0, 0.3, 0.8, 1.3, 2.0])
}

/// One beyond the poles, with an obliquity and a place of the Sun of its own.
fn second_in_space() -> SpaceProblem {
    let initial = InitialInSpace {
        mean: [0.9, 0.3, 1.9, 4.0],
        sigma: [0.004, 0.001, 0.002, 0.003],
        correlation: [0.6, 0.0, 0.0, 0.0, 0.0, -0.5],
    };
    let forces = SunMoon { force: SrpJ2 { radiation: 0.05, oblateness: 0.2 }, sun: 8e-4, moon: 1.8e-3 };
    posed_in_space(Vectorial { forces, obliquity: 0.3, sun_longitude: 4.0 }, initial, vec![0.0, 0.6, 1.0])
}

fn posed_in_space(model: Vectorial, initial: InitialInSpace, times: Vec<f64>) -> SpaceProblem {
    let model = SpaceModel::Vectorial { model, axis: Some(2.5) };
    SpaceProblem { model, initial, spread: None, times, critical_e: 0.5, shadow: false, reentry_altitude: None }
}

fn in_space(name: &'static str, problem: SpaceProblem) -> Result<Scenario, LostOrbit> {
    let axes = pilot::axes(&problem, &[BINS.0, BINS.1, BINS.1, BINS.1])?;
    Ok(Scenario { name, posed: Posed::InSpace(Box::new(problem), axes) })
}

fn cloud(mean_phi: f64, mean_e: f64, sigma_phi: f64, sigma_e: f64) -> InitialGaussian {
    InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation: 0.0 }
}

fn bounded(name: &'static str, force: SrpJ2, initial: InitialGaussian, times: Vec<f64>) -> Result<Scenario, LostOrbit> {
    let problem = Problem { model: Planar::from(force), initial, times, critical_e: 0.5 };
    let grids = comparison_grids(&problem, &Flow::new(problem.model), BINS.0, BINS.1)?;
    Ok(Scenario { name, posed: Posed::InPlane(Plane { problem, grids }) })
}
