//! Propagators of a model that is not phasecloud's: `rigid-rotation mc` draws samples, `rigid-rotation ut` carries a
//! Gaussian by the unscented transform. Both take the model from the scenario's parameters, by name.

use std::process::ExitCode;

use density::flow::Flow;
use density::gaussian::Gaussian;
use density::mixture::any_model;
use density::mixture::component::Component;
use density::mixture::library::{Library, Variance};
use density::mixture::unscented::Unscented;
use density::model::Model;
use density::orbits::Orbits;
use density::sampling::draw_variables;
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::{Form, Propagator};
use messages::content::{Mixture, Samples};

#[path = "../../density/tests/rotation/mod.rs"]
mod rotation;
use rotation::RigidRotation;

const SAMPLES: usize = 40_000;

/// The model and the initial Gaussian that a scenario states.
fn stated(assignment: &Assignment) -> Result<(Flow<RigidRotation>, Gaussian<3>), Failure> {
    let said = &assignment.description;
    if said.model != "rigid-rotation" {
        return Err(Failure::Refused(format!("it turns points, it knows nothing of \"{}\"", said.model)));
    }
    let value = |name: &str| said.parameters.iter().find(|parameter| parameter.name == name).map_or(0.0, |p| p.value);
    let model = RigidRotation { axis: ["x", "y", "z"].map(value), turns: value("turns") };
    let (&[a, b, c], &[aa, ab, ac, bb, bc, cc]) = (&said.mean[..], &said.covariance[..]) else {
        return Err(Failure::Refused("a point has three variables".into()));
    };
    let gaussian = Gaussian::new([a, b, c], [[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]]);
    let gaussian = gaussian.map_err(|why| Failure::Refused(why.to_string()))?;
    Ok((Flow::new(model), gaussian))
}

#[derive(Default)]
struct MonteCarlo(Option<(Orbits<RigidRotation>, Vec<f64>)>);

impl Propagator for MonteCarlo {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let (flow, gaussian) = stated(assignment)?;
        let columns = draw_variables(&gaussian, RigidRotation::VARIABLES, 1, 0..SAMPLES);
        let orbits = Orbits::from_variables(flow, &columns.each_ref().map(Vec::as_slice));
        self.0 = Some((orbits, assignment.times.clone()));
        Ok(Form::whole(Samples::INDEPENDENT, SAMPLES))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (orbits, times) = self.0.as_mut().ok_or_else(Failure::no_scenario)?;
        orbits.advance_to(times[index])?;
        Ok(SAMPLES)
    }

    fn write(&self, columns: &mut [f64]) {
        if let Some((orbits, _)) = &self.0 {
            orbits.read_out_columns(&mut Samples::columns::<3>(columns));
        }
    }
}

#[derive(Default)]
struct UnscentedGaussian(Option<(any_model::MixturePropagator<RigidRotation, 3>, Vec<f64>)>);

impl Propagator for UnscentedGaussian {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let (flow, gaussian) = stated(assignment)?;
        let refused = |why: &dyn std::fmt::Display| Failure::Refused(why.to_string());
        let single = Library::new(1, Variance::Kept).map_err(|why| refused(&why))?;
        let propagator = any_model::MixturePropagator::new(flow, &gaussian, Unscented::THIRD_ORDER, &single, 0);
        self.0 = Some((propagator.map_err(|why| refused(&why))?, assignment.times.clone()));
        Ok(Form::whole(Mixture::UNJUDGED, 1))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (propagator, times) = self.0.as_mut().ok_or_else(Failure::no_scenario)?;
        propagator.advance_to(times[index])?;
        Ok(1)
    }

    fn trajectories(&self) -> u64 {
        7
    }

    fn write(&self, columns: &mut [f64]) {
        let Some((propagator, _)) = &self.0 else { return };
        for (row, Component { weight, mean: [a, b, c], covariance }) in propagator.mixture().into_iter().enumerate() {
            let [[aa, ab, ac], [_, bb, bc], [_, _, cc]] = covariance;
            Mixture::write_row(columns, row, [weight, a, b, c, aa, ab, ac, bb, bc, cc]);
        }
    }
}

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("mc") => kit::main(MonteCarlo::default()),
        _ => kit::main(UnscentedGaussian::default()),
    }
}
