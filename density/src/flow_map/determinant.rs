//! The determinant of a map's derivative, by which it changes a density.
//!
//! The derivative is less accurate than the map. A polynomial of degree `n` that is nowhere above `ε` on `[-1, 1]` has
//! a slope of `n² ε` at most (A. Markov 1889), so that is what a slope of the map may be off where the map itself is
//! off by `ε`. Where the determinant is small against that, as next to `e = 0`, at which all solar angles are one
//! state, it says nothing, and the density changes by Liouville's theorem instead.

use super::FlowMap;
use super::chebyshev::nodes_along_an_axis;
use crate::model::plane::{PlanarHamiltonian, State, density_growth};

/// What a determinant may be off at most, relatively, to change a density.
const LARGEST_DOUBT: f64 = 1e-3;

/// A determinant, and what it may be off relatively.
#[derive(Debug, Clone, Copy)]
struct Determinant {
    value: f64,
    doubt: f64,
}

impl<M: PlanarHamiltonian> FlowMap<M, 2> {
    /// The determinant of the derivative of the state at snapshot `index` by the state at the start, of the orbit that
    /// starts with these variables; `None` if it has to be propagated directly. The flow itself keeps the measure `dx1
    /// dx2/s`, so the right value is `s_t/s_0` (Liouville's theorem). By how much this one is off
    /// shows how good the map is.
    ///
    /// # Panics
    /// If there is no such snapshot.
    pub fn determinant(&self, variables: &[f64; 2], index: usize) -> Option<f64> {
        self.determinant_with_doubt(variables, index).map(|determinant| determinant.value)
    }

    fn determinant_with_doubt(&self, variables: &[f64; 2], index: usize) -> Option<Determinant> {
        let (number, local) = self.locate(variables)?;
        if index == 0 {
            return Some(Determinant { value: 1.0, doubt: 0.0 });
        }
        let [x1, x2] = self.states(number, index) else { return None };
        let ([x1_a, x1_b], [x2_a, x2_b]) = (x1.slopes(&local), x2.slopes(&local));
        // The variables are a linear function of the local coordinates.
        let cell = &self.cells[number as usize].cell;
        let [corner, along_a, along_b] =
            [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]].map(|local| self.gaussian.point(cell.point(&local)));
        let slope = |end: [f64; 2], k: usize| 0.5 * (end[k] - corner[k]);
        let of_variables = slope(along_a, 0) * slope(along_b, 1) - slope(along_a, 1) * slope(along_b, 0);
        let [_, e] = *variables;
        let of_state = (x1_a * x2_b - x1_b * x2_a).abs();
        let slope_error = (nodes_along_an_axis(2) - 1).pow(2) as f64 * self.summary.error;
        let doubt = slope_error * [x1_a, x1_b, x2_a, x2_b].map(f64::abs).iter().sum::<f64>() / of_state;
        Some(Determinant { value: of_state / (e * of_variables).abs(), doubt })
    }

    /// The factor by which a density per unit `phi`-`e` area has changed by snapshot `index` on the way from the
    /// variables at the start to the state `end`: by the determinant of the map, or in closed form where that is not
    /// known to a thousandth, or where the orbit is propagated directly.
    ///
    /// # Panics
    /// If there is no such snapshot.
    pub fn growth(&self, variables: &[f64; 2], end: State, index: usize) -> f64 {
        let [phi, e] = *variables;
        match self.determinant_with_doubt(variables, index) {
            Some(Determinant { value, doubt }) if doubt <= LARGEST_DOUBT => end.eccentricity() / (e * value),
            _ => density_growth(State::from_polar(phi, e), end),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::flow::Flow;
    use crate::flow_map::{FlowMap, Settings};
    use crate::model::plane::State;
    use crate::problem::paper::scenario;

    #[test]
    fn the_determinant_of_a_map_is_that_of_the_measure_which_the_flow_keeps() {
        for number in 1..=3 {
            let problem = scenario(number);
            let flow = Flow::new(problem.model);
            let map = FlowMap::new(flow, problem.initial.into(), &problem.times, None, &Settings::default()).unwrap();
            let mut seen = 0;
            for (a, b) in (0..81).map(|i| (f64::from(i / 9 - 4) * 0.7, f64::from(i % 9 - 4) * 0.7)) {
                let (phi, e) = problem.initial.point(a, b);
                for index in 0..problem.times.len() {
                    let variables = [phi, e];
                    let (Some(determinant), true) = (map.determinant(&variables, index), e > 0.0) else { continue };
                    let end = map.state(&variables, index).unwrap();
                    let right = end.s() / State::from_polar(phi, e).s();
                    // A slope of a polynomial of degree 15 is off by up to 225 times what the polynomial is, over half
                    // the width of its cell: 225 x 1e-9 over some 0.01 in these clouds.
                    assert!((determinant / right - 1.0).abs() < 1e-4, "{number} {phi} {e}: {determinant} {right}");
                    seen += 1;
                }
            }
            assert!(seen > 200, "{seen}");
        }
    }
}
