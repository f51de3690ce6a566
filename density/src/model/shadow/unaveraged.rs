//! The unaveraged model with the Earth's shadow, or with a height at which the satellite re-enters.
//!
//! Sunlight is on or off. In between the equations are smooth, so that the series of the model without the shadow is
//! followed to the next edge and begins anew there, with the pressure of the other side. An edge is looked for at
//! [`PLACES`] places of every step; a stretch that begins and ends between two of them, which takes a satellite less
//! than a minute, is passed over.

use super::super::irradiated::{Irradiated, irradiated_carried_here};
use super::super::osculating::{self, Osculating, OsculatingSeries, State, above_pericentre, halves};
use super::super::uncertain_radiation::Scale;
use super::super::vector::{Vector, dot};
use super::super::{LANES, Lanes, Model, Quantity, Series, Variable, carried_here, ecliptic};
use crate::model::earth::SUN_MEAN_MOTION;

/// Number of places of a step at which an edge is looked for.
const PLACES: usize = 8;

/// The unaveraged model with the shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowedOsculating {
    /// The model without the shadow.
    pub model: Osculating,
    /// Whether there is a shadow at all.
    pub has_shadow: bool,
    /// Height of the osculating pericentre above the Earth's centre at which the satellite re-enters \[Earth radii\];
    /// where there is none, it re-enters at a critical eccentricity.
    pub reentry_radius: Option<f64>,
}

impl ShadowedOsculating {
    /// A function that is below 0 in the shadow and nowhere else, and smooth but for the rim of the Earth's disc as the
    /// Sun sees it.
    fn outside(&self, to_sun: Vector<f64>, position: Vector<f64>) -> f64 {
        let toward = dot(position, to_sun);
        let beyond = dot(position, position) - toward * toward - self.model.semi_major_axis.powi(-2);
        toward.max(beyond)
    }

    /// Whether a satellite in this state is in the shadow at a time \[yr\].
    pub fn is_dark(&self, time: f64, state: State) -> bool {
        self.has_shadow && self.outside(self.sunward(time), halves(state).0) < 0.0
    }

    /// The direction to the Sun, the same on every machine.
    fn sunward(&self, time: f64) -> Vector<f64> {
        ecliptic::direction(libm::sincos(self.model.longitude_of_sun(time)), self.model.obliquity)
    }
}

irradiated_carried_here!(ShadowedOsculating);

impl<S: Scale> Irradiated<S> for ShadowedOsculating {
    const WITH_RADIATION: &'static [Variable] = <Osculating as Irradiated<S>>::WITH_RADIATION;

    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        let is_dark = self.is_dark(time.number(), state.map(Quantity::number));
        self.model.rate_with(if is_dark { T::from(0.0) } else { radiation }, time, state)
    }

    #[inline(always)]
    fn irradiate<const P: usize>(series: &mut ShadowedSeries<P>, lane: usize, radiation: f64) {
        series.lanes[lane].radiation = radiation;
        series.illuminate(lane);
    }
}

impl Model for ShadowedOsculating {
    type State<T: Quantity> = State<T>;
    type Variables = [f64; 6];
    type Series<const P: usize> = ShadowedSeries<P>;

    const VARIABLES: &'static [Variable] = &osculating::VARIABLES;
    const REENTRY: usize = Osculating::REENTRY;

    carried_here!();

    fn rate<T: Quantity>(&self, time: T, state: State<T>) -> State<T> {
        let is_dark = self.is_dark(time.number(), state.map(Quantity::number));
        let radiation = if is_dark { 0.0 } else { self.model.forces.force.radiation };
        self.model.rate_with(T::from(radiation), time, state)
    }

    fn is_inside(&self, state: State) -> bool {
        self.model.is_inside(state)
    }

    fn state(&self, time: f64, variables: [f64; 6]) -> State {
        self.model.state(time, variables)
    }

    fn read_out(&self, time: f64, state: State) -> [f64; 6] {
        self.model.read_out(time, state)
    }

    fn clearance<T: Quantity>(&self, state: State<T>) -> T {
        match self.reentry_radius {
            Some(radius) => above_pericentre(state, radius / self.model.semi_major_axis),
            None => self.model.clearance(state),
        }
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        match self.reentry_radius {
            Some(_) => 0.0,
            None => self.model.critical_clearance(critical),
        }
    }

    /// As without the shadow: the pressure on either side of an edge does not depend on the place, and the satellite's
    /// path is continuous in position and velocity across it. Where the edge itself lies depends on the position alone,
    /// so that the flow keeps the volume.
    fn density_growth(&self, start: State, end: State) -> Option<f64> {
        self.model.density_growth(start, end)
    }
}

/// The series of the model without the shadow, in whose lanes the light is on or off.
#[derive(Debug)]
pub struct ShadowedSeries<const P: usize> {
    model: ShadowedOsculating,
    series: OsculatingSeries<P>,
    lanes: [Lane; LANES],
}

#[derive(Debug, Clone, Copy)]
struct Lane {
    time: f64,
    radiation: f64,
    sign: f64,
    is_dark: bool,
    /// Length of the step to the next edge, infinite if there is none within the step that is planned.
    to_edge: f64,
}

impl<const P: usize> ShadowedSeries<P> {
    /// Gives a lane the pressure that it has where it is.
    #[inline(always)]
    fn illuminate(&mut self, lane: usize) {
        let Lane { is_dark, radiation, .. } = self.lanes[lane];
        self.series.irradiate(lane, if is_dark { 0.0 } else { radiation });
    }

    /// [`ShadowedOsculating::outside`] after a step of this length.
    fn outside(&self, lane: usize, step: f64) -> f64 {
        let own = &self.lanes[lane];
        let signed = own.sign * step;
        let position = [0, 1, 2].map(|k| {
            self.series
                .coordinate(k)
                .iter()
                .rev()
                .fold(0.0f64, |sum, coefficient| sum.mul_add(signed, coefficient[lane]))
        });
        self.model.outside(self.model.sunward(own.time + signed / SUN_MEAN_MOTION), position)
    }

    /// Whether a satellite in the light is farther from the shadow than it can move in a step of this length, at up to
    /// twice its speed.
    fn is_far_from_shadow(&self, lane: usize, step: f64) -> bool {
        let (position, velocity) = halves(self.state_of(lane));
        let toward = dot(position, self.model.sunward(self.lanes[lane].time));
        let from_axis = (dot(position, position) - toward * toward).max(0.0).sqrt();
        let apart = toward.max(from_axis - 1.0 / self.model.model.semi_major_axis);
        apart > 2.0 * step * self.model.model.pace() * dot(velocity, velocity).sqrt()
    }

    /// Length of the step to the first edge within a step of this length.
    fn first_edge(&self, lane: usize, step: f64) -> f64 {
        let is_dark = self.lanes[lane].is_dark;
        if !is_dark && self.is_far_from_shadow(lane, step) {
            return f64::INFINITY;
        }
        let inward = if is_dark { -1.0 } else { 1.0 };
        // Above 0 on this side of the edge, whatever rounding says at an edge that has just been crossed.
        let (mut low, mut at_low) = (0.0, (inward * self.outside(lane, 0.0)).max(f64::MIN_POSITIVE));
        for place in 1..=PLACES {
            let high = step * place as f64 / PLACES as f64;
            let at_high = inward * self.outside(lane, high);
            if at_high < 0.0 {
                return self.edge_between(lane, inward, (low, at_low), (high, at_high));
            }
            (low, at_low) = (high, at_high);
        }
        f64::INFINITY
    }

    /// The edge between two lengths at which the function has these values, by the Illinois variant of the false
    /// position.
    fn edge_between(&self, lane: usize, inward: f64, mut low: (f64, f64), mut high: (f64, f64)) -> f64 {
        const MOST_STEPS: usize = 60;
        const ENOUGH: f64 = 1e-14;
        let end = high.0;
        for _ in 0..MOST_STEPS {
            let place = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let place = if place > low.0 && place < high.0 { place } else { low.0.midpoint(high.0) };
            let value = inward * self.outside(lane, place);
            if value < 0.0 {
                high = (place, value);
                low.1 *= 0.5;
            } else {
                low = (place, value.max(f64::MIN_POSITIVE));
                high.1 *= 0.5;
            }
            if high.0 - low.0 <= ENOUGH * end || value.abs() <= ENOUGH {
                break;
            }
        }
        high.0
    }

    fn state_of(&self, lane: usize) -> State {
        std::array::from_fn(|k| self.series.coordinate(k)[0][lane])
    }
}

impl<const P: usize> Series<P> for ShadowedSeries<P> {
    type Model = ShadowedOsculating;

    #[inline(always)]
    fn new(model: &ShadowedOsculating) -> Self {
        let radiation = model.model.forces.force.radiation;
        let lane = Lane { time: 0.0, radiation, sign: 1.0, is_dark: false, to_edge: f64::INFINITY };
        let mut series = OsculatingSeries::new(&model.model);
        series.watch_height(model.reentry_radius.map(|radius| radius / model.model.semi_major_axis));
        Self { model: *model, series, lanes: [lane; LANES] }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, time: f64) {
        self.series.start(lane, state, time);
        let radiation = self.model.model.forces.force.radiation;
        let is_dark = self.model.is_dark(time, state);
        self.lanes[lane] = Lane { time, radiation, sign: 1.0, is_dark, to_edge: f64::INFINITY };
        self.illuminate(lane);
    }

    #[inline(always)]
    fn head_for(&mut self, lane: usize, years: f64) {
        self.lanes[lane].sign = years.signum();
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        self.series.expand(with_clearance);
    }

    #[inline(always)]
    fn shorten(&mut self, mut planned: Lanes) -> Lanes {
        for (lane, step) in planned.iter_mut().enumerate() {
            let is_looked_for = *step > 0.0 && self.model.has_shadow;
            let edge = if is_looked_for { self.first_edge(lane, *step) } else { f64::INFINITY };
            self.lanes[lane].to_edge = edge;
            *step = step.min(edge);
        }
        planned
    }

    #[inline(always)]
    fn may_creep(&self, _: usize) -> bool {
        true
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        self.series.move_on(steps);
        for (lane, step) in steps.iter().enumerate() {
            let own = &mut self.lanes[lane];
            own.time += step / SUN_MEAN_MOTION;
            if step.abs() == own.to_edge {
                own.is_dark = !own.is_dark;
                self.illuminate(lane);
            }
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.model.is_inside(self.state_of(lane))
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        self.series.coordinate(k)
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        self.series.clearance()
    }
}
