//! High-degree interpolation of the flow between lattice points.
//!
//! The flow is an analytic map of the initial plane, so on a lattice of initial points its image `(x1, x2)` can be
//! interpolated by polynomials of degree `d`: in each lattice cell the tensor product of the Lagrange polynomials on the
//! `d + 1` nearest lattice lines (sliding stencils, one-sided at the border). Neighbouring cells agree on their common
//! edge. The error falls as `h^(d+1)`, against `h²` for straight triangles; `d = 2` makes patches of nine nodes.
//!
//! Two things follow from the same polynomials: a finer lattice ([`Refinement`]), and the weights with which values at the
//! lattice points give their mean under the Gaussian ([`gaussian_weights`]).

use rayon::prelude::*;

use super::MeshError;

/// The largest degree supported. Equidistant nodes make higher ones oscillate near the border.
pub const MOST_DEGREE: usize = 11;

const POINTS: usize = MOST_DEGREE + 1;

/// A value as a weighted sum of `degree + 1` neighbouring nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stencil {
    first: usize,
    weights: [f64; POINTS],
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
    /// Value and slope at the middle of each gap, outer and inner direction.
    middles: [Vec<[Stencil; 2]>; 2],
    /// Fine lattice lines across the outer direction.
    pub outer: Vec<f64>,
    /// Fine lattice lines across the inner direction.
    pub inner: Vec<f64>,
}

impl Refinement {
    /// From the lattice lines `outer` and `inner` (ascending, as many of each), each gap divided into `factor`.
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
                    let first = first_node(cell, side, degree);
                    (at, Stencil { first, weights: lagrange(&lines[first..=first + degree], at) })
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
            .flat_map_iter(|row| self.columns.iter().map(|stencil| self.sum(stencil, |k| row[k])))
            .collect();
        let width = self.columns.len();
        self.rows
            .par_iter()
            .flat_map_iter(|stencil| {
                let across = &across;
                (0..width).map(move |j| self.sum(stencil, |k| across[k * width + j]))
            })
            .collect()
    }

    /// The interpolant's value and its slopes in the outer and inner direction in the middle of coarse cell `(i, j)`.
    pub fn middle(&self, values: &[f64], i: usize, j: usize) -> [f64; 3] {
        let ([value_i, slope_i], [value_j, slope_j]) = (&self.middles[0][i], &self.middles[1][j]);
        let product =
            |row: &Stencil, column: &Stencil| self.sum(row, |k| self.sum(column, |l| values[k * self.coarse + l]));
        [product(value_i, value_j), product(slope_i, value_j), product(value_i, slope_j)]
    }

    fn sum(&self, stencil: &Stencil, value: impl Fn(usize) -> f64) -> f64 {
        (0..=self.degree).map(|k| stencil.weights[k] * value(stencil.first + k)).sum()
    }
}

/// Whether a lattice of `side` lines can be interpolated to degree `degree`.
pub(super) fn check_degree(degree: usize, side: usize) -> Result<(), MeshError> {
    if degree == 0 || degree > MOST_DEGREE || degree >= side {
        return Err(MeshError::Degree { degree, most: MOST_DEGREE, side });
    }
    Ok(())
}

/// Weights `∫ p(u) l_i(u) du` of the nodes, `p` the standard normal density: what the interpolant of degree `degree`
/// through values at the nodes has as its mean over the range that they span.
pub fn gaussian_weights(nodes: &[f64], degree: usize) -> Vec<f64> {
    // Gauss-Legendre points and weights on (-1, 1), Abramowitz & Stegun Table 25.4, n = 8 (one half).
    const POINTS: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_27),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
    ];
    let mut weights = vec![0.0; nodes.len()];
    for (cell, ends) in nodes.windows(2).enumerate() {
        let first = first_node(cell, nodes.len(), degree);
        let half = 0.5 * (ends[1] - ends[0]);
        for (point, weight) in POINTS.iter().flat_map(|&(point, weight)| [(point, weight), (-point, weight)]) {
            let at = ends[0].midpoint(ends[1]) + half * point;
            let density = (-0.5 * at * at).exp() / (2.0 * std::f64::consts::PI).sqrt();
            let polynomials = lagrange(&nodes[first..=first + degree], at);
            for k in 0..=degree {
                weights[first + k] += half * weight * density * polynomials[k];
            }
        }
    }
    weights
}

/// The lattice lines in standard deviations, outer and inner direction.
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

/// Two counter-clockwise triangles a cell.
pub(super) fn lattice_triangles(side: usize) -> Vec<[u32; 3]> {
    let node = |i: usize, j: usize| (i * side + j) as u32;
    (0..(side - 1) * (side - 1))
        .flat_map(|cell| {
            let (i, j) = (cell / (side - 1), cell % (side - 1));
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let [value, outer, inner] = Refinement::new(&nodes, &nodes, 4, 1).unwrap().middle(&values, 0, 4);
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
    fn gaussian_weights_give_the_moments_of_the_normal_distribution() {
        let nodes = lines(31, -6.0, 6.0);
        let weights = gaussian_weights(&nodes, 5);
        let moment = |power| nodes.iter().zip(&weights).map(|(u, w)| w * u.powi(power)).sum::<f64>();
        for (power, expected) in [(0, 1.0), (1, 0.0), (2, 1.0), (4, 3.0)] {
            assert!((moment(power) - expected).abs() < 1e-5, "{power}: {}", moment(power));
        }
    }

    #[test]
    fn impossible_degrees_are_refused() {
        let nodes = lines(5, 0.0, 1.0);
        for degree in [0, 5, MOST_DEGREE + 1] {
            assert!(matches!(Refinement::new(&nodes, &nodes, degree, 2), Err(MeshError::Degree { .. })));
        }
    }
}
