//! Unaveraged orbits, read out as averages over a revolution.
//!
//! Results of averaged and unaveraged models are compared in the same variables, so the osculating elements, which
//! oscillate within a revolution, are not what is read out: the eccentricity and angular momentum vectors are averaged
//! over one revolution centred on the time, and solar angle, eccentricity, inclination and node are those of the
//! averages.

use rayon::prelude::*;

use super::VARIABLES;
use super::cloud::Cloud;
use crate::flow::{Flow, Passages};
use crate::model::elements::Elements;
use crate::model::irradiated::WithRadiation;
use crate::model::osculating::Osculating;
use crate::model::osculating::mean::mean_vectors;
use crate::model::shadow::ShadowedOsculating;
use crate::model::uncertain_radiation::Scale;
use crate::model::{Coordinates, Model, irradiated::Irradiated};
use crate::orbits::{LostOrbit, Orbits};

/// A model whose first six coordinates are the state of the unaveraged model.
pub trait Unaveraged: Model {
    /// The unaveraged model, with any radiation parameter.
    fn nominal(&self) -> &Osculating;
}

impl Unaveraged for Osculating {
    fn nominal(&self) -> &Osculating {
        self
    }
}

impl Unaveraged for ShadowedOsculating {
    fn nominal(&self) -> &Osculating {
        &self.model
    }
}

impl<S: Scale, M: Unaveraged + Irradiated<S>> Unaveraged for WithRadiation<M, S> {
    fn nominal(&self) -> &Osculating {
        self.model.nominal()
    }
}

/// Number of orbits that a thread takes at a time: two batches of the integrator.
const SET: usize = 32;
/// A revolution takes hours, and a year of a set of orbits about a second: how far all are moved at a time \[yr\].
const STRIDE: f64 = 0.02;

/// Unaveraged orbits.
#[derive(Debug)]
pub struct MeanCloud<M> {
    sets: Vec<Orbits<M>>,
    orbits: usize,
    time: f64,
    /// The variables of the averages, orbit by orbit.
    means: Vec<[f64; 5]>,
}

impl<M: Unaveraged> MeanCloud<M> {
    /// Orbits whose osculating variables at `t = 0` are in these columns.
    pub fn new(flow: Flow<M>, columns: &[Vec<f64>]) -> Self {
        let orbits = columns.first().map_or(0, Vec::len);
        let set = |first: usize| {
            let columns: Vec<&[f64]> = columns.iter().map(|column| &column[first..orbits.min(first + SET)]).collect();
            Orbits::from_variables(flow, &columns)
        };
        let sets = (0..orbits).step_by(SET).map(set).collect();
        Self { sets, orbits, time: 0.0, means: Vec::new() }
    }
}

/// The error of the first set that has one, whose orbits are counted from the first of all.
fn first_error<T>(results: Vec<Result<T, LostOrbit>>) -> Result<Vec<T>, LostOrbit> {
    let counted = |(set, result): (usize, Result<T, LostOrbit>)| result.map_err(|lost| lost.counted_from(set * SET));
    results.into_iter().enumerate().map(counted).collect()
}

impl<M: Unaveraged> Cloud for MeanCloud<M> {
    fn advance_watching(
        &mut self,
        time: f64,
        critical: f64,
        Passages { passages, pending, note }: Passages<'_, u8>,
    ) -> Result<(), LostOrbit> {
        let sets = self.sets.par_iter_mut().zip(passages.par_chunks_mut(SET));
        let moved = sets
            .map(|(orbits, passages)| orbits.advance_watching(time, critical, Passages { passages, pending, note }));
        first_error(moved.collect()).map(|_| self.time = time)
    }

    fn stride(&self) -> Option<f64> {
        Some(STRIDE)
    }

    fn settle(&mut self) -> Result<(), LostOrbit> {
        let means = self.sets.par_iter().map(|orbits| means(orbits, self.time)).collect();
        self.means = first_error(means)?.concat();
        Ok(())
    }

    fn read_out(&self, columns: &mut [f64]) {
        for (k, column) in columns.chunks_exact_mut(self.orbits.max(1)).enumerate() {
            column.iter_mut().zip(&self.means).for_each(|(place, mean)| *place = mean[k]);
        }
    }
}

/// The variables of the averages of some orbits; the last is the radiation parameter where that is a variable.
fn means<M: Unaveraged>(orbits: &Orbits<M>, time: f64) -> Result<Vec<[f64; 5]>, LostOrbit> {
    let model = &orbits.flow.model;
    let vectors = mean_vectors(&orbits.flow, model.nominal(), time, orbits.columns())
        .map_err(|escaped| orbits.lost(escaped, time))?;
    let variables = |(i, vectors): (usize, crate::model::elements::Vectors)| {
        let Elements { eccentricity, inclination, node, longitude_of_pericentre } = vectors.elements();
        let phi = model.nominal().solar_angle(time, longitude_of_pericentre);
        let state = Coordinates::from_fn(|k| orbits.columns()[k][i]);
        let osculating = model.read_out(time, state);
        let of_ellipse = VARIABLES.len() + 2;
        let radiation = if M::VARIABLES.len() > of_ellipse { osculating.component(of_ellipse) } else { f64::NAN };
        [phi, eccentricity, inclination, node, radiation]
    };
    Ok(vectors.into_iter().enumerate().map(variables).collect())
}
