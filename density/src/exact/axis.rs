//! Every orbit is identified by the point at which it is least eccentric.
//!
//! The flow is reversible: `(x1, x2) -> (-x1, x2)` with time reversed maps orbits onto orbits. The eccentricity grows
//! wherever `x1 > 0` and falls where `x1 < 0` ([`PlanarHamiltonian::eccentricity_follows_x1`]; of the paper's model
//! `e' = n_sun C s sin(phi)`, Eq. 1). So all stationary points lie on the axis `x1 = 0`, every closed orbit encloses a
//! point of the axis, crosses it, is its own mirror image, and crosses it exactly twice: its eccentricity is least at
//! the crossing where `x1` grows, and largest at the other one. On the axis, in the paper's model,
//!
//! ```text
//! h(q) = H(0, q) = s + C q + (W/3)/s³      h'(q) = C + q (W/s⁴ - 1)/s      s = sqrt(1 - q²)
//! ```
//!
//! and `x1' = n_sun s h'(q)`. So every orbit of the plane has exactly one point on the axis with `h' > 0`.

use std::f64::consts::FRAC_PI_2;

use crate::model::plane::{PlanarHamiltonian, State};

use super::hamiltonian_range::HamiltonianRange;

/// Number of steps in which the axis is searched for stationary points, equal in the arc sine of `q`.
const STEPS: u32 = 20_000;
/// The outermost point of the axis that is examined.
const RIM: f64 = 1.0 - 1e-9;

/// The parts of the axis `x1 = 0` on which `H` grows with `q = x2`: one point per orbit.
#[derive(Debug, Clone)]
pub(crate) struct Axis<M> {
    model: M,
    /// Intervals of `q` in ascending order, each from a minimum of `h` (or the rim) to a maximum (or the rim).
    rising: Vec<(f64, f64)>,
}

impl<M: PlanarHamiltonian> Axis<M> {
    pub(crate) fn new(model: M) -> Self {
        let angle = |k: u32| FRAC_PI_2 * (2.0 * f64::from(k) / f64::from(STEPS) - 1.0);
        let point = |k: u32| angle(k).sin().clamp(-RIM, RIM);
        let mut rising = Vec::new();
        let mut start = (model.slope_on_axis(-RIM) > 0.0).then_some(-RIM);
        for k in 0..STEPS {
            let (a, b) = (point(k), point(k + 1));
            match (model.slope_on_axis(a) > 0.0, model.slope_on_axis(b) > 0.0) {
                (false, true) => start = Some(turning_point(&model, a, b)),
                (true, false) => rising.extend(start.take().map(|start| (start, turning_point(&model, a, b)))),
                _ => {}
            }
        }
        rising.extend(start.map(|start| (start, RIM)));
        Self { model, rising }
    }

    /// `h(q)`.
    pub(crate) fn hamiltonian(&self, q: f64) -> f64 {
        self.model.hamiltonian(State { x1: 0.0, x2: q })
    }

    /// The parts of the rising parts on which `h(q)` lies in the interval `h`.
    pub(crate) fn within(&self, h: HamiltonianRange) -> Vec<(f64, f64)> {
        let part = |&(low, high): &(f64, f64)| {
            let from = if self.hamiltonian(low) >= h.low { low } else { self.point_of(h.low, low, high)? };
            let to = if self.hamiltonian(high) <= h.high { high } else { self.point_of(h.high, low, high)? };
            (from < to).then_some((from, to))
        };
        self.rising.iter().filter_map(part).collect()
    }

    /// The point of a rising part at which `h(q) = h`; `None` if there is none.
    fn point_of(&self, h: f64, low: f64, high: f64) -> Option<f64> {
        let holds = self.hamiltonian(low) <= h && h <= self.hamiltonian(high);
        holds.then(|| boundary(low, high, |q| self.hamiltonian(q) < h))
    }

    /// All points of the rising parts at which orbits change their kind: the orbits that come from or run into a
    /// stationary point, that touch the circle `e = critical_e`, or that pass through `e = 0`.
    pub(crate) fn special_points(&self, critical_e: f64) -> Vec<f64> {
        let stationary = self.rising.iter().flat_map(|&(low, high)| [low, high]);
        let touching = [critical_e, -critical_e];
        let levels: Vec<f64> = stationary.chain(touching).chain([0.0]).map(|q| self.hamiltonian(q)).collect();
        let on_parts = |&(low, high): &(f64, f64)| {
            let crossings = levels.iter().filter_map(move |&h| self.point_of(h, low, high));
            crossings.chain([0.0, critical_e, -critical_e]).filter(move |&q| low < q && q < high).collect::<Vec<_>>()
        };
        let mut points: Vec<f64> = self.rising.iter().flat_map(on_parts).collect();
        points.sort_by(f64::total_cmp);
        // Two points that differ by rounding only would leave an interval that no rule can use.
        points.dedup_by(|a, b| (*a - *b).abs() < 1e-15);
        points
    }

    /// The point at which the orbit through `state` passes a rising part: among the points with the same `H`, the most
    /// eccentric one that is not more eccentric than the state.
    pub(crate) fn orbit_of(&self, state: State) -> Option<f64> {
        let (h, e) = (self.model.hamiltonian(state), state.eccentricity());
        let points = self.rising.iter().filter_map(|&(low, high)| self.point_of(h, low, high));
        points.filter(|q| q.abs() <= e + 1e-9).max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

fn turning_point(model: &impl PlanarHamiltonian, a: f64, b: f64) -> f64 {
    let rises = model.slope_on_axis(a) > 0.0;
    boundary(a, b, |q| (model.slope_on_axis(q) > 0.0) == rises)
}

/// The point at which `holds` becomes false between `low`, where it is true, and `high`, to the last bit.
fn boundary(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    while low.midpoint(high) > low && low.midpoint(high) < high {
        let middle = low.midpoint(high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Flow;
    use crate::model::planar::SrpJ2;

    const PAPER: SrpJ2 = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };

    #[test]
    fn rising_parts_lie_between_the_papers_stationary_points() {
        let axis = Axis::new(PAPER);
        let expected = [(-0.641096, 0.277260), (0.509659, RIM)];
        assert_eq!(axis.rising.len(), 2);
        for ((low, high), (from, to)) in axis.rising.iter().zip(expected) {
            assert!((low - from).abs() < 1e-6 && (high - to).abs() < 1e-6, "{low} {high}");
        }
    }

    #[test]
    fn an_orbits_least_eccentric_point_is_found_from_any_of_its_states() {
        for force in [PAPER, SrpJ2 { radiation: 2.5, oblateness: 0.8 }, SrpJ2 { radiation: 0.02, oblateness: 3.0 }] {
            let (axis, flow) = (Axis::new(force), Flow::new(force));
            for (phi, e) in [(0.3, 0.2), (2.0, 0.6), (4.5, 0.5), (6.0, 1e-4), (0.0, 0.3)] {
                let state = State::from_polar(phi, e);
                let q = axis.orbit_of(state).unwrap();
                let mut least = f64::INFINITY;
                let mut now = state;
                // Ten years in steps short enough to see a passage by e = 0.
                for _ in 0..50_000 {
                    now = flow.advance_one(now, 2e-4).unwrap();
                    least = least.min(now.eccentricity());
                }
                assert!((q.abs() - least).abs() < 5e-5, "{force:?} {phi} {e}: {q} {least}");
            }
        }
    }
}
