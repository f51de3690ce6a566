//! Tests of Monte Carlo's error bars against exact moments, over many seeds.
//!
//! All tests are at snapshots of scenario 1 where the cloud is far from Gaussian. Whether 95 % intervals cover the
//! exact moments is judged by the number of seeds for which they do: it must lie in the range of a binomial count of
//! probability 0.95 that leaves out 0.05 % on either side.

mod common;

use std::num::NonZeroUsize;

use common::paper;
use density::binning;
use density::estimate::{Estimate, Moments};
use density::exact::{Exact, ExactSettings};
use density::first_passage::empirical::wilson_interval;
use density::flow::Flow;
use density::grid::{Grid, comparison_grids};
use density::model::planar::SrpJ2;
use density::orbits::Orbits;
use density::problem::Problem;
use density::sampling::{Draws, SamplingPlan};
use density::standard_errors;

const SEEDS: u64 = 200;
/// 97.5 % quantiles of the normal distribution and of Student's distribution with 9 degrees of freedom.
const NORMAL: f64 = 1.959_963_984_540_054;
const STUDENT_9: f64 = 2.262_157_162_740_99;

/// The range of a binomial count of probability 0.95, without 0.05 % on either side.
fn band(trials: u64) -> std::ops::RangeInclusive<u64> {
    let p: f64 = 0.95;
    let mut term = (1.0 - p).powi(trials as i32);
    let mut sum = 0.0;
    let (mut low, mut high) = (0, trials);
    for count in 0..=trials {
        if sum + term < 5e-4 {
            low = count + 1;
        }
        if sum < 1.0 - 5e-4 {
            high = count;
        }
        sum += term;
        term *= (trials - count) as f64 / (count + 1) as f64 * p / (1.0 - p);
    }
    low..=high
}

#[test]
fn band_of_two_hundred_trials_is_about_three_deviations_wide() {
    // Mean 190, deviation 3.08, skewed to the left.
    assert_eq!(band(SEEDS), 179..=198);
}

struct Snapshot {
    problem: Problem,
    flow: Flow<SrpJ2>,
    grid: Grid,
    years: f64,
    exact: [f64; 6],
}

impl Snapshot {
    fn of_scenario_1(index: usize) -> Self {
        let problem = paper(1);
        let flow = Flow::new(problem.model);
        let (grid, years) = (comparison_grids(&problem, &flow, 20, 20).unwrap()[index], problem.times[index]);
        let exact = Exact::new(&problem, &flow, ExactSettings::default());
        let moments = exact.moments(years).unwrap();
        let probability = exact.probability_above(problem.critical_e, years).unwrap().value;
        let exact = [moments.mean_phi, moments.std_phi, moments.mean_e, moments.std_e, moments.cov_phi_e, probability];
        Self { problem, flow, grid, years, exact }
    }

    /// The estimate of a sample; the standard errors are computed by groups if there are several.
    fn estimate(&self, draws: Draws, seed: u64, replicates: usize, count: usize) -> Estimate {
        let plan = SamplingPlan { draws, seed, replicates: NonZeroUsize::new(replicates).unwrap() };
        let (x1, x2) = plan.draw(&self.problem.initial, count);
        let mut orbits = Orbits::new(self.flow, x1, x2);
        orbits.advance_to(self.years).unwrap();
        let (mut phi, mut e) = (vec![0.0; count], vec![0.0; count]);
        orbits.read_out(&mut phi, &mut e);
        let critical_e = self.problem.critical_e;
        if replicates == 1 {
            binning::estimate(&phi, &e, self.grid, critical_e)
        } else {
            binning::estimate_in_groups(&phi, &e, self.grid, critical_e, replicates)
        }
    }

    /// Errors of the moments.
    fn errors(&self, moments: Moments) -> [f64; 6] {
        let moments = moments.to_array();
        std::array::from_fn(|k| moments[k] - self.exact[k])
    }

    /// Number of seeds whose intervals of `quantile` standard errors hold the exact moment, for each moment.
    fn covered(&self, draws: Draws, replicates: usize, count: usize, quantile: f64) -> [u64; 6] {
        let mut covered = [0; 6];
        for seed in 0..SEEDS {
            let estimate = self.estimate(draws, seed, replicates, count);
            let (errors, bars) = (self.errors(estimate.moments), estimate.standard_errors.to_array());
            (0..6).for_each(|k| covered[k] += u64::from(errors[k].abs() <= quantile * bars[k]));
        }
        covered
    }

    /// Root mean square errors of the moments over seeds.
    fn rms(&self, draws: Draws, count: usize) -> [f64; 6] {
        const RUNS: u64 = 40;
        let mut squares = [0.0; 6];
        for seed in 0..RUNS {
            let errors = self.errors(self.estimate(draws, 1000 + seed, 1, count).moments);
            (0..6).for_each(|k| squares[k] += errors[k] * errors[k]);
        }
        squares.map(|sum: f64| (sum / RUNS as f64).sqrt())
    }
}

#[test]
fn error_bars_of_independent_samples_cover_the_exact_moments() {
    for index in [1, 2] {
        let covered = Snapshot::of_scenario_1(index).covered(Draws::Independent, 1, 3000, NORMAL);
        assert!(covered[..5].iter().all(|count| band(SEEDS).contains(count)), "{index} {covered:?}");
    }
}

#[test]
fn wilsons_interval_covers_a_small_probability() {
    // P(e > 0.6) is 0.011 at half a year: 33 samples in 3000.
    let snapshot = Snapshot::of_scenario_1(1);
    let covers = |seed: &u64| {
        let p = snapshot.estimate(Draws::Independent, *seed, 1, 3000).moments.prob_above_critical_e;
        let (low, high) = wilson_interval(p, 3000.0);
        (low..=high).contains(&snapshot.exact[5])
    };
    let covered = (0..SEEDS).filter(covers).count() as u64;
    assert!(band(SEEDS).contains(&covered), "{covered}");
}

#[test]
fn error_bars_of_bins_cover_the_exact_density() {
    const COUNT: usize = 3000;
    let snapshot = Snapshot::of_scenario_1(2);
    let exact = Exact::new(&snapshot.problem, &snapshot.flow, ExactSettings::default());
    let grids = vec![snapshot.grid; snapshot.problem.times.len()];
    let density = exact.snapshot(&grids, 2).unwrap().estimate.marginal_e;
    let width = snapshot.grid.e.width();
    // Bins with at least 100 samples on average, where a count is nearly normal.
    let full: Vec<usize> = (0..20).filter(|&j| density[j] * width * COUNT as f64 > 100.0).collect();
    let mut covered = vec![0; 20];
    for seed in 0..SEEDS {
        let marginal = snapshot.estimate(Draws::Independent, seed, 1, COUNT).marginal_e;
        let bars = standard_errors::of_density(&marginal, COUNT, width);
        full.iter().for_each(|&j| covered[j] += u64::from((marginal[j] - density[j]).abs() <= NORMAL * bars[j]));
    }
    assert!(full.len() > 5 && full.iter().all(|&j| band(SEEDS).contains(&covered[j])), "{covered:?}");
}

#[test]
fn error_bars_by_groups_cover_the_exact_moments_for_every_kind_of_draws() {
    let snapshot = Snapshot::of_scenario_1(1);
    for draws in [Draws::Independent, Draws::Antithetic, Draws::Sobol] {
        let covered = snapshot.covered(draws, 10, 10 * 256, STUDENT_9);
        assert!(covered[..5].iter().all(|count| band(SEEDS).contains(count)), "{draws:?} {covered:?}");
    }
}

/// Factor by which the error of `draws` is smaller than that of independent draws, for each moment, with 4096 samples.
/// The factor is known to 16 %.
fn gains(snapshot: &Snapshot, draws: Draws) -> [f64; 6] {
    let (independent, other) = (snapshot.rms(Draws::Independent, 4096), snapshot.rms(draws, 4096));
    std::array::from_fn(|k| independent[k] / other[k])
}

#[test]
fn sobol_draws_err_less_than_independent_ones_by_more_than_ten() {
    // Measured: 15 (deviation of e at one year) to 258 (mean of phi at two years).
    for index in [1, 2, 4] {
        let gains = gains(&Snapshot::of_scenario_1(index), Draws::Sobol);
        assert!(gains[..5].iter().all(|&gain| gain > 10.0), "{index} {gains:?}");
    }
    // A probability jumps at the critical eccentricity, where the sequence gains less. Measured: 5.7.
    assert!(gains(&Snapshot::of_scenario_1(1), Draws::Sobol)[5] > 4.0);
}

#[test]
fn antithetic_draws_gain_in_the_mean_angle_and_lose_at_most_half_their_number_elsewhere() {
    // Moments that are even about the mean lose up to sqrt(1/2); measured: 3.9 to 6.6 in the mean angle, 0.6 to 8
    // elsewhere.
    for index in [1, 2, 4] {
        let gains = gains(&Snapshot::of_scenario_1(index), Draws::Antithetic);
        assert!(gains[0] > 3.0 && gains[..5].iter().all(|&gain| gain > 0.5f64.sqrt() * 0.7), "{index} {gains:?}");
    }
}
