//! One layer of a stack: sums over its cloud, and how well its polynomials resolve the flow.

use crate::angle::nearest;
use crate::grid::Grid;
use crate::mesh::carried::judge_cells;
use crate::mesh::gaussian::{Standard, standard_density};
use crate::mesh::lattice::Refinement;
use crate::mesh::quadrature::{Quadrature, Whole};
use crate::mesh::{MeshDiagnostics, MeshError};
use crate::model::plane::State;
use crate::problem::InitialGaussian;

/// What all layers have in common.
#[derive(Debug, Clone)]
pub(super) struct LayerMesh {
    initial: InitialGaussian,
    lines: [Vec<f64>; 2],
    quadrature: Quadrature,
    /// The polynomials in the middle of each cell, and those two degrees lower.
    middles: Refinement,
    rougher: Option<Refinement>,
}

/// The states in the middle of each cell.
#[derive(Debug, Clone)]
pub(super) struct Middles {
    /// By the polynomials.
    pub states: [Vec<f64>; 2],
    /// By polynomials of a lower degree, in the layer and between the layers.
    pub others: Vec<[Vec<f64>; 2]>,
}

/// Sums over clouds.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// Of 1, phi, e, phi², phi e and e², less a centre.
    pub powers: [f64; 6],
    /// Of the third variable less its mean, alone and times phi and e.
    pub with_third: [f64; 3],
    /// Of sine and cosine of phi.
    pub vector: [f64; 2],
    /// Probability above the critical eccentricity.
    pub above: f64,
    /// Probability that is counted in a wrong bin at most.
    pub misplaced: f64,
    /// Probability of each bin.
    pub joint: Vec<f64>,
}

impl Sums {
    /// Of no cloud at all.
    pub(super) fn zero(grid: &Grid) -> Self {
        Self {
            powers: [0.0; 6],
            with_third: [0.0; 3],
            vector: [0.0; 2],
            above: 0.0,
            misplaced: 0.0,
            joint: vec![0.0; grid.len()],
        }
    }

    fn each(&mut self) -> impl Iterator<Item = &mut f64> {
        let few = self.powers.iter_mut().chain(&mut self.with_third).chain(&mut self.vector);
        few.chain([&mut self.above, &mut self.misplaced]).chain(&mut self.joint)
    }

    /// Adds other sums, times a weight.
    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        let few = other.powers.iter().chain(&other.with_third).chain(&other.vector);
        let terms = few.chain([&other.above, &other.misplaced]).chain(&other.joint);
        self.each().zip(terms).for_each(|(sum, term)| *sum += weight * term);
    }

    /// Multiplies all by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        self.each().for_each(|sum| *sum *= factor);
    }
}

impl LayerMesh {
    /// The layers with these lattice lines in standard deviations, interpolated to `degree`.
    pub(super) fn new(initial: &InitialGaussian, lines: [Vec<f64>; 2], degree: usize) -> Result<Self, MeshError> {
        let refined = |degree: usize| Refinement::new(&lines[0], &lines[1], degree, 1);
        let middles = refined(degree)?;
        let rougher = if degree > 2 { Some(refined(degree - 2)?) } else { None };
        let quadrature = Quadrature::of_many(lines.clone(), degree);
        Ok(Self { initial: *initial, lines, quadrature, middles, rougher })
    }

    /// The points of the layer with these states.
    pub(super) fn whole(&self, [x1, x2]: &[Vec<f64>; 2]) -> Whole {
        self.quadrature.whole_cells(x1, x2)
    }

    /// The points of a layer.
    pub(super) fn quadrature(&self) -> &Quadrature {
        &self.quadrature
    }

    /// The probability of a cell, by the density in its middle.
    pub(super) fn cell_mass(&self, cell: usize) -> f64 {
        let cells = self.lines[1].len() - 1;
        let width = |axis: usize, k: usize| self.lines[axis][k + 1] - self.lines[axis][k];
        standard_density(self.middle(cell)) * width(0, cell / cells) * width(1, cell % cells)
    }

    fn middle(&self, cell: usize) -> Standard {
        let cells = self.lines[1].len() - 1;
        let middle = |lines: &[f64], k: usize| lines[k].midpoint(lines[k + 1]);
        [middle(&self.lines[0], cell / cells), middle(&self.lines[1], cell % cells)]
    }

    /// Where a point of the lattice starts.
    pub(super) fn node(&self, k: usize) -> Standard {
        let side = self.lines[1].len();
        [self.lines[0][k / side], self.lines[1][k % side]]
    }

    /// The sums over the cloud with these states, whose points are `whole`. `third` is the layer's distance from the
    /// mean of the third variable; `share` says at which place in its part of the cloud each point is counted.
    pub(super) fn sums(
        &self,
        ([x1, x2], whole): (&[Vec<f64>; 2], Whole),
        grid: &Grid,
        centre: [f64; 2],
        critical_e: f64,
        (third, share): (f64, [f64; 2]),
    ) -> Sums {
        let mut sums = Sums::zero(grid);
        let mut counted = 0.0;
        let bin = [grid.phi.width(), grid.e.width()];
        sums.misplaced = self.quadrature.spread(&whole, share, bin, |phi, e, weight| {
            counted += weight;
            if e > critical_e {
                sums.above += weight;
            }
            if let Some(bin) = grid.bin(phi, e) {
                sums.joint[bin] += weight;
            }
        });
        (sums.powers, sums.vector) = self.quadrature.power_sums([x1, x2], centre, whole);
        // The places differ from layer to layer; the probability of a layer does not.
        let scale = sums.powers[0] / counted;
        sums.above *= scale;
        sums.joint.iter_mut().for_each(|bin| *bin *= scale);
        sums.with_third = [third * sums.powers[0], third * sums.powers[1], third * sums.powers[2]];
        sums
    }

    /// The states in the middles of the cells; `rough` has the states by polynomials of a lower degree in the third
    /// variable.
    pub(super) fn middles(&self, states: &[Vec<f64>; 2], rough: Option<&[Vec<f64>; 2]>) -> Middles {
        let by = |refinement: &Refinement, states: &[Vec<f64>; 2]| {
            states.each_ref().map(|values| {
                let [values, ..] = refinement.middles(values);
                values
            })
        };
        let in_layer = self.rougher.as_ref().map(|rougher| by(rougher, states));
        let between = rough.map(|rough| by(&self.middles, rough));
        Middles { states: by(&self.middles, states), others: in_layer.into_iter().chain(between).collect() }
    }

    /// How well the polynomials resolve the flow where they are used: not in the cells that are marked as `direct`.
    pub(super) fn judge(
        &self,
        states: &[Vec<f64>; 2],
        rough: Option<&[Vec<f64>; 2]>,
        grid: &Grid,
        direct: &[bool],
    ) -> MeshDiagnostics {
        let lines = [self.lines[0].as_slice(), &self.lines[1]];
        let judged = judge_cells(&self.initial, lines, &self.middles, [&states[0], &states[1]], direct);
        let Middles { states, others } = self.middles(states, rough);
        let cell = |cell: usize| (direct.get(cell) != Some(&true), standard_density(self.middle(cell)));
        let misplaced_mass = others.iter().map(|other| moved(&states, other, cell, grid)).sum();
        MeshDiagnostics { misplaced_mass, ..judged }
    }
}

/// Mean distance of states from others, in bins and at most one, where `cell` says whether a state is used and how
/// dense the cloud was there.
fn moved(states: &[Vec<f64>; 2], others: &[Vec<f64>; 2], cell: impl Fn(usize) -> (bool, f64), grid: &Grid) -> f64 {
    let polar = |[x1, x2]: &[Vec<f64>; 2], k: usize| {
        let state = State { x1: x1[k], x2: x2[k] };
        (state.x1.atan2(state.x2), state.eccentricity())
    };
    let one = |k: usize| {
        let ((phi, e), (other_phi, other_e)) = (polar(states, k), polar(others, k));
        let bins = nearest(phi - other_phi, 0.0).abs() / grid.phi.width() + (e - other_e).abs() / grid.e.width();
        let (is_used, density) = cell(k);
        (if is_used { density * bins.min(1.0) } else { 0.0 }, density)
    };
    let (moved, total) = (0..states[0].len()).map(one).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    moved / total
}
