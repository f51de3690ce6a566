//! All orbits of a cloud: integrals over the cloud are integrals over the orbits that it is made of.
//!
//! An orbit is given by a point `q` of the axis ([`super::axis`]), and `dH = h'(q) dq`. So the mean of a function `f`
//! of the state at time `t` is
//!
//! ```text
//! E[f] = ∫ dq h'(q) ∮ dθ a(θ; q) f(state(θ + n_sun t; q))
//! ```
//!
//! Only the outer integral is left to be refined. Its integrand is smooth except at the points where orbits change
//! their kind. These points are ends of intervals, and the refinement closes in on them geometrically. Nothing in it
//! grows with `t` except the number of turns by which neighbouring orbits come apart.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use rayon::prelude::*;

use crate::flow::Flow;
use crate::model::plane::{PlanarHamiltonian, State};

use super::adaptive::{Interval, kronrod_error, remove, worst};
use super::axis::Axis;
use super::contour::Contour;
use super::detail::Detail;
use super::hamiltonian_range::range_within;
use super::measure::Measure;
use super::rules::POINTS;
use super::share::Share;
use super::trail::Trail;

/// Number of orbits that a thread traces at a time.
const BATCH: usize = 15;
/// Distance from the mean out to which the points lie whose orbits show where the cloud lies, in standard deviations.
const PILOT_REACH: f64 = 6.0;

/// An orbit with its share of the initial probability.
#[derive(Debug)]
pub(crate) struct Orbit {
    /// `h'(q)`: the width in `H` of a unit of `q`.
    pub width: f64,
    /// The orbit itself.
    pub contour: Contour,
    /// The initial probability along it, per unit of `H`.
    pub share: Share,
    trail: OnceLock<Trail>,
}

impl Orbit {
    /// Points on the orbit, close enough together for cubic interpolation.
    pub(crate) fn trail(&self, model: &impl PlanarHamiltonian) -> &Trail {
        self.trail.get_or_init(|| Trail::new(&self.contour, model))
    }
}

/// The orbits of a cloud.
#[derive(Debug)]
pub(crate) struct Family<M> {
    pub flow: Flow<M>,
    pub measure: Measure,
    /// The intervals of `q` at the start, as pairs of their ends.
    first: Vec<(f64, f64)>,
    /// Smallest share of an orbit that matters: the inverse of the cloud's width in `H`.
    scale: f64,
    detail: Detail,
    known: Mutex<HashMap<u64, Option<Arc<Orbit>>>>,
}

impl<M: PlanarHamiltonian> Family<M> {
    /// The orbits of the cloud `measure`; an orbit that touches the circle `e = critical_e` is the end of an interval.
    pub(crate) fn new(flow: &Flow<M>, measure: Measure, critical_e: f64, detail: Detail) -> Self {
        let axis = Axis::new(flow.model);
        let pilots = pilots(&axis, &measure, detail.pilots);
        let parts = axis.within(range_within(&flow.model, &measure, detail.radius));
        let special = axis.special_points(critical_e);
        let first = parts.iter().flat_map(|&part| intervals(part, &special, &pilots, detail)).collect();
        let levels = pilots.iter().map(|&q| axis.hamiltonian(q));
        let (low, high) = levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        let scale = 1.0 / (high - low).max(1e-12);
        Self { flow: *flow, measure, first, scale, detail, known: Mutex::default() }
    }

    /// The intervals of `q` to begin with.
    pub(crate) fn first_intervals(&self) -> Vec<Interval> {
        self.first.iter().map(|&(low, high)| Interval { low, high }).collect()
    }

    fn known(&self) -> MutexGuard<'_, HashMap<u64, Option<Arc<Orbit>>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The orbits at the nodes of an interval; `None` for one that leaves the disc `e < 1`.
    pub(crate) fn orbits(&self, interval: Interval) -> Vec<Option<Arc<Orbit>>> {
        let points = interval.nodes().map(|(q, ..)| q);
        let mut orbits: Vec<Option<Option<Arc<Orbit>>>> = {
            let known = self.known();
            points.iter().map(|q| known.get(&q.to_bits()).cloned()).collect()
        };
        let missing: Vec<usize> = (0..POINTS).filter(|&k| orbits[k].is_none()).collect();
        let traced = missing.chunks(BATCH).flat_map(|batch| {
            let qs: Vec<f64> = batch.iter().map(|&k| points[k]).collect();
            let contours = Contour::trace(&self.flow, &qs);
            qs.into_iter().zip(contours).map(|(q, contour)| contour.map(|contour| Arc::new(self.orbit(q, contour))))
        });
        let traced: Vec<_> = missing.iter().copied().zip(traced).collect();
        let mut known = self.known();
        for (k, orbit) in traced {
            if known.len() < self.detail.kept {
                known.insert(points[k].to_bits(), orbit.clone());
            }
            orbits[k] = Some(orbit);
        }
        orbits.into_iter().map(Option::flatten).collect()
    }

    fn orbit(&self, q: f64, contour: Contour) -> Orbit {
        let share = Share::new(&self.measure, &contour, self.scale, self.detail);
        Orbit { width: self.flow.model.slope_on_axis(q), contour, share, trail: OnceLock::new() }
    }

    /// The integrals over all orbits of `count` functions of an orbit. They are refined until their errors meet
    /// `tolerances`, a function of the values and errors reached, or until `most_orbits` have been taken.
    pub(crate) fn integrate(
        &self,
        intervals: Vec<Interval>,
        count: usize,
        function: impl Fn(&Orbit) -> Vec<f64> + Sync,
        tolerances: impl Fn(&[f64], &[f64]) -> Vec<f64>,
        most_orbits: usize,
    ) -> Integrals {
        let mut panels: Vec<OrbitPanel> = Vec::new();
        let mut pending = intervals;
        let mut orbits = 0;
        loop {
            orbits += pending.len() * POINTS;
            let fresh = pending.par_iter().map(|&interval| self.panel(interval, count, &function));
            panels.extend(fresh.collect::<Vec<_>>());
            panels.sort_by(|a, b| a.interval.low.total_cmp(&b.interval.low));
            let sum = |of: fn(&OrbitPanel) -> &Vec<f64>| -> Vec<f64> {
                (0..count).map(|f| panels.iter().map(|panel| of(panel)[f]).sum()).collect()
            };
            let (values, errors) = (sum(|panel| &panel.values), sum(|panel| &panel.errors));
            let tolerances = tolerances(&values, &errors);
            let shares: Vec<f64> = panels.iter().map(|panel| panel.share_of_error(&errors, &tolerances)).collect();
            let most = most_orbits.saturating_sub(orbits) / (2 * POINTS);
            let worst = worst(&shares, most, |i| panels[i].interval.can_be_halved());
            if worst.is_empty() {
                let intervals = panels.iter().map(|panel| panel.interval).collect();
                let lost = panels.iter().map(|panel| panel.lost).sum();
                return Integrals { values, errors, lost, orbits, intervals };
            }
            pending = worst.iter().flat_map(|&i| panels[i].interval.halves()).collect();
            remove(&mut panels, &worst);
        }
    }

    fn panel(&self, interval: Interval, count: usize, function: &(impl Fn(&Orbit) -> Vec<f64> + Sync)) -> OrbitPanel {
        let (mut kronrod, mut gauss, mut size) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let mut lost = 0;
        for ((_, kronrod_weight, gauss_weight), orbit) in interval.nodes().iter().zip(self.orbits(interval)) {
            let Some(orbit) = orbit else {
                lost += 1;
                continue;
            };
            if orbit.share.total() == 0.0 {
                continue;
            }
            for (f, value) in function(&orbit).into_iter().enumerate() {
                kronrod[f] += kronrod_weight * orbit.width * value;
                gauss[f] += gauss_weight * orbit.width * value;
                size[f] += kronrod_weight * orbit.width * value.abs();
            }
        }
        let errors = (0..count).map(|f| kronrod_error(kronrod[f] - gauss[f], size[f])).collect();
        OrbitPanel { interval, values: kronrod, errors, lost }
    }
}

/// Integrals over all orbits.
#[derive(Debug, Clone)]
pub(crate) struct Integrals {
    pub values: Vec<f64>,
    /// Error estimates.
    pub errors: Vec<f64>,
    /// Number of nodes whose orbits leave the disc `e < 1`.
    pub lost: usize,
    /// Number of orbits taken.
    pub orbits: usize,
    /// The intervals that were needed.
    pub intervals: Vec<Interval>,
}

/// An interval of `q` with its part of the integrals.
struct OrbitPanel {
    interval: Interval,
    /// By the Kronrod rule.
    values: Vec<f64>,
    errors: Vec<f64>,
    lost: usize,
}

impl OrbitPanel {
    /// The largest ratio of the panel's error to the tolerance, over the functions whose tolerance is not met.
    fn share_of_error(&self, errors: &[f64], tolerances: &[f64]) -> f64 {
        let unmet = (0..errors.len()).filter(|&f| errors[f] > tolerances[f]);
        unmet.map(|f| self.errors[f] / tolerances[f].max(f64::MIN_POSITIVE)).fold(0.0, f64::max)
    }
}

/// The points `q` of the orbits through points all over the cloud, ascending.
fn pilots(axis: &Axis<impl PlanarHamiltonian>, measure: &Measure, side: u32) -> Vec<f64> {
    let at = |i: u32| PILOT_REACH * (2.0 * f64::from(i) / f64::from(side - 1) - 1.0);
    let point = |k: u32| {
        let (phi, e) = measure.gaussian.point(at(k / side), at(k % side));
        (e > 0.0 && e < 1.0).then(|| axis.orbit_of(State::from_polar(phi, e))).flatten()
    };
    let mut points: Vec<f64> = (0..side * side).filter_map(point).collect();
    points.sort_by(f64::total_cmp);
    points
}

/// A part of the axis, cut at its special points, between the pilots, and at the first and the last pilot if that is
/// wanted.
fn intervals((low, high): (f64, f64), special: &[f64], pilots: &[f64], detail: Detail) -> Vec<(f64, f64)> {
    let here: Vec<f64> = pilots.iter().copied().filter(|q| (low..=high).contains(q)).collect();
    let mut cuts = vec![low, high];
    cuts.extend(special.iter().copied().filter(|&q| low < q && q < high));
    if !here.is_empty() {
        let parts = if detail.cuts_ends { 0..=detail.parts } else { 1..=detail.parts - 1 };
        cuts.extend(parts.map(|part| here[part * (here.len() - 1) / detail.parts]));
    }
    cuts.sort_by(f64::total_cmp);
    let pairs = cuts.windows(2).map(|pair| (pair[0], pair[1]));
    pairs.filter(|&(a, b)| Interval { low: a, high: b }.can_be_halved()).collect()
}
