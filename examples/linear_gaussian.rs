//! A propagator of one's own: a single Gaussian moved by the linearised flow, the classical covariance propagation.
//!
//! Put it into a launch file as
//!
//! ```toml
//! [[propagator]]
//! label = "linear"
//! command = ["target/release/examples/linear_gaussian"]
//! ```

use std::process::ExitCode;

use density::angle::nearest;
use density::flow::Flow;
use density::orbits::Orbits;
use density::problem::InitialGaussian;
use messages::layout::kind;
use nodes::assignment::Assignment;
use nodes::failure::Failure;
use nodes::kit::{self, Form, Propagator};

/// Step of the central differences, in standard deviations.
const STEP: f64 = 1e-3;

/// The mean, and its neighbours one step away in `phi` and in `e`.
struct LinearGaussian {
    course: Option<(Orbits, Vec<f64>)>,
}

impl Propagator for LinearGaussian {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let initial: &InitialGaussian = &assignment.problem.initial;
        let stencil = [(0.0, 0.0), (STEP, 0.0), (-STEP, 0.0), (0.0, STEP), (0.0, -STEP)];
        let (phi, e): (Vec<f64>, Vec<f64>) = stencil.iter().map(|&(u, v)| initial.point(u, v)).unzip();
        let flow = Flow::new(assignment.problem.force);
        self.course = Some((Orbits::from_polar(flow, &phi, &e), assignment.problem.times.clone()));
        Ok(Form { kind: kind::MIXTURE, most_rows: 1, ..Form::default() })
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (orbits, times) = self.course.as_mut().ok_or_else(Failure::no_scenario)?;
        orbits.advance_to(times[index])?;
        Ok(1)
    }

    fn write(&self, columns: &mut [f64]) {
        let Some((orbits, _)) = &self.course else { return };
        let (mut phi, mut e) = ([0.0; 5], [0.0; 5]);
        orbits.read_out(&mut phi, &mut e);
        let slope = |k: usize| [nearest(phi[k] - phi[k + 1], 0.0) / (2.0 * STEP), (e[k] - e[k + 1]) / (2.0 * STEP)];
        let (a, b) = (slope(1), slope(3));
        let covariance = |i: usize, j: usize| a[i] * a[j] + b[i] * b[j];
        columns.copy_from_slice(&[1.0, phi[0], e[0], covariance(0, 0), covariance(0, 1), covariance(1, 1)]);
    }
}

fn main() -> ExitCode {
    kit::main(LinearGaussian { course: None })
}
