//! A Gaussian carried by second-order state transition tensors (Park & Scheeres, J. Guid. Control Dyn. 29(6), 2006):
//! GMM-STT with one component. Where the flow takes `u` standard deviations from the initial mean to `m + A u + ½ uᵀ B
//! u`, the mean is `m_i + ½ tr B_i` and the covariance `A_i·A_j + ½ tr(B_i B_j)`, exact for a flow that is quadratic.
use density::model::earth::SUN_MEAN_MOTION;
use density::model::planar::SrpJ2;
use density::model::registry::Planar;
use kit::{Assignment, Failure, Form, Propagator};
use messages::content::Mixture;
use num_dual::{DualNum, HyperDual64};

type State = [HyperDual64; 2]; // e sin(phi) and e cos(phi), each with two first derivatives and one second by u

/// Eq. 1 of Sun et al. (2022) \[1/yr\].
fn rate(force: SrpJ2, [x1, x2]: State) -> State {
    let s = (-x1 * x1 - x2 * x2 + 1.0).sqrt();
    let g = s.powi(-4) * force.oblateness - 1.0;
    [(s * force.radiation + x2 * g) * SUN_MEAN_MOTION, -x1 * g * SUN_MEAN_MOTION]
}

fn step(force: SrpJ2, x: State, h: f64) -> State {
    let rate_at = |k: State, h: f64| rate(force, [0, 1].map(|i| x[i] + k[i] * h));
    let (a, b) = (rate(force, x), rate_at(rate(force, x), h / 2.0));
    let c = rate_at(b, h / 2.0);
    [0, 1].map(|i| x[i] + (a[i] + (b[i] + c[i]) * 2.0 + rate_at(c, h)[i]) * (h / 6.0))
}

/// The forces, the snapshot times, and the mean with its derivatives by `(u1, u1)`, `(u1, u2)` and `(u2, u2)`.
struct SttGaussian(Option<(SrpJ2, Vec<f64>, [State; 3])>);

impl Propagator for SttGaussian {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let problem = &assignment.plane()?.problem;
        let Planar::SrpJ2(force) = problem.model else {
            return Err(Failure::Refused("it moves orbits by radiation pressure and oblateness alone".into()));
        };
        let states = [(0, 0), (0, 1), (1, 1)].map(|(a, b)| {
            let u = [0, 1].map(|i| HyperDual64::new(0.0, f64::from(a == i), f64::from(b == i), 0.0));
            let initial = problem.initial;
            let e = u[1] * initial.sigma_e + initial.mean_e;
            let along = u[1] * initial.correlation * initial.sigma_phi; // the part of phi that goes with e
            let phi = u[0] * initial.sigma_phi_given_e() + along + initial.mean_phi;
            [e * phi.sin(), e * phi.cos()]
        });
        self.0 = Some((force, problem.times.clone(), states));
        Ok(Form::whole(Mixture::UNJUDGED, 1))
    }
    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (force, times, states) = self.0.as_mut().ok_or_else(Failure::no_scenario)?;
        let years = times[index] - times[index.saturating_sub(1)];
        let steps = (2000.0 * years).ceil().max(1.0); // of Runge-Kutta
        *states = states.map(|state| (0..steps as u32).fold(state, |x, _| step(*force, x, years / steps)));
        Ok(1)
    }
    fn write(&self, columns: &mut [f64]) {
        let Some((_, _, states)) = &self.0 else { return };
        let d = states.map(|[x1, x2]| [x1.atan2(x2), (x1 * x1 + x2 * x2).sqrt()]); // of phi and e
        let mean = |i: usize| d[0][i].re + (d[0][i].eps1eps2 + d[2][i].eps1eps2) / 2.0;
        let second = |i: usize, j: usize| [0, 1, 1, 2].map(|k| d[k][i].eps1eps2 * d[k][j].eps1eps2).iter().sum::<f64>();
        let cov = |i: usize, j: usize| d[0][i].eps1 * d[0][j].eps1 + d[2][i].eps1 * d[2][j].eps1 + second(i, j) / 2.0;
        columns.copy_from_slice(&[1.0, mean(0), mean(1), cov(0, 0), cov(0, 1), cov(1, 1)]);
    }
}

fn main() -> std::process::ExitCode {
    kit::main(SttGaussian(None))
}
