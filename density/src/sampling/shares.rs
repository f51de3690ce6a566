//! Draws as points of the unit cube: shares of the probability that lie above a draw, one for each variable.
//!
//! Whoever has a distribution turns them into a draw by its quantiles. A plan's points depend on the plan and on the
//! number of the draw alone, so that two models that take the same plan are given the same orbits.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::sobol::{Scramble, middle};
use super::{Draws, SamplingPlan, group, scramble, within_group};

impl SamplingPlan {
    /// Point number `i` as a function of `i`, inside the open unit cube.
    pub fn shares<const N: usize>(&self) -> impl Fn(usize) -> [f64; N] + Sync + Send + use<N> {
        let (draws, replicates) = (self.draws, self.replicates.get());
        let generator = ChaCha8Rng::seed_from_u64(self.seed);
        let groups = if draws == Draws::Sobol { replicates } else { 0 };
        let scrambles: Vec<Scramble<N>> = (0..groups).map(|group| scramble(&generator, group as u64)).collect();
        let independent = move |index: usize| -> [f64; N] {
            let mut stream = generator.clone();
            stream.set_stream(index as u64);
            std::array::from_fn(|_| middle(stream.next_u64()))
        };
        move |index| match draws {
            Draws::Independent => independent(index),
            Draws::Antithetic => {
                let point = independent(index & !1);
                if index & 1 == 0 { point } else { point.map(|share| 1.0 - share) }
            }
            Draws::Sobol => scrambles[group(index, replicates)].point(within_group(index, replicates)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use super::*;

    fn plan(draws: Draws) -> SamplingPlan {
        SamplingPlan { draws, seed: 5, replicates: NonZeroUsize::new(2).unwrap() }
    }

    #[test]
    fn antithetic_points_lie_opposite_one_another_about_the_middle() {
        let shares = plan(Draws::Antithetic).shares::<6>();
        for pair in 0..20 {
            let (one, other) = (shares(2 * pair), shares(2 * pair + 1));
            assert!(one.iter().zip(other).all(|(a, b)| (a + b - 1.0).abs() < 1e-15 && *a > 0.0 && *a < 1.0));
        }
    }

    #[test]
    fn the_mean_of_a_smooth_function_is_far_nearer_with_sobol_points_than_with_independent_ones() {
        let error = |draws| {
            let shares = plan(draws).shares::<6>();
            let term =
                |i: usize| shares(i).iter().enumerate().map(|(k, x)| 1.0 + (x - 0.5) / (k + 1) as f64).product::<f64>();
            ((0..8192).map(term).sum::<f64>() / 8192.0 - 1.0).abs()
        };
        let (independent, sobol) = (error(Draws::Independent), error(Draws::Sobol));
        assert!(sobol < 1e-4 && sobol < 0.1 * independent, "{sobol} {independent}");
    }
}
