//! Draws: what they depend on, where they lie, how they are distributed.

use super::*;
use crate::problem::paper::scenario;

const ALL: [Draws; 3] = [Draws::Independent, Draws::Antithetic, Draws::Sobol];

fn plan(draws: Draws, seed: u64, replicates: usize) -> SamplingPlan {
    SamplingPlan { draws, seed, replicates: NonZeroUsize::new(replicates).unwrap() }
}

/// A Gaussian half of which is cut away.
const HALVED: InitialGaussian =
    InitialGaussian { mean_phi: 1.0, mean_e: 0.0, sigma_phi: 0.1, sigma_e: 0.3, correlation: 0.0 };

#[test]
fn a_draw_depends_on_seed_and_index_alone() {
    let initial = scenario(1).initial;
    for draws in ALL {
        let (few, _) = plan(draws, 7, 3).draw(&initial, 10);
        let (many, _) = plan(draws, 7, 3).draw(&initial, 1000);
        assert_eq!(few, many[..10]);
        assert_ne!(few, plan(draws, 8, 3).draw(&initial, 10).0);
    }
    let generator = ChaCha8Rng::seed_from_u64(7);
    let (phi, e) = draw_one(&initial, &generator, 9);
    assert_eq!(State::from_polar(phi, e).x1, draw(&initial, 7, 10).0[9]);
    assert_eq!(draw(&initial, 7, 10), plan(Draws::Independent, 7, 5).draw(&initial, 10));
}

#[test]
fn draws_of_a_range_are_those_of_its_numbers() {
    for initial in [scenario(1).initial, HALVED] {
        for draws in ALL {
            let (plan, numbers) = (plan(draws, 7, 3), 13..1000);
            let polar = plan.polar(&initial);
            let starts: Vec<[f64; 2]> = numbers.clone().map(|number| polar(number).into()).collect();
            assert_eq!(plan.starts(&initial)(numbers), starts, "{draws:?}");
        }
    }
}

#[test]
fn draws_over_a_models_variables_are_the_planes_where_the_gaussian_is() {
    for initial in [scenario(1).initial, HALVED] {
        let [phi, e] = draw_variables(&Gaussian::from(initial), &crate::model::plane::VARIABLES, 7, 0..1000);
        let polar = plan(Draws::Independent, 7, 1).polar(&initial);
        assert!((0..1000).all(|i| polar(i) == (phi[i], e[i])));
    }
}

#[test]
fn draws_stay_inside_the_cut_even_where_it_takes_half_the_gaussian() {
    for draws in ALL {
        let polar = plan(draws, 1, 2).polar(&HALVED);
        assert!((0..1000).map(|i| polar(i).1).all(|e| 0.0 < e && e < 1.0));
    }
}

#[test]
fn draws_of_every_kind_have_the_distribution_of_the_cut_gaussian() {
    // One draw per seed, so that the draws are independent; draw 1 is the mirrored one. Kolmogorov's test at 0.1 %.
    const SEEDS: u64 = 4000;
    let tail = |z: f64| 0.5 * libm::erfc(z / 2f64.sqrt());
    let above = tail(1.0 / 0.3);
    let distribution = |e: f64| 1.0 - (tail(e / 0.3) - above) / (0.5 - above);
    for draws in ALL {
        let mut values: Vec<f64> = (0..SEEDS).map(|seed| plan(draws, seed, 1).polar(&HALVED)(1).1).collect();
        values.sort_by(f64::total_cmp);
        let at = |i: usize| (i as f64 + 0.5) / SEEDS as f64;
        let distance = values.iter().enumerate().map(|(i, &e)| (distribution(e) - at(i)).abs()).fold(0.0, f64::max);
        assert!(distance < 1.95 / (SEEDS as f64).sqrt(), "{draws:?} {distance}");
    }
}

#[test]
fn mean_of_antithetic_draws_is_exact_at_the_start() {
    let initial = scenario(1).initial;
    let polar = plan(Draws::Antithetic, 3, 4).polar(&initial);
    let count = 1000;
    let sum = (0..count).map(&polar).fold((0.0, 0.0), |sum, (phi, e)| (sum.0 + phi, sum.1 + e));
    assert!((sum.0 / count as f64 - initial.mean_phi).abs() < 1e-13);
    // The cut takes 3e-9 of the lower tail, which moves the mirror image by up to 3e-9 over the normal density.
    assert!((sum.1 / count as f64 - initial.mean_e).abs() < 1e-6 * initial.sigma_e);
}

#[test]
fn groups_are_dealt_whole_pairs_and_share_alike() {
    let mut counts = [0; 7];
    (0..1003).for_each(|i| counts[group(i, 7)] += 1);
    assert!(counts.iter().all(|&count| (142..=144).contains(&count)), "{counts:?}");
    assert!((0..1000).step_by(2).all(|i| group(i, 7) == group(i + 1, 7)));
}

#[test]
fn every_group_of_sobol_draws_fills_the_gaussian_evenly() {
    // 16 draws in each of 3 groups: each group has one draw in every sixteenth of the distribution of phi.
    let initial = scenario(1).initial;
    let polar = plan(Draws::Sobol, 5, 3).polar(&initial);
    let mut counts = [[0; 16]; 3];
    for i in 0..48 {
        let u = initial.standardise(polar(i).0, 0.1).0;
        counts[group(i, 3)][(16.0 * 0.5 * libm::erfc(-u / 2f64.sqrt())) as usize] += 1;
    }
    assert_eq!(counts, [[1; 16]; 3]);
}
