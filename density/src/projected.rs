//! Clouds over the variables of any model, read out on projections: mean, covariance, and densities of one or two variables.
//!
//! The plane has more ([`crate::binning`], [`crate::mixture`]): what is here asks nothing of a model but which of its variables are angles.

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::angle::{Circular, fold, nearest};
use crate::estimate::ordered_sum;
use crate::grid::Axis;
use crate::sampling::group;

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

/// Reads out equally weighted samples, one column per variable. A column of NaN is that of a variable that the sampled model does not have:
/// nothing is said of it. Samples are independent, or were drawn in this number of independent groups ([`crate::sampling::group`]).
///
/// # Panics
/// If there is not one column per variable, or if they differ in length.
pub fn of_samples(columns: &[&[f64]], question: &Question<'_>, groups: Option<usize>) -> Cloud {
    let count = question.circles.len();
    let rows = columns.first().map_or(0, |column| column.len());
    assert!(columns.len() == count && columns.iter().all(|column| column.len() == rows), "one column per variable");
    let whole = Sample { columns, question, row: |i| i, rows };
    let SampleMoments { mean, covariance, above, circular } = whole.moments();
    let errors = groups.map_or_else(|| whole.errors(&mean, &covariance, above), |groups| of_groups(&whole, groups));
    let is_absent = |variable: usize| columns[variable].first().is_none_or(|value| value.is_nan());
    let count_in = |projection: &Projection| {
        if projection.axes.iter().any(|&(variable, _)| is_absent(variable)) {
            return vec![f64::NAN; projection.len()];
        }
        let mut counts = vec![0u64; projection.len()];
        let bin_of = |i: usize| {
            projection.axes.iter().try_fold(0, |bin, &(variable, axis)| {
                let value = on_axis(columns[variable][i], question.circles[variable], axis);
                Some(bin * axis.bins + axis.bin(value)?)
            })
        };
        (0..rows).filter_map(bin_of).for_each(|bin| counts[bin] += 1);
        counts.into_iter().map(|count| count as f64 / (rows as f64 * projection.cell())).collect()
    };
    let densities = question.projections.iter().map(count_in).collect();
    Cloud { mean, covariance, above, circular, errors: Some(errors), densities }
}

/// Some rows of a sample.
struct Sample<'a, R> {
    columns: &'a [&'a [f64]],
    question: &'a Question<'a>,
    row: R,
    rows: usize,
}

/// The moments of a sample.
struct SampleMoments {
    mean: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    above: f64,
    circular: Vec<Option<Circular>>,
}

impl<R: Fn(usize) -> usize + Sync> Sample<'_, R> {
    fn value(&self, k: usize, i: usize) -> f64 {
        self.columns[k][(self.row)(i)]
    }

    fn mean_of(&self, term: &(dyn Fn(usize) -> f64 + Sync)) -> f64 {
        ordered_sum(self.rows, |i| [term(i)])[0] / self.rows as f64
    }

    fn table(&self, entry: &dyn Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
        let count = self.columns.len();
        (0..count).map(|a| (0..count).map(|b| entry(a, b)).collect()).collect()
    }

    fn moments(&self) -> SampleMoments {
        let Self { columns, question, .. } = self;
        let circular: Vec<Option<Circular>> = (0..columns.len())
            .map(|k| {
                let vector = || {
                    let sin = self.mean_of(&|i| self.value(k, i).sin());
                    Circular::from_mean_vector(sin, self.mean_of(&|i| self.value(k, i).cos()))
                };
                question.circles[k].then(vector)
            })
            .collect();
        let on_branch = |k: usize, i: usize| {
            let value = self.value(k, i);
            circular[k].map_or(value, |circular| nearest(value, circular.mean))
        };
        let mean: Vec<f64> = (0..columns.len()).map(|k| self.mean_of(&|i| on_branch(k, i))).collect();
        let off = |k: usize, i: usize| on_branch(k, i) - mean[k];
        let covariance = self.table(&|a, b| self.mean_of(&|i| off(a, i) * off(b, i)));
        let (reentry, critical) = question.critical;
        let above = self.mean_of(&|i| f64::from(self.value(reentry, i) > critical));
        SampleMoments { mean, covariance, above, circular }
    }

    /// Standard errors of independent samples, to leading order in `1/n` (Kendall & Stuart, *The Advanced Theory of Statistics* 1, 1977,
    /// Chapter 10); what the cut of an angle's branch adds is left out.
    fn errors(&self, mean: &[f64], covariance: &[Vec<f64>], above: f64) -> Errors {
        let on_branch = |k: usize, i: usize| match self.question.circles[k] {
            true => nearest(self.value(k, i), mean[k]),
            false => self.value(k, i),
        };
        let off = |k: usize, i: usize| on_branch(k, i) - mean[k];
        let fourth = self.table(&|a, b| self.mean_of(&|i| (off(a, i) * off(b, i)).powi(2)));
        // Rounding may leave a variance below 0; NaN stays what it is.
        let error = |variance: f64| (if variance < 0.0 { 0.0 } else { variance } / self.rows as f64).sqrt();
        Errors {
            mean: (0..mean.len()).map(|k| error(covariance[k][k])).collect(),
            deviation: (0..mean.len())
                .map(|k| error((fourth[k][k] - covariance[k][k].powi(2)) / (4.0 * covariance[k][k])))
                .collect(),
            covariance: self.table(&|a, b| error(fourth[a][b] - covariance[a][b].powi(2))),
            above: error(above * (1.0 - above)),
        }
    }
}

/// Standard errors from the spread of the moments of independent groups, see [`crate::standard_errors`]; NaN where there are fewer than two
/// groups, or fewer than two samples in each.
fn of_groups<R: Fn(usize) -> usize + Sync>(whole: &Sample<'_, R>, groups: usize) -> Errors {
    let Sample { columns, question, rows, .. } = *whole;
    let mut members = vec![Vec::with_capacity(rows / groups.max(1) + 2); groups];
    (0..rows).for_each(|row| members[group(row, groups)].push(row));
    let moments: Vec<SampleMoments> = members
        .iter()
        .map(|members| Sample { columns, question, row: |i| members[i], rows: members.len() }.moments())
        .collect();
    let has_spread = groups >= 2 && rows / 2 >= groups;
    let error = |value: &dyn Fn(&SampleMoments) -> f64| {
        let count = groups as f64;
        let first = value(&moments[0]);
        let mean = moments.iter().map(|m| value(m) - first).sum::<f64>() / count;
        let squares: f64 = moments.iter().map(|m| (value(m) - first - mean).powi(2)).sum();
        if has_spread { (squares / ((count - 1.0) * count)).sqrt() } else { f64::NAN }
    };
    // Groups may find an angle on different turns.
    let mean_of = |m: &SampleMoments, k: usize| match question.circles[k] {
        true => nearest(m.mean[k], moments[0].mean[k]),
        false => m.mean[k],
    };
    let count = columns.len();
    Errors {
        mean: (0..count).map(|k| error(&|m| mean_of(m, k))).collect(),
        deviation: (0..count).map(|k| error(&|m| m.covariance[k][k].sqrt())).collect(),
        covariance: whole.table(&|a, b| error(&|m| m.covariance[a][b])),
        above: error(&|m| m.above),
    }
}

/// The representative of an angle on the branch that an axis is on, as [`crate::grid::Grid::fold`]; other values as they are.
fn on_axis(value: f64, is_circle: bool, axis: Axis) -> f64 {
    if is_circle { fold(value, axis.low.midpoint(axis.high) - PI) } else { value }
}

/// A Gaussian of a mixture in any number of variables.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Share of the probability.
    pub weight: f64,
    /// Mean.
    pub mean: Vec<f64>,
    /// Covariance.
    pub covariance: Vec<Vec<f64>>,
}

/// Reads out a Gaussian mixture. Weights need not sum to 1. The mean vector of an angle is that of normals wrapped round the circle (Mardia
/// & Jupp, *Directional Statistics*, 2000, Eq. 3.5.60). Components are not cut at the bounds of their variables.
pub fn of_mixture(components: &[Component], question: &Question<'_>) -> Cloud {
    let count = question.circles.len();
    let total: f64 = components.iter().map(|component| component.weight).sum();
    let weighted = |term: &dyn Fn(&Component) -> f64| -> f64 {
        components.iter().map(|component| component.weight * term(component)).sum::<f64>() / total
    };
    let circular: Vec<Option<Circular>> = (0..count)
        .map(|k| {
            let length = |component: &Component| (-0.5 * component.covariance[k][k]).exp();
            let sin = weighted(&|component| length(component) * component.mean[k].sin());
            let cos = weighted(&|component| length(component) * component.mean[k].cos());
            question.circles[k].then(|| Circular::from_mean_vector(sin, cos))
        })
        .collect();
    let on_branch = |k: usize, value: f64| circular[k].map_or(value, |circular| nearest(value, circular.mean));
    let mean: Vec<f64> = (0..count).map(|k| weighted(&|component| on_branch(k, component.mean[k]))).collect();
    let off = |k: usize, component: &Component| on_branch(k, component.mean[k]) - mean[k];
    let covariance = (0..count)
        .map(|a| {
            let of = |b: usize| weighted(&|c| c.covariance[a][b] + off(a, c) * off(b, c));
            (0..count).map(of).collect()
        })
        .collect();
    let (reentry, critical) = question.critical;
    let above = weighted(&|c| 1.0 - normal(critical, c.mean[reentry], c.covariance[reentry][reentry].sqrt()));
    let on = |projection: &Projection| {
        let mut density = vec![0.0; projection.len()];
        let scale = 1.0 / (total * projection.cell());
        for component in components {
            add(&mut density, component, projection, question.circles, component.weight * scale);
        }
        density
    };
    let densities = question.projections.iter().map(on).collect();
    Cloud { mean, covariance, above, circular, errors: None, densities }
}

/// The distribution function of a normal variable.
fn normal(value: f64, mean: f64, deviation: f64) -> f64 {
    0.5 * libm::erfc((mean - value) / (SQRT_2 * deviation))
}

/// The means of the images of a normal variable that reach an axis within this many deviations.
const REACH: f64 = 9.0;

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
fn add(density: &mut [f64], component: &Component, projection: &Projection, circles: &[bool], scale: f64) {
    let of = |(variable, axis): (usize, Axis)| {
        let deviation = component.covariance[variable][variable].sqrt();
        (deviation, images(component.mean[variable], deviation, circles[variable], axis))
    };
    match projection.axes[..] {
        [one] => {
            let (deviation, means) = of(one);
            for mean in means {
                let below = |i: usize| normal(one.1.edge(i), mean, deviation);
                (0..one.1.bins).for_each(|i| density[i] += scale * (below(i + 1) - below(i)));
            }
        }
        [first, second] => {
            let ((a, means), (b, others)) = (of(first), of(second));
            let slope = component.covariance[first.0][second.0] / (a * a);
            let rest = (b * b - slope * slope * a * a).max(0.0).sqrt().max(f64::MIN_POSITIVE);
            // The probability of thin slices along the first variable, times that of the second given the slice's middle.
            let slices = ((16.0 * first.1.width() / a).ceil() as usize).clamp(4, 64);
            let axis = Axis { bins: first.1.bins * slices, ..first.1 };
            for (mean, other) in means.iter().flat_map(|&mean| others.iter().map(move |&other| (mean, other))) {
                for i in 0..axis.bins {
                    let share = normal(axis.edge(i + 1), mean, a) - normal(axis.edge(i), mean, a);
                    if share <= 0.0 {
                        continue;
                    }
                    let centre = other + slope * (axis.centre(i) - mean);
                    let row = &mut density[i / slices * second.1.bins..][..second.1.bins];
                    let mut below = normal(second.1.edge(0), centre, rest);
                    for (j, bin) in row.iter_mut().enumerate() {
                        let upper = normal(second.1.edge(j + 1), centre, rest);
                        *bin += scale * share * (upper - below);
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

    fn component() -> Component {
        let covariance = COVARIANCE.iter().map(|row| row.to_vec()).collect();
        Component { weight: 2.0, mean: MEAN.to_vec(), covariance }
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

    #[test]
    fn independent_samples_in_groups_have_the_errors_of_independent_samples() {
        const ROWS: usize = 40_000;
        let variables: &'static [Variable] = &[
            Variable { name: "x", symbol: "x", unit: "", kind: Kind::Circle },
            Variable { name: "y", symbol: "y", unit: "", kind: Kind::Interval { low: -100.0, high: 100.0 } },
        ];
        let gaussian = Gaussian::new([6.2, 5.0], [[0.04, 0.05], [0.05, 0.25]]).unwrap();
        let columns = draw_variables(&gaussian, variables, 3, 0..ROWS);
        let question = Question { circles: &[true, false], projections: &[], critical: (1, 5.5) };
        let errors = |groups| of_samples(&columns.each_ref().map(Vec::as_slice), &question, groups).errors.unwrap();
        let (formula, spread) = (errors(None), errors(Some(200)));
        // The spread of 200 groups knows a standard error to 5 %.
        let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.25;
        assert!(is_near(spread.mean[0], formula.mean[0]) && is_near(spread.deviation[1], formula.deviation[1]));
        assert!(is_near(spread.covariance[0][1], formula.covariance[0][1]) && is_near(spread.above, formula.above));
        assert!(errors(Some(1)).above.is_nan(), "one group has no spread");
    }

    #[test]
    fn nothing_is_said_of_a_variable_that_the_sampled_model_does_not_have() {
        let (known, absent) = ([0.1, 0.2, 0.4, 0.3], [f64::NAN; 4]);
        let axis = |k| (k, Axis { low: 0.0, high: 1.0, bins: 2 });
        let projections = [
            Projection { axes: vec![axis(0), axis(1)] },
            Projection { axes: vec![axis(0)] },
            Projection { axes: vec![axis(1)] },
        ];
        let question = Question { circles: &[false, true], projections: &projections, critical: (0, 0.25) };
        let cloud = of_samples(&[&known, &absent], &question, None);
        assert!((cloud.mean[0] - 0.25).abs() < 1e-15 && cloud.mean[1].is_nan() && cloud.covariance[0][1].is_nan());
        assert_eq!((cloud.above, &cloud.densities[1]), (0.5, &vec![2.0, 0.0]));
        assert!(cloud.errors.is_some_and(|errors| errors.mean[1].is_nan() && errors.mean[0] > 0.0));
        assert!(cloud.densities[0].iter().chain(&cloud.densities[2]).all(|density| density.is_nan()));
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
