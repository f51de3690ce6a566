//! Clouds over the variables of any model, read out on projections: mean, covariance, and densities of one or two
//! variables.
//!
//! The plane has more ([`crate::binning`], [`crate::mixture`]): what is here asks nothing of a model but which of its
//! variables are angles.

mod samples;

use std::f64::consts::{SQRT_2, TAU};
use std::ops::Range;

use rayon::prelude::*;

use crate::angle::{Circular, nearest};
use crate::grid::Axis;
use crate::wrapped::{self, BeyondCut};

pub use samples::of_samples;

/// One variable or two, each with the bins of its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    /// Positions of the variables, the outermost first, and their axes.
    pub axes: Vec<(usize, Axis)>,
}

impl Projection {
    /// Number of bins.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|(_, axis)| axis.bins).product()
    }

    /// Whether it has no bins at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Length or area of a bin, in the units of the variables.
    pub fn cell(&self) -> f64 {
        self.axes.iter().map(|(_, axis)| axis.width()).product()
    }
}

/// What is asked of a cloud.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// Which of the variables are angles without a beginning.
    pub circles: &'a [bool],
    /// On which projections its density is wanted.
    pub projections: &'a [Projection],
    /// Position of the re-entry variable, and its critical value.
    pub critical: (usize, f64),
}

/// A cloud as it is read out.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// Mean of each variable; of an angle on the branch around its circular mean.
    pub mean: Vec<f64>,
    /// Covariance.
    pub covariance: Vec<Vec<f64>>,
    /// Probability that the re-entry variable exceeds its critical value.
    pub above: f64,
    /// Circular mean and resultant length of each angle; `None` for other variables.
    pub circular: Vec<Option<Circular>>,
    /// Standard errors of means, deviations and covariances, and of the probability, where the cloud is a sample.
    pub errors: Option<Errors>,
    /// Mean density in each bin of each projection, first variable outermost.
    pub densities: Vec<Vec<f64>>,
}

/// Standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Of the means.
    pub mean: Vec<f64>,
    /// Of the deviations.
    pub deviation: Vec<f64>,
    /// Of the covariances.
    pub covariance: Vec<Vec<f64>>,
    /// Of the probability.
    pub above: f64,
}

/// A Gaussian of a mixture in a number of variables that is known only when the program runs.
#[derive(Debug, Clone, PartialEq)]
pub struct AnyComponent {
    /// Share of the probability.
    pub weight: f64,
    /// Mean.
    pub mean: Vec<f64>,
    /// Covariance.
    pub covariance: Vec<Vec<f64>>,
}

/// Components that a thread takes at a time.
const PIECE: usize = 2048;

/// Reads out a Gaussian mixture. Weights need not sum to 1. The mean vector of an angle is that of normals wrapped
/// round the circle (Mardia & Jupp, *Directional Statistics*, 2000, Eq. 3.5.60), and what lies beyond the cut of its
/// circle counts at the other end. Components are not cut at the bounds of their variables.
pub fn of_mixture(components: &[AnyComponent], question: &Question<'_>) -> Cloud {
    let count = question.circles.len();
    let total: f64 = components.iter().map(|component| component.weight).sum();
    let weighted = |term: &dyn Fn(&AnyComponent) -> f64| -> f64 {
        components.iter().map(|component| component.weight * term(component)).sum::<f64>() / total
    };
    let circular: Vec<Option<Circular>> = (0..count)
        .map(|k| {
            let length = |component: &AnyComponent| (-0.5 * component.covariance[k][k]).exp();
            let sin = weighted(&|component| length(component) * component.mean[k].sin());
            let cos = weighted(&|component| length(component) * component.mean[k].cos());
            question.circles[k].then(|| Circular::from_mean_vector(sin, cos))
        })
        .collect();
    let on_branch = |k: usize, value: f64| circular[k].map_or(value, |circular| nearest(value, circular.mean));
    let beyond = |k: usize, component: &AnyComponent| -> Option<BeyondCut> {
        let middle = circular[k]?.mean;
        Some(BeyondCut::new(on_branch(k, component.mean[k]) - middle, component.covariance[k][k].sqrt()))
    };
    let mean_of = |k: usize, component: &AnyComponent| {
        on_branch(k, component.mean[k]) + beyond(k, component).map_or(0.0, |beyond| beyond.mean())
    };
    let mean: Vec<f64> = (0..count).map(|k| weighted(&|component| mean_of(k, component))).collect();
    let off = |k: usize, component: &AnyComponent| on_branch(k, component.mean[k]) - mean[k];
    let product = |a: usize, b: usize, component: &AnyComponent| {
        wrapped::product([a, b], |i, j| component.covariance[i][j], |k| off(k, component), |k| beyond(k, component))
    };
    let covariance =
        (0..count).map(|a| (0..count).map(|b| weighted(&|component| product(a, b, component))).collect()).collect();
    let (reentry, critical) = question.critical;
    let above = weighted(&|c| 1.0 - normal(critical, c.mean[reentry], c.covariance[reentry][reentry].sqrt()));
    let on = |projection: &Projection| {
        let scale = 1.0 / (total * projection.cell());
        // The pieces and the order of their sums are fixed, so that the numbers are the same bytes whatever the
        // threads.
        let piece = |components: &[AnyComponent]| {
            let mut density = vec![0.0; projection.len()];
            for component in components {
                add(&mut density, component, projection, question.circles, component.weight * scale);
            }
            density
        };
        let pieces: Vec<Vec<f64>> = components.par_chunks(PIECE).map(piece).collect();
        let mut density = vec![0.0; projection.len()];
        pieces.iter().for_each(|piece| density.iter_mut().zip(piece).for_each(|(sum, part)| *sum += part));
        density
    };
    let densities = question.projections.iter().map(on).collect();
    Cloud { mean, covariance, above, circular, errors: None, densities }
}

/// The distribution function of a normal variable.
fn normal(value: f64, mean: f64, deviation: f64) -> f64 {
    0.5 * libm::erfc((mean - value) / (SQRT_2 * deviation))
}

/// The means of the images of a normal variable that reach an axis within this many deviations, beyond which there are
/// 8e-11 of it.
const REACH: f64 = 6.5;

/// The bins of an axis that a normal variable reaches.
fn within(axis: Axis, mean: f64, deviation: f64) -> Range<usize> {
    let bin = |value: f64| ((value - axis.low) / axis.width()).clamp(0.0, axis.bins as f64);
    let (first, last) = (bin(mean - REACH * deviation).floor(), bin(mean + REACH * deviation).ceil());
    first as usize..last as usize
}

fn images(mean: f64, deviation: f64, is_circle: bool, axis: Axis) -> Vec<f64> {
    if !is_circle {
        return vec![mean];
    }
    let (low, high) = (axis.low - REACH * deviation, axis.high + REACH * deviation);
    let first = ((low - mean) / TAU).ceil() as i64;
    let last = ((high - mean) / TAU).floor() as i64;
    (first..=last).map(|turn| mean + TAU * turn as f64).collect()
}

/// Adds the probability of a component in each bin of a projection, times `scale`.
fn add(density: &mut [f64], component: &AnyComponent, projection: &Projection, circles: &[bool], scale: f64) {
    let of = |(variable, axis): (usize, Axis)| {
        let deviation = component.covariance[variable][variable].sqrt();
        (deviation, images(component.mean[variable], deviation, circles[variable], axis))
    };
    match projection.axes[..] {
        [one] => {
            let (deviation, means) = of(one);
            for mean in means {
                let below = |i: usize| normal(one.1.edge(i), mean, deviation);
                within(one.1, mean, deviation).for_each(|i| density[i] += scale * (below(i + 1) - below(i)));
            }
        }
        [first, second] => {
            let ((a, means), (b, others)) = (of(first), of(second));
            let slope = component.covariance[first.0][second.0] / (a * a);
            let rest = (b * b - slope * slope * a * a).max(0.0).sqrt().max(f64::MIN_POSITIVE);
            // The probability of thin slices along the first variable, times that of the second given the slice's
            // middle.
            let slices = ((16.0 * first.1.width() / a).ceil() as usize).clamp(4, 64);
            let axis = Axis { bins: first.1.bins * slices, ..first.1 };
            for (mean, other) in means.iter().flat_map(|&mean| others.iter().map(move |&other| (mean, other))) {
                for i in within(axis, mean, a) {
                    let share = normal(axis.edge(i + 1), mean, a) - normal(axis.edge(i), mean, a);
                    if share <= 0.0 {
                        continue;
                    }
                    let centre = other + slope * (axis.centre(i) - mean);
                    let row = &mut density[i / slices * second.1.bins..][..second.1.bins];
                    let bins = within(second.1, centre, rest);
                    let mut below = normal(second.1.edge(bins.start), centre, rest);
                    for j in bins {
                        let upper = normal(second.1.edge(j + 1), centre, rest);
                        row[j] += scale * share * (upper - below);
                        below = upper;
                    }
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaussian::Gaussian;
    use crate::model::{Kind, Variable};
    use crate::sampling::draw_variables;

    const MEAN: [f64; 3] = [6.2, 5.0, -2.0];
    const COVARIANCE: [[f64; 3]; 3] = [[0.04, 0.05, -0.02], [0.05, 0.25, 0.03], [-0.02, 0.03, 0.09]];
    const CIRCLES: [bool; 3] = [true, false, false];

    fn projections() -> Vec<Projection> {
        let axis = |k: usize| {
            let reach = 5.0 * COVARIANCE[k][k].sqrt();
            (k, Axis { low: MEAN[k] - reach, high: MEAN[k] + reach, bins: 20 })
        };
        vec![Projection { axes: vec![axis(0), axis(1)] }, Projection { axes: vec![axis(2)] }]
    }

    fn component() -> AnyComponent {
        let covariance = COVARIANCE.iter().map(|row| row.to_vec()).collect();
        AnyComponent { weight: 2.0, mean: MEAN.to_vec(), covariance }
    }

    #[test]
    fn a_gaussian_and_its_samples_are_read_out_alike() {
        const ROWS: usize = 40_000;
        let interval = Kind::Interval { low: -100.0, high: 100.0 };
        let variable = |kind| Variable { name: "x", symbol: "x", unit: "", kind };
        let variables: &'static [Variable] =
            Box::leak(Box::new([variable(Kind::Circle), variable(interval), variable(interval)]));
        let columns = draw_variables(&Gaussian::new(MEAN, COVARIANCE).unwrap(), variables, 3, 0..ROWS);
        let projections = projections();
        let question = Question { circles: &CIRCLES, projections: &projections, critical: (2, -1.7) };
        let exact = of_mixture(&[component()], &question);
        let sampled = of_samples(&columns.each_ref().map(Vec::as_slice), &question, None);
        let errors = sampled.errors.unwrap();
        for k in 0..3 {
            assert!((exact.mean[k] - MEAN[k]).abs() < 1e-12 || k == 0);
            assert!(nearest(sampled.mean[k] - exact.mean[k], 0.0).abs() < 4.0 * errors.mean[k], "mean {k}");
            for (l, right) in COVARIANCE[k].into_iter().enumerate() {
                assert!((exact.covariance[k][l] - right).abs() < 1e-12);
                let apart = (sampled.covariance[k][l] - right).abs();
                assert!(apart < 4.0 * errors.covariance[k][l], "covariance {k} {l}");
            }
        }
        assert!((sampled.above - exact.above).abs() < 4.0 * errors.above && exact.above > 0.1);
        for ((exact, sampled), projection) in exact.densities.iter().zip(&sampled.densities).zip(&projections) {
            let mass = |density: &Vec<f64>| density.iter().sum::<f64>() * projection.cell();
            assert!((mass(exact) - 1.0).abs() < 1e-5, "{}", mass(exact));
            let variation: f64 = exact.iter().zip(sampled).map(|(p, q)| 0.5 * (p - q).abs() * projection.cell()).sum();
            assert!(variation < 0.05, "{variation}");
        }
    }

    /// The probability of a quadrant of a correlated normal is `1/4 + asin(rho)/(2 pi)` (Sheppard 1899).
    #[test]
    fn bins_of_two_variables_have_sheppards_probabilities() {
        let rho = COVARIANCE[0][1] / (COVARIANCE[0][0] * COVARIANCE[1][1]).sqrt();
        let half = |k: usize| {
            let reach = 40.0 * COVARIANCE[k][k].sqrt();
            (k, Axis { low: MEAN[k] - reach, high: MEAN[k] + reach, bins: 2 })
        };
        let projections = [Projection { axes: vec![half(0), half(1)] }];
        let question = Question { circles: &[false; 3], projections: &projections, critical: (2, 0.0) };
        let density = &of_mixture(&[component()], &question).densities[0];
        let quadrant = density[3] * projections[0].cell();
        assert!((quadrant - (0.25 + rho.asin() / TAU)).abs() < 0.02, "{quadrant}");
    }
}
