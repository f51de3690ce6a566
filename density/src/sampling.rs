//! Random draws from the initial Gaussian.
//!
//! Draw `i` depends on the seed and on `i` alone: each has its own stream of a ChaCha8 generator (Bernstein 2008; a
//! counter-based generator whose streams are independent), so results are the same bytes for any number of threads, shards
//! or restarts. Draws with `e` outside `(0, 1)` are drawn again.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use crate::dynamics::State;
use crate::problem::InitialGaussian;

/// Draws `count` states `(x1, x2)` from `initial`, on all threads.
pub fn draw(initial: &InitialGaussian, seed: u64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let generator = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .into_par_iter()
        .map(|index| {
            let (phi, e) = draw_one(initial, &generator, index as u64);
            let state = State::from_polar(phi, e);
            (state.x1, state.x2)
        })
        .unzip()
}

/// Draw number `index` from `initial`: `phi` \[rad\] and `e`.
pub fn draw_one(initial: &InitialGaussian, generator: &ChaCha8Rng, index: u64) -> (f64, f64) {
    let mut stream = generator.clone();
    stream.set_stream(index);
    loop {
        let (phi, e) = initial.point(StandardNormal.sample(&mut stream), StandardNormal.sample(&mut stream));
        if e > 0.0 && e < 1.0 {
            return (phi, e);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::paper::scenario;

    #[test]
    fn a_draw_depends_on_seed_and_index_alone() {
        let initial = scenario(1).initial;
        let (few, _) = draw(&initial, 7, 10);
        let (many, _) = draw(&initial, 7, 1000);
        assert_eq!(few, many[..10]);
        assert_ne!(few, draw(&initial, 8, 10).0);
    }

    #[test]
    fn draws_stay_inside_the_cut_even_where_it_takes_half_the_gaussian() {
        let initial = InitialGaussian { mean_phi: 1.0, mean_e: 0.0, sigma_phi: 0.1, sigma_e: 0.3 };
        let generator = ChaCha8Rng::seed_from_u64(1);
        assert!((0..1000).map(|i| draw_one(&initial, &generator, i).1).all(|e| 0.0 < e && e < 1.0));
    }
}
