//! The mixture over `phi`, `e` and an uncertain radiation parameter, against moments that another program computed by quadrature.

mod planar_reference;

use density::flow::{Accuracy, Flow};
use density::mixture::adaptive::{AdaptiveMixture, Fineness};
use density::mixture::any_model::moments;
use density::mixture::linearity::DISTRUST;
use density::mixture::unscented::Unscented;
use density::model::Model;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::uncertain::{Distribution, Spread, UncertainProblem, UncertainTask};
use planar_reference::{Snapshot, apart, relative_deviation_of_radiation, scenario};

/// Moments in the plane and the disagreement at each time, and the number of components and orbits.
struct Found {
    moments: Vec<[f64; 5]>,
    disagreements: Vec<f64>,
    components: usize,
    orbits: usize,
}

struct Mixed<'a>(&'a UncertainProblem);

impl UncertainTask for Mixed<'_> {
    type Output = Found;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Found {
        let (problem, times) = (self.0, &self.0.plane.times);
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let (unscented, fineness) = (Unscented::default(), Fineness::default());
        let mut mixture = AdaptiveMixture::new(flow, &problem.gaussian(), times, unscented, fineness).unwrap();
        let at = |&time: &f64| {
            mixture.advance_to(time).unwrap();
            let found = moments(UncertainRadiation::<S>::VARIABLES, &mixture.mixture());
            let [phi, e, _] = found.deviations();
            [found.mean[0], phi, found.mean[1], e, found.covariance[0][1]]
        };
        let moments = times.iter().map(at).collect();
        let disagreements = (0..times.len()).map(|k| mixture.disagreement(k)).collect();
        Found { moments, disagreements, components: mixture.components(), orbits: mixture.trajectories() }
    }
}

/// The error in deviations and the disagreement at each time.
fn judged(name: &str) -> Vec<(f64, f64, f64)> {
    let (plane, snapshots) = scenario(name);
    let relative = relative_deviation_of_radiation(name);
    let problem = UncertainProblem::new(plane, Spread { relative, distribution: Distribution::Gaussian }).unwrap();
    let found = problem.perform(Mixed(&problem));
    println!("{name}: {} components, {} orbits", found.components, found.orbits);
    let one = |(k, snapshot): (usize, &Snapshot)| {
        let (difference, disagreement) = (apart(found.moments[k], snapshot.moments), found.disagreements[k]);
        println!("{name} at {} yr: off by {difference:.1e}, disagreement {disagreement:.3}", snapshot.years);
        println!("{:?} {:?}", found.moments[k], snapshot.moments);
        (snapshot.years, difference, disagreement)
    };
    snapshots.iter().enumerate().map(one).collect()
}

/// The reference is good to 1e-5, except for `uncertain-3` at two years (6e-4, see `uncertain.rs`).
#[test]
fn the_mixture_has_the_moments_of_the_reference_to_a_tenth_of_its_disagreement() {
    for name in ["uncertain-1", "uncertain-3"] {
        for (years, difference, disagreement) in judged(name) {
            assert!(difference < 0.1 * disagreement + 1e-5, "{name} at {years} yr: {difference:e} {disagreement}");
        }
    }
}

#[test]
fn a_mixture_on_the_cliff_says_that_it_should_not_be_trusted() {
    for (years, difference, disagreement) in judged("cliff") {
        assert!(difference < 0.01 || disagreement > DISTRUST, "cliff at {years} yr: {difference:e} {disagreement}");
    }
}
