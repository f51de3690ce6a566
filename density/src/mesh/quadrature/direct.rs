//! Points of a quadrature that orbits reach, not polynomials.

use super::{Quadrature, Whole};
use crate::mesh::gaussian::Standard;
use crate::model::plane::State;

/// Which points stand for all: every `stride`-th.
#[derive(Debug, Clone, Copy)]
pub(in crate::mesh) struct Sparse {
    /// One of so many is taken.
    pub stride: usize,
    /// Where the count begins. Lattices of which a mean is taken begin at different numbers, so that every point is
    /// taken in some.
    pub first: usize,
}

impl Sparse {
    /// Whether the point with these numbers along the two directions is taken.
    fn takes(self, [outer, inner]: [usize; 2]) -> bool {
        (outer + 3 * inner + self.first).is_multiple_of(self.stride)
    }
}

impl Quadrature {
    /// Points in every cell.
    pub(in crate::mesh) fn points_in_cell(&self) -> usize {
        self.points_a_cell * self.points_a_cell
    }

    /// Replaces the states of the points in these cells by those to which `carry` takes their starts, where it can. The
    /// points that are taken share the probability of all points of these cells; if none is taken, nothing changes.
    pub(in crate::mesh) fn replace(
        &self,
        whole: &mut Whole,
        cells: &[bool],
        sparse: Sparse,
        carry: impl FnOnce(&[Standard]) -> Vec<Option<State>>,
    ) {
        let (n, side) = (self.points_a_cell, self.lines[0].len() - 1);
        let samples = &mut whole.samples;
        let (mut taken, mut starts, mut others, mut mass) = (Vec::new(), Vec::new(), Vec::new(), [0.0; 2]);
        for cell in (0..cells.len()).filter(|&cell| cells[cell]) {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let (row, point) = (cell * n * n + i * n + j, [cell / side * n + i, cell % side * n + j]);
                let is_taken = sparse.takes(point);
                mass[usize::from(is_taken)] += samples.weights[row];
                if is_taken {
                    taken.push(row);
                    starts.push([self.axes[0][point[0]].at, self.axes[1][point[1]].at]);
                } else {
                    others.push(row);
                }
            }
        }
        if taken.is_empty() {
            return;
        }
        others.into_iter().for_each(|row| samples.weights[row] = 0.0);
        for (row, state) in taken.into_iter().zip(carry(&starts)) {
            samples.weights[row] *= 1.0 + mass[0] / mass[1];
            let Some(state) = state else { continue };
            (samples.phi[row], samples.e[row]) = (state.x1.atan2(state.x2), state.eccentricity());
        }
        whole.direct = cells.to_vec();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orbits that end where the polynomials say, and a lattice of which no point is on its own.
    #[test]
    fn points_that_stand_for_others_have_the_probability_of_all_and_the_states_of_their_orbits() {
        let lines: Vec<f64> = (0..21).map(|i| 0.5 * f64::from(i) - 5.0).collect();
        let quadrature = Quadrature::of_many([lines.clone(), lines.clone()], 3);
        let state = |[u, v]: Standard| State { x1: 0.3 + 0.02 * u, x2: 0.4 + 0.03 * v };
        let nodes = lines.iter().flat_map(|&u| lines.iter().map(move |&v| state([u, v])));
        let (x1, x2): (Vec<f64>, Vec<f64>) = nodes.map(|state| (state.x1, state.x2)).unzip();
        let whole = quadrature.whole_cells(&x1, &x2);
        let [mass, sin, cos, e] = Quadrature::mean_vector(&whole);
        let some: Vec<bool> = (0..400).map(|cell| cell % 3 > 0).collect();
        for stride in [1, 2, 8] {
            let replaced = |carry: fn(f64) -> f64| {
                let mut whole = whole.clone();
                let by = |starts: &[Standard]| {
                    let ends = starts.iter().map(|&[u, v]| Some(state([carry(u), v])));
                    ends.collect::<Vec<_>>()
                };
                quadrature.replace(&mut whole, &some, Sparse { stride, first: 1 }, by);
                Quadrature::mean_vector(&whole)
            };
            let same = replaced(|u| u);
            assert!((same[0] - mass).abs() < 1e-12, "{stride}");
            let off = [same[1] - sin, same[2] - cos, same[3] - e].into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            assert!(off < if stride == 1 { 1e-12 } else { 2e-3 }, "{stride}: {off:e}");
            let moved = replaced(|u| u + 1.0);
            // Two thirds of the cells have moved by one deviation in x1.
            assert!((moved[1] - sin).abs() > 5e-3, "{stride}: {moved:?}");
        }
        let mut untouched = whole.clone();
        quadrature.replace(&mut untouched, &vec![false; 400], Sparse { stride: 1, first: 0 }, |_| unreachable!());
        assert_eq!(Quadrature::mean_vector(&untouched), [mass, sin, cos, e]);
    }
}
