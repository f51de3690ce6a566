//! How far a simpler model, or a model without one of its forces, moves the figures of a cloud.
//!
//! All variants move the same orbits, drawn in independent replicates of a scrambled Sobol sequence. The difference of
//! two variants is taken replicate by replicate, so that what they have in common cancels, and its standard error
//! follows from the spread of these differences (common random numbers: Owen, *Monte Carlo theory, methods and
//! examples*, 2013, Sect. 8.6).

use std::num::NonZeroUsize;

use super::sampled::Sampled;
use super::{REENTRY, SpaceProblem, VARIABLES};
use crate::angle::nearest;
use crate::flow::{Accuracy, Passages};
use crate::model::model_name::ModelName;
use crate::orbits::LostOrbit;
use crate::problem_error::ProblemError;
use crate::projected::{Question, of_samples};
use crate::sampling::{Draws, SamplingPlan, group};

/// Number of replicates.
pub const REPLICATES: usize = 16;
/// What is compared of a cloud: mean and deviation of each variable, the probability above the critical eccentricity,
/// and that of ever having reached it.
pub const QUANTITIES: usize = 2 * VARIABLES.len() + 2;

/// A model that is compared with a fuller one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// The model in which orbits move, if not in the problem's.
    pub simplification: Option<ModelName>,
    /// The force that is left out, if one is.
    pub without: Option<&'static str>,
}

impl Variant {
    /// The model in which orbits of the problem move.
    pub fn model(&self, problem: &SpaceProblem) -> ModelName {
        self.simplification.unwrap_or(problem.model.model_name())
    }
}

/// The variants that are compared, each with the one that it simplifies.
pub fn comparisons(problem: &SpaceProblem) -> Vec<(Variant, Variant)> {
    let own = Variant { simplification: None, without: None };
    let simplified = |name| Variant { simplification: Some(name), ..own };
    let simpler = std::iter::successors(problem.model.model_name().next_simpler(), |name| name.next_simpler());
    // Forces are left out where that costs little: in the fullest averaged model.
    let averaged = match problem.model.is_averaged() {
        true => own,
        false => simpler.clone().find(|name| name.is_averaged()).map_or(own, simplified),
    };
    let lacking = problem.acting().into_iter().map(|force| (averaged, Variant { without: Some(force), ..averaged }));
    simpler.map(|name| (own, simplified(name))).chain(lacking).collect()
}

/// The figures of a cloud at one snapshot, of all orbits and of each replicate.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    whole: [f64; QUANTITIES],
    replicates: Vec<[f64; QUANTITIES]>,
    /// How many orbits there are.
    orbits: usize,
}

/// An event that none of `n` independent orbits shows may still have a probability of this, divided by `n`: the upper
/// end of the exact 95 % interval (Clopper & Pearson, Biometrika 26, 1934).
const UNSEEN: f64 = 3.7;

/// A figure of a variant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Its value in the variant.
    pub value: f64,
    /// By how much it is larger than in the fuller model.
    pub shift: f64,
    /// The standard error of that difference.
    pub error: f64,
}

/// Why figures cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Trouble {
    /// An orbit cannot be followed.
    #[error("{0}")]
    Lost(#[from] LostOrbit),
    /// The model asks for more than the problem states.
    #[error("{0}")]
    Problem(#[from] ProblemError),
}

/// The figures of a variant at each snapshot, from this number of orbits in each replicate; `progress` hears of every
/// stride, as a time \[yr\].
///
/// # Errors
/// [`Trouble`] if an orbit cannot be followed.
pub fn figures(
    problem: &SpaceProblem,
    variant: Variant,
    orbits: usize,
    seed: u64,
    progress: &dyn Fn(f64),
) -> Result<Vec<Figures>, Trouble> {
    let problem = variant.without.map_or_else(|| problem.clone(), |force| problem.without(force));
    let total = orbits * REPLICATES;
    let plan = SamplingPlan {
        draws: Draws::Sobol,
        seed,
        replicates: NonZeroUsize::new(REPLICATES).unwrap_or(NonZeroUsize::MIN),
    };
    let accuracy = Accuracy::Medium;
    let sampled = Sampled { problem: &problem, simplification: variant.simplification, plan, accuracy };
    let mut cloud = sampled.cloud(0..total)?;
    let mut passed = vec![0u8; total];
    let mut now = 0.0;
    let mut all = Vec::new();
    for &time in &problem.times {
        loop {
            let next = cloud.stride().map_or(time, |stride| time.min(now + stride));
            let passages = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
            cloud.advance_watching(next, problem.critical_e, passages)?;
            now = next;
            progress(now);
            if next == time {
                break;
            }
        }
        cloud.settle()?;
        let mut columns = vec![0.0; problem.variables().len() * total];
        cloud.read_out(&mut columns);
        let columns: Vec<&[f64]> = columns.chunks_exact(total).take(VARIABLES.len()).collect();
        let of = |rows: Vec<usize>| of_rows(&columns, &passed, &rows, problem.critical_e);
        let members = |replicate: usize| (0..total).filter(|&row| group(row, REPLICATES) == replicate).collect();
        let replicates = (0..REPLICATES).map(|replicate| of(members(replicate))).collect();
        all.push(Figures { whole: of((0..total).collect()), replicates, orbits: total });
    }
    Ok(all)
}

/// The figures of some orbits.
fn of_rows(columns: &[&[f64]], passed: &[u8], rows: &[usize], critical_e: f64) -> [f64; QUANTITIES] {
    let circles = VARIABLES.each_ref().map(|variable| variable.is_circle());
    let question = Question { circles: &circles, projections: &[], critical: (REENTRY, critical_e) };
    let own: Vec<Vec<f64>> = columns.iter().map(|column| rows.iter().map(|&row| column[row]).collect()).collect();
    let cloud = of_samples(&own.iter().map(Vec::as_slice).collect::<Vec<_>>(), &question, None);
    let ever = rows.iter().filter(|&&row| passed[row] > 0).count() as f64 / rows.len() as f64;
    std::array::from_fn(|q| match q / 2 {
        k if k < VARIABLES.len() && q % 2 == 0 => cloud.mean[k],
        k if k < VARIABLES.len() => cloud.covariance[k][k].sqrt(),
        _ if q % 2 == 0 => cloud.above,
        _ => ever,
    })
}

impl Figures {
    /// How far each figure is from that of a fuller model.
    pub fn against(&self, fuller: &Self) -> [Shift; QUANTITIES] {
        std::array::from_fn(|q| {
            let is_angle = q % 2 == 0 && q / 2 < VARIABLES.len() && VARIABLES[q / 2].is_circle();
            let difference = |a: f64, b: f64| if is_angle { nearest(a - b, 0.0) } else { a - b };
            let shift = difference(self.whole[q], fuller.whole[q]);
            let pairs = self.replicates.iter().zip(&fuller.replicates);
            // Replicates of an angle may lie on either side of a turn's end.
            let beyond = |off: f64| if is_angle { nearest(off, 0.0) } else { off };
            let off: Vec<f64> = pairs.map(|(a, b)| beyond(difference(a[q], b[q]) - shift)).collect();
            let count = off.len() as f64;
            let mean = off.iter().sum::<f64>() / count;
            let squares: f64 = off.iter().map(|off| (off - mean).powi(2)).sum();
            let error = (squares / ((count - 1.0) * count)).sqrt();
            // Where no orbit of all differs, their spread says nothing: a share of up to 3.7/n may differ all the same,
            // with 95 % probability.
            let is_probability = q / 2 >= VARIABLES.len();
            let least = if is_probability { 0.5 * UNSEEN / self.orbits as f64 } else { 0.0 };
            Shift { value: self.whole[q], shift, error: error.max(least) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;

    fn shifts(variant: Variant, orbits: usize) -> [Shift; QUANTITIES] {
        let problem = example::problem();
        let own = Variant { simplification: None, without: None };
        let of = |variant| figures(&problem, variant, orbits, 3, &|_| {}).unwrap();
        of(variant)[2].against(&of(own)[2])
    }

    #[test]
    fn a_force_that_is_weak_moves_the_figures_by_little_and_is_seen_through_the_sampling_error() {
        let variant = Variant { simplification: None, without: Some("moon") };
        let [_, _, e, ..] = shifts(variant, 64);
        assert!(e.shift.abs() > 5.0 * e.error && e.shift.abs() < 0.05, "{e:?}");
        // More orbits find the same shift.
        let [_, _, more, ..] = shifts(variant, 256);
        assert!((more.shift - e.shift).abs() < 4.0 * e.error.hypot(more.error), "{e:?} {more:?}");
    }

    #[test]
    fn a_probability_that_no_orbit_shows_is_not_said_to_be_zero_for_sure() {
        let [.., above, ever] = shifts(Variant { simplification: None, without: Some("moon") }, 16);
        let least = 0.5 * UNSEEN / (16 * REPLICATES) as f64;
        assert!(above.error >= least && ever.error >= least, "{above:?} {ever:?}");
    }

    #[test]
    fn nothing_is_said_of_inclination_and_node_in_the_plane() {
        let shifts = shifts(Variant { simplification: Some(ModelName::Planar), without: None }, 16);
        assert!(shifts[2].shift.is_finite() && shifts[4..8].iter().all(|shift| shift.shift.is_nan()), "{shifts:?}");
    }

    #[test]
    fn every_force_and_every_simpler_model_is_compared_with_the_fuller_one() {
        let comparisons = comparisons(&example::problem());
        let names: Vec<_> = comparisons.iter().map(|(_, variant)| (variant.simplification, variant.without)).collect();
        let forces = ["srp", "j2", "sun", "moon"].map(|force| (None, Some(force)));
        assert_eq!(names, [&[(Some(ModelName::Planar), None)][..], &forces].concat());
    }
}
