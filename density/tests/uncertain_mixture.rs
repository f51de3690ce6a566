//! The mixture over `phi`, `e` and an uncertain radiation parameter, against moments that another program computed by
//! quadrature.

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

struct Mixed<'a>(&'a UncertainProblem, Fineness);

impl UncertainTask for Mixed<'_> {
    type Output = Found;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Found {
        let Self(problem, fineness) = self;
        let times = &problem.plane.times;
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let gaussian = problem.gaussian();
        let mut mixture = AdaptiveMixture::new(flow, &gaussian, times, Unscented::default(), fineness).unwrap();
        let (mut all, mut disagreements) = (Vec::new(), Vec::new());
        for (k, &time) in times.iter().enumerate() {
            mixture.advance_to(time).unwrap();
            let found = moments(UncertainRadiation::<S>::VARIABLES, &mixture.mixture());
            let [phi, e, _] = found.deviations();
            all.push([found.mean[0], phi, found.mean[1], e, found.covariance[0][1]]);
            disagreements.push(mixture.present_disagreement(k));
        }
        Found { moments: all, disagreements, components: mixture.components(), orbits: mixture.trajectories() }
    }
}

/// A tenth of the components that a mixture has unless told otherwise; all of them if `PHASECLOUD_WHOLE` is set.
fn fineness() -> Fineness {
    let whole = Fineness::default();
    let share = if std::env::var_os("PHASECLOUD_WHOLE").is_some() { 1 } else { 10 };
    Fineness { components: whole.components / share, ..whole }
}

/// The error in deviations and the disagreement at each time.
fn judged(name: &str) -> Vec<(f64, f64, f64)> {
    let (plane, snapshots) = scenario(name);
    let relative = relative_deviation_of_radiation(name);
    let problem = UncertainProblem::new(plane, Spread { relative, distribution: Distribution::Gaussian }).unwrap();
    let found = problem.perform(Mixed(&problem, fineness()));
    println!("{name}: {} components, {} orbits", found.components, found.orbits);
    let one = |(k, snapshot): (usize, &Snapshot)| {
        let (difference, disagreement) = (apart(found.moments[k], snapshot.moments), found.disagreements[k]);
        println!("{name} at {} yr: off by {difference:.1e}, disagreement {disagreement:.3}", snapshot.years);
        println!("{:?} {:?}", found.moments[k], snapshot.moments);
        (snapshot.years, difference, disagreement)
    };
    snapshots.iter().enumerate().map(one).collect()
}

/// The reference is good to 1e-5, except for `uncertain-3` at two years (8.4e-4; see `uncertain.rs`).
#[test]
#[ignore = "long; .ci/long runs it"]
fn the_mixture_has_the_moments_of_the_reference_to_a_two_thousandth() {
    for name in ["uncertain-1", "uncertain-3"] {
        for (years, difference, disagreement) in judged(name) {
            let of_reference = if name == "uncertain-3" && years == 2.0 { 8.4e-4 } else { 1e-5 };
            assert!(difference < 5e-4 + of_reference, "{name} at {years} yr: {difference:e}");
            assert!(
                difference < 0.1 * disagreement + of_reference,
                "{name} at {years} yr: {difference:e} {disagreement}"
            );
        }
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_mixture_on_the_cliff_says_that_it_should_not_be_trusted() {
    for (years, difference, disagreement) in judged("cliff") {
        assert!(difference < 0.01 || disagreement > DISTRUST, "cliff at {years} yr: {difference:e} {disagreement}");
    }
}
