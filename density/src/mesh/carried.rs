//! The carried mesh: triangles of initial points that the flow moves and that keep their probability.
//!
//! It is the continuity equation in integral form: a region carried by the flow keeps its probability. The initial
//! points are triangulated once, in standard deviations; each triangle gets its exact probability under the initial
//! Gaussian ([`super::gaussian`]) and keeps it at all times. At a snapshot that probability is spread over the
//! triangle's image in proportion to the densities that the characteristics at its corners carry, and divided exactly
//! among the bins.
//!
//! Moments use the same weights for every snapshot. On scattered points (degree 1) the flow is taken as linear in each
//! triangle, and `∫ p phi² = Σ phi_i phi_j ∫ p L_i L_j` is exact for a linear flow. On a lattice of degree `d` the flow
//! is a polynomial in every cell ([`super::lattice`]): moments are integrals of these polynomials
//! ([`super::quadrature`]), and the joint density is read from a refined lattice ([`super::fine`]), which is finer
//! where the bins need it.
//!
//! **When to trust it.** The flow keeps the measure `e/s dphi de`; a mesh does so only where it resolves the flow, see
//! [`super::diagnostics`].

use std::sync::OnceLock;

use rayon::prelude::*;

use super::delaunay::triangulate;
use super::diagnostics::{MeshDiagnostics, cell_ratio};
use super::fine::{Elements, FineLattice};
use super::gaussian::barycentric_moments;
use super::lattice::{Refinement, lattice_lines, lattice_triangles};
use super::quadrature::Quadrature;
use super::readout::{Node, invariant_measure, polar_measure};
use super::share::Share;
use super::{MeshError, check_points, parts};
use crate::angle::nearest;
use crate::estimate::{Estimate, Moments, ordered_sum, weighted_moments};
use crate::grid::Grid;
use crate::model::plane::State;
use crate::problem::InitialGaussian;

/// Number of cells per side to which a lattice is refined for the joint density.
const FINE_CELLS: usize = 300;
/// Finer numbers of cells per side, for when [`FINE_CELLS`] would misplace more than [`MISPLACED`]: the first that does
/// not is taken, or the last.
const FINER_CELLS: [usize; 3] = [450, 600, 900];
/// Misplacement of the joint density by straight triangles, in total variation, above which the lattice is refined
/// further.
const MISPLACED: f64 = 1.5e-3;

/// A mesh over initial points, ready to be carried.
#[derive(Debug, Clone)]
pub struct CarriedMesh {
    initial: InitialGaussian,
    points: usize,
    scheme: Scheme,
}

/// How the flow is approximated between the points.
#[derive(Debug, Clone)]
enum Scheme {
    /// Linear in each triangle.
    Linear {
        elements: Elements,
        /// `∫ p L_i L_j` of each triangle.
        second: Vec<[f64; 6]>,
        /// `∫ p L_i`, summed over the triangles at each point.
        weights: Vec<f64>,
        /// Invariant measure of each triangle at `t = 0`.
        measure: Vec<f64>,
    },
    /// A polynomial in each cell of a lattice.
    Lattice {
        /// Lattice lines in standard deviations, in the outer and the inner direction.
        lines: [Vec<f64>; 2],
        degree: usize,
        quadrature: Box<Quadrature>,
        fine: Box<FineLattice>,
        /// Lattices with [`FINER_CELLS`], made when they are first needed.
        finer: [OnceLock<Box<FineLattice>>; 3],
    },
}

impl CarriedMesh {
    /// A mesh over the initial points `(phi0, e0)`. With `lattice` points per side it is a lattice (solar angle
    /// outermost, both ascending) whose image is interpolated to degree `degree`; otherwise it has Delaunay triangles
    /// and is linear, whatever the degree.
    ///
    /// # Errors
    /// [`MeshError`] if the columns do not match or hold no elliptic orbits, if the points span no triangle or are not
    /// the announced lattice, or if the degree does not fit it.
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
        let elements = Elements::new(initial, points, triangles, mass);
        let scheme = Scheme::Linear { elements, second, weights, measure };
        Self { initial: *initial, points: points.len(), scheme }
    }

    fn polynomial(initial: &InitialGaussian, lines: [Vec<f64>; 2], degree: usize) -> Result<Self, MeshError> {
        let fine = Box::new(FineLattice::new(initial, &lines, degree, FINE_CELLS)?);
        let quadrature = Box::new(Quadrature::new(lines.clone(), degree));
        let points = lines[0].len() * lines[1].len();
        let scheme = Scheme::Lattice { lines, degree, quadrature, fine, finer: Default::default() };
        Ok(Self { initial: *initial, points, scheme })
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
        let (elements, nodes, (moments, circular), diagnostics) = match &self.scheme {
            Scheme::Linear { elements, second, weights, measure } => {
                let nodes = elements.nodes(&x1, &x2);
                let diagnostics = judge_triangles(elements, &nodes, measure);
                let (moments, circular) = weighted_moments(phi, e, Some(weights), critical_e);
                let moments = second_moments(elements, [phi, e], second, moments, circular.mean);
                (elements, nodes, (moments, circular), diagnostics)
            }
            Scheme::Lattice { lines, degree, quadrature, fine, finer } => {
                let mut diagnostics =
                    judge_cells(&self.initial, [&lines[0], &lines[1]], &fine.refinement, [&x1, &x2], &[]);
                let (mut fine, mut states) = (fine, fine.refine(&x1, &x2));
                let mut by_chords = fine.misplaced_by_chords(&states, grid);
                let by_interpolation = fine.misplaced_by_interpolation([&x1, &x2], &states, grid);
                if let Some(k) = finer_needed(by_chords, fine.refinement.outer.len() - 1) {
                    if finer[k].get().is_none() {
                        let made = FineLattice::new(&self.initial, lines, *degree, FINER_CELLS[k])?;
                        finer[k].get_or_init(|| Box::new(made));
                    }
                    fine = finer[k].get().unwrap_or(fine);
                    states = fine.refine(&x1, &x2);
                    by_chords = fine.misplaced_by_chords(&states, grid);
                }
                diagnostics.misplaced_mass = by_chords + by_interpolation;
                (&fine.elements, fine.nodes(&states), quadrature.moments(&x1, &x2, critical_e), diagnostics)
            }
        };
        let truncated_mass = (1.0 - elements.total / self.initial.mass_inside()).max(0.0);
        let diagnostics = MeshDiagnostics { truncated_mass, ..diagnostics };
        let (mut joint, above) = share_out(elements, &nodes, grid, critical_e);
        joint.iter_mut().for_each(|mass| *mass /= elements.total * grid.bin_area());
        let moments = Moments { prob_above_critical_e: (above / elements.total).clamp(0.0, 1.0), ..moments };
        Ok((Estimate::from_joint(*grid, joint, moments, circular), diagnostics))
    }
}

/// Index of the one of [`FINER_CELLS`] that is needed where `cells` cells per side misplace `misplaced`: what straight
/// triangles misplace grows with the square of their size.
fn finer_needed(misplaced: f64, cells: usize) -> Option<usize> {
    let needed = cells as f64 * (misplaced / MISPLACED).sqrt();
    let last = FINER_CELLS.len() - 1;
    let finer = FINER_CELLS.iter().position(|&finer| finer as f64 >= needed).unwrap_or(last);
    (misplaced > MISPLACED && cells < FINER_CELLS[last]).then_some(finer).filter(|&finer| FINER_CELLS[finer] > cells)
}

/// How far the interpolated flow of a lattice keeps the invariant measure, cell by cell; in cells that are marked as
/// `direct` it is not interpolated and keeps it.
pub(super) fn judge_cells(
    initial: &InitialGaussian,
    lines: [&[f64]; 2],
    refinement: &Refinement,
    states: [&[f64]; 2],
    direct: &[bool],
) -> MeshDiagnostics {
    let cells = lines[0].len() - 1;
    let [x1, x2] = states.map(|values| refinement.middles(values));
    let ratio = |k: usize| {
        let [i, j] = [k / cells, k % cells];
        let at = [lines[0][i].midpoint(lines[0][i + 1]), lines[1][j].midpoint(lines[1][j + 1])];
        let (ratio, mass) = cell_ratio(initial, at, [&x1, &x2].map(|all| all.each_ref().map(|values| values[k])));
        (if direct.get(k) == Some(&true) { 1.0 } else { ratio }, mass)
    };
    let ratios: Vec<(f64, f64)> = (0..cells * cells).into_par_iter().map(ratio).collect();
    MeshDiagnostics::from_ratios(ratios.into_iter())
}

/// Adds the standard deviations and the covariance, for a flow that is linear in each triangle.
fn second_moments(
    elements: &Elements,
    [phi, e]: [&[f64]; 2],
    second: &[[f64; 6]],
    mean: Moments,
    centre: f64,
) -> Moments {
    let sums = ordered_sum(elements.triangles.len(), |k| {
        let rows = elements.triangles[k].map(|row| row as usize);
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
    let [var_phi, var_e, cov_phi_e] = sums.map(|sum| sum / elements.total);
    Moments { std_phi: var_phi.sqrt(), std_e: var_e.sqrt(), cov_phi_e, ..mean }
}

/// Probability of each bin, and probability above the critical eccentricity.
fn share_out(elements: &Elements, nodes: &[Node], grid: &Grid, critical_e: f64) -> (Vec<f64>, f64) {
    let count = elements.triangles.len();
    let parts = parts(count, grid.len());
    let share = |part: usize| {
        let mut share = Share::new(grid, critical_e);
        for k in count * part / parts..count * (part + 1) / parts {
            share.add(&elements.corners(nodes, k), elements.mass[k]);
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

fn judge_triangles(elements: &Elements, nodes: &[Node], measure: &[f64]) -> MeshDiagnostics {
    let ratio = |k: usize| (invariant_measure(&elements.corners(nodes, k)) / measure[k], elements.mass[k]);
    let ratios: Vec<(f64, f64)> = (0..measure.len()).into_par_iter().map(ratio).collect();
    MeshDiagnostics::from_ratios(ratios.into_iter())
}
