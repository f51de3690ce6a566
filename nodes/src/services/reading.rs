//! A density message, decoded: the figures of a cloud at a snapshot, in the scenario's space.

use std::sync::Arc;

use density::grid::Axis;
use messages::layout::DensityHeader;
use messages::scenario::Projection;

use kit::assignment::Assignment;
use kit::space::{Quantity, Space};

/// A decoded message of the density topic.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The header.
    pub header: DensityHeader,
    /// The space of the scenario.
    pub space: Arc<Space>,
    /// The scenario's axes at this snapshot, one per variable.
    pub axes: Vec<Axis>,
    /// The quantities, their standard errors, and the densities.
    numbers: Vec<f64>,
}

impl Reading {
    /// Reads a message on a density of this scenario.
    ///
    /// # Errors
    /// What does not fit the scenario.
    pub fn new(header: DensityHeader, numbers: &[f64], assignment: &Assignment) -> Result<Self, String> {
        let Some(axes) = assignment.axes.get(header.index as usize) else {
            return Err(format!("snapshot {} of {}", header.index, assignment.axes.len()));
        };
        let reading = Self { header, space: assignment.space.clone(), axes: axes.clone(), numbers: numbers.to_vec() };
        let (quantities, expected) = (reading.quantities(), reading.start_of(reading.space.projections.len()));
        if header.quantities as usize != quantities || numbers.len() != expected {
            return Err(format!(
                "{} numbers with {} quantities, the scenario has {expected} with {quantities}",
                numbers.len(),
                header.quantities
            ));
        }
        Ok(reading)
    }

    /// How many numbers a message on a snapshot of this scenario has.
    pub fn numbers_of(assignment: &Assignment) -> usize {
        let cells: usize = assignment.space.projections.iter().map(cells).sum();
        2 * assignment.space.quantities().len() + cells
    }

    fn quantities(&self) -> usize {
        self.space.quantities().len()
    }

    fn start_of(&self, projection: usize) -> usize {
        2 * self.quantities() + self.space.projections[..projection].iter().map(cells).sum::<usize>()
    }

    /// All quantities of the cloud, in the order of the space.
    pub fn values(&self) -> &[f64] {
        &self.numbers[..self.quantities()]
    }

    /// A quantity; NaN if the method withholds it, or if the space does not have it.
    pub fn value(&self, quantity: Quantity) -> f64 {
        self.space.place(quantity).map_or(f64::NAN, |place| self.values()[place])
    }

    /// The standard errors of all quantities, in the order of the space; NaN where the method has none.
    pub fn errors(&self) -> &[f64] {
        &self.numbers[self.quantities()..2 * self.quantities()]
    }

    /// The standard error of a quantity; NaN if the method has none.
    pub fn error(&self, quantity: Quantity) -> f64 {
        self.space.place(quantity).map_or(f64::NAN, |place| self.errors()[place])
    }

    /// The density on a projection, first variable outermost.
    pub fn density(&self, projection: usize) -> &[f64] {
        &self.numbers[self.start_of(projection)..self.start_of(projection + 1)]
    }

    /// The density on the first projection.
    pub fn joint(&self) -> &[f64] {
        self.density(0)
    }

    /// Length or area of a bin of a projection.
    pub fn cell(&self, projection: usize) -> f64 {
        self.space.projections[projection].axes().map(|(variable, _)| self.axes[variable].width()).product()
    }

    /// The density of a variable by itself, with its axis, where it is a projection and not withheld.
    pub fn marginal(&self, variable: usize) -> Option<(&[f64], Axis)> {
        let is_it = |projection: &Projection| projection.first.0 == variable && projection.second.is_none();
        let place = self.space.projections.iter().position(is_it)?;
        let is_there = self.header.mass_on_grid.is_finite() && self.header.mass_on_grid > 0.0;
        is_there.then(|| (self.density(place), self.axes[variable]))
    }
}

/// Number of bins of a projection.
fn cells(projection: &Projection) -> usize {
    projection.axes().map(|(_, bins)| bins).product()
}
