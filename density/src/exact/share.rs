//! How the initial probability is spread along one orbit.
//!
//! With `dphi de = (s/e) n_sun dH dt` (the flow keeps `e/s dphi de`, Eq. 3) an orbit's share of the probability between
//! `θ` and `θ + dθ` is, per unit of `H`,
//!
//! ```text
//! a(θ) dθ = n_0(phi, e) (s/e) dθ ,     θ = n_sun t .
//! ```
//!
//! The orbit is cut into intervals on each of which eight-point Gauss-Legendre nodes resolve `a`; an interval that may
//! hide the cloud between its nodes is cut further. The probability of an arc is a sum of positive terms, so a small
//! one keeps its digits.

use std::sync::LazyLock;

use crate::model::plane::State;

use super::contour::Contour;
use super::detail::Detail;
use super::measure::{Measure, REACH};
use super::rules::{GAUSS_POINTS, gauss};

/// Number of halvings after which an interval is taken as it is.
const DEEPEST: u32 = 44;
/// Largest distance between two nodes near the cloud, in standard deviations.
const SPACING: f64 = 1.2;

/// The initial probability along an orbit, per unit of `H`.
#[derive(Debug, Clone)]
pub(crate) struct Share {
    /// Ends of the intervals \[rad\], from minus to plus half a period.
    times: Vec<f64>,
    /// Probability before each end.
    before: Vec<f64>,
    /// `a` in each interval; `None` where it is zero.
    parts: Vec<Option<Part>>,
}

/// `a` in one interval.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// `a` at the nodes of the Gauss rule.
    pub density: [f64; GAUSS_POINTS],
    /// The integral of `a` from the start of the interval, as a polynomial on `[-1, 1]` to be multiplied by half the
    /// length.
    integral: [f64; GAUSS_POINTS + 1],
}

/// `a` at a state.
pub(super) fn density(measure: &Measure, state: State) -> f64 {
    let e = state.eccentricity();
    if e > 0.0 { measure.density(state) * state.s() / e } else { 0.0 }
}

impl Share {
    /// The share of the orbit `contour`; `scale` is the probability per unit of `H` of an orbit through the middle of
    /// the cloud.
    pub(super) fn new(measure: &Measure, contour: &Contour, scale: f64, detail: Detail) -> Self {
        let knots: Vec<f64> = contour.knots().collect();
        let mut share = Self { times: vec![-contour.half], before: vec![0.0], parts: Vec::new() };
        let cutter = Cutter { measure, contour, scale, detail };
        for pair in knots.windows(2).rev() {
            cutter.cut(&mut share, (-pair[1], -pair[0]), DEEPEST);
        }
        for pair in knots.windows(2) {
            cutter.cut(&mut share, (pair[0], pair[1]), DEEPEST);
        }
        share
    }

    /// The orbit's total probability.
    pub(crate) fn total(&self) -> f64 {
        self.before.last().copied().unwrap_or(0.0)
    }

    /// The intervals that hold probability, with their ends.
    pub(super) fn parts(&self) -> impl Iterator<Item = (f64, f64, &Part)> + '_ {
        let ends = self.times.windows(2).zip(&self.parts);
        ends.filter_map(|(ends, part)| part.as_ref().map(|part| (ends[0], ends[1], part)))
    }

    /// The probability between two times `from <= to`, at most one period apart; either may be any number of periods
    /// away.
    pub(crate) fn between(&self, contour: &Contour, from: f64, to: f64) -> f64 {
        if to - from >= contour.period() * (1.0 - 1e-15) {
            return self.total();
        }
        let (a, b) = (contour.wrap(from), contour.wrap(to));
        if a <= b {
            self.within(a, b)
        } else if to <= from {
            0.0
        } else {
            self.within(a, contour.half) + self.within(-contour.half, b)
        }
    }

    /// The same within one period: a sum of positive terms.
    fn within(&self, from: f64, to: f64) -> f64 {
        let (first, last) = (self.interval(from), self.interval(to));
        let until = |k: usize, time: f64| self.within_interval(k, time);
        if first == last {
            return (until(first, to) - until(first, from)).max(0.0);
        }
        let mass = |k: usize| until(k, self.times[k + 1]);
        (mass(first) - until(first, from)).max(0.0) + (first + 1..last).map(mass).sum::<f64>() + until(last, to)
    }

    /// Probability before a time between minus and plus half a period.
    #[inline]
    pub(super) fn before(&self, theta: f64) -> f64 {
        let k = self.interval(theta);
        self.before[k] + self.within_interval(k, theta)
    }

    /// Probability in interval `k` before a time.
    #[inline]
    fn within_interval(&self, k: usize, theta: f64) -> f64 {
        let Some(part) = &self.parts[k] else { return 0.0 };
        let (low, high) = (self.times[k], self.times[k + 1]);
        let half = 0.5 * (high - low);
        let x = ((theta - low) / half - 1.0).clamp(-1.0, 1.0);
        (half * part.integral.iter().rev().fold(0.0, |sum, c| sum * x + c)).max(0.0)
    }

    fn interval(&self, theta: f64) -> usize {
        self.times.partition_point(|&time| time <= theta).clamp(1, self.parts.len()) - 1
    }
}

/// The matrices that turn values at the Gauss nodes into Legendre coefficients, and these into the powers of the
/// integral from -1.
struct Basis {
    legendre: [[f64; GAUSS_POINTS]; GAUSS_POINTS],
    integrals: [[f64; GAUSS_POINTS + 1]; GAUSS_POINTS],
}

static BASIS: LazyLock<Basis> = LazyLock::new(|| {
    // Powers of the Legendre polynomials, by (k + 1) P_{k+1} = (2k + 1) x P_k - k P_{k-1}.
    let mut powers = [[0.0; GAUSS_POINTS + 2]; GAUSS_POINTS + 1];
    powers[0][0] = 1.0;
    powers[1][1] = 1.0;
    for k in 1..GAUSS_POINTS {
        for n in 0..=k + 1 {
            let raised = if n > 0 { powers[k][n - 1] } else { 0.0 };
            powers[k + 1][n] = ((2 * k + 1) as f64 * raised - k as f64 * powers[k - 1][n]) / (k + 1) as f64;
        }
    }
    let value = |k: usize, x: f64| powers[k].iter().rev().fold(0.0, |sum, c| sum * x + c);
    let nodes = gauss(-1.0, 1.0);
    let legendre =
        std::array::from_fn(|k| std::array::from_fn(|j| (k as f64 + 0.5) * nodes[j].1 * value(k, nodes[j].0)));
    let integrals = std::array::from_fn(|k| {
        let mut integral = [0.0; GAUSS_POINTS + 1];
        for n in 0..GAUSS_POINTS {
            integral[n + 1] = powers[k][n] / (n + 1) as f64;
        }
        integral[0] = -integral.iter().rev().fold(0.0, |sum, c| c - sum);
        integral
    });
    Basis { legendre, integrals }
});

impl Part {
    /// From the values at the nodes, and the size of the last two Legendre coefficients.
    fn new(density: [f64; GAUSS_POINTS]) -> (Self, f64) {
        let Basis { legendre, integrals } = &*BASIS;
        let coefficients = legendre.map(|row| row.iter().zip(&density).map(|(l, d)| l * d).sum::<f64>());
        let mut integral = [0.0; GAUSS_POINTS + 1];
        for (coefficient, row) in coefficients.iter().zip(integrals) {
            integral.iter_mut().zip(row).for_each(|(sum, power)| *sum += coefficient * power);
        }
        let tail = coefficients[GAUSS_POINTS - 1].abs().max(coefficients[GAUSS_POINTS - 2].abs());
        (Self { density, integral }, tail)
    }
}

struct Cutter<'a> {
    measure: &'a Measure,
    contour: &'a Contour,
    scale: f64,
    detail: Detail,
}

impl Cutter<'_> {
    fn cut(&self, share: &mut Share, (low, high): (f64, f64), depth: u32) {
        let nodes = gauss(low, high);
        let states = nodes.map(|(theta, _)| self.contour.at(theta));
        let middle = low.midpoint(high);
        let may_halve = depth > 0 && middle > low && middle < high;
        let halves = |share: &mut Share| {
            self.cut(share, (low, middle), depth - 1);
            self.cut(share, (middle, high), depth - 1);
        };
        match self.nearness(&states) {
            Nearness::Unresolved if may_halve => return halves(share),
            Nearness::Far => return self.push(share, high, 0.0, None),
            _ => {}
        }
        let (part, tail) = Part::new(states.map(|state| density(self.measure, state)));
        let size = part.density.iter().copied().fold(0.0, f64::max);
        let Detail { tail: most, rough_tail, little, .. } = self.detail;
        let holds_little = tail * (high - low) <= little * self.scale || tail <= most * size;
        if size > 0.0 && may_halve && !(holds_little && tail <= rough_tail * size) {
            return halves(share);
        }
        let mass = nodes.iter().zip(&part.density).map(|((_, weight), density)| weight * density).sum();
        self.push(share, high, mass, Some(part).filter(|_| size > 0.0));
    }

    fn push(&self, share: &mut Share, end: f64, mass: f64, part: Option<Part>) {
        share.before.push(share.total() + mass);
        share.times.push(end);
        share.parts.push(part);
    }

    /// Whether the nodes of an interval lie so far from the cloud that no part of it lies between them, or are too far
    /// apart to decide.
    fn nearness(&self, states: &[State]) -> Nearness {
        let sigma_phi = self.measure.gaussian.sigma_phi_given_e();
        let standardise = |state: &State| self.measure.standardise(state.solar_angle(), state.eccentricity());
        let points: Vec<(f64, f64)> = states.iter().map(standardise).collect();
        let turn = self.measure.turn();
        let (mut wide_u, mut wide_v): (f64, f64) = (0.0, 0.0);
        for (pair, ends) in points.windows(2).zip(states.windows(2)) {
            let du = (pair[1].0 - pair[0].0).abs();
            wide_u = wide_u.max(du.min(turn - du));
            // Near the origin a curve can turn between two nodes by more than the nodes show.
            let moved = (ends[1].x1 - ends[0].x1).hypot(ends[1].x2 - ends[0].x2);
            let turned = (moved / ends[0].eccentricity().max(1e-300)).min(std::f64::consts::PI) / sigma_phi;
            wide_u = wide_u.max(turned.min(turn));
            wide_v = wide_v.max((pair[1].1 - pair[0].1).abs());
        }
        // At all nodes, the curve is beside the cloud in one direction by more than the distance between two nodes.
        let above = points.iter().all(|&(_, v)| v > REACH + 2.0 * wide_v);
        let below = points.iter().all(|&(_, v)| v < -REACH - 2.0 * wide_v);
        let beside = points.iter().all(|&(u, _)| u.abs() > REACH + 2.0 * wide_u) && 4.0 * wide_u < turn;
        if above || below || beside {
            Nearness::Far
        } else if wide_u > SPACING || wide_v > SPACING {
            Nearness::Unresolved
        } else {
            Nearness::Near
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Nearness {
    Far,
    Near,
    Unresolved,
}
