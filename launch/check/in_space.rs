//! The right answers of scenarios in space: those of orbits of our own, in our own model.

use std::num::NonZeroUsize;

use density::flow::{Accuracy, Passages};
use density::in_space::SpaceProblem;
use density::in_space::sampled::Sampled;
use density::projected::of_samples;
use density::sampling::{Draws, SamplingPlan};
use kit::assignment::Assignment;
use kit::kind::{Estimated, Place};
use kit::space::Quantity;
use messages::content::Content;

use super::moments::{Compared, GENEROUS, SIGMAS, Unit};
use super::table::Table;

/// Our own orbits, and the independent replicates in which they are drawn. The clouds are small, so that these know
/// their moments to 1e-4 standard deviations.
const ORBITS: usize = 16_384;
const REPLICATES: usize = 16;

/// The quantities of the cloud at each snapshot, with our own errors.
#[derive(Debug)]
pub struct Right(Vec<Estimated>);

impl Right {
    /// The right answers of a scenario.
    ///
    /// # Errors
    /// Why our own orbits cannot be followed.
    pub fn new(problem: &SpaceProblem, assignment: &Assignment) -> Result<Self, String> {
        let replicates = NonZeroUsize::new(REPLICATES).unwrap_or(NonZeroUsize::MIN);
        let plan = SamplingPlan { draws: Draws::Sobol, seed: 1, replicates };
        let sampled = Sampled { problem, simplification: None, plan, accuracy: Accuracy::Medium };
        let lost = |why: String| format!("our own orbits cannot be followed: {why}");
        let mut cloud = sampled.cloud(0..ORBITS).map_err(|why| lost(why.to_string()))?;
        let mut passed = vec![0; ORBITS];
        let mut columns = vec![0.0; problem.variables().len() * ORBITS];
        let mut at = |(index, &time): (usize, &f64)| {
            let passages = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
            cloud.advance_watching(time, problem.critical_e, passages).map_err(|why| lost(why.to_string()))?;
            cloud.read_out(&mut columns);
            let columns: Vec<&[f64]> = columns.chunks_exact(ORBITS).collect();
            let place = Place { assignment, index };
            Ok(Estimated::of_cloud(&place.ask(|question| of_samples(&columns, question, Some(REPLICATES))), &place))
        };
        problem.times.iter().enumerate().map(&mut at).collect::<Result<_, _>>().map(Self)
    }

    /// The moments of a snapshot beside the right ones.
    pub fn compared(&self, assignment: &Assignment, table: &Table, found: &Estimated) -> Vec<Compared> {
        let (space, Some(right)) = (&assignment.space, self.0.get(table.index)) else { return Vec::new() };
        let deviation = |k: usize| {
            let place = space.place(Quantity::Deviation(k));
            place.and_then(|place| right.values.get(place)).copied().unwrap_or(f64::NAN)
        };
        let one = |(place, quantity): (usize, Quantity)| {
            let scale = match quantity {
                Quantity::Mean(k) | Quantity::Deviation(k) | Quantity::CircularMean(k) => deviation(k),
                Quantity::Covariance(a, b) => deviation(a) * deviation(b),
                Quantity::AboveCritical | Quantity::ResultantLength(_) => 1.0,
            };
            let ours = right.errors[place];
            let (allowed, unit) = match table.snapshot.content {
                // Samples that are all on one side of the critical eccentricity have no standard error.
                Content::Samples(_) if quantity == Quantity::AboveCritical => {
                    let p = right.values[place];
                    (SIGMAS * (p * (1.0 - p) / table.rows()).sqrt() + 25.0 / table.rows(), Unit::StandardErrors)
                }
                Content::Samples(_) => (SIGMAS * found.errors[place].hypot(ours), Unit::StandardErrors),
                _ => (GENEROUS * scale, Unit::Deviations),
            };
            Compared {
                what: format!("{} at {} yr", space.in_words(quantity), table.time()),
                seen: found.values[place],
                right: right.values[place],
                is_angle: space.is_angle(quantity),
                allowed,
                unit,
            }
        };
        space.moments().into_iter().enumerate().map(one).collect()
    }
}
