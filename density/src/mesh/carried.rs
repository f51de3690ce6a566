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
//! **When to trust it.** The flow keeps the measure `e/s dphi de`, straight triangles do so only where they resolve the
//! flow. The mean change of a triangle's measure, weighted by its probability, is [`MeshDiagnostics::measure_defect`].

use rayon::prelude::*;

use super::delaunay::triangulate;
use super::gaussian::{barycentric_moments, triangle_probability};
use super::lattice::{Refinement, gaussian_weights};
use super::polygon::{BinUnits, Polygon, share_above, twice_area};
use super::readout::{Node, Part, for_each_part, invariant_measure, polar_measure};
use super::{MeshError, check_points, parts};
use crate::angle::{fold, nearest};
use crate::dynamics::State;
use crate::estimate::{Estimate, Moments, ordered_sum, weighted_moments};
use crate::grid::Grid;
use crate::problem::InitialGaussian;

/// Cells a side to which a lattice is refined for the joint density.
const FINE_CELLS: usize = 300;

/// A mesh over initial points, ready to be carried.
#[derive(Debug, Clone)]
pub struct CarriedMesh {
    points: usize,
    refinement: Option<Refinement>,
    triangles: Vec<[u32; 3]>,
    /// Probability of each triangle.
    mass: Vec<f64>,
    /// Invariant measure of each triangle at the start.
    measure: Vec<f64>,
    /// `n0 s0/e0` at each node.
    invariant_density: Vec<f64>,
    weights: Weights,
    truncated_mass: f64,
}

/// How moments follow from values at the points given.
#[derive(Debug, Clone)]
enum Weights {
    /// `∫ p L_i L_j` of each triangle, and their sums at each point.
    Triangles { second: Vec<[f64; 6]>, first: Vec<f64> },
    /// Weights of the points.
    Points(Vec<f64>),
}

/// What a snapshot says about its own reliability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshDiagnostics {
    /// Triangles of the (refined) mesh.
    pub triangles: usize,
    /// Triangles that the flow seems to have turned over, which a diffeomorphism cannot do.
    pub flipped_triangles: usize,
    /// Their probability.
    pub flipped_mass: f64,
    /// Mean relative change of the triangles' invariant measure, weighted by probability; zero for a resolved flow.
    pub measure_defect: f64,
    /// Probability outside the mesh, which is left out.
    pub truncated_mass: f64,
}

impl MeshDiagnostics {
    /// Above this [`MeshDiagnostics::measure_defect`] the mesh is too coarse for the flow.
    pub const LARGEST_DEFECT: f64 = 0.05;

    /// Whether the mesh resolved the flow.
    pub fn is_resolved(&self) -> bool {
        self.measure_defect <= Self::LARGEST_DEFECT && self.flipped_mass <= 0.01
    }
}

impl CarriedMesh {
    /// A mesh over the initial points `(phi0, e0)`: with `lattice` points a side a lattice (solar angle outermost, both
    /// ascending) whose image is interpolated to degree `degree`; otherwise Delaunay triangles, always of degree 1.
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
        let standard: Vec<[f64; 2]> =
            phi0.iter().zip(e0).map(|(&phi, &e)| initial.standardise(phi, e).into()).collect();
        let Some(side) = lattice else {
            let (u, v): (Vec<f64>, Vec<f64>) = standard.iter().map(|&[u, v]| (u, v)).unzip();
            return Ok(Self::build(initial, phi0.len(), standard, triangulate(&u, &v)?, None, None));
        };
        let (outer, inner) = lattice_lines(&standard, side)?;
        let factor = if degree == 1 { 1 } else { (FINE_CELLS / (side - 1)).max(1) };
        let refinement = Refinement::new(&outer, &inner, degree, factor)?;
        let fine = refinement.outer.iter().flat_map(|&u| refinement.inner.iter().map(move |&v| [u, v])).collect();
        let triangles = lattice_triangles(refinement.inner.len());
        if degree == 1 {
            return Ok(Self::build(initial, phi0.len(), fine, triangles, None, None));
        }
        let (outer, inner) = (gaussian_weights(&outer, degree), gaussian_weights(&inner, degree));
        let weights = outer.iter().flat_map(|&a| inner.iter().map(move |&b| a * b)).collect();
        Ok(Self::build(initial, phi0.len(), fine, triangles, Some(refinement), Some(weights)))
    }

    fn build(
        initial: &InitialGaussian,
        points: usize,
        nodes: Vec<[f64; 2]>,
        triangles: Vec<[u32; 3]>,
        refinement: Option<Refinement>,
        weights: Option<Vec<f64>>,
    ) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|node| nodes[node as usize]);
        let second: Vec<[f64; 6]> =
            triangles.par_iter().map(|triangle| barycentric_moments(&corners(triangle))).collect();
        let mass: Vec<f64> = second.iter().map(|[a, b, c, ab, bc, ca]| a + b + c + 2.0 * (ab + bc + ca)).collect();
        let total: f64 = triangles.iter().map(|triangle| triangle_probability(&corners(triangle))).sum();
        let polar = |[u, v]: [f64; 2]| {
            let (phi, e) = initial.point(u, v);
            [phi, e, 0.0]
        };
        let measure = triangles.par_iter().map(|triangle| polar_measure(&corners(triangle).map(polar))).collect();
        let invariant_density = nodes
            .par_iter()
            .map(|&node| {
                let [phi, e, _] = polar(node);
                initial.density(phi, e) * State::from_polar(phi, e).s() / e
            })
            .map(|density| if density.is_finite() { density } else { 0.0 })
            .collect();
        let weights = weights.map_or_else(|| Weights::of_triangles(&triangles, second, points), Weights::Points);
        let truncated_mass = (1.0 - total / initial.mass_inside()).max(0.0);
        Self { points, refinement, triangles, mass, measure, invariant_density, weights, truncated_mass }
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
        let nodes = self.nodes(phi, e);
        let (joint, above, diagnostics) = self.share_out(&nodes, grid, critical_e);
        let total: f64 = self.mass.iter().sum();
        let per_area = 1.0 / (total * grid.bin_area());
        let joint = joint.into_iter().map(|mass| mass * per_area).collect();
        let (moments, circular) = match &self.weights {
            Weights::Points(weights) => weighted_moments(phi, e, Some(weights), critical_e),
            Weights::Triangles { second, first } => {
                let (moments, circular) = weighted_moments(phi, e, Some(first), critical_e);
                (self.second_moments(phi, e, second, moments, circular.mean), circular)
            }
        };
        let moments = Moments { prob_above_critical_e: above / total, ..moments };
        Ok((Estimate::from_joint(*grid, joint, moments, circular), diagnostics))
    }

    fn nodes(&self, phi: &[f64], e: &[f64]) -> Vec<Node> {
        let states = phi.par_iter().zip(e).map(|(&phi, &e)| {
            let state = State::from_polar(phi, e);
            (state.x1, state.x2)
        });
        let (x1, x2): (Vec<f64>, Vec<f64>) = states.unzip();
        let (x1, x2) = match &self.refinement {
            Some(refinement) => (refinement.apply(&x1), refinement.apply(&x2)),
            None => (x1, x2),
        };
        let densities = &self.invariant_density;
        x1.par_iter().zip(&x2).zip(densities).map(|((&x1, &x2), &density)| Node::new(x1, x2, density)).collect()
    }

    /// Standard deviations and covariance of the flow that is linear in each triangle.
    fn second_moments(&self, phi: &[f64], e: &[f64], second: &[[f64; 6]], mean: Moments, centre: f64) -> Moments {
        let [total, var_phi, var_e, cov_phi_e] = ordered_sum(self.triangles.len(), |k| {
            let rows = self.triangles[k].map(|row| row as usize);
            let x = rows.map(|row| nearest(phi[row], centre) - mean.mean_phi);
            let y = rows.map(|row| e[row] - mean.mean_e);
            let [aa, bb, cc, ab, bc, ca] = second[k];
            let form = |p: [f64; 3], q: [f64; 3]| {
                let cross = |i: usize, j: usize| p[i] * q[j] + p[j] * q[i];
                let squares = aa * p[0] * q[0] + bb * p[1] * q[1] + cc * p[2] * q[2];
                squares + ab * cross(0, 1) + bc * cross(1, 2) + ca * cross(2, 0)
            };
            [self.mass[k], form(x, x), form(y, y), form(x, y)]
        });
        Moments {
            std_phi: (var_phi / total).sqrt(),
            std_e: (var_e / total).sqrt(),
            cov_phi_e: cov_phi_e / total,
            ..mean
        }
    }

    /// Probability of each bin, probability above the critical eccentricity, and diagnostics.
    fn share_out(&self, nodes: &[Node], grid: &Grid, critical_e: f64) -> (Vec<f64>, f64, MeshDiagnostics) {
        let count = self.triangles.len();
        let parts = parts(count, grid.len());
        let shares: Vec<Share> = (0..parts)
            .into_par_iter()
            .map(|part| {
                let mut share = Share::new(grid, critical_e);
                for k in count * part / parts..count * (part + 1) / parts {
                    let triangle = self.triangles[k].map(|node| nodes[node as usize]);
                    share.add(&triangle, self.mass[k], self.measure[k]);
                }
                share
            })
            .collect();
        let mut joint = vec![0.0; grid.len()];
        let mut diagnostics = MeshDiagnostics {
            triangles: count,
            flipped_triangles: 0,
            flipped_mass: 0.0,
            measure_defect: 0.0,
            truncated_mass: self.truncated_mass,
        };
        let mut above = 0.0;
        for share in shares {
            joint.iter_mut().zip(&share.joint).for_each(|(sum, mass)| *sum += mass);
            above += share.above;
            diagnostics.flipped_triangles += share.flipped;
            diagnostics.flipped_mass += share.flipped_mass;
            diagnostics.measure_defect += share.defect;
        }
        let total: f64 = self.mass.iter().sum();
        diagnostics.flipped_mass /= total;
        diagnostics.measure_defect /= total;
        (joint, above, diagnostics)
    }
}

impl Weights {
    fn of_triangles(triangles: &[[u32; 3]], second: Vec<[f64; 6]>, points: usize) -> Self {
        let mut first = vec![0.0; points];
        for (&[a, b, c], [aa, bb, cc, ab, bc, ca]) in triangles.iter().zip(&second) {
            first[a as usize] += aa + ab + ca;
            first[b as usize] += bb + ab + bc;
            first[c as usize] += cc + bc + ca;
        }
        Self::Triangles { second, first }
    }
}

/// What some of the triangles contribute to a snapshot.
struct Share {
    units: BinUnits,
    branch_low: f64,
    critical_e: f64,
    joint: Vec<f64>,
    above: f64,
    flipped: usize,
    flipped_mass: f64,
    defect: f64,
}

impl Share {
    fn new(grid: &Grid, critical_e: f64) -> Self {
        Self {
            units: BinUnits::new(grid),
            branch_low: grid.branch_low(),
            critical_e,
            joint: vec![0.0; grid.len()],
            above: 0.0,
            flipped: 0,
            flipped_mass: 0.0,
            defect: 0.0,
        }
    }

    fn add(&mut self, triangle: &[Node; 3], mass: f64, measure: f64) {
        let change = invariant_measure(triangle) / measure;
        self.defect += mass * if change.is_finite() { (change - 1.0).abs() } else { 1.0 };
        if change < 0.0 {
            self.flipped += 1;
            self.flipped_mass += mass;
        }
        let mut integral = 0.0;
        for_each_part(triangle, &mut |part| {
            integral += match part {
                Part::Triangle(corners) => Polygon::new(corners).integral().abs(),
                Part::Point { integral, .. } => integral.abs(),
            };
        });
        let scale = mass / integral;
        if scale.is_finite() {
            for_each_part(triangle, &mut |part| self.add_part(part, scale));
        } else {
            self.add_point(triangle[0].phi, triangle[0].e, mass);
        }
    }

    fn add_part(&mut self, part: &Part, scale: f64) {
        let corners = match part {
            Part::Triangle(corners) => corners,
            Part::Point { phi, e, integral } => return self.add_point(*phi, *e, scale * integral.abs()),
        };
        let above = share_above(corners, self.critical_e);
        if above > 0.0 {
            self.above += above * scale * Polygon::new(corners).integral().abs();
        }
        // A part turned over integrates to a negative number, but its probability is positive all the same.
        let scale = scale.copysign(twice_area(corners));
        let shift = fold(corners[0][0], self.branch_low) - corners[0][0];
        let shifted = corners.map(|[phi, e, n]| [phi + shift, e, n]);
        self.deposit(&shifted, scale);
        // A triangle across the cut of the circle shows at the other end as well.
        let turn = std::f64::consts::TAU;
        if shifted.iter().any(|corner| corner[0] < self.branch_low) {
            self.deposit(&shifted.map(|[phi, e, n]| [phi + turn, e, n]), scale);
        }
        if shifted.iter().any(|corner| corner[0] >= self.branch_low + turn) {
            self.deposit(&shifted.map(|[phi, e, n]| [phi - turn, e, n]), scale);
        }
    }

    /// Deposits a triangle; measured in bins, its integral changes by a factor that `scale` takes out again.
    fn deposit(&mut self, triangle: &[[f64; 3]; 3], scale: f64) {
        let measured = triangle.map(|corner| self.units.measure(corner));
        self.units.deposit(&measured, scale * self.units.bin_area(), &mut self.joint);
    }

    fn add_point(&mut self, phi: f64, e: f64, mass: f64) {
        if e > self.critical_e {
            self.above += mass;
        }
        let [x, y, _] = self.units.measure([fold(phi, self.branch_low), e, 0.0]);
        if let Some(bin) = self.units.bin(x, y) {
            self.joint[bin] += mass;
        }
    }
}

/// The lattice lines in standard deviations, outer and inner direction.
fn lattice_lines(standard: &[[f64; 2]], side: usize) -> Result<(Vec<f64>, Vec<f64>), MeshError> {
    const TOLERANCE: f64 = 1e-6;
    let points = side.saturating_mul(side);
    if points != standard.len() {
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
        None => Ok((outer, inner)),
    }
}

/// Two counter-clockwise triangles a cell.
fn lattice_triangles(side: usize) -> Vec<[u32; 3]> {
    let node = |i: usize, j: usize| (i * side + j) as u32;
    (0..(side - 1) * (side - 1))
        .flat_map(|cell| {
            let (i, j) = (cell / (side - 1), cell % (side - 1));
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect()
}
