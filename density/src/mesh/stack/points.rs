//! Where the characteristics of a stack start: a cubic lattice over `phi`, `e` and the third variable.

use crate::mesh::points::{Points, lattice_points, lattice_reach};
use crate::mesh::{MeshError, check_column};
use crate::uncertain::UncertainProblem;

/// Initial points in layers, one for each value of the third variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// The points of one layer, the same for all.
    pub plane: Points,
    /// The third variable of each layer, ascending.
    pub third: Vec<f64>,
}

impl Layers {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.plane.phi.len() * self.third.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The variables of point `row`; the layers come one after the other.
    pub fn point(&self, row: usize) -> [f64; 3] {
        let (layer, within) = (row / self.plane.phi.len(), row % self.plane.phi.len());
        [self.plane.phi[within], self.plane.e[within], self.third[layer]]
    }
}

/// Points per side of a cubic lattice of at most `count` points.
pub fn cubic_side(count: usize) -> usize {
    let root = (count as f64).cbrt() as usize + 1;
    if root.saturating_pow(3) <= count { root } else { root - 1 }
}

/// A cubic lattice of the largest number of points that does not exceed `count`, over [`lattice_reach`] standard
/// deviations to each side of the mean in all three directions, cut to `0 < e < 1` and where the distribution of the
/// third variable is cut.
///
/// # Errors
/// As [`lattice_points`].
pub fn cubic_lattice(problem: &UncertainProblem, count: usize) -> Result<Layers, MeshError> {
    let side = cubic_side(count);
    layered_lattice(problem, side, side)
}

/// The same with layers of `side` by `side` points.
///
/// # Errors
/// As [`lattice_points`].
pub fn layered_lattice(problem: &UncertainProblem, side: usize, layers: usize) -> Result<Layers, MeshError> {
    let reach = lattice_reach(side);
    let plane = lattice_points(&problem.plane, side, reach)?;
    let low = problem.lowest().max(-reach);
    let at = |k: usize| problem.third_at(low + (reach - low) * (k as f64 / (layers - 1) as f64));
    let third = (0..layers).map(at).collect();
    Ok(Layers { plane, third })
}

/// The number of layers of `side` by `side` points among so many points; at least two.
pub(super) fn layers_of(points: usize, side: usize) -> usize {
    (points / side.saturating_mul(side).max(1)).max(2)
}

/// The third variable of each layer in standard deviations, from that of all points of equal layers with `side` points
/// per side.
///
/// # Errors
/// [`MeshError`] if the columns are not those of equal layers at ascending, evenly spaced values.
pub(super) fn levels(
    problem: &UncertainProblem,
    [phi, e, third]: [&[f64]; 3],
    (side, layers): (usize, usize),
) -> Result<Vec<f64>, MeshError> {
    /// Largest difference of a spacing from the others, as a share of them.
    const UNEVEN: f64 = 1e-6;
    let layer = side.saturating_mul(side);
    let rows = layer.saturating_mul(layers);
    check_column("the third variable", third, rows, "finite", f64::is_finite)?;
    let off = |row: usize| {
        let (first, within) = (row - row % layer, row % layer);
        third[row] != third[first] || phi[row] != phi[within] || e[row] != e[within]
    };
    if let Some(row) = (0..rows).find(|&row| off(row)) {
        return Err(MeshError::NotALattice { side, row: row % layer });
    }
    let (mean, sigma) = problem.third();
    let levels: Vec<f64> = (0..layers).map(|k| (third[k * layer] - mean) / sigma).collect();
    let step = (levels[layers - 1] - levels[0]) / (layers - 1) as f64;
    let is_even = |pair: &[f64]| pair[1] > pair[0] && ((pair[1] - pair[0]) / step - 1.0).abs() < UNEVEN;
    match levels.windows(2).position(|pair| !is_even(pair)) {
        None => Ok(levels),
        Some(k) => Err(MeshError::Value {
            column: "the third variable",
            row: (k + 1) * layer,
            value: third[(k + 1) * layer],
            expected: "as far above that of the layer before as in all layers",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_of_a_cube_is_the_largest_that_fits() {
        for (count, side) in [(7, 1), (8, 2), (26, 2), (27, 3), (99_999, 46), (97_336, 46), (97_335, 45)] {
            assert_eq!(cubic_side(count), side, "{count}");
        }
        assert!((1..2000).all(|side: usize| cubic_side(side.pow(3)) == side));
    }
}
