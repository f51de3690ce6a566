//! Where and how a Gaussian is split, so that the flow over each of its parts is nearly linear.
//!
//! The Gaussian is a tree of parts ([`super::pieces`]). A part is carried through all snapshots by a stencil of points,
//! which give how far the flow over it is from linear ([`super::curvature`]); where that is more than the part may
//! have, it is split in the direction in which the flow is most nonlinear. The width of the new parts is found by
//! trial: parts that still bend too much in that direction are thrown away for narrower ones, since to split them once
//! more in the same direction would need many more.
//!
//! ```text
//! largest D_c = tolerance max(1, (w_0/w)^(1/2)),   w_0 = 1e-4
//! ```
//!
//! is what a part of the weight `w` may have: parts that weigh less may be less linear. And no part may add more than
//! `w E_c = 1e-8` to the error of the moments. The parts that exceed this most are split first; no more are made than
//! are allowed.

use rayon::prelude::*;

use super::curvature::Curvature;
use super::differences::{places, points};
use super::error::MixtureError;
use super::fifth_degree;
use super::part::Part;
use super::pieces::{Piece, Position};
use super::unscented::Unscented;
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::{Coordinates, Model};
use crate::sampling::draw_variables;
use crate::variable_moments::weighted_moments;

/// In a round those parts are split whose priority is at least this share of the largest.
const ROUND: f64 = 0.2;
/// The narrowest and the widest parts of a split, in standard deviations of what is split.
const NARROWEST: f64 = 0.03;
const WIDEST: f64 = 0.75;
/// The narrowest parts of a split for the sake of the moments.
const NARROWEST_FOR_MOMENTS: f64 = 0.2;
/// Narrowest first trial, since differences over a whole part say little of how narrow parts must be.
const FIRST_TRIAL: f64 = 0.15;
/// Number of widths tried in a split.
const TRIALS: usize = 4;
/// The width of parts that are split because they reach across a bound of a variable.
const AT_A_BOUND: f64 = 0.5;
/// A part that reaches across a bound is left out if it weighs less than this.
const NEGLIGIBLE: f64 = 1e-6;
/// Orbits and seed of the sample from which the deviations of the cloud are taken.
const SAMPLE: usize = 1_000;
const SEED: u64 = 1;

/// How finely a Gaussian is split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// The largest disagreement of a component that counts.
    pub tolerance: f64,
    /// The largest number of components.
    pub components: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Self { tolerance: 0.15, components: 60_000 }
    }
}

/// Parts whose disagreement is known, with the probability left out among them and the number of orbits that this took.
#[derive(Debug, Clone, Default)]
struct Judged<const N: usize> {
    parts: Vec<Part<N>>,
    left_out: f64,
    trajectories: usize,
}

/// The work of splitting a Gaussian.
#[derive(Debug, Clone)]
pub(super) struct Splitting<M, const N: usize> {
    pub flow: Flow<M>,
    pub initial: Gaussian<N>,
    pub times: Vec<f64>,
    fineness: Fineness,
    distance: f64,
    /// How far from its centre the outermost point of a part may lie, in standard deviations.
    reach: f64,
    pub places: Vec<[f64; N]>,
    /// Standard deviations of the whole cloud at each time.
    deviations: Vec<[f64; N]>,
    /// Parts that may have to be split.
    open: Vec<Part<N>>,
    /// Parts that stay as they are.
    pub done: Vec<Part<N>>,
    pub left_out: f64,
    pub trajectories: usize,
}

impl<M: Model<Variables = [f64; N]>, const N: usize> Splitting<M, N> {
    pub fn new(
        flow: Flow<M>,
        initial: Gaussian<N>,
        times: Vec<f64>,
        unscented: Unscented,
        fineness: Fineness,
    ) -> Result<Self, MixtureError> {
        if let Some(&time) = times.iter().find(|time| !time.is_finite()) {
            return Err(MixtureError::Time(time));
        }
        let distance = unscented.distance_squared_in(N).sqrt();
        let start = draw_variables(&initial, M::VARIABLES, SEED, 0..SAMPLE);
        let states = (0..SAMPLE).map(|i| flow.model.state(0.0, std::array::from_fn(|k| start[k][i])));
        let mut columns = vec![Vec::with_capacity(SAMPLE); M::State::<f64>::COUNT];
        for state in states {
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
        }
        let (mut deviations, mut now) = (Vec::new(), 0.0);
        for &time in &times {
            flow.carry(&mut columns.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>(), now, time)?;
            now = time;
            let read = |i: usize| flow.model.read_out(time, Coordinates::from_fn(|k| columns[k][i]));
            let points: Vec<[f64; N]> = (0..SAMPLE).map(read).collect();
            let variables: [Vec<f64>; N] = std::array::from_fn(|k| points.iter().map(|point| point[k]).collect());
            let variables = variables.each_ref().map(Vec::as_slice);
            deviations.push(weighted_moments(M::VARIABLES, variables, None).deviations());
        }
        let places = places(distance);
        let reach = if N <= fifth_degree::MOST_VARIABLES { distance.max(fifth_degree::REACH) } else { distance };
        let (open, done) = (Vec::new(), Vec::new());
        let (left_out, trajectories) = (0.0, SAMPLE);
        let mut whole = Self {
            flow,
            initial,
            times,
            fineness,
            distance,
            reach,
            places,
            deviations,
            open,
            done,
            left_out,
            trajectories,
        };
        let judged = whole.judged(vec![Piece::whole()])?;
        whole.open = whole.count(judged);
        Ok(whole)
    }

    /// Splits the parts for which that matters most, unless every part may stay as it is, or there are as many as
    /// allowed. Returns whether there is more to do.
    pub fn split_once(&mut self) -> Result<bool, MixtureError> {
        let Fineness { tolerance, components } = self.fineness;
        let (mut bent, fine): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.open).into_iter().partition(|part| part.excess(tolerance).largest() > 1.0);
        self.done.extend(fine);
        bent.sort_by(|a, b| b.priority(tolerance).total_cmp(&a.priority(tolerance)));
        let Some(first) = bent.first().map(|part| part.priority(tolerance)) else { return Ok(false) };
        // Those that matter less wait, so that they do not take the room.
        let waiting = bent.split_off(bent.partition_point(|part| part.priority(tolerance) >= ROUND * first));
        let split: Vec<Judged<N>> =
            bent.par_iter().map(|part| self.split(part, tolerance)).collect::<Result<_, _>>()?;
        let mut open = waiting;
        let mut pairs = bent.into_iter().zip(split);
        while let Some((part, judged)) = pairs.next() {
            if self.done.len() + open.len() + pairs.len() + judged.parts.len() > components {
                // There is no room: what is bent stays so, and the disagreement says it.
                let bent = [part].into_iter().chain(pairs.map(|(part, _)| part)).chain(open);
                let (across, inside): (Vec<_>, Vec<_>) = bent.partition(|part| part.across.is_some());
                self.left_out += across.iter().map(|part| part.piece.weight).sum::<f64>();
                self.done.extend(inside);
                return Ok(false);
            }
            open.extend(self.count(judged));
        }
        self.open = open;
        Ok(true)
    }

    /// The share of the probability whose parts stay as they are.
    pub fn share_done(&self) -> f64 {
        (self.left_out + self.done.iter().map(|part| part.piece.weight).sum::<f64>()).min(1.0)
    }

    /// Counts what parts cost and what was left out among them.
    fn count(&mut self, Judged { parts, left_out, trajectories }: Judged<N>) -> Vec<Part<N>> {
        self.left_out += left_out;
        self.trajectories += trajectories;
        parts
    }

    /// Splits a part in the direction in which it needs that most.
    fn split(&self, part: &Part<N>, tolerance: f64) -> Result<Judged<N>, MixtureError> {
        if let Some(direction) = part.across {
            return self.judged(part.piece.split(direction, AT_A_BOUND));
        }
        let Some([bent, off]) = &part.worst else { return Ok(Judged::default()) };
        let excess = part.excess(tolerance);
        if excess.moments > excess.disagreement {
            // With the width of the parts their weight falls, and E_c with its square or its fourth power.
            let s = (0.5 / excess.moments).cbrt().clamp(NARROWEST_FOR_MOMENTS, WIDEST);
            return self.judged(part.piece.split(off.whole.direction(), s));
        }
        let direction = bent.local.direction();
        // Half of what is allowed is for the other directions.
        let allowed = 0.5 * part.allowed(tolerance);
        let enough = |s: &f64| bent.local.after_split(direction, *s) <= allowed;
        let widths = || std::iter::successors(Some(WIDEST), |s| Some(s / 1.1)).take_while(|s| *s > NARROWEST);
        let mut s = widths().find(enough).unwrap_or(NARROWEST).max(FIRST_TRIAL);
        let mut trajectories = 0;
        for trial in 1..=TRIALS {
            let judged = self.judged(part.piece.split(direction, s))?;
            trajectories += judged.trajectories;
            let needed = Self::narrower(&judged.parts, tolerance);
            if trial == TRIALS || needed > 0.8 || s <= NARROWEST {
                return Ok(Judged { trajectories, ..judged });
            }
            s = (s * needed.max(0.3)).max(NARROWEST);
        }
        Ok(Judged::default())
    }

    /// The factor by which the parts of a split, whose first axis is its direction, should be narrower: a mean over
    /// those that disagree by too much.
    fn narrower(parts: &[Part<N>], tolerance: f64) -> f64 {
        let first = std::array::from_fn(|k| f64::from(k == 0));
        let (mut sum, mut weights) = (0.0, 0.0);
        for part in parts.iter().filter(|part| part.across.is_none()) {
            let Some([bent, _]) = &part.worst else { continue };
            let allowed = 0.5 * part.allowed(tolerance);
            let left = bent.local.after_split(first, 1.0);
            // A bend falls with the square of the width, a twist with the width.
            sum += part.piece.weight * (allowed / left.max(1e-300)).powf(0.6).min(1.0);
            weights += part.piece.weight;
        }
        if weights > 0.0 { sum / weights } else { 1.0 }
    }

    /// Carries the points of parts through all times. Parts outside the ranges of the variables are left out.
    fn judged(&self, pieces: Vec<Piece<N>>) -> Result<Judged<N>, MixtureError> {
        let (mut parts, mut left_out) = (Vec::new(), 0.0);
        let mut inside = Vec::new();
        for piece in pieces {
            let across = match piece.position(&self.initial, M::VARIABLES, self.reach) {
                Position::Inside => None,
                Position::Across(_) if piece.weight < NEGLIGIBLE => {
                    left_out += piece.weight;
                    continue;
                }
                Position::Across(direction) => Some(direction),
                Position::Outside => continue,
            };
            if across.is_none() {
                inside.push(parts.len());
            }
            parts.push(Part::new(piece, self.times.len(), across));
        }
        let size = points(N);
        let mut columns = vec![Vec::with_capacity(size * inside.len()); M::State::<f64>::COUNT];
        for &part in &inside {
            for &place in &self.places {
                let state = self.flow.model.state(0.0, parts[part].piece.point(&self.initial, place));
                columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
            }
        }
        let trajectories = size * inside.len();
        let mut now = 0.0;
        for (index, &time) in self.times.iter().enumerate() {
            let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
            self.flow.carry(&mut slices, now, time)?;
            now = time;
            let read = |row: usize| self.flow.model.read_out(time, Coordinates::from_fn(|k| columns[k][row]));
            let of = |position: usize| {
                let carried: Vec<[f64; N]> = (position * size..(position + 1) * size).map(read).collect();
                Curvature::new(M::VARIABLES, &carried, self.distance, self.deviations[index])
            };
            let found: Vec<Curvature<N>> = (0..inside.len()).into_par_iter().map(of).collect();
            inside.iter().zip(found).for_each(|(&part, found)| parts[part].learn(index, found));
        }
        Ok(Judged { parts, left_out, trajectories })
    }
}
