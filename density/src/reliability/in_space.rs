//! Points of a map in space: there is no exact curve, and every quantity is that of a quasi-random sample of orbits.
//!
//! All points have the same starts by their numbers, so that a map is smooth where the probability is ([`super::by_orbits`]).

use crate::exact::Estimated;
use crate::in_space::SpaceProblem;

use super::by_orbits::{Asked, ByOrbits};
use super::cloud::Cloud;
use super::followed::Followed;
use super::quantity::Quantity;
use super::replicates::Numbers;
use super::required::{error_at, factor_for};
use super::rows::{REACH, Row, SMALLEST};
use super::{UNKNOWN, by_orbits};

/// Whether two points share the radiation parameters with which their orbits pass.
pub fn are_alike(one: &SpaceProblem, other: &SpaceProblem) -> bool {
    let kind = |problem: &SpaceProblem| problem.spread.map(|spread| spread.distribution);
    let mut moved = SpaceProblem { spread: one.spread, times: one.times.clone(), ..other.clone() };
    moved.model.forces_mut().force.radiation = radiation(one);
    kind(one) == kind(other) && moved == *one
}

/// The radiation parameter, or its mean.
pub(super) fn radiation(problem: &SpaceProblem) -> f64 {
    problem.model.forces().force.radiation
}

/// The quantity at each of the points of a row, which must be alike ([`are_alike`]), to about `tolerance`.
pub fn evaluate(row: &[SpaceProblem], quantity: Quantity, tolerance: f64) -> Row {
    let by_borders = asked(row, quantity).zip(row.first().and_then(|first| Cloud::in_space(first).ok()));
    match (by_borders, quantity) {
        (Some((asked, cloud)), _) => with_borders(row, quantity, tolerance, (&cloud, asked)),
        (None, Quantity::RequiredFactor { .. }) => vec![UNKNOWN; row.len()],
        (None, _) => row.iter().map(|point| followed(point, quantity, tolerance)).collect(),
    }
}

/// The quantity by the radiation parameters with which orbits pass.
fn with_borders(row: &[SpaceProblem], quantity: Quantity, tolerance: f64, (cloud, asked): (&Cloud, Asked)) -> Row {
    let probability = |orbits: &ByOrbits, point: &SpaceProblem, factor: f64| {
        orbits.probability(factor * radiation(point), point.spread)
    };
    let error = |orbits: &ByOrbits| {
        let at = |point: &SpaceProblem| error_at(quantity, |factor| probability(orbits, point, factor));
        row.iter().map(at).fold(0.0, f64::max)
    };
    let orbits = ByOrbits::new(cloud, asked, tolerance, error);
    let at = |point: &SpaceProblem| match quantity {
        Quantity::RequiredFactor { probability: wanted, .. } => {
            factor_for(wanted, |factor| probability(&orbits, point, factor))
        }
        _ => probability(&orbits, point, 1.0),
    };
    row.iter().map(at).collect()
}

/// Which radiation parameters the quantity of a row needs; `None` if it does not follow from them, or if there is no radiation pressure.
pub(super) fn asked(row: &[SpaceProblem], quantity: Quantity) -> Option<Asked> {
    let (Quantity::Reentry { within: years } | Quantity::RequiredFactor { within: years, .. }) = quantity else {
        return None;
    };
    let (least, most) = quantity.factors();
    let ends = row.iter().map(|point| {
        let mean = radiation(point);
        let at = |z: f64| point.spread.map_or(mean, |spread| spread.radiation(mean, z.max(spread.lowest())));
        (least * at(-REACH), most * at(REACH))
    });
    let (low, high) = ends.fold((f64::INFINITY, 0.0f64), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let spreads = row.iter().map(|point| point.spread.map_or(0.0, |spread| spread.relative));
    let narrowest = spreads.fold(f64::INFINITY, f64::min);
    let acts = row.iter().all(|point| radiation(point) > 0.0);
    acts.then_some(Asked { ends: (low.max(SMALLEST * high), high), narrowest, years })
}

/// The quantity of a point by orbits that are followed, each with the radiation parameter that was drawn for it.
fn followed(point: &SpaceProblem, quantity: Quantity, tolerance: f64) -> Estimated {
    let Ok(cloud) = Cloud::in_space(point) else { return UNKNOWN };
    let mut found = Followed::none(quantity);
    for numbers in Numbers::up_to(2 * by_orbits::MOST_STARTS) {
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
    use crate::in_space::models::SpaceModel;
    use crate::in_space::{InitialInSpace, example};
    use crate::model::vectorial::Vectorial;
    use crate::problem::{InitialGaussian, Problem};
    use crate::uncertain::{Distribution, Spread};

    const TOLERANCE: f64 = 2e-3;

    fn with_radiation(problem: &SpaceProblem, radiation: f64) -> SpaceProblem {
        let mut changed = problem.clone();
        changed.model.forces_mut().force.radiation = radiation;
        changed
    }

    /// A cloud in the equator under a Sun in the equator, for which the planar model is right, with that of the plane.
    fn flat(radiation: f64) -> (SpaceProblem, Point) {
        let mut problem = with_radiation(&example::problem(), radiation);
        let Vectorial { mut forces, sun_longitude, .. } = problem.model.averaged();
        (forces.sun, forces.moon) = (0.0, 0.0);
        problem.model =
            SpaceModel::Vectorial { model: Vectorial { forces, sun_longitude, obliquity: 0.0 }, axis: None };
        (problem.initial.mean[2], problem.initial.sigma[2], problem.initial.sigma[3]) = (0.0, 0.0, 0.0);
        problem.initial.correlation = [0.0; 6];
        problem.spread = Some(Spread { relative: 0.05, distribution: Distribution::LogNormal });
        problem.critical_e = 0.52;
        let InitialInSpace { mean, sigma, .. } = problem.initial;
        let initial = InitialGaussian {
            mean_phi: mean[0],
            mean_e: mean[1],
            sigma_phi: sigma[0],
            sigma_e: sigma[1],
            correlation: 0.0,
        };
        let plane = Problem { model: problem.model.planar(), initial, times: problem.times.clone(), critical_e: 0.52 };
        let point = Point { problem: plane, spread: problem.spread };
        (problem, point)
    }

    #[test]
    fn in_the_equator_every_quantity_is_that_of_the_exact_curve_within_its_error() {
        let (row, of_plane): (Vec<SpaceProblem>, Vec<Point>) = [0.06, 0.085, 0.1, 0.12].map(flat).into_iter().unzip();
        for quantity in [
            Quantity::Reentry { within: 1.0 },
            Quantity::RequiredFactor { probability: 0.9, within: 1.0 },
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

    #[test]
    fn points_share_their_orbits_if_they_differ_in_the_radiation_parameter_alone() {
        let one = example::problem();
        assert!(are_alike(&one, &with_radiation(&one, 0.3)));
        let mut other = with_radiation(&one, 0.3);
        other.initial.mean[2] = 0.3;
        assert!(!are_alike(&one, &other));
        assert!(!are_alike(&one, &SpaceProblem { spread: None, ..one.clone() }));
    }
}
