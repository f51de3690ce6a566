//! When the orbits of a panel rise above the critical eccentricity.

use crate::exact::contour::Contour;
use crate::flow_map::chebyshev::{Basis, MOST_NODES, series};
use crate::flow_map::passing::TIME_ERROR;
use crate::model::earth::SUN_MEAN_MOTION;

/// The time on the orbit, between 0 and half a period, from which on an orbit is above the critical eccentricity until
/// the mirror image of that time.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rise {
    /// None of them is ever above it.
    Never,
    /// All of them always are.
    Always,
    /// The series of the time \[rad\] in the panel's local coordinate.
    At([f64; MOST_NODES]),
    /// It has to be searched for on every orbit: among these orbits are such as just touch the critical eccentricity.
    Search,
}

/// What is known from the orbits at the nodes and at further points (`checks`), with an estimate of the error of the
/// time \[yr\].
pub(super) fn rise_of(basis: &Basis, nodes: &[&Contour], checks: &[(f64, &Contour)], critical_e: f64) -> (Rise, f64) {
    let all = || nodes.iter().copied().chain(checks.iter().map(|(_, orbit)| *orbit));
    let rises: Vec<Option<f64>> = all().map(|orbit| orbit.rises_above(critical_e)).collect();
    if rises.iter().all(Option::is_none) {
        return (Rise::Never, 0.0);
    }
    if rises.iter().all(|rise| *rise == Some(0.0)) {
        return (Rise::Always, 0.0);
    }
    let Some(mut values) = rises.iter().map(|rise| rise.filter(|&time| time > 0.0)).collect::<Option<Vec<f64>>>()
    else {
        return (Rise::Search, 0.0);
    };
    let right = values.split_off(nodes.len());
    basis.transform::<1>(&mut values);
    let mut coefficients = [0.0; MOST_NODES];
    coefficients[..values.len()].copy_from_slice(&values);
    let off = checks.iter().zip(right).map(|((a, _), right)| (series(&coefficients, *a) - right).abs());
    let error = off.fold(0.0, f64::max) / SUN_MEAN_MOTION;
    if error < TIME_ERROR { (Rise::At(coefficients), error) } else { (Rise::Search, 0.0) }
}
