//! First passage time of every orbit of a sample.
//!
//! Orbits are carried in segments ([`super::segments`]). In a segment `f = e² - e_crit²` is followed by the quintic
//! through value, slope and second derivative at both ends. In the paper's model
//!
//! ```text
//! f' = 2 n_sun C s x1      f'' = 2 n_sun C (s x1' - n_sun C x1²)
//! ```
//!
//! The eccentricity peaks where `x1 = 0`, so a peak between the ends cannot hide. Where the bound `max(f_a, f_b) +
//! max|f''| h²/8` reaches zero, the quintic decides; where its peak is too close to zero to decide, the orbit is
//! carried to the peak itself. The passage is then the root of `f` along the true orbit. Orbits that have passed are
//! carried no further.

use rayon::prelude::*;

use crate::flow::{Escaped, Flow};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::plane::{PlanarHamiltonian, State};

use super::{Quintic, segments};

/// Number of orbits that a thread takes at a time.
const CHUNK: usize = 1024;
/// Smallest distance from zero, in `e²`, of a quintic's peak that decides.
const DECISIVE: f64 = 1e-4;
/// Largest number of root-finding steps.
const MOST_STEPS: usize = 12;
/// Accuracy of a root \[yr\], at which root-finding ends.
const SMALL_STEP: f64 = 1e-13;

/// First time \[yr\] within `[0, end]` at which the orbit `(x1[i], x2[i])` has `e >= critical_e`; infinite if there is
/// none.
///
/// # Errors
/// [`Escaped`] if an orbit leaves `e < 1` within the segment of its passage.
///
/// # Panics
/// If the slices differ in length.
pub fn first_passage_times<M: PlanarHamiltonian>(
    flow: &Flow<M>,
    x1: &[f64],
    x2: &[f64],
    critical_e: f64,
    end: f64,
) -> Result<Vec<f64>, Escaped> {
    assert_eq!(x1.len(), x2.len(), "one x1 for every x2");
    let mut times = vec![f64::INFINITY; x1.len()];
    (times.par_chunks_mut(CHUNK).zip(x1.par_chunks(CHUNK)).zip(x2.par_chunks(CHUNK)))
        .enumerate()
        .map(|(chunk, ((times, x1), x2))| {
            let threshold = Threshold::new(flow, critical_e, end);
            threshold.pass(times, x1, x2).map_err(|escaped| Escaped { index: chunk * CHUNK + escaped.index, ..escaped })
        })
        .reduce(|| Ok(()), Result::and)?;
    Ok(times)
}

struct Threshold<'a, M> {
    flow: &'a Flow<M>,
    critical_e: f64,
    segments: usize,
    segment: f64,
    /// Upper bound of the height of a peak above the ends of its segment.
    headroom: f64,
}

/// An orbit that passes, or may pass, in the segment.
struct Candidate {
    /// Position among the active orbits.
    position: usize,
    /// Years from the start of the segment.
    time: f64,
    /// Whether it is already certain that the orbit passes.
    certain: bool,
}

/// `f` and its first two derivatives.
pub(crate) fn excess(model: &impl PlanarHamiltonian, critical_e: f64, state: State) -> [f64; 3] {
    let f = state.x1 * state.x1 + state.x2 * state.x2 - critical_e * critical_e;
    let [slope, bend] = model.eccentricity_squared_rates(state);
    [f, slope, bend]
}

impl<'a, M: PlanarHamiltonian> Threshold<'a, M> {
    fn new(flow: &'a Flow<M>, critical_e: f64, end: f64) -> Self {
        let segments = segments(&flow.model, critical_e, end);
        let segment = end / segments as f64;
        let turning = |e: f64| flow.model.turning_rate(State { x1: 0.0, x2: e });
        let (pull, g) = (flow.model.pull(), turning(0.0).max(turning(critical_e)));
        let bend = 2.0 * SUN_MEAN_MOTION.powi(2) * pull * (2.0 * pull + g * critical_e);
        Self { flow, critical_e, segments, segment, headroom: 0.125 * bend * segment * segment }
    }

    fn excess(&self, state: State) -> [f64; 3] {
        excess(&self.flow.model, self.critical_e, state)
    }

    /// Fills in the times of a chunk's orbits.
    fn pass(&self, times: &mut [f64], x1: &[f64], x2: &[f64]) -> Result<(), Escaped> {
        let state = |i: usize| State { x1: x1[i], x2: x2[i] };
        let mut active: Vec<usize> = (0..times.len()).collect();
        active.retain(|&i| {
            let above = self.excess(state(i))[0] >= 0.0;
            if above {
                times[i] = 0.0;
            }
            !above
        });
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = active.iter().map(|&i| (x1[i], x2[i])).unzip();
        for k in 0..self.segments {
            let start = self.segment * k as f64;
            let before = (x1.clone(), x2.clone());
            let locate = |escaped: Escaped| Escaped { index: active[escaped.index], ..escaped };
            self.flow.advance(&mut x1, &mut x2, self.segment).map_err(locate)?;
            let candidates = self.candidates(&before, (&x1, &x2));
            let passed = self.refine(&before, candidates).map_err(locate)?;
            let mut stays = vec![true; active.len()];
            for (position, time) in passed {
                times[active[position]] = start + time;
                stays[position] = false;
            }
            let keep = |values: &mut Vec<f64>| {
                let mut stays = stays.iter();
                values.retain(|_| *stays.next().unwrap_or(&true));
            };
            keep(&mut x1);
            keep(&mut x2);
            let mut stay = stays.iter();
            active.retain(|_| *stay.next().unwrap_or(&true));
        }
        Ok(())
    }

    /// Orbits that pass, or may pass, in the segment between two sets of states.
    fn candidates(&self, before: &(Vec<f64>, Vec<f64>), after: (&[f64], &[f64])) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        for position in 0..after.0.len() {
            let start = State { x1: before.0[position], x2: before.1[position] };
            let end = State { x1: after.0[position], x2: after.1[position] };
            let value = |state: State| state.x1 * state.x1 + state.x2 * state.x2 - self.critical_e * self.critical_e;
            if value(end) < 0.0 && value(start).max(value(end)) + self.headroom < 0.0 {
                continue;
            }
            let (start, end) = (self.excess(start), self.excess(end));
            let quintic = Quintic::new(start, end, self.segment);
            let peak = if end[0] >= 0.0 { Some(self.segment) } else { quintic.peak() };
            let Some(until) = peak else { continue };
            let peak = quintic.at(until);
            if end[0] >= 0.0 || peak > DECISIVE {
                candidates.push(Candidate { position, time: quintic.first_rise(until), certain: true });
            } else if peak > -DECISIVE {
                candidates.push(Candidate { position, time: until, certain: false });
            }
        }
        candidates
    }

    /// The passages among the candidates: position and years from the start of the segment.
    fn refine(
        &self,
        before: &(Vec<f64>, Vec<f64>),
        mut candidates: Vec<Candidate>,
    ) -> Result<Vec<(usize, f64)>, Escaped> {
        // An uncertain orbit is carried to its peak, where x1 = 0 and f' = 0.
        let mut doubtful: Vec<Candidate> = candidates.extract_if(.., |candidate| !candidate.certain).collect();
        self.solve(before, &mut doubtful, |[_, slope, bend]| -slope / bend)?;
        let peaks = self.at(before, &doubtful)?;
        for (mut candidate, [peak, _, bend]) in doubtful.into_iter().zip(peaks) {
            if peak >= 0.0 && candidate.time > 0.0 {
                candidate.time = (candidate.time - (-2.0 * peak / bend).max(0.0).sqrt()).max(0.0);
                candidates.push(candidate);
            }
        }
        // The nearest root of the parabola through f, f', f'': near a peak, a step from the slope alone is misleading.
        self.solve(before, &mut candidates, |[f, slope, bend]| {
            let discriminant = slope * slope - 2.0 * f * bend;
            if slope > 0.0 && discriminant >= 0.0 { -2.0 * f / (slope + discriminant.sqrt()) } else { -slope / bend }
        })?;
        Ok(candidates.iter().map(|candidate| (candidate.position, candidate.time)).collect())
    }

    /// Moves the candidates' times by `step`, a function of `f`, `f'`, `f''`, until the steps are small.
    fn solve(
        &self,
        before: &(Vec<f64>, Vec<f64>),
        candidates: &mut [Candidate],
        step: impl Fn([f64; 3]) -> f64,
    ) -> Result<(), Escaped> {
        for _ in 0..MOST_STEPS {
            let mut largest: f64 = 0.0;
            for (candidate, excess) in self.at(before, candidates)?.into_iter().enumerate() {
                let time = &mut candidates[candidate].time;
                let step = step(excess);
                let moved = (*time + if step.is_finite() { step } else { 0.0 }).clamp(0.0, self.segment);
                // Convergence is of third order: a step whose cube is small leaves an error that is smaller still.
                largest = largest.max((moved - *time).abs());
                *time = moved;
            }
            if largest < SMALL_STEP.cbrt() * 0.1 {
                break;
            }
        }
        Ok(())
    }

    /// `f`, `f'`, `f''` of the candidates at their times.
    fn at(&self, before: &(Vec<f64>, Vec<f64>), candidates: &[Candidate]) -> Result<Vec<[f64; 3]>, Escaped> {
        let mut x1: Vec<f64> = candidates.iter().map(|c| before.0[c.position]).collect();
        let mut x2: Vec<f64> = candidates.iter().map(|c| before.1[c.position]).collect();
        let years: Vec<f64> = candidates.iter().map(|c| c.time).collect();
        let locate = |escaped: Escaped| Escaped { index: candidates[escaped.index].position, ..escaped };
        self.flow.advance_each(&mut x1, &mut x2, &years).map_err(locate)?;
        Ok(x1.iter().zip(&x2).map(|(&x1, &x2)| self.excess(State { x1, x2 })).collect())
    }
}
