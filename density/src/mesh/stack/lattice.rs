//! The lattice of a stack, and its layers where the flow has carried them, with those between them by polynomials.

use super::layer::{LayerMesh, Middles};
use super::points;
use crate::exact::measure::normal_density;
use crate::mesh::lattice::{check_degree, lattice_lines, stencil};
use crate::mesh::points::unfold;
use crate::mesh::{MeshError, check_points};
use crate::uncertain::UncertainProblem;

/// A stack of carried meshes, ready to be carried.
#[derive(Debug, Clone)]
pub struct Stack {
    pub(super) problem: UncertainProblem,
    pub(super) side: usize,
    pub(super) degree: usize,
    /// The third variable of each layer, in standard deviations.
    pub(super) levels: Vec<f64>,
    pub(super) layer: LayerMesh,
}

impl Stack {
    /// The stack of the initial points in these columns, solar angle, eccentricity and third variable: layers of `side`
    /// by `side` points.
    ///
    /// # Errors
    /// [`MeshError`] if the columns are no such lattice, or if the degree does not fit it.
    pub fn new(
        problem: &UncertainProblem,
        [phi, e, third]: [&[f64]; 3],
        side: usize,
        degree: usize,
    ) -> Result<Self, MeshError> {
        let layers = points::layers_of(phi.len(), side);
        check_points(phi, e, layers.saturating_mul(side.saturating_pow(2)))?;
        check_degree(degree, side.min(layers))?;
        let levels = points::levels(problem, [phi, e, third], (side, layers))?;
        let initial = &problem.plane.initial;
        let (phi, e) = (&phi[..side * side], &e[..side * side]);
        let unfolded = unfold(initial, phi, e, side);
        let standard: Vec<[f64; 2]> = unfolded.iter().zip(e).map(|(&p, &e)| initial.standardise(p, e).into()).collect();
        let layer = LayerMesh::new(initial, lattice_lines(&standard, side)?, degree)?;
        Ok(Self { problem: problem.clone(), side, degree, levels, layer })
    }

    /// The weight of a layer at `z` in a sum of step 1.
    pub(super) fn density(&self, z: f64) -> f64 {
        normal_density(z) / self.problem.mass_inside()
    }

    /// The third variable in standard deviations at a position, counted in layers.
    pub(super) fn z_at(&self, position: f64) -> f64 {
        self.levels[0] + position * (self.levels[1] - self.levels[0])
    }

    /// Whether the distribution is cut at the lowest layer.
    pub(super) fn is_cut(&self) -> bool {
        self.levels[0] <= self.problem.lowest() + 1e-9
    }
}

/// A stack whose points the flow has carried.
pub(super) struct Carried<'a> {
    pub(super) stack: &'a Stack,
    pub(super) x1: Vec<f64>,
    pub(super) x2: Vec<f64>,
}

impl Carried<'_> {
    /// The states in the middle of the gap after layer `gap`.
    pub(super) fn middles(&self, gap: usize) -> Middles {
        let position = gap as f64 + 0.5;
        self.stack.layer.middles(&self.states(position), self.rough_states(position).as_ref())
    }

    /// The states of the layer at a position, counted in layers of the lattice.
    pub(super) fn states(&self, position: f64) -> [Vec<f64>; 2] {
        if position.fract() == 0.0 {
            let size = self.stack.side * self.stack.side;
            let first = position as usize * size;
            return [&self.x1, &self.x2].map(|values| values[first..first + size].to_vec());
        }
        self.between_layers(position, self.stack.degree)
    }

    /// The same by polynomials two degrees lower, of a layer between those of the lattice.
    pub(super) fn rough_states(&self, position: f64) -> Option<[Vec<f64>; 2]> {
        let degree = self.stack.degree.checked_sub(2).filter(|degree| *degree > 0)?;
        Some(self.between_layers(position, degree))
    }

    fn between_layers(&self, position: f64, degree: usize) -> [Vec<f64>; 2] {
        let Stack { side, levels, .. } = self.stack;
        let size = side * side;
        let lines: Vec<f64> = (0..levels.len()).map(|k| k as f64).collect();
        let stencil = stencil(&lines, position as usize, degree, position);
        let of = |values: &[f64]| (0..size).map(|i| stencil.sum(degree, |k| values[k * size + i])).collect();
        [of(&self.x1), of(&self.x2)]
    }
}
