//! The orbits between two points of the axis: where they are at every time on the orbit, and half their period.
//!
//! The state is a function of the least eccentric point `q` and of the time `θ` since the orbit passed it, in units of
//! half the period: `u = θ/half`, from 0 to 1. The other half of the orbit is the mirror image. Interpolated in `q` and
//! `u`, it is smooth next to a centre too, where the orbits become points: only an angle is singular there, not the
//! state.

use crate::exact::contour::{Contour, angle_of};
use crate::flow_map::chebyshev::{Basis, MOST_NODES, series};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::plane::State;

use super::patch::{Patch, Slopes};
use super::rise::Rise;

/// How far beyond its edges a panel may be used, as a share of half its width: the root of rounding, which is by how
/// much the Hamiltonian misplaces an orbit next to a centre.
const BEYOND: f64 = 1e-3;
/// Largest number of steps of Newton's method.
const MOST_STEPS: usize = 24;
/// A state is on an orbit if it is as near as that; rounding alone leaves a few 1e-16.
const NEAR: f64 = 2e-15;
/// The largest distance with which a search is content.
const NEAR_ENOUGH: f64 = 1e-12;

/// The orbits of an interval of `q`.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub low: f64,
    pub high: f64,
    /// Half the period \[rad\] as a series in the local coordinate.
    pub half: [f64; MOST_NODES],
    /// The states, for equal parts of half a period.
    pub patches: Vec<Patch>,
    /// When the orbits rise above the critical eccentricity.
    pub rise: Rise,
}

/// Where a state is on the orbits of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    /// The local coordinate of the orbit, from -1 to 1.
    pub a: f64,
    /// The time on the orbit, between minus and plus half a period \[rad\].
    pub theta: f64,
}

impl Panel {
    /// Half the period of an orbit \[rad\].
    pub fn half_of(&self, a: f64) -> f64 {
        series(&self.half, a)
    }

    /// The local coordinate of a point of the axis.
    fn local(&self, q: f64) -> f64 {
        (q - self.low.midpoint(self.high)) * (2.0 / (self.high - self.low))
    }

    /// The spot where an orbit is `years` after it was at this one.
    pub fn later(&self, Spot { a, theta }: Spot, years: f64) -> Spot {
        let half = self.half_of(a);
        let time = theta + angle_of(years);
        let turns = (time / (2.0 * half)).round();
        Spot { a, theta: (time - turns * 2.0 * half).clamp(-half, half) }
    }

    /// The patch of a time, the local coordinate in it, and whether the state is a mirror image.
    fn place(&self, Spot { a, theta }: Spot) -> (&Patch, f64, bool) {
        let parts = self.patches.len();
        let part = (theta.abs() / self.half_of(a)).min(1.0) * parts as f64;
        let patch = (part as usize).min(parts - 1);
        (&self.patches[patch], 2.0 * (part - patch as f64) - 1.0, theta < 0.0)
    }

    /// The state at a spot.
    pub fn state(&self, spot: Spot) -> State {
        let (patch, b, is_mirrored) = self.place(spot);
        let [x1, x2] = patch.at(spot.a, b);
        State { x1: if is_mirrored { -x1 } else { x1 }, x2 }
    }

    /// The area of the states of a rectangle of orbits and times about a spot, in a unit that is the same for all times
    /// on an orbit: the motion shears such rectangles and keeps their areas, so the ratio of two such numbers is the
    /// determinant of the flow's derivative.
    pub fn area(&self, spot: Spot) -> f64 {
        let (patch, b, _) = self.place(spot);
        patch.slopes(spot.a, b).determinant().abs()
    }

    /// Where a state is, whose orbit has its least eccentric point about `q`; `None` if it is not found on an orbit of
    /// the panel.
    pub fn locate(&self, State { x1, x2 }: State, q: f64) -> Option<Spot> {
        let (a, right) = (self.local(q), [x1.abs(), x2]);
        let e2 = x1 * x1 + x2 * x2;
        let square = |patch: usize, b: f64| {
            let [x1, x2] = self.patches[patch].at(a, b);
            x1 * x1 + x2 * x2
        };
        // The eccentricity grows all the way from the least eccentric point to the most eccentric one.
        let (mut patch, mut beyond) = (0, self.patches.len());
        while beyond - patch > 1 {
            let middle = patch.midpoint(beyond);
            if square(middle, -1.0) <= e2 { patch = middle } else { beyond = middle }
        }
        let (low, high) = (square(patch, -1.0), square(patch, 1.0));
        let share = if high > low { ((e2 - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        self.newton(patch, (a, 2.0 * share - 1.0), right)
            .or_else(|| {
                let (mut from, mut to) = (-1.0f64, 1.0f64);
                for _ in 0..30 {
                    let middle = from.midpoint(to);
                    if square(patch, middle) < e2 { from = middle } else { to = middle }
                }
                self.newton(patch, (a, from), right)
            })
            .map(|(a, u)| {
                let theta = u * self.half_of(a);
                Spot { a, theta: if x1 < 0.0 { -theta } else { theta } }
            })
    }

    /// The orbit and the share of half a period at which the state is the `right` one, searched from a point of a
    /// patch.
    fn newton(&self, mut patch: usize, (mut a, mut b): (f64, f64), right: [f64; 2]) -> Option<(f64, f64)> {
        let parts = self.patches.len();
        let mut best = (f64::INFINITY, (a, b, patch));
        for _ in 0..MOST_STEPS {
            let slopes = self.patches[patch].slopes(a, b);
            let Slopes { value, by_a, by_b } = slopes;
            let miss = [right[0] - value[0], right[1] - value[1]];
            let distance = miss[0].abs().max(miss[1].abs());
            // Where rounding is all that is left, another step does not come nearer.
            let is_stuck = distance >= best.0 && best.0 < NEAR_ENOUGH;
            if distance < best.0 {
                best = (distance, (a, b, patch));
            }
            let determinant = slopes.determinant();
            if distance < NEAR || is_stuck || determinant == 0.0 || !distance.is_finite() {
                break;
            }
            let step_a = (miss[0] * by_b[1] - miss[1] * by_b[0]) / determinant;
            let step_b = (by_a[0] * miss[1] - by_a[1] * miss[0]) / determinant;
            a = (a + step_a.clamp(-0.5, 0.5)).clamp(-1.0 - BEYOND, 1.0 + BEYOND);
            b += step_b.clamp(-0.7, 0.7);
            if b > 1.0 && patch + 1 < parts {
                (patch, b) = (patch + 1, b - 2.0);
            } else if b < -1.0 && patch > 0 {
                (patch, b) = (patch - 1, b + 2.0);
            }
            b = b.clamp(-1.01, 1.01);
        }
        let (distance, (a, b, patch)) = best;
        (distance < NEAR_ENOUGH).then(|| (a, ((patch as f64 + 0.5 * (b + 1.0)) / parts as f64).clamp(0.0, 1.0)))
    }

    /// How many years after it was at this spot an orbit first reaches the critical eccentricity; infinite if it never
    /// does.
    pub fn passage(&self, spot: Spot, critical_e: f64) -> f64 {
        let rise = match &self.rise {
            Rise::Never => return f64::INFINITY,
            Rise::Always => return 0.0,
            Rise::At(coefficients) => series(coefficients, spot.a),
            Rise::Search => match self.searched_rise(spot.a, critical_e) {
                Some(rise) => rise,
                None => return f64::INFINITY,
            },
        };
        if spot.theta.abs() >= rise { 0.0 } else { (rise - spot.theta) / SUN_MEAN_MOTION }
    }

    /// The time on an orbit at which it rises above the critical eccentricity.
    fn searched_rise(&self, a: f64, critical_e: f64) -> Option<f64> {
        let half = self.half_of(a);
        let is_above = |theta: f64| self.state(Spot { a, theta }).eccentricity() >= critical_e;
        let (mut low, mut high) = (0.0f64, half);
        if is_above(low) {
            return Some(0.0);
        }
        is_above(high).then(|| {
            for _ in 0..50 {
                let middle = low.midpoint(high);
                if is_above(middle) { high = middle } else { low = middle }
            }
            high
        })
    }
}

/// The states of orbits at the nodes of a patch, one of so many equal parts of half a period.
pub(super) fn patch_of(basis: &Basis, orbits: &[&Contour], part: usize, parts: usize) -> [Vec<f64>; 2] {
    let mut columns = [0, 1].map(|_| Vec::with_capacity(basis.len::<2>()));
    for index in 0..basis.len::<2>() {
        let orbit = orbits[index / basis.count];
        let [_, b] = basis.node::<2>(index);
        let State { x1, x2 } = orbit.at((part as f64 + 0.5 * (b + 1.0)) / parts as f64 * orbit.half);
        columns[0].push(x1);
        columns[1].push(x2);
    }
    columns.iter_mut().for_each(|column| basis.transform::<2>(column));
    columns
}
