//! High-degree interpolation of the flow between lattice points.
//!
//! The flow is an analytic map of the initial plane, so on a lattice of initial points its image `(x1, x2)` can be
//! interpolated by polynomials of degree `d`: in each lattice cell the tensor product of the Lagrange polynomials on
//! the `d + 1` nearest lattice lines (sliding stencils, one-sided at the border). Neighbouring cells agree on their
//! common edge. The error falls as `h^(d+1)`, against `h²` for straight triangles; `d = 2` makes patches of nine nodes.
//!
//! A finer lattice follows from the same polynomials ([`Refinement`]), and so do moments ([`super::quadrature`]).

use rayon::prelude::*;

use super::MeshError;

/// The largest degree supported. Equidistant nodes make higher ones oscillate near the border.
pub const MOST_DEGREE: usize = 11;

const POINTS: usize = MOST_DEGREE + 1;

/// Weights that give a value from those at `degree + 1` neighbouring nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stencil {
    first: usize,
    weights: [f64; POINTS],
}

impl Stencil {
    /// The weighted sum of the values at the nodes.
    pub(super) fn sum(&self, degree: usize, value: impl Fn(usize) -> f64) -> f64 {
        (0..=degree).map(|k| self.weights[k] * value(self.first + k)).sum()
    }
}

/// The stencil of degree `degree` at a point of the cell between the lines `cell` and `cell + 1`.
pub(super) fn stencil(lines: &[f64], cell: usize, degree: usize, at: f64) -> Stencil {
    let first = first_node(cell, lines.len(), degree);
    Stencil { first, weights: lagrange(&lines[first..=first + degree], at) }
}

/// First node of the stencil of the cell between nodes `cell` and `cell + 1`.
fn first_node(cell: usize, nodes: usize, degree: usize) -> usize {
    cell.saturating_sub((degree - 1) / 2).min(nodes - 1 - degree)
}

/// Lagrange polynomials on `nodes` at `at`.
fn lagrange(nodes: &[f64], at: f64) -> [f64; POINTS] {
    let mut weights = [0.0; POINTS];
    for (i, weight) in weights.iter_mut().enumerate().take(nodes.len()) {
        *weight = (0..nodes.len()).filter(|&j| j != i).map(|j| (at - nodes[j]) / (nodes[i] - nodes[j])).product();
    }
    weights
}

/// Slopes of the Lagrange polynomials on `nodes` at `at`.
fn lagrange_slopes(nodes: &[f64], at: f64) -> [f64; POINTS] {
    let mut slopes = [0.0; POINTS];
    for (i, slope) in slopes.iter_mut().enumerate().take(nodes.len()) {
        let others = |skip: usize| (0..nodes.len()).filter(move |&j| j != i && j != skip);
        *slope = others(i)
            .map(|m| {
                let rest = others(m).map(|j| (at - nodes[j]) / (nodes[i] - nodes[j])).product::<f64>();
                rest / (nodes[i] - nodes[m])
            })
            .sum();
    }
    slopes
}

/// Interpolation from a lattice to one `factor` times as fine.
#[derive(Debug, Clone)]
pub struct Refinement {
    degree: usize,
    coarse: usize,
    rows: Vec<Stencil>,
    columns: Vec<Stencil>,
    /// Value and slope at the middle of each gap, in the outer and the inner direction.
    middles: [Vec<[Stencil; 2]>; 2],
    /// Fine lattice lines across the outer direction.
    pub outer: Vec<f64>,
    /// Fine lattice lines across the inner direction.
    pub inner: Vec<f64>,
}

impl Refinement {
    /// From the lattice lines `outer` and `inner` (ascending, equally many of each), each gap divided into `factor`
    /// parts.
    ///
    /// # Errors
    /// [`MeshError::Degree`] unless `1 <= degree <= MOST_DEGREE` and the lattice has more than `degree` lines.
    pub fn new(outer: &[f64], inner: &[f64], degree: usize, factor: usize) -> Result<Self, MeshError> {
        let side = outer.len().min(inner.len());
        check_degree(degree, side)?;
        let fine = |lines: &[f64]| -> (Vec<f64>, Vec<Stencil>) {
            (0..=(side - 1) * factor)
                .map(|k| {
                    let cell = (k / factor).min(side - 2);
                    let share = (k - cell * factor) as f64 / factor as f64;
                    let at = lines[cell] + share * (lines[cell + 1] - lines[cell]);
                    (at, stencil(&lines[..side], cell, degree, at))
                })
                .unzip()
        };
        let middles = [outer, inner].map(|lines| {
            let middle = |cell: usize| {
                let (first, at) = (first_node(cell, side, degree), lines[cell].midpoint(lines[cell + 1]));
                let nodes = &lines[first..=first + degree];
                [lagrange(nodes, at), lagrange_slopes(nodes, at)].map(|weights| Stencil { first, weights })
            };
            (0..side - 1).map(middle).collect()
        });
        let ((outer, rows), (inner, columns)) = (fine(outer), fine(inner));
        Ok(Self { degree, coarse: side, rows, columns, middles, outer, inner })
    }

    /// Values on the fine lattice from values on the coarse one, outer direction outermost.
    pub fn apply(&self, values: &[f64]) -> Vec<f64> {
        let across: Vec<f64> = values
            .par_chunks(self.coarse)
            .flat_map_iter(|row| self.columns.iter().map(|stencil| stencil.sum(self.degree, |k| row[k])))
            .collect();
        let width = self.columns.len();
        let mut fine = vec![0.0; self.rows.len() * width];
        fine.par_chunks_mut(width).zip(&self.rows).for_each(|(row, stencil)| self.add_rows(stencil, &across, row));
        fine
    }

    /// The interpolant's values and its slopes in the outer and inner direction in the middle of every coarse cell.
    pub fn middles(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let cells = self.coarse - 1;
        let along = |which: usize| -> Vec<f64> {
            let row = |row: &[f64]| -> Vec<f64> {
                self.middles[1].iter().map(|stencils| stencils[which].sum(self.degree, |l| row[l])).collect()
            };
            values.par_chunks(self.coarse).flat_map_iter(row).collect()
        };
        let across = |which: usize, along: &[f64]| -> Vec<f64> {
            let mut found = vec![0.0; cells * cells];
            let rows = found.par_chunks_mut(cells).zip(&self.middles[0]);
            rows.for_each(|(row, stencils)| self.add_rows(&stencils[which], along, row));
            found
        };
        let (value, slope) = (along(0), along(1));
        [across(0, &value), across(1, &value), across(0, &slope)]
    }

    /// Adds the weighted rows of a stencil to `sum`, whose length is that of a row of `values`.
    fn add_rows(&self, stencil: &Stencil, values: &[f64], sum: &mut [f64]) {
        let rows = values.chunks_exact(sum.len()).skip(stencil.first);
        for (weight, row) in stencil.weights[..=self.degree].iter().zip(rows) {
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
    }
}

/// Whether a lattice of `side` lines can be interpolated to degree `degree`.
pub(super) fn check_degree(degree: usize, side: usize) -> Result<(), MeshError> {
    if degree == 0 || degree > MOST_DEGREE || degree >= side {
        return Err(MeshError::Degree { degree, most: MOST_DEGREE, side });
    }
    Ok(())
}

/// The lattice lines in standard deviations, in the outer and the inner direction.
pub(super) fn lattice_lines(standard: &[[f64; 2]], side: usize) -> Result<[Vec<f64>; 2], MeshError> {
    const TOLERANCE: f64 = 1e-6;
    let points = side.saturating_mul(side);
    if side < 2 || points != standard.len() {
        return Err(MeshError::Length { column: "phi0", found: standard.len(), expected: points });
    }
    let outer: Vec<f64> = (0..side).map(|i| standard[i * side][0]).collect();
    let inner: Vec<f64> = (0..side).map(|j| standard[j][1]).collect();
    let off = |row: usize| {
        let (i, j) = (row / side, row % side);
        let falls = (i > 0 && outer[i] <= outer[i - 1]) || (j > 0 && inner[j] <= inner[j - 1]);
        falls || (standard[row][0] - outer[i]).abs() > TOLERANCE || (standard[row][1] - inner[j]).abs() > TOLERANCE
    };
    match (0..points).find(|&row| off(row)) {
        Some(row) => Err(MeshError::NotALattice { side, row }),
        None => Ok([outer, inner]),
    }
}

/// Two counter-clockwise triangles per cell.
pub(super) fn lattice_triangles(side: usize) -> Vec<[u32; 3]> {
    let node = |i: usize, j: usize| (i * side + j) as u32;
    (0..(side - 1) * (side - 1))
        .flat_map(|cell| {
            let (i, j) = (cell / (side - 1), cell % (side - 1));
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            halves([a, b, c, d], i + j)
        })
        .collect()
}

/// Like [`lattice_triangles`], for the lattice with these lines in standard deviations, but with fewer and larger
/// triangles where the Gaussian is thinner.
///
/// What a straight triangle of width `h` misplaces grows as its probability times `h²`. For a given number of triangles
/// the sum is least where `h` is inversely proportional to the fourth root of the density, `exp(r²/8)`. Tiles of
/// [`TILE`] cells per side take every `h`-th line, from [`FULL`] standard deviations on. Where a tile meets a coarser
/// one, their common edge is straight for one and not for the other, which misplaces no more than the coarser triangles
/// do. Every triangle has its own probability, so none is lost.
pub(super) fn graded_triangles(outer: &[f64], inner: &[f64]) -> Vec<[u32; 3]> {
    let tiles = |lines: &[f64]| (lines.len() - 1).div_ceil(TILE);
    let ends = |lines: &[f64], tile: usize| (tile * TILE, (lines.len() - 1).min((tile + 1) * TILE));
    let distance = |lines: &[f64], (from, to): (usize, usize)| lines[from].max(-lines[to]).max(0.0);
    let mut triangles = Vec::new();
    for (i, j) in (0..tiles(outer)).flat_map(|i| (0..tiles(inner)).map(move |j| (i, j))) {
        let (rows, columns) = (ends(outer, i), ends(inner, j));
        let radius = distance(outer, rows).hypot(distance(inner, columns));
        let width = 2.0 * ((radius * radius - FULL * FULL) / 8.0).exp();
        let step = STEPS.into_iter().rev().find(|&step| step as f64 <= width).unwrap_or(1);
        let lines = |(from, to): (usize, usize)| (from..to).step_by(step).map(move |k| [k, to.min(k + step)]);
        for [low, high] in lines(rows) {
            for [left, right] in lines(columns) {
                let node = |i: usize, j: usize| (i * inner.len() + j) as u32;
                let corners = [node(low, left), node(high, left), node(high, right), node(low, right)];
                triangles.extend(halves(corners, (low + left) / step));
            }
        }
    }
    triangles
}

/// Cells per side of a tile, in which all triangles are equally large.
const TILE: usize = 12;
/// Standard deviations out to which triangles are as small as possible: a critical eccentricity that is exceeded with a
/// probability of a per cent lies within them.
const FULL: f64 = 2.9;
/// Widths of triangles in cells; all of them divide a tile.
const STEPS: [usize; 4] = [1, 2, 3, 4];

/// The two counter-clockwise triangles of a cell; neighbours are cut along opposite diagonals.
fn halves([a, b, c, d]: [u32; 4], parity: usize) -> [[u32; 3]; 2] {
    if parity.is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_triangles_cover_the_lattice_once() {
        for side in [5, 13, 40] {
            let (outer, inner) = (lines(side, -5.0, 5.5), lines(side, -5.5, 5.5));
            let triangles = graded_triangles(&outer, &inner);
            let corner = |node: u32| [outer[node as usize / inner.len()], inner[node as usize % inner.len()], 0.0];
            let areas = triangles.iter().map(|t| 0.5 * crate::mesh::polygon::twice_area(&t.map(corner)));
            assert!(areas.clone().all(|area| area > 0.0));
            assert!((areas.sum::<f64>() / (10.5 * 11.0) - 1.0).abs() < 1e-12);
            assert!(triangles.len() <= lattice_triangles(side as usize).len());
        }
    }

    fn lines(count: u32, low: f64, high: f64) -> Vec<f64> {
        (0..count).map(|i| low + (high - low) * f64::from(i) / f64::from(count - 1)).collect()
    }

    #[test]
    fn a_polynomial_of_the_degree_is_reproduced_everywhere() {
        let polynomial = |u: f64, v: f64| 1.0 + u * u * u - 2.0 * u * v * v + v.powi(3);
        let (outer, inner) = (lines(9, -2.0, 1.0), lines(9, 0.0, 2.0));
        let refinement = Refinement::new(&outer, &inner, 3, 4).unwrap();
        let grid = |outer: &[f64], inner: &[f64]| -> Vec<f64> {
            outer.iter().flat_map(|&u| inner.iter().map(move |&v| polynomial(u, v))).collect()
        };
        let found = refinement.apply(&grid(&outer, &inner));
        let expected = grid(&refinement.outer, &refinement.inner);
        assert_eq!(found.len(), 33 * 33);
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn slopes_in_the_middle_of_a_cell_are_those_of_the_polynomial() {
        let nodes = lines(6, -1.0, 1.0);
        let values: Vec<f64> = (0..36).map(|k| nodes[k / 6].powi(3) * (1.0 + nodes[k % 6].powi(2))).collect();
        let [value, outer, inner] = Refinement::new(&nodes, &nodes, 4, 1).unwrap().middles(&values).map(|all| all[4]);
        let (u, v) = (-0.8f64, 0.8f64);
        assert!((value - u.powi(3) * (1.0 + v * v)).abs() < 1e-13);
        assert!((outer - 3.0 * u * u * (1.0 + v * v)).abs() < 1e-12);
        assert!((inner - u.powi(3) * 2.0 * v).abs() < 1e-12);
    }

    #[test]
    fn interpolation_error_falls_with_the_degree() {
        let nodes = lines(21, -1.0, 1.0);
        let values: Vec<f64> = (0..441).map(|k| (2.0 * nodes[k / 21] + nodes[k % 21]).sin()).collect();
        let error = |degree| {
            let refinement = Refinement::new(&nodes, &nodes, degree, 3).unwrap();
            let found = refinement.apply(&values);
            let width = refinement.inner.len();
            (0..found.len())
                .map(|k| (found[k] - (2.0 * refinement.outer[k / width] + refinement.inner[k % width]).sin()).abs())
                .fold(0.0, f64::max)
        };
        let errors = [1, 2, 3, 5, 7].map(error);
        assert!(errors.windows(2).all(|pair| pair[1] < 0.2 * pair[0]), "{errors:?}");
    }

    #[test]
    fn impossible_degrees_are_refused() {
        let nodes = lines(5, 0.0, 1.0);
        for degree in [0, 5, MOST_DEGREE + 1] {
            assert!(matches!(Refinement::new(&nodes, &nodes, degree, 2), Err(MeshError::Degree { .. })));
        }
    }
}
