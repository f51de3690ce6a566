//! The moments of two clouds side by side, with all that they may differ by if both are right.

use density::grid::Axis;
use messages::layout::{DensityHeader, diagnostic};

use super::RecordedDensity;
use super::agreement::{TURN, VECTOR_RANGE, angle_between, apart};

/// Sectors of the circle at whose edges moments may cut it.
const SECTORS: f64 = 256.0;
/// Errors of samples in groups follow from the groups' spread; those of pairs may be larger than those of independent samples.
const GROUPED: f64 = std::f64::consts::SQRT_2;

/// The marginals of a density.
pub(super) struct Marginals<'a> {
    pub(super) phi: &'a [f64],
    pub(super) e: &'a [f64],
    pub(super) phi_axis: Axis,
    pub(super) e_axis: Axis,
}

impl<'a> Marginals<'a> {
    /// Of a density that is not withheld and as long as its header says.
    pub(super) fn of(recorded: &'a RecordedDensity) -> Option<Self> {
        let header = &recorded.header;
        let (phi_bins, e_bins) = (header.phi_bins as usize, header.e_bins as usize);
        let (phi, e) = recorded.values.get(phi_bins.checked_mul(e_bins)?..)?.split_at_checked(phi_bins)?;
        let [phi_low, phi_high, e_low, e_high] = header.grid;
        let is_there = header.mass_on_grid.is_finite() && header.mass_on_grid > 0.0 && e.len() == e_bins;
        let phi_axis = Axis { low: phi_low, high: phi_high, bins: phi_bins };
        let e_axis = Axis { low: e_low, high: e_high, bins: e_bins };
        is_there.then_some(Self { phi, e, phi_axis, e_axis })
    }

    /// The probability that lies where the circle is cut, opposite to `mean`. What is off the grid lies close to it, so it
    /// counts if the grid spans half the circle.
    fn near_the_cut(&self, mean: f64, half_width: f64) -> f64 {
        let width = self.phi_axis.width();
        let reach = half_width + 0.5 * width;
        let is_near = |bin: &usize| {
            let middle = self.phi_axis.low + (*bin as f64 + 0.5) * width;
            angle_between(middle, mean + 0.5 * TURN) <= reach
        };
        let near: f64 = (0..self.phi.len()).filter(is_near).map(|bin| self.phi[bin] * width).sum();
        let on_grid: f64 = self.phi.iter().map(|density| density * width).sum();
        let spans_half = self.phi_axis.high - self.phi_axis.low >= 0.5 * TURN;
        if spans_half { near + (1.0 - on_grid).max(0.0) } else { near }
    }
}

/// A snapshot of a case that knows its errors: samples with standard errors, or a density with error estimates.
pub(super) struct Cloud<'a> {
    header: &'a DensityHeader,
    marginals: Option<Marginals<'a>>,
    pub(super) is_exact: bool,
    /// How many samples it is of, or 0.
    pub(super) samples: f64,
}

/// A moment of two clouds.
pub(super) struct Compared {
    pub(super) name: &'static str,
    pub(super) values: (f64, f64),
    pub(super) difference: f64,
    /// Error estimates of both in the units of the difference.
    pub(super) estimates: (f64, f64),
    /// What another cut of the circle explains.
    pub(super) branch: f64,
    pub(super) standard_error: f64,
    /// What moving one sample from end to end of the cloud would change, times the number of samples.
    pub(super) range: f64,
}

impl<'a> Cloud<'a> {
    /// `None` of a method that does not know its errors.
    pub(super) fn of(recorded: &'a RecordedDensity) -> Option<Self> {
        let header = &recorded.header;
        let is_exact = header.diagnostic == diagnostic::NUMERICAL;
        let is_sampled = header.standard_errors[2].is_finite();
        let samples = if is_sampled && !is_exact { f64::from(header.rows) } else { 0.0 };
        (is_exact || is_sampled).then(|| Self { header, marginals: Marginals::of(recorded), is_exact, samples })
    }

    /// An error estimate in standard deviations or of the resultant vector; 0 of samples.
    fn estimate(&self, place: usize) -> f64 {
        if self.is_exact { self.header.diagnostics[place] } else { 0.0 }
    }

    /// The standard error of a moment, and not less than that of as many samples of a Gaussian; 0 of an exact density.
    fn standard_error(&self, moment: usize, gaussian: f64) -> f64 {
        if self.is_exact {
            return 0.0;
        }
        self.header.standard_errors[moment].max(GROUPED * gaussian / self.samples.sqrt())
    }

    /// All moments that an exact cloud and another one state.
    pub(super) fn compared(exact: &Self, other: &Self) -> Vec<Compared> {
        let (a, b) = (exact.header, other.header);
        let ([phi_a, std_phi_a, e_a, std_e_a, cov_a, _], [phi_b, std_phi_b, e_b, std_e_b, cov_b, _]) =
            (a.moments, b.moments);
        let first = |a: f64, b: f64| if a.is_finite() { a } else { b };
        let (std_phi, std_e) = (first(std_phi_a, std_phi_b), first(std_e_a, std_e_b));
        let in_units = |unit: f64| (exact.estimate(0) * unit, other.estimate(0) * unit);
        let [phi_low, phi_high, e_low, e_high] = a.grid;
        // The grid holds the image of the 4-sigma ellipse.
        let (range_phi, range_e) = ((2.0 * (phi_high - phi_low)).min(TURN), (2.0 * (e_high - e_low)).min(1.0));
        let cut = exact.cut(other);
        let circular = (exact.estimate(1), other.estimate(1));
        let spread = (1.0 - b.resultant * b.resultant).max(0.0).sqrt();
        let moment = |name, values, difference: f64, estimates, branch, standard_error, range| Compared {
            name,
            values,
            difference: difference.abs(),
            estimates,
            branch,
            standard_error,
            range,
        };
        let variance = |name, (a, b): (f64, f64), std: f64, branch, place, range: f64| {
            // Of two deviations the squares are compared: those are means.
            let standard_error = 2.0 * std * other.standard_error(place, std * 0.5f64.sqrt());
            moment(name, (a, b), a * a - b * b, in_units(2.0 * std * std), branch, standard_error, range * range)
        };
        let vector_error = if other.is_exact { 0.0 } else { GROUPED * spread / other.samples.sqrt() };
        vec![
            moment(
                "the mean of e",
                (e_a, e_b),
                e_a - e_b,
                in_units(std_e),
                0.0,
                other.standard_error(2, std_e),
                range_e,
            ),
            variance("the deviation of e", (std_e_a, std_e_b), std_e, 0.0, 3, range_e),
            moment(
                "the circular mean of phi (or its resultant length)",
                (a.circular_mean, b.circular_mean),
                apart(a, b),
                circular,
                0.0,
                vector_error,
                VECTOR_RANGE,
            ),
            moment(
                "the mean of phi",
                (phi_a, phi_b),
                angle_between(phi_a, phi_b),
                in_units(std_phi),
                TURN * cut,
                other.standard_error(0, std_phi),
                range_phi,
            ),
            variance("the deviation of phi", (std_phi_a, std_phi_b), std_phi, TURN * TURN * cut, 1, range_phi),
            moment(
                "the covariance",
                (cov_a, cov_b),
                cov_a - cov_b,
                in_units(std_phi * std_e),
                TURN * cut,
                other.standard_error(4, std_phi * std_e),
                range_phi * range_e,
            ),
        ]
    }

    /// At most the probability that two clouds may put on different sides of the cut.
    fn cut(&self, other: &Self) -> f64 {
        let (a, b) = (self.header.circular_mean, other.header.circular_mean);
        let half_width = angle_between(a, b) + TURN / SECTORS;
        let near =
            [self, other].into_iter().filter_map(|cloud| Some(cloud.marginals.as_ref()?.near_the_cut(a, half_width)));
        let near = near.fold(f64::NAN, f64::max);
        let is_clear = near == 0.0 && self.marginals.is_some();
        let n = other.samples;
        // What a sample may have there beyond its share.
        if is_clear || n == 0.0 { near } else { near + 5.0 * (near / n).sqrt() + 15.0 / n }
    }
}
