//! The points of a quadrature as places that fill the plane, from which a density can be counted.

use super::{Point, Quadrature, Samples, Whole};
use crate::model::plane::State;

impl Quadrature {
    /// Calls `visit` with a state and a weight for each point. A point stands for a part of its cell; the state is that
    /// at the fraction `share` of this part, found from the slopes to the neighbouring points. Lattices that are
    /// averaged have different shares, so that their points do not coincide. Points that were propagated as orbits stay
    /// where they are.
    pub(in crate::mesh) fn spread(&self, whole: &Whole, share: [f64; 2], mut visit: impl FnMut(State, f64)) {
        let (n, cells) = (self.points_a_cell, self.lines[0].len() - 1);
        // How far the place is from each point along a direction, and the distance to the point's neighbour in the
        // cell.
        let along = |axis: usize| -> Vec<(f64, f64)> {
            let mut start = self.lines[axis][0];
            let points = &self.axes[axis];
            let one = |k: usize| {
                let Point { at, width, .. } = points[k];
                let from_point = start + share[axis] * width - at;
                start += width;
                let neighbour = if k % n + 1 < n { k + 1 } else { k - 1 };
                (from_point, points[neighbour].at - at)
            };
            (0..points.len()).map(one).collect()
        };
        let (outer, inner) = (along(0), along(1));
        let Samples { phi, e, weights } = &whole.samples;
        for cell in 0..cells * cells {
            let first = cell * n * n;
            let state = |i: usize, j: usize| State::from_polar(phi[first + i * n + j], e[first + i * n + j]);
            let other = |k: usize| if k + 1 < n { k + 1 } else { k - 1 };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                if whole.is_direct(cell) {
                    visit(state(i, j), weights[first + i * n + j]);
                    continue;
                }
                let (here, ahead, aside) = (state(i, j), state(other(i), j), state(i, other(j)));
                let (by, of) = outer[cell / cells * n + i];
                let (across, width) = inner[cell % cells * n + j];
                let (a, b) = (by / of, across / width);
                let x1 = here.x1 + a * (ahead.x1 - here.x1) + b * (aside.x1 - here.x1);
                let x2 = here.x2 + a * (ahead.x2 - here.x2) + b * (aside.x2 - here.x2);
                // The Gaussian at that place instead of at the point: its exponent is quadratic in the distance.
                let [u, v] = [self.axes[0][cell / cells * n + i].at, self.axes[1][cell % cells * n + j].at];
                let thinner = (-by * (u + 0.5 * by) - across * (v + 0.5 * across)).exp();
                visit(State { x1, x2 }, thinner * weights[first + i * n + j]);
            }
        }
    }
}
