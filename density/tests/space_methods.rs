//! The methods in space against randomised quasi-Monte Carlo, in inclined clouds over ten years.
//!
//! `PHASECLOUD_SPACE=1` takes all four clouds and the methods' own settings, which takes some ten minutes; the gate
//! takes fewer components and orbits.
#![allow(missing_docs)]

mod space_support;

use density::exact::{Exact, ExactSettings};
use density::flow::{Accuracy, Flow};
use density::flow_map::draw::one_by_one;
use density::flow_map::{FlowMap, MappedOrbits, Settings, Summary};
use density::gaussian::Gaussian;
use density::in_space::SpaceProblem;
use density::in_space::draws::{Distributed, Start};
use density::in_space::example::in_the_equator;
use density::in_space::task::SpaceTask;
use density::mixture::adaptive::{AdaptiveMixture, Fineness};
use density::mixture::unscented::Unscented;
use density::model::unfolded::{InSpace, Unfolded};
use density::projected::{self, Cloud, of_mixture, of_samples};
use space_support::{NAMES, apart, asked, by_qmc, plan, scenario};

fn is_campaign() -> bool {
    std::env::var_os("PHASECLOUD_SPACE").is_some()
}

/// The clouds of a mixture and its disagreements at the snapshots.
struct ByMixture<'a>(&'a SpaceProblem, Fineness);

impl SpaceTask for ByMixture<'_> {
    type Output = Vec<(Cloud, f64)>;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) -> Self::Output {
        let Self(problem, fineness) = self;
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let mut mixture = AdaptiveMixture::new(flow, &initial, &problem.times, Unscented::default(), fineness).unwrap();
        println!("{} components, {} orbits", mixture.components(), mixture.trajectories());
        let at = |(index, &time): (usize, &f64)| {
            mixture.advance_to(time).unwrap();
            let component = |c: &density::mixture::component::Component<N>| projected::AnyComponent {
                weight: c.weight,
                mean: c.mean.to_vec(),
                covariance: c.covariance.iter().map(|row| row.to_vec()).collect(),
            };
            let components: Vec<projected::AnyComponent> = mixture.mixture().iter().map(component).collect();
            (asked(problem, |question| of_mixture(&components, question)), mixture.disagreement(index))
        };
        problem.times.iter().enumerate().map(at).collect()
    }
}

/// The clouds of so many points that move by a map.
struct ByMap<'a>(&'a SpaceProblem, Settings, usize);

impl SpaceTask for ByMap<'_> {
    type Output = Vec<Cloud>;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) -> Self::Output {
        let Self(problem, settings, points) = self;
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let map = FlowMap::new(flow, initial, &problem.times, None, &settings).unwrap();
        let Summary { orbits, cells, mapped, error, .. } = map.summary();
        println!("{orbits} orbits in {cells} cells with {mapped:.5} of the cloud, off by {error:.1e}");
        let draw = Distributed::of(problem).unwrap().draw(&plan(12));
        let variables = move |number: usize| -> [f64; N] {
            let Start { variables, radiation, .. } = draw(number);
            std::array::from_fn(|k| variables.get(k).copied().unwrap_or(radiation))
        };
        let mut orbits = MappedOrbits::new(map, 0..points, one_by_one(variables));
        println!("{} of {points} points directly", orbits.direct());
        let at = |index: usize| {
            orbits.advance_watching(index, problem.critical_e).unwrap();
            let mut columns = vec![vec![0.0; points]; N];
            orbits.read_out_columns(&mut columns.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            asked(problem, |question| of_samples(&columns, question, Some(space_support::REPLICATES)))
        };
        (0..problem.times.len()).map(at).collect()
    }
}

/// The largest error of a moment, in deviations and beyond two standard errors of the reference.
fn worst(name: &str, time: f64, found: &Cloud, right: &Cloud) -> f64 {
    let off = apart(found, right);
    let told: Vec<String> = off.iter().map(|[mean, deviation]| format!("{mean:.1e} {deviation:.1e}")).collect();
    println!("{name} at {time} yr: {} above {:+.1e}", told.join(", "), found.above - right.above);
    off.into_iter().flatten().fold(0.0, f64::max)
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn the_mixture_has_every_moment_of_quasi_monte_carlo_to_half_a_percent() {
    let (names, components, orbits) =
        if is_campaign() { (&NAMES[..], 5_000, 65_536) } else { (&NAMES[..2], 500, 4_096) };
    for name in names {
        let problem = scenario(name);
        let right = by_qmc(&problem, orbits);
        let fineness = Fineness { components, ..Fineness::default() };
        let found = problem.perform(ByMixture(&problem, fineness)).unwrap();
        for (((cloud, disagreement), right), time) in found.iter().zip(&right).zip(&problem.times) {
            let worst = worst(name, *time, cloud, right);
            println!("  disagreement {disagreement:.3}");
            assert!(worst < 0.005 && worst < 0.1 * disagreement + 1e-3, "{name} at {time} yr: {worst} {disagreement}");
        }
    }
}

/// Inclination and node of a cloud in the equator do not vary, so that its covariances are singular.
#[test]
fn the_mixture_of_a_cloud_in_the_equator_has_the_exact_moments_of_the_plane() {
    let (problem, plane) = in_the_equator(0.1, None);
    let found = problem.perform(ByMixture(&problem, Fineness { components: 500, ..Fineness::default() })).unwrap();
    let flow = Flow { model: plane.model, accuracy: Accuracy::Medium };
    let exact = Exact::new(&plane, &flow, ExactSettings::default());
    for ((cloud, _), &time) in found.iter().zip(&problem.times).skip(1) {
        let right = exact.moments(time).unwrap();
        let deviation = cloud.covariance[1][1].sqrt();
        let off = [(cloud.mean[1] - right.mean_e) / right.std_e, deviation / right.std_e - 1.0];
        assert!(off.iter().all(|off| off.abs() < 2e-3), "{time} yr: {off:?}");
        assert!(cloud.mean[2].abs() < 1e-9 && cloud.covariance[2][2] < 1e-15, "{time} yr: {:?}", cloud.covariance);
    }
}

#[test]
fn points_that_move_by_a_map_have_every_moment_of_quasi_monte_carlo_to_a_tenth_of_a_percent() {
    let (names, points, orbits) =
        if is_campaign() { (&NAMES[..], 1 << 18, 65_536) } else { (&NAMES[1..2], 1 << 15, 4_096) };
    for name in names {
        let problem = scenario(name);
        let right = by_qmc(&problem, orbits);
        let settings =
            Settings { error: 1e-6, most_orbits: 100_000, smallest_share: 1e-3, least_mapped: 0.0, reach: 4.5 };
        let found = problem.perform(ByMap(&problem, settings, points)).unwrap();
        for ((cloud, right), time) in found.iter().zip(&right).zip(&problem.times).skip(1) {
            let worst = worst(name, *time, cloud, right);
            assert!(worst < 0.001, "{name} at {time} yr: {worst}");
        }
    }
}
