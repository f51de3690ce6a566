//! Points of a map in space: there is no exact curve, and every quantity is that of a quasi-random sample of orbits.
//!
//! Each orbit is followed to the end with a radiation parameter that is drawn for it. The borders in that parameter, by
//! which the plane is answered ([`super::by_orbits`]), are of no use here: near resonances with the Sun and the Moon
//! several of them lie within a tenth of the parameter, and halving finds one. All points have the same starts by their
//! numbers, so that a map is smooth where the probability is.

use crate::exact::Estimated;
use crate::in_space::SpaceProblem;

use super::UNKNOWN;
use super::cloud::Cloud;
use super::followed::{Followed, MOST_ORBITS};
use super::quantity::Quantity;
use super::replicates::Numbers;
use super::rows::Row;

/// The radiation parameter, or its mean.
pub(super) fn radiation(problem: &SpaceProblem) -> f64 {
    problem.model.forces().force.radiation
}

/// The quantity at each of some points, to about `tolerance`. Factors on the radiation parameter are not computed.
pub fn evaluate(points: &[SpaceProblem], quantity: Quantity, tolerance: f64) -> Row {
    match quantity {
        Quantity::RequiredFactor { .. } => vec![UNKNOWN; points.len()],
        _ => points.iter().map(|point| followed(point, quantity, tolerance)).collect(),
    }
}

/// The quantity of a point by orbits that are followed, each with the radiation parameter that was drawn for it.
fn followed(point: &SpaceProblem, quantity: Quantity, tolerance: f64) -> Estimated {
    let Ok(cloud) = Cloud::in_space(point) else { return UNKNOWN };
    let mut found = Followed::none(quantity);
    for numbers in Numbers::up_to(MOST_ORBITS) {
        found.add(&cloud, numbers);
        if found.figures().iter().all(|figure| figure.error <= tolerance) {
            break;
        }
    }
    quantity.of(&found.figures())
}

#[cfg(test)]
mod tests {
    use super::super::difference::{monte_carlo, space_less_plane};
    use super::super::rows::{self, Point};
    use super::*;
    use crate::in_space::example;
    use crate::uncertain::{Distribution, Spread};

    const TOLERANCE: f64 = 5e-3;

    fn with_radiation(problem: &SpaceProblem, radiation: f64) -> SpaceProblem {
        let mut changed = problem.clone();
        changed.model.forces_mut().force.radiation = radiation;
        changed
    }

    /// A cloud in the equator under a Sun in the equator, for which the planar model is right, with that of the plane.
    fn flat(radiation: f64) -> (SpaceProblem, Point) {
        let spread = Some(Spread { relative: 0.05, distribution: Distribution::LogNormal });
        let (problem, plane) = example::in_the_equator(radiation, spread);
        (problem, Point { problem: plane, spread })
    }

    #[test]
    #[ignore = "long; .ci/long runs it"]
    fn in_the_equator_every_quantity_is_that_of_the_exact_curve_within_its_error() {
        let (row, of_plane): (Vec<SpaceProblem>, Vec<Point>) = [0.06, 0.085, 0.1, 0.12].map(flat).into_iter().unzip();
        for quantity in [
            Quantity::Reentry { within: 1.0 },
            Quantity::TimeOfReentry { probability: 0.5, within: 1.0 },
            Quantity::MeanEccentricity { after: 1.0 },
        ] {
            let found = evaluate(&row, quantity, TOLERANCE);
            let exact = rows::evaluate(&of_plane, quantity, 2e-4);
            for (found, exact) in found.iter().zip(exact) {
                let is_same =
                    found.value == exact.value || (found.value - exact.value).abs() <= found.error + exact.error;
                assert!(is_same, "{quantity:?}: {found:?} {exact:?}");
            }
            assert!(found.iter().any(|found| found.error > 0.0 && found.error < 0.02), "{quantity:?}: {found:?}");
        }
    }

    #[test]
    #[ignore = "long; .ci/long runs it"]
    fn out_of_the_equator_the_probabilities_are_those_of_monte_carlo_within_both_errors() {
        let certain = SpaceProblem { spread: None, ..example::problem() };
        let quantity = Quantity::Reentry { within: 2.0 };
        let mut on_the_cliff = 0;
        for problem in [example::problem(), certain] {
            for inclination in [0.05, 0.2, 1.0] {
                let mut problem = problem.clone();
                problem.initial.mean[2] = inclination;
                let row = [0.09, 0.105, 0.12, 0.15, 0.2, 0.3].map(|radiation| with_radiation(&problem, radiation));
                let found = evaluate(&row, quantity, TOLERANCE);
                for (point, found) in row.iter().zip(found) {
                    let sampled = monte_carlo(&Cloud::in_space(point).unwrap(), quantity, 20_000, 7);
                    let difference = (found.value - sampled.value).abs();
                    assert!(difference <= found.error + sampled.error, "{inclination}: {found:?} {sampled:?}");
                    on_the_cliff += usize::from((0.02..0.98).contains(&found.value));
                }
            }
        }
        assert!(on_the_cliff >= 4, "{on_the_cliff}");
    }

    #[test]
    fn the_difference_to_the_plane_is_that_of_the_two_and_none_in_the_equator() {
        let quantity = Quantity::Reentry { within: 1.0 };
        let (problem, _) = flat(0.09);
        let none = space_less_plane(&[problem], quantity, TOLERANCE)[0];
        assert!(none.value.abs() <= none.error && none.error < TOLERANCE, "{none:?}");
        for quantity in [Quantity::Reentry { within: 2.0 }, Quantity::MeanEccentricity { after: 2.0 }] {
            let point = with_radiation(&example::problem(), 0.12);
            let found = space_less_plane(std::slice::from_ref(&point), quantity, TOLERANCE)[0];
            let sampled = |cloud| monte_carlo(&cloud, quantity, 40_000, 5);
            let one = sampled(Cloud::in_space(&point).unwrap());
            let other = sampled(Cloud::flattened(&point).unwrap());
            let difference = one.value - other.value;
            assert!(difference.abs() > 2e-3, "{difference}");
            assert!(
                (found.value - difference).abs() <= found.error + one.error + other.error,
                "{found:?} {difference}"
            );
        }
    }
}
