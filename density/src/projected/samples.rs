//! Samples of a cloud, read out on projections, with the standard errors of independent samples or of independent
//! groups of them.

use std::f64::consts::PI;

use super::{Cloud, Errors, Projection, Question};
use crate::angle::{Circular, fold, nearest};
use crate::estimate::ordered_sum;
use crate::grid::Axis;
use crate::sampling::group;

/// Reads out equally weighted samples, one column per variable. A column of NaN is that of a variable that the sampled
/// model does not have: nothing is said of it. Samples are independent, or were drawn in this number of independent
/// groups ([`crate::sampling::group`]).
///
/// # Panics
/// If there is not one column per variable, or if they differ in length.
pub fn of_samples(columns: &[&[f64]], question: &Question<'_>, groups: Option<usize>) -> Cloud {
    let count = question.circles.len();
    let rows = columns.first().map_or(0, |column| column.len());
    assert!(columns.len() == count && columns.iter().all(|column| column.len() == rows), "one column per variable");
    let whole = Sample { columns, question, row: |i| i, rows };
    let moments = whole.moments();
    let errors = groups.map_or_else(|| whole.errors(&moments), |groups| of_groups(&whole, groups));
    let SampleMoments { mean, covariance, above, circular } = moments;
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

    /// Standard errors of independent samples, to leading order in `1/n` (Kendall & Stuart, *The Advanced Theory of
    /// Statistics* 1, 1977, Chapter 10), with what the cut of an angle's branch adds where the cloud reaches it.
    fn errors(&self, SampleMoments { mean, covariance, above, circular }: &SampleMoments) -> Errors {
        let on_branch = |k: usize, i: usize| {
            let value = self.value(k, i);
            circular[k].map_or(value, |circular| nearest(value, circular.mean))
        };
        let off = |k: usize, i: usize| on_branch(k, i) - mean[k];
        let count = mean.len();
        let cuts: Vec<Option<BranchCut>> = (0..count).map(|k| self.branch_cut(k, circular[k]?, mean, &off)).collect();
        // What a sample adds to the mean of `term`, where the branch of angle `k` moves with the sample.
        let moved = |k: usize, per_turn: f64, i: usize| {
            cuts[k].as_ref().map_or(0.0, |cut| per_turn * cut.turn * cut.influence(self.value(k, i)))
        };
        let variance = |influence: &(dyn Fn(usize) -> f64 + Sync)| {
            let middle = self.mean_of(influence);
            self.mean_of(&|i| (influence(i) - middle).powi(2))
        };
        // Rounding may leave a variance below 0; NaN stays what it is.
        let error = |variance: f64| (if variance < 0.0 { 0.0 } else { variance } / self.rows as f64).sqrt();
        let of_square = |k: usize| {
            let from_centre = cuts[k].as_ref().map_or(0.0, |cut| cut.from_centre);
            variance(&|i| off(k, i).powi(2) + moved(k, -2.0 * from_centre, i))
        };
        let beside = |angle: usize, other: usize| cuts[angle].as_ref().map_or(0.0, |cut| cut.beside[other]);
        let of_product = |a: usize, b: usize| {
            variance(&|i| off(a, i) * off(b, i) + moved(a, beside(a, b), i) + moved(b, beside(b, a), i))
        };
        let squares: Vec<f64> = (0..count).map(of_square).collect();
        Errors {
            mean: (0..count).map(|k| error(variance(&|i| off(k, i) + moved(k, 1.0, i)))).collect(),
            deviation: (0..count).map(|k| error(squares[k] / (4.0 * covariance[k][k]))).collect(),
            covariance: self.table(&|a, b| error(if a == b { squares[a] } else { of_product(a, b) })),
            above: error(above * (1.0 - above)),
        }
    }

    /// The cut of the branch of an angle; `None` if no sample is next to it.
    fn branch_cut(
        &self,
        k: usize,
        Circular { mean: centre, resultant }: Circular,
        mean: &[f64],
        off: &(dyn Fn(usize, usize) -> f64 + Sync),
    ) -> Option<BranchCut> {
        let is_beside = |i: usize| (nearest(self.value(k, i), centre) - centre).abs() > PI - BESIDE;
        let share = self.mean_of(&|i| f64::from(is_beside(i)));
        let of = |b: usize| self.mean_of(&|i| if is_beside(i) { off(b, i) } else { 0.0 }) / share;
        (share > 0.0).then(|| BranchCut {
            centre,
            resultant,
            turn: PI * share / BESIDE,
            from_centre: mean[k] - centre,
            beside: (0..mean.len()).map(of).collect(),
        })
    }
}

/// How far from the cut a sample is beside it \[rad\].
const BESIDE: f64 = PI / 32.0;

/// The cut of an angle's branch, opposite to the circular mean: it moves with the sample, and samples beside it change
/// by a turn. See [`crate::sample_sums`] for the derivation.
struct BranchCut {
    /// The circular mean.
    centre: f64,
    /// The mean resultant length.
    resultant: f64,
    /// 2π times the density of the angle at the cut.
    turn: f64,
    /// Mean of the angle less the circular mean.
    from_centre: f64,
    /// Mean of each variable beside the cut, less its mean.
    beside: Vec<f64>,
}

impl BranchCut {
    /// By how much a sample turns the circular mean, times the number of samples.
    fn influence(&self, value: f64) -> f64 {
        (value - self.centre).sin() / self.resultant
    }
}

/// Standard errors from the spread of the moments of independent groups, see [`crate::standard_errors`]; NaN where
/// there are fewer than two groups, or fewer than two samples in each.
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

/// The representative of an angle on the branch that an axis is on, as [`crate::grid::Grid::fold`]; other values as
/// they are.
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

    /// The errors that 400 samples of 1,000 state on average, against the spread of their moments, where an angle
    /// reaches round the circle.
    #[test]
    fn errors_hold_what_the_cut_of_a_branch_adds() {
        const SEEDS: u64 = 400;
        let variables: &'static [Variable] = &[
            Variable { name: "x", symbol: "x", unit: "", kind: Kind::Circle },
            Variable { name: "y", symbol: "y", unit: "", kind: Kind::Interval { low: -100.0, high: 100.0 } },
        ];
        let gaussian = Gaussian::new([0.3, 5.0], [[1.69, 0.4], [0.4, 0.25]]).unwrap();
        let question = Question { circles: &[true, false], projections: &[], critical: (1, 5.5) };
        let cloud = |seed| {
            let columns = draw_variables(&gaussian, variables, seed, 0..1_000);
            of_samples(&columns.each_ref().map(Vec::as_slice), &question, None)
        };
        let clouds: Vec<Cloud> = (0..SEEDS).map(cloud).collect();
        type Figure = (&'static str, fn(&Cloud) -> f64, fn(&Errors) -> f64);
        let figures: [Figure; 3] = [
            ("mean", |c| nearest(c.mean[0], 0.3), |e| e.mean[0]),
            ("deviation", |c| c.covariance[0][0].sqrt(), |e| e.deviation[0]),
            ("covariance", |c| c.covariance[0][1], |e| e.covariance[0][1]),
        ];
        for (name, value, error) in figures {
            let mean = clouds.iter().map(value).sum::<f64>() / SEEDS as f64;
            let squares = clouds.iter().map(|c| (value(c) - mean).powi(2)).sum::<f64>();
            let spread = (squares / (SEEDS - 1) as f64).sqrt();
            let stated = clouds.iter().filter_map(|c| c.errors.as_ref()).map(error).sum::<f64>() / SEEDS as f64;
            // The spread of 400 samples is known to 3.5 %.
            assert!((stated / spread - 1.0).abs() < 0.14, "{name}: {stated} stated, {spread} seen");
        }
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
