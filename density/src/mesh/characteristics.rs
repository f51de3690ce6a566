//! The density that each characteristic carries, by Eq. 8 in closed form.
//!
//! Eq. 8 of Sun et al. (2022), `n' = n_sun C x1/s n`, is the continuity equation of a density per unit `x1`-`x2` area.
//! Since `s' = -n_sun C x1`, its solution is `n_t/n_0 = s_0/s_t`. A density per unit `phi`-`e` area is `e` times as
//! large, hence
//!
//! ```text
//! n_t = n_0 (s_0/s_t) (e_t/e_0)
//! ```
//!
//! The paper starts from densities per `phi`-`e` area, evolves them by Eq. 8 as it stands, and reads them out per
//! `phi`-`e` area again: the factor `e_t/e_0` is missing. `with_jacobian = false` reproduces the paper.

use rayon::prelude::*;

use super::{MeshError, check_column, check_points};
use crate::model::plane::{State, density_growth, density_growth_without_jacobian};
use crate::problem::InitialGaussian;

/// Density per unit `phi`-`e` area \[1/rad\] that each characteristic carries, from its initial solar angle and
/// eccentricity and its present state `(x1, x2)`. If not `with_jacobian`, the Jacobian of the polar coordinates is left
/// out, as in the paper.
///
/// # Errors
/// [`MeshError::Length`] or [`MeshError::Value`] if the columns do not match or hold no elliptic orbits.
pub fn characteristic_densities(
    initial: &InitialGaussian,
    phi0: &[f64],
    e0: &[f64],
    x1: &[f64],
    x2: &[f64],
    with_jacobian: bool,
) -> Result<Vec<f64>, MeshError> {
    let rows = phi0.len();
    check_points(phi0, e0, rows)?;
    check_column("x1", x1, rows, "in (-1, 1)", |x| x.abs() < 1.0)?;
    check_column("x2", x2, rows, "in (-1, 1)", |x| x.abs() < 1.0)?;
    let growth = if with_jacobian { density_growth } else { density_growth_without_jacobian };
    let density = |i: usize| {
        let n0 = initial.density(phi0[i], e0[i]);
        if n0 > 0.0 { n0 * growth(State::from_polar(phi0[i], e0[i]), State { x1: x1[i], x2: x2[i] }) } else { 0.0 }
    };
    let n: Vec<f64> = (0..rows).into_par_iter().map(density).collect();
    check_column("n", &n, rows, "finite: the state must have e < 1", f64::is_finite)?;
    Ok(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::PlanarHamiltonian;
    use crate::model::earth::SUN_MEAN_MOTION;
    use crate::model::planar::SrpJ2;
    use crate::problem::paper::scenario;

    /// `(x1, x2, ln n)` after `years`, Eq. 8 integrated beside the equations of motion by the classical Runge-Kutta
    /// method.
    fn integrate_eq_8(force: SrpJ2, start: State, years: f64, steps: u32) -> (State, f64) {
        let rate = |[x1, x2, _]: [f64; 3]| {
            let state = State { x1, x2 };
            let velocity = force.motion(state);
            [velocity.x1, velocity.x2, SUN_MEAN_MOTION * x1 * force.radiation / state.s()]
        };
        let h = years / f64::from(steps);
        let add = |y: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
        let mut y = [start.x1, start.x2, 0.0];
        for _ in 0..steps {
            let k1 = rate(y);
            let k2 = rate(add(y, k1, h / 2.0));
            let k3 = rate(add(y, k2, h / 2.0));
            let k4 = rate(add(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        (State { x1: y[0], x2: y[1] }, y[2])
    }

    #[test]
    fn closed_form_solves_eq_8() {
        for number in 1..=3 {
            let problem = scenario(number);
            let (phi0, e0) = problem.initial.point(1.0, -1.5);
            let (end, log_growth) = integrate_eq_8(problem.model, State::from_polar(phi0, e0), 2.0, 20_000);
            let n0 = problem.initial.density(phi0, e0);
            let carried = |with_jacobian| {
                characteristic_densities(&problem.initial, &[phi0], &[e0], &[end.x1], &[end.x2], with_jacobian).unwrap()
                    [0]
            };
            let per_x1_x2_area = n0 * log_growth.exp();
            assert!((carried(false) / per_x1_x2_area - 1.0).abs() < 1e-9);
            assert!((carried(true) / (per_x1_x2_area * end.eccentricity() / e0) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn an_escaped_state_is_named() {
        let initial = scenario(1).initial;
        let error = characteristic_densities(&initial, &[2.2], &[0.14], &[0.9], &[0.9], true).unwrap_err();
        assert!(matches!(error, MeshError::Value { column: "n", row: 0, .. }), "{error}");
    }
}
