//! The carried mesh: triangles of initial points that the flow moves and that keep their probability.
//!
//! The continuity equation in integral form: a region carried by the flow keeps its probability. The initial points are
//! triangulated once, in standard deviations; each triangle gets its exact probability under the initial Gaussian
//! ([`super::gaussian`]) and keeps it at all times. At a snapshot that probability is spread over the triangle's image in
//! proportion to the densities that the characteristics at its corners carry, and shared out to the bins exactly.
//!
//! Moments use the same weights for every snapshot. On scattered points (degree 1) the flow is taken as linear in each
//! triangle, and `∫ p phi² = Σ phi_i phi_j ∫ p L_i L_j` is exact for a linear flow. On a lattice of degree `d` they are
//! weighted sums over the lattice points, exact for a flow that is polynomial of degree `d` between them
//! ([`super::lattice`]); the joint density is read from a refined lattice.
//!
//! **When to trust it.** The flow keeps the measure `e/s dphi de`, a mesh does so only where it resolves the flow: see
//! [`super::diagnostics`].

use rayon::prelude::*;

use super::delaunay::triangulate;
use super::diagnostics::{MeshDiagnostics, cell_ratio};
use super::gaussian::{barycentric_moments, probability};
use super::lattice::{Refinement, gaussian_weights, graded_triangles, lattice_lines, lattice_triangles};
use super::readout::{Node, invariant_measure, polar_measure};
use super::share::Share;
use super::{MeshError, check_points, parts};
use crate::angle::Circular;
use crate::angle::nearest;
use crate::dynamics::State;
use crate::estimate::{Estimate, Moments, ordered_sum, weighted_moments};
use crate::grid::Grid;
use crate::problem::InitialGaussian;

/// Cells a side to which a lattice is refined for the joint density, where that is large.
const FINE_CELLS: usize = 300;

/// A mesh over initial points, ready to be carried.
#[derive(Debug, Clone)]
pub struct CarriedMesh {
    initial: InitialGaussian,
    points: usize,
    triangles: Vec<[u32; 3]>,
    /// Probability of each triangle.
    mass: Vec<f64>,
    /// Sum of the above.
    total: f64,
    /// `n0 s0/e0` at each node.
    invariant_density: Vec<f64>,
    scheme: Scheme,
}

/// What the flow is taken for between the points.
#[derive(Debug, Clone)]
enum Scheme {
    /// Linear in each triangle.
    Linear {
        /// `∫ p L_i L_j` of each triangle.
        second: Vec<[f64; 6]>,
        /// `∫ p L_i`, summed over the triangles at each point.
        weights: Vec<f64>,
        /// Invariant measure of each triangle at the start.
        measure: Vec<f64>,
    },
    /// A polynomial in each cell of a lattice.
    Lattice {
        /// Lattice lines in standard deviations, outer and inner direction.
        lines: [Vec<f64>; 2],
        refinement: Box<Refinement>,
        /// Those points of the refined lattice that are nodes.
        used: Vec<u32>,
        /// Weights of the points in any mean.
        weights: Vec<f64>,
    },
}

impl CarriedMesh {
    /// A mesh over the initial points `(phi0, e0)`: with `lattice` points a side a lattice (solar angle outermost, both
    /// ascending) whose image is interpolated to degree `degree`; otherwise Delaunay triangles, whatever the degree linear.
    ///
    /// # Errors
    /// [`MeshError`] if the columns do not match or hold no elliptic orbits, the points span no triangle, are not the
    /// lattice announced, or the degree does not fit it.
    pub fn new(
        initial: &InitialGaussian,
        phi0: &[f64],
        e0: &[f64],
        lattice: Option<usize>,
        degree: usize,
    ) -> Result<Self, MeshError> {
        check_points(phi0, e0, phi0.len())?;
        if phi0.len() < 4 {
            return Err(MeshError::TooFewPoints { found: phi0.len(), needed: 4 });
        }
        let points: Vec<[f64; 2]> = phi0.iter().zip(e0).map(|(&phi, &e)| initial.standardise(phi, e).into()).collect();
        let Some(side) = lattice else {
            let (u, v): (Vec<f64>, Vec<f64>) = points.iter().map(|&[u, v]| (u, v)).unzip();
            return Ok(Self::linear(initial, &points, triangulate(&u, &v)?));
        };
        let lines = lattice_lines(&points, side)?;
        if degree == 1 {
            return Ok(Self::linear(initial, &points, lattice_triangles(side)));
        }
        Self::polynomial(initial, lines, degree)
    }

    fn linear(initial: &InitialGaussian, points: &[[f64; 2]], triangles: Vec<[u32; 3]>) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|node| points[node as usize]);
        let second: Vec<[f64; 6]> = triangles.par_iter().map(|t| barycentric_moments(&corners(t))).collect();
        let polar = |[u, v]: [f64; 2]| {
            let (phi, e) = initial.point(u, v);
            [phi, e, 0.0]
        };
        let measure = triangles.par_iter().map(|t| polar_measure(&corners(t).map(polar))).collect();
        let mut weights = vec![0.0; points.len()];
        for (&[a, b, c], [aa, bb, cc, ab, bc, ca]) in triangles.iter().zip(&second) {
            weights[a as usize] += aa + ab + ca;
            weights[b as usize] += bb + ab + bc;
            weights[c as usize] += cc + bc + ca;
        }
        let mass = second.iter().map(|[aa, bb, cc, ab, bc, ca]| aa + bb + cc + 2.0 * (ab + bc + ca)).collect();
        Self::assemble(initial, points.len(), points, triangles, mass, Scheme::Linear { second, weights, measure })
    }

    fn polynomial(initial: &InitialGaussian, lines: [Vec<f64>; 2], degree: usize) -> Result<Self, MeshError> {
        let side = lines[0].len();
        let factor = FINE_CELLS.div_ceil(side - 1);
        let refinement = Refinement::new(&lines[0], &lines[1], degree, factor)?;
        let [outer, inner] = lines.each_ref().map(|lines| gaussian_weights(lines, degree));
        let weights = outer.iter().flat_map(|&a| inner.iter().map(move |&b| a * b)).collect();
        let (triangles, used) = number_nodes(graded_triangles(&refinement.outer, &refinement.inner));
        let width = refinement.inner.len() as u32;
        let point = |&k: &u32| [refinement.outer[(k / width) as usize], refinement.inner[(k % width) as usize]];
        let nodes: Vec<[f64; 2]> = used.iter().map(point).collect();
        let mass = triangles.par_iter().map(|t| probability(&t.map(|node| nodes[node as usize]))).collect();
        let scheme = Scheme::Lattice { lines, refinement: Box::new(refinement), used, weights };
        Ok(Self::assemble(initial, side * side, &nodes, triangles, mass, scheme))
    }

    fn assemble(
        initial: &InitialGaussian,
        points: usize,
        nodes: &[[f64; 2]],
        triangles: Vec<[u32; 3]>,
        mass: Vec<f64>,
        scheme: Scheme,
    ) -> Self {
        let invariant_density = |&[u, v]: &[f64; 2]| {
            let (phi, e) = initial.point(u, v);
            let density = initial.density(phi, e) * State::from_polar(phi, e).s() / e;
            if density.is_finite() { density } else { 0.0 }
        };
        let invariant_density = nodes.par_iter().map(invariant_density).collect();
        let total = mass.iter().sum();
        Self { initial: *initial, points, triangles, mass, total, invariant_density, scheme }
    }

    /// The density at a snapshot, from the points' present solar angles \[rad\] and eccentricities.
    ///
    /// # Errors
    /// [`MeshError::Length`] or [`MeshError::Value`] if the columns are not those of the mesh's points.
    pub fn estimate(
        &self,
        phi: &[f64],
        e: &[f64],
        grid: &Grid,
        critical_e: f64,
    ) -> Result<(Estimate, MeshDiagnostics), MeshError> {
        check_points(phi, e, self.points)?;
        let (x1, x2): (Vec<f64>, Vec<f64>) = phi
            .par_iter()
            .zip(e)
            .map(|(&phi, &e)| {
                let state = State::from_polar(phi, e);
                (state.x1, state.x2)
            })
            .unzip();
        let (moments, circular) = self.moments(phi, e, critical_e);
        let (nodes, diagnostics) = match &self.scheme {
            Scheme::Linear { measure, .. } => {
                let nodes = self.nodes(&x1, &x2);
                let diagnostics = self.judge_triangles(&nodes, measure);
                (nodes, diagnostics)
            }
            Scheme::Lattice { lines, refinement, used, .. } => {
                let refine = |values: &[f64]| -> Vec<f64> {
                    let fine = refinement.apply(values);
                    used.iter().map(|&node| fine[node as usize]).collect()
                };
                let nodes = self.nodes(&refine(&x1), &refine(&x2));
                (nodes, self.judge_cells([&lines[0], &lines[1]], refinement, [&x1, &x2]))
            }
        };
        let (mut joint, above) = self.share_out(&nodes, grid, critical_e);
        joint.iter_mut().for_each(|mass| *mass /= self.total * grid.bin_area());
        let moments = Moments { prob_above_critical_e: (above / self.total).clamp(0.0, 1.0), ..moments };
        Ok((Estimate::from_joint(*grid, joint, moments, circular), diagnostics))
    }

    fn nodes(&self, x1: &[f64], x2: &[f64]) -> Vec<Node> {
        let densities = &self.invariant_density;
        x1.par_iter().zip(x2).zip(densities).map(|((&x1, &x2), &density)| Node::new(x1, x2, density)).collect()
    }

    fn corners(&self, nodes: &[Node], triangle: usize) -> [Node; 3] {
        self.triangles[triangle].map(|node| nodes[node as usize])
    }

    fn moments(&self, phi: &[f64], e: &[f64], critical_e: f64) -> (Moments, Circular) {
        match &self.scheme {
            Scheme::Lattice { weights, .. } => weighted_moments(phi, e, Some(weights), critical_e),
            Scheme::Linear { second, weights, .. } => {
                let (moments, circular) = weighted_moments(phi, e, Some(weights), critical_e);
                (self.second_moments(phi, e, second, moments, circular.mean), circular)
            }
        }
    }

    /// Standard deviations and covariance of the flow that is linear in each triangle.
    fn second_moments(&self, phi: &[f64], e: &[f64], second: &[[f64; 6]], mean: Moments, centre: f64) -> Moments {
        let sums = ordered_sum(self.triangles.len(), |k| {
            let rows = self.triangles[k].map(|row| row as usize);
            let x = rows.map(|row| nearest(phi[row], centre) - mean.mean_phi);
            let y = rows.map(|row| e[row] - mean.mean_e);
            let [aa, bb, cc, ab, bc, ca] = second[k];
            let form = |p: [f64; 3], q: [f64; 3]| {
                let cross = |i: usize, j: usize| p[i] * q[j] + p[j] * q[i];
                let squares = aa * p[0] * q[0] + bb * p[1] * q[1] + cc * p[2] * q[2];
                squares + ab * cross(0, 1) + bc * cross(1, 2) + ca * cross(2, 0)
            };
            [form(x, x), form(y, y), form(x, y)]
        });
        let [var_phi, var_e, cov_phi_e] = sums.map(|sum| sum / self.total);
        Moments { std_phi: var_phi.sqrt(), std_e: var_e.sqrt(), cov_phi_e, ..mean }
    }

    /// Probability of each bin, and above the critical eccentricity.
    fn share_out(&self, nodes: &[Node], grid: &Grid, critical_e: f64) -> (Vec<f64>, f64) {
        let count = self.triangles.len();
        let parts = parts(count, grid.len());
        let share = |part: usize| {
            let mut share = Share::new(grid, critical_e);
            for k in count * part / parts..count * (part + 1) / parts {
                share.add(&self.corners(nodes, k), self.mass[k]);
            }
            share
        };
        let shares: Vec<Share> = (0..parts).into_par_iter().map(share).collect();
        let mut joint = vec![0.0; grid.len()];
        for share in &shares {
            joint.iter_mut().zip(&share.joint).for_each(|(sum, mass)| *sum += mass);
        }
        (joint, shares.iter().map(|share| share.above).sum())
    }

    fn truncated_mass(&self) -> f64 {
        (1.0 - self.total / self.initial.mass_inside()).max(0.0)
    }

    fn judge_triangles(&self, nodes: &[Node], measure: &[f64]) -> MeshDiagnostics {
        let ratio = |k: usize| (invariant_measure(&self.corners(nodes, k)) / measure[k], self.mass[k]);
        let ratios: Vec<(f64, f64)> = (0..measure.len()).into_par_iter().map(ratio).collect();
        MeshDiagnostics::from_ratios(ratios.into_iter(), self.truncated_mass())
    }

    fn judge_cells(&self, lines: [&[f64]; 2], refinement: &Refinement, states: [&[f64]; 2]) -> MeshDiagnostics {
        let cells = lines[0].len() - 1;
        let [x1, x2] = states.map(|values| refinement.middles(values));
        let ratio = |k: usize| {
            let [i, j] = [k / cells, k % cells];
            let at = [lines[0][i].midpoint(lines[0][i + 1]), lines[1][j].midpoint(lines[1][j + 1])];
            cell_ratio(&self.initial, at, [&x1, &x2].map(|all| all.each_ref().map(|values| values[k])))
        };
        let ratios: Vec<(f64, f64)> = (0..cells * cells).into_par_iter().map(ratio).collect();
        MeshDiagnostics::from_ratios(ratios.into_iter(), self.truncated_mass())
    }
}

/// Numbers the points that triangles use from zero on; also says which those are.
fn number_nodes(mut triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let mut number = vec![0; used.last().map_or(0, |&last| last as usize + 1)];
    used.iter().zip(0..).for_each(|(&point, node)| number[point as usize] = node);
    triangles.as_flattened_mut().iter_mut().for_each(|point| *point = number[*point as usize]);
    (triangles, used)
}
