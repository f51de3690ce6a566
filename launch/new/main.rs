//! A propagator for phasecloud. As it stands it is a small Monte Carlo; put your own method in its place.
//!
//! `phasecloud check -- target/release/NAME` says whether it keeps the contract and has its numbers right.

use std::num::NonZeroUsize;
use std::process::ExitCode;

use density::flow::Flow;
use density::model::registry::Planar;
use density::orbits::Orbits;
use density::sampling::{Draws, SamplingPlan};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::{Form, Propagator};
use messages::content::Samples;

const SAMPLES: usize = 2000;

/// What the method remembers of the scenario that it works on.
#[derive(Default)]
struct Mine {
    work: Option<(Orbits<Planar>, Vec<f64>)>,
}

impl Propagator for Mine {
    /// A new scenario: `assignment.plane()` has the model, the initial Gaussian, the times and the critical
    /// eccentricity.
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let problem = &assignment.plane()?.problem;
        let plan = SamplingPlan { draws: Draws::Independent, seed: 1, replicates: NonZeroUsize::MIN };
        let (x1, x2) = plan.draw(&problem.initial, SAMPLES);
        self.work = Some((Orbits::new(Flow::new(problem.model), x1, x2), problem.times.clone()));
        // `messages::content` says which other kinds of snapshot there are, and what their columns are.
        Ok(Form::whole(Samples::INDEPENDENT, SAMPLES))
    }

    /// Moves on to the snapshot at time number `index` and returns how many rows it has.
    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (orbits, times) = self.work.as_mut().ok_or_else(Failure::no_scenario)?;
        orbits.advance_to(times[index])?;
        Ok(orbits.len())
    }

    /// Fills the columns of the snapshot, one after the other, in the memory in which they will be read.
    fn write(&self, columns: &mut [f64]) {
        if let Some((orbits, _)) = &self.work {
            let [phi, e] = Samples::columns(columns);
            orbits.read_out(phi, e);
        }
    }
}

fn main() -> ExitCode {
    kit::main(Mine::default())
}
