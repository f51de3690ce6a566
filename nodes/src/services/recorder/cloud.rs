//! The moments of two clouds side by side, with the differences that are allowed if both are right.

use std::f64::consts::{SQRT_2, TAU};

use density::angle::nearest;
use density::grid::Axis;
use density::trust::Diagnosis;
use messages::scenario::Range;

use crate::services::reading::Reading;
use kit::diagnosis;
use kit::space::Quantity;

/// Number of sectors of the circle. Moments may cut the circle at the edges of the sectors.
const SECTORS: f64 = 256.0;
/// Factor by which standard errors may exceed those of independent samples, if samples are drawn in antithetic pairs
/// and their errors follow from the spread of groups.
const GROUPED: f64 = std::f64::consts::SQRT_2;

/// The probability near the point opposite to `mean` at which the circle is cut, according to the density of an
/// angle. The probability that is off the axis lies close to the axis, so it counts only if the axis spans half the
/// circle.
fn near_the_cut((density, axis): (&[f64], Axis), mean: f64, half_width: f64) -> f64 {
    let width = axis.width();
    let reach = half_width + 0.5 * width;
    let is_near = |bin: &usize| {
        let middle = axis.low + (*bin as f64 + 0.5) * width;
        angle_between(middle, mean + 0.5 * TURN) <= reach
    };
    let near: f64 = (0..density.len()).filter(is_near).map(|bin| density[bin] * width).sum();
    let on_axis: f64 = density.iter().map(|density| density * width).sum();
    let spans_half = axis.high - axis.low >= 0.5 * TURN;
    if spans_half { near + (1.0 - on_axis).max(0.0) } else { near }
}

/// A snapshot of a case that knows its errors: samples with standard errors, or a density with error estimates.
pub(super) struct Cloud<'a> {
    reading: &'a Reading,
    pub(super) is_exact: bool,
    /// Number of its samples; 0 for a density with error estimates.
    pub(super) samples: f64,
}

/// A moment of two clouds.
pub(super) struct Compared {
    pub(super) name: String,
    pub(super) values: (f64, f64),
    pub(super) difference: f64,
    /// Error estimates of both in the units of the difference.
    pub(super) estimates: (f64, f64),
    /// The difference that another cut of the circle can explain.
    pub(super) branch: f64,
    pub(super) standard_error: f64,
    /// The change of the moment if one sample moves from one end of the cloud to the other, times the number of
    /// samples.
    pub(super) range: f64,
}

impl<'a> Cloud<'a> {
    /// `None` for a method that does not know its errors.
    pub(super) fn of(reading: &'a Reading) -> Option<Self> {
        let is_exact = diagnosis::of(&reading.header).is_stated();
        let is_sampled = reading.error(Quantity::Mean(reading.space.reentry)).is_finite();
        let samples = if is_sampled && !is_exact { f64::from(reading.header.rows) } else { 0.0 };
        (is_exact || is_sampled).then_some(Self { reading, is_exact, samples })
    }

    /// The error estimates of moments, in standard deviations, and of the resultant vector; 0 for samples.
    fn estimates(&self) -> (f64, f64) {
        match diagnosis::of(&self.reading.header) {
            Diagnosis::Stated { moments, resultant, .. } => (moments, resultant),
            _ => (0.0, 0.0),
        }
    }

    /// The standard error of a moment, at least that of as many samples of a Gaussian; 0 for an exact density. For
    /// one sample of a Gaussian it would be `gaussian`.
    fn standard_error(&self, moment: Quantity, gaussian: f64) -> f64 {
        if self.is_exact {
            return 0.0;
        }
        self.reading.error(moment).max(GROUPED * gaussian / self.samples.sqrt())
    }

    /// All moments of an exact cloud and of another one: first those of numbers, then those of angles, then
    /// covariances.
    pub(super) fn compared(exact: &Self, other: &Self) -> Vec<Compared> {
        let pair = Pair { exact, other };
        let count = exact.reading.space.variables.len();
        let is_circle = |k: &usize| exact.reading.space.is_circle(*k);
        let numbers = (0..count).filter(|k| !is_circle(k)).flat_map(|k| [pair.mean(k), pair.deviation(k)]);
        let angles = (0..count).filter(is_circle).flat_map(|k| [pair.vector(k), pair.mean(k), pair.deviation(k)]);
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        numbers.chain(angles).chain(pairs.map(|(a, b)| pair.covariance(a, b))).collect()
    }
}

/// An exact cloud and another one.
struct Pair<'a> {
    exact: &'a Cloud<'a>,
    other: &'a Cloud<'a>,
}

impl Pair<'_> {
    fn values(&self, quantity: Quantity) -> (f64, f64) {
        (self.exact.reading.value(quantity), self.other.reading.value(quantity))
    }

    /// The standard deviation of a variable, from the exact cloud if that states it, else from the other one.
    fn unit(&self, variable: usize) -> f64 {
        let (a, b) = self.values(Quantity::Deviation(variable));
        if a.is_finite() { a } else { b }
    }

    fn in_units(&self, unit: f64) -> (f64, f64) {
        (self.exact.estimates().0 * unit, self.other.estimates().0 * unit)
    }

    /// The greatest distance between two values of a variable; a full turn for an angle.
    fn whole(&self, variable: usize) -> f64 {
        match self.exact.reading.space.variables[variable].range {
            Range::Circle => TURN,
            Range::Interval { low, high } => high - low,
        }
    }

    /// How far apart two samples of the cloud lie at most: the axis holds the image of the 4-sigma ellipse.
    fn range(&self, variable: usize) -> f64 {
        let axis = self.exact.reading.axes[variable];
        let on_axis = if axis.bins > 0 { 2.0 * (axis.high - axis.low) } else { f64::INFINITY };
        on_axis.min(self.whole(variable))
    }

    fn compared(&self, quantity: Quantity, difference: f64, unit: f64, branch: f64, range: f64) -> Compared {
        Compared {
            name: self.exact.reading.space.in_words(quantity),
            values: self.values(quantity),
            difference: difference.abs(),
            estimates: self.in_units(unit),
            branch,
            standard_error: self.other.standard_error(quantity, unit),
            range,
        }
    }

    fn mean(&self, k: usize) -> Compared {
        let (a, b) = self.values(Quantity::Mean(k));
        let difference = if self.exact.reading.space.is_circle(k) { angle_between(a, b) } else { a - b };
        self.compared(Quantity::Mean(k), difference, self.unit(k), TURN * self.cut(k), self.range(k))
    }

    /// Compares the squares of the standard deviations, since squares are means.
    fn deviation(&self, k: usize) -> Compared {
        let ((a, b), unit, range) = (self.values(Quantity::Deviation(k)), self.unit(k), self.range(k));
        let branch = TURN * TURN * self.cut(k);
        let standard_error = 2.0 * unit * self.other.standard_error(Quantity::Deviation(k), unit * 0.5f64.sqrt());
        let compared = self.compared(Quantity::Deviation(k), a * a - b * b, 2.0 * unit * unit, branch, range * range);
        Compared { standard_error, ..compared }
    }

    fn vector(&self, k: usize) -> Compared {
        let length = self.other.reading.value(Quantity::ResultantLength(k));
        let spread = (1.0 - length * length).max(0.0).sqrt();
        let standard_error = if self.other.is_exact { 0.0 } else { GROUPED * spread / self.other.samples.sqrt() };
        let quantity = Quantity::CircularMean(k);
        Compared {
            name: format!("{} (or its resultant length)", self.exact.reading.space.in_words(quantity)),
            values: self.values(quantity),
            difference: apart(self.exact.reading, self.other.reading, k),
            estimates: (self.exact.estimates().1, self.other.estimates().1),
            branch: 0.0,
            standard_error,
            range: VECTOR_RANGE,
        }
    }

    fn covariance(&self, a: usize, b: usize) -> Compared {
        let quantity = Quantity::Covariance(a, b);
        let (first, second) = self.values(quantity);
        let unit = self.unit(a) * self.unit(b);
        let branch = TURN * (self.cut(a) * self.whole(b) + self.cut(b) * self.whole(a));
        self.compared(quantity, first - second, unit, branch, self.range(a) * self.range(b))
    }

    /// Upper bound of the probability that the two clouds may put on different sides of the cut of an angle; 0 for
    /// other variables.
    fn cut(&self, variable: usize) -> f64 {
        if !self.exact.reading.space.is_circle(variable) {
            return 0.0;
        }
        let (a, b) = self.values(Quantity::CircularMean(variable));
        let half_width = angle_between(a, b) + TURN / SECTORS;
        let of = |cloud: &Cloud| Some(near_the_cut(cloud.reading.marginal(variable)?, a, half_width));
        let near = [self.exact, self.other].into_iter().filter_map(of).fold(f64::NAN, f64::max);
        let is_clear = near == 0.0 && self.exact.reading.marginal(variable).is_some();
        let n = self.other.samples;
        // The samples may have more there than the expected number.
        if is_clear || n == 0.0 { near } else { near + 5.0 * (near / n).sqrt() + 15.0 / n }
    }
}

/// How far the resultant vectors of an angle are apart in two clouds.
fn apart(a: &Reading, b: &Reading, variable: usize) -> f64 {
    let vector = |reading: &Reading| {
        let length = reading.value(Quantity::ResultantLength(variable));
        let mean = reading.value(Quantity::CircularMean(variable));
        (length * mean.cos(), length * mean.sin())
    };
    let ((ax, ay), (bx, by)) = (vector(a), vector(b));
    (ax - bx).hypot(ay - by)
}

/// How far two means of an angle are apart, the short way round.
fn angle_between(a: f64, b: f64) -> f64 {
    nearest(a - b, 0.0).abs()
}

/// The largest distance of two resultant vectors that differ in a part of the cloud.
const VECTOR_RANGE: f64 = 2.0 * SQRT_2;
/// A turn: what a part of the cloud moves by that lies on the other side of the branch cut.
const TURN: f64 = TAU;
