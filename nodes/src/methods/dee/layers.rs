//! Characteristics in layers, one for each value of an uncertain radiation parameter.

use std::fmt::Debug;
use std::ops::Range;

use density::first_passage::over_leaves::{Passed, curve_on_lattices};
use density::flow::{Accuracy, Flow};
use density::mesh::stack::{Layers, cubic_lattice};
use density::model::plane::{State, density_growth};
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::orbits::{LostOrbit, Orbits};
use density::uncertain::{UncertainProblem, UncertainTask};
use kit::failure::Failure;
use messages::content::Lattice;

use super::settings::{LAYERS, Settings};

/// Lines per side of the lattices from which first passages follow: enough for a mean over many values of the
/// parameter.
const PASSAGE_LINES: usize = 31;

/// The characteristics of a scenario whose radiation parameter is uncertain.
#[derive(Debug)]
pub(super) struct LayersWork {
    problem: UncertainProblem,
    accuracy: Accuracy,
    degree: usize,
    layers: Layers,
    /// The points that this process propagates.
    range: Range<usize>,
    orbits: Box<dyn Carried>,
}

impl LayersWork {
    /// The points of the case, of which `part` says the share of this process from their number.
    pub(super) fn new(
        problem: &UncertainProblem,
        settings: &Settings,
        accuracy: Accuracy,
        part: impl FnOnce(usize) -> Result<Range<usize>, Failure>,
    ) -> Result<Self, Failure> {
        let degree = settings.check_layers().map_err(Failure::Refused)?;
        let layers = cubic_lattice(problem, LAYERS.saturating_mul(settings.samples))?;
        let range = part(layers.len())?;
        let starts: Vec<[f64; 3]> = range.clone().map(|row| layers.point(row)).collect();
        let orbits = problem.perform(Start { starts: &starts, accuracy });
        Ok(Self { problem: problem.clone(), accuracy, degree, layers, range, orbits })
    }

    /// Number of points of the whole case.
    pub(super) fn total(&self) -> usize {
        self.layers.len()
    }

    /// Number of points of this process.
    pub(super) fn rows(&self) -> usize {
        self.range.len()
    }

    pub(super) fn lattice(&self) -> Lattice {
        Lattice { side: self.layers.third.len() as u32, degree: self.degree as u32 }
    }

    pub(super) fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let time = self.problem.plane.times[index];
        self.orbits.advance_to(time).map_err(|lost| lost.counted_from(self.range.start))?;
        Ok(self.range.len())
    }

    /// Writes solar angle, eccentricity and third variable of the points, and the density in the three that each
    /// carries: the flow changes neither the third variable nor the density in it.
    pub(super) fn write(&self, columns: &mut [f64]) {
        const VARIABLES: usize = 3;
        let rows = self.range.len();
        let (variables, n) = columns.split_at_mut(VARIABLES * rows);
        self.orbits.read_out(variables);
        let (phi, e) = (&variables[..rows], &variables[rows..2 * rows]);
        for (k, row) in self.range.clone().enumerate() {
            let [phi0, e0, third] = self.layers.point(row);
            let start = self.problem.plane.initial.density(phi0, e0) * self.problem.third_density(third);
            let growth = density_growth(State::from_polar(phi0, e0), State::from_polar(phi[k], e[k]));
            n[k] = if start > 0.0 { start * growth } else { 0.0 };
        }
    }

    /// The first-passage curve, and what re-entry says of the radiation parameter.
    pub(super) fn passed(&self, times: &[f64]) -> Result<Vec<Passed>, Failure> {
        let side = self.layers.third.len().min(PASSAGE_LINES);
        let degree = self.degree.min(side - 1);
        Ok(curve_on_lattices(&self.problem, self.accuracy, (side, degree), times)?)
    }
}

/// Orbits of a model in three variables.
trait Carried: Debug {
    fn advance_to(&mut self, time: f64) -> Result<(), LostOrbit>;

    /// Writes the variables, one column after the other.
    fn read_out(&self, columns: &mut [f64]);
}

impl<S: Scale> Carried for Orbits<UncertainRadiation<S>> {
    fn advance_to(&mut self, time: f64) -> Result<(), LostOrbit> {
        Orbits::advance_to(self, time)
    }

    fn read_out(&self, columns: &mut [f64]) {
        self.read_out_columns(&mut columns.chunks_exact_mut(self.len().max(1)).collect::<Vec<_>>());
    }
}

/// Starts orbits at points in three variables.
struct Start<'a> {
    starts: &'a [[f64; 3]],
    accuracy: Accuracy,
}

impl UncertainTask for Start<'_> {
    type Output = Box<dyn Carried>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let columns = [0, 1, 2].map(|k| self.starts.iter().map(|start| start[k]).collect::<Vec<f64>>());
        let flow = Flow { model, accuracy: self.accuracy };
        Box::new(Orbits::from_variables(flow, &columns.each_ref().map(Vec::as_slice)))
    }
}
