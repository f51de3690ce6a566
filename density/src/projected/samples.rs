//! Samples of a cloud, read out on projections, with the standard errors of independent samples or of independent groups of them.

use std::f64::consts::PI;

use super::{Cloud, Errors, Projection, Question};
use crate::angle::{Circular, fold, nearest};
use crate::estimate::ordered_sum;
use crate::grid::Axis;
use crate::sampling::group;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaussian::Gaussian;
    use crate::model::{Kind, Variable};
    use crate::sampling::draw_variables;

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
}
