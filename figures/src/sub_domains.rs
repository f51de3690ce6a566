//! Sub-domains of the phase portrait: how the solar angle moves along a contour, and where this changes.
//!
//! The Hamiltonian is even in `phi`, so a closed contour meets the axis `sin(phi) = 0` twice. Between the stationary
//! points, where all of them lie on that axis, the Hamiltonian is monotone along it, so where a contour ends is found
//! without a scan. Where gravity of the Sun outweighs the radiation pressure some lie off the axis; the sub-domains of
//! such a portrait have no numbers.
//!
//! Sun et al. (2022) number the three sub-domains of their portrait, which is of type III (Krivov & Getino 1997),
//! between the levels of its stationary points. Each of them holds one kind of motion, and here the numbers stand for
//! the kinds of motion in all portraits: 1 about the centre at `phi = π`, 2 round `e = 0`, 3 about the centre at `phi =
//! 0`. A portrait need not have all of them.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use density::model::PlanarHamiltonian;
use density::model::plane::State;

use crate::elements::Point;
use crate::hamiltonian::{self, Stationary, is_still};

/// The motion of the solar angle along a contour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Motion {
    /// It swings about π.
    AboutPi,
    /// It goes round inside every saddle.
    Round,
    /// It swings about 0.
    AboutZero,
    /// It goes round outside a saddle.
    Beyond,
    /// The contour leads to `e = 1`.
    Open,
    /// Nobody says: there are stationary points off the axis.
    Unsorted,
}

impl Motion {
    /// The number of the sub-domain. Contours that lead to `e = 1`, or that go round all others towards it, have none.
    pub fn number(self) -> Option<usize> {
        match self {
            Self::AboutPi => Some(1),
            Self::Round => Some(2),
            Self::AboutZero => Some(3),
            Self::Beyond | Self::Open | Self::Unsorted => None,
        }
    }

    /// The motion in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::AboutPi => "φ swings about π",
            Self::Round => "φ goes round e = 0",
            Self::AboutZero => "φ swings about 0",
            Self::Beyond => "φ goes round outside of the saddle, towards e = 1",
            Self::Open => "the contours end at e = 1",
            Self::Unsorted => "stationary points lie off the axis, and the sub-domains are not numbered",
        }
    }
}

/// The motion along the contour through `(phi, e)`.
pub fn motion<M: PlanarHamiltonian>(model: M, points: &[Stationary], phi: f64, e: f64) -> Motion {
    if is_still(model) {
        return Motion::Round;
    }
    if !model.eccentricity_follows_x1() {
        return Motion::Unsorted;
    }
    let level = hamiltonian::at(model, phi, e);
    let signed = |x2: f64| model.hamiltonian(State { x1: 0.0, x2 }) - level;
    // On the contour the Hamiltonian at phi = 0 is at least the level, at phi = π at most.
    let is_on = |e: f64| signed(e) >= 0.0 && signed(-e) <= 0.0;
    let mut turns: Vec<f64> = points.iter().map(|point| point.e).filter(|e| *e > 0.0).collect();
    turns.sort_by(f64::total_cmp);
    let highest = 1.0 - 1e-9;
    let upwards = turns.iter().copied().filter(|turn| *turn > e).chain([highest]);
    let downwards = turns.iter().rev().copied().filter(|turn| *turn < e).chain([0.0]);
    let Some(upper) = end_of(is_on, e, upwards) else { return Motion::Open };
    let lower = end_of(is_on, e, downwards).unwrap_or(0.0);
    // The end is at phi = 0 if the condition there is the one that fails next.
    let is_at_zero = |e: f64| signed(e).abs() < signed(-e).abs();
    let crossing = |e: f64| if is_at_zero(e) { e } else { -e };
    let (p, q) = (crossing(lower), crossing(upper));
    let has_saddle = points.iter().any(|s| !s.is_centre && (p.min(q)..p.max(q)).contains(&(s.e * s.phi.cos())));
    match (p >= 0.0, q >= 0.0) {
        (true, true) => Motion::AboutZero,
        (false, false) => Motion::AboutPi,
        _ if has_saddle => Motion::Beyond,
        _ => Motion::Round,
    }
}

/// Where `is_on` ends on the way from `start` through `nodes`; between two nodes each of its conditions fails at most
/// once.
fn end_of(is_on: impl Fn(f64) -> bool, start: f64, nodes: impl Iterator<Item = f64>) -> Option<f64> {
    let mut inside = start;
    for node in nodes {
        if !is_on(node) {
            return Some(hamiltonian::border(&is_on, node, inside));
        }
        inside = node;
    }
    None
}

/// The contours that divide sub-domains, with `phi` in `[0, π]`: the one through `e = 0`, where the `(phi, e)` plane
/// has a kink, and those through the saddles. A level may have parts elsewhere; they divide nothing.
pub fn borders<M: PlanarHamiltonian>(model: M, points: &[Stationary]) -> Vec<Vec<Point>> {
    if is_still(model) {
        return Vec::new();
    }
    let through_zero = hamiltonian::contour(model, hamiltonian::at(model, 0.0, 0.0));
    let mut borders: Vec<Vec<Point>> =
        through_zero.into_iter().filter(|piece| piece.first().is_some_and(|(_, e)| *e < 1e-4)).collect();
    for saddle in points.iter().filter(|point| !point.is_centre) {
        let meets = |&(phi, e): &Point| (e - saddle.e).abs() < 1e-4 && (phi - saddle.phi).abs() < 0.1;
        let pieces = hamiltonian::contour(model, saddle.level);
        borders.extend(
            pieces.into_iter().filter(|piece| piece.first().is_some_and(meets) || piece.last().is_some_and(meets)),
        );
    }
    borders
}

/// The motions that the portrait has up to the eccentricity `highest`.
pub fn present<M: PlanarHamiltonian>(model: M, points: &[Stationary], highest: f64) -> BTreeSet<Motion> {
    const SIDE: usize = 40;
    let middle = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let lattice = (0..SIDE * SIDE).map(|k| motion(model, points, PI * middle(k / SIDE), highest * middle(k % SIDE)));
    let is_shown = |point: &&Stationary| point.is_centre && point.e > 1e-9 && point.e < highest;
    let about = |point: &Stationary| if point.phi.cos() > 0.0 { Motion::AboutZero } else { Motion::AboutPi };
    let centres =
        points.iter().filter(is_shown).filter(|_| !is_still(model) && model.eccentricity_follows_x1()).map(about);
    lattice.chain(centres).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::model::planar::SrpJ2;

    fn force(radiation: f64, oblateness: f64) -> SrpJ2 {
        SrpJ2 { radiation, oblateness }
    }

    fn numbers(radiation: f64, oblateness: f64) -> Vec<usize> {
        let force = force(radiation, oblateness);
        let present = present(force, &hamiltonian::stationary_points(force), 0.95);
        present.into_iter().filter_map(Motion::number).collect()
    }

    #[test]
    fn the_papers_three_scenarios_lie_in_the_sub_domains_that_it_says() {
        let force = force(0.15, 0.40921);
        let points = hamiltonian::stationary_points(force);
        for (number, (phi, e)) in [(1, (2.2069, 0.145)), (2, (0.5419, 0.095)), (3, (0.3004, 0.23))] {
            assert_eq!(motion(force, &points, phi, e).number(), Some(number));
        }
        assert_eq!(motion(force, &points, 0.0, 0.7), Motion::Beyond);
    }

    #[test]
    fn a_portrait_has_the_sub_domains_that_its_stationary_points_allow_and_no_others() {
        assert_eq!(numbers(0.15, 0.40921), [1, 2, 3]);
        assert_eq!(numbers(0.15, 0.2), [1, 2, 3]);
        assert_eq!(numbers(0.15, 0.0), [2, 3], "without oblateness there is no centre at phi = π");
        assert_eq!(numbers(1.0, 0.40921), [1, 2], "strong radiation has no centre at phi = 0");
        assert_eq!(numbers(0.15, 2.0), [1, 2]);
        assert_eq!(numbers(0.0, 0.40921), [2], "without radiation pressure e stands still and phi goes round");
    }

    #[test]
    fn the_contour_through_e_0_is_inside_of_the_saddle_where_oblateness_is_small() {
        // The level of e = 0 is above that of the saddle there, so numbers by ascending level would be wrong.
        let force = force(0.15, 0.2);
        let points = hamiltonian::stationary_points(force);
        let at = |phi: f64, e: f64| motion(force, &points, phi, e);
        assert_eq!(at(0.0, 0.1), Motion::AboutZero);
        assert_eq!(at(PI, 0.1), Motion::Round);
        assert_eq!(at(PI, 0.6), Motion::AboutPi);
        assert_eq!(at(0.0, 0.79), Motion::Beyond, "the same level as circulating contours below, but another contour");
    }

    #[test]
    fn a_border_leads_through_e_0_or_through_a_saddle() {
        for force in [force(0.15, 0.40921), force(0.15, 0.2), force(0.01, 0.9), force(1.0, 0.40921)] {
            let points = hamiltonian::stationary_points(force);
            let borders = borders(force, &points);
            assert!(!borders.is_empty());
            for piece in borders {
                let ends = [piece[0], *piece.last().unwrap()];
                let is_saddle = |e: f64| points.iter().any(|p| !p.is_centre && (p.e - e).abs() < 1e-4);
                assert!(ends.iter().any(|&(_, e)| e < 1e-4 || is_saddle(e)), "{force:?} {ends:?}");
            }
        }
    }
}
