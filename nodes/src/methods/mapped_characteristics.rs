//! Characteristics in the plane that move by a flow map: points of a lattice, and the density that each carries,
//! changed by the determinant of the map's derivative.
//!
//! Liouville's theorem gives the same density in closed form, from which the map's own is off as far as the map is: the
//! estimator compares both and reports the difference among the diagnostics.

use std::ops::Range;
use std::sync::Arc;

use density::flow::Flow;
use density::flow_map::draw::one_by_one;
use density::flow_map::{AngleMap, AngleOrbits, FlowMap, MappedOrbits};
use density::mesh::Points;
use density::model::plane::State;
use density::model::registry::Planar;
use density::problem::Problem;
use kit::Form;
use kit::failure::Failure;
use messages::content::{Characteristics, Lattice};
use rayon::prelude::*;

use crate::methods::map_refusal::{self, Asked, By};
use crate::methods::mapped_samples::Mapping;

/// The characteristics of a case on their way.
#[derive(Debug)]
pub struct MappedCharacteristics {
    problem: Problem<Planar>,
    /// The points of the whole case at the start.
    start: Arc<Points>,
    /// Those of this process.
    range: Range<usize>,
    moved: Moved,
    index: usize,
}

/// The points as orbits of either map.
#[derive(Debug)]
enum Moved {
    Cells(MappedOrbits<Planar, 2>),
    Angles(AngleOrbits<Planar>),
}

impl MappedCharacteristics {
    /// The points at the start.
    ///
    /// # Errors
    /// A map that is refused.
    pub fn new(
        problem: &Problem<Planar>,
        start: Points,
        range: Range<usize>,
        mapping: Mapping,
    ) -> Result<Self, Failure> {
        let flow = Flow { model: problem.model, accuracy: mapping.accuracy };
        let start = Arc::new(start);
        let points = Arc::clone(&start);
        let draw = one_by_one(move |number| [points.phi[number], points.e[number]]);
        let numbers = range.clone();
        let asked = Asked { by: mapping.by, may_be_by_angle: true };
        let moved = match mapping.by {
            By::Cells => FlowMap::new(flow, problem.initial.into(), &problem.times, None, &mapping.map)
                .map(|map| Moved::Cells(MappedOrbits::new(map, numbers, draw))),
            By::ActionAngle => AngleMap::new(flow, &problem.initial, &problem.times, None, &mapping.map)
                .map(|map| Moved::Angles(AngleOrbits::new(map, numbers, draw))),
        };
        let moved = moved.map_err(|refused| map_refusal::in_words(&refused, asked))?;
        Ok(Self { problem: problem.clone(), start, range, moved, index: 0 })
    }

    /// What is sent of them.
    pub fn form(&self, degree: usize) -> Form {
        let lattice = self.start.lattice.map(|side| Lattice { side: side as u32, degree: degree as u32 });
        let content = Characteristics::CarriedMesh { lattice }.into();
        Form { content, most_rows: self.range.len(), total_rows: self.start.phi.len() }
    }

    /// Moves the points to a snapshot and returns how many there are.
    ///
    /// # Errors
    /// The point that cannot be followed.
    pub fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.index = index;
        let critical = self.problem.critical_e;
        match &mut self.moved {
            Moved::Cells(orbits) => orbits.advance_watching(index, critical)?,
            Moved::Angles(orbits) => orbits.advance_watching(index, critical)?,
        }
        Ok(self.range.len())
    }

    /// Writes the points and the density that each carries.
    pub fn write(&self, columns: &mut [f64]) {
        let [phi, e, n] = Characteristics::columns(columns);
        match &self.moved {
            Moved::Cells(orbits) => orbits.read_out_columns(&mut [&mut *phi, &mut *e]),
            Moved::Angles(orbits) => orbits.read_out_columns(phi, e),
        }
        let time = self.problem.times[self.index];
        n.par_iter_mut().enumerate().for_each(|(row, n)| {
            let number = self.range.start + row;
            let (phi0, e0) = (self.start.phi[number], self.start.e[number]);
            let end = State::from_polar(phi[row], e[row]);
            let density = self.problem.initial.density(phi0, e0);
            let growth = || match &self.moved {
                Moved::Cells(orbits) => orbits.map().growth(&[phi0, e0], end, self.index),
                Moved::Angles(orbits) => orbits.map().growth(State::from_polar(phi0, e0), end, time),
            };
            *n = if density > 0.0 { density * growth() } else { 0.0 };
        });
    }

    /// Orbits that were propagated: those of the map, and the points that it left.
    pub fn orbits(&self) -> usize {
        match &self.moved {
            Moved::Cells(orbits) => orbits.map().summary().orbits + orbits.direct(),
            Moved::Angles(orbits) => orbits.map().summary().orbits + orbits.direct(),
        }
    }

    /// The estimate of the map's error.
    pub fn error(&self) -> f64 {
        match &self.moved {
            Moved::Cells(orbits) => orbits.map().summary().error,
            Moved::Angles(orbits) => orbits.map().summary().error,
        }
    }
}
