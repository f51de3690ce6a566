//! Contours of the Hamiltonian in the `(phi, e)` plane, and its stationary points.
//!
//! At a given eccentricity the Hamiltonian of every planar model so far is `h0 + h1 cos(phi) + h2 cos²(phi)`; `h2` is
//! the Sun's gravity. No contours are drawn of a model with another Hamiltonian ([`check_form`]). On a contour `H = h`
//! the solar angle follows from the eccentricity in closed form, and contours
//! are drawn piece by piece between the eccentricities where the right side passes ±1 or ceases to be real, with points
//! that crowd where the curve turns.

use std::f64::consts::{FRAC_PI_2, PI};

use density::model::PlanarHamiltonian;
use density::model::plane::{State, zero_between};
use density::model::registry::Planar;

use crate::draw_error::DrawError;
use crate::elements::Point;

/// Number of eccentricities at which pieces of a contour are looked for.
const NODES: usize = 480;
/// Number of points of a piece.
const POINTS: usize = 40;
/// Largest eccentricity drawn.
const HIGHEST: f64 = 0.995;

/// A pull below this leaves the eccentricity as it is.
const STILL: f64 = 1e-9;

/// Whether the eccentricity of every orbit stays as it is.
pub fn is_still<M: PlanarHamiltonian>(model: M) -> bool {
    model.pull() < STILL
}

/// The Hamiltonian at `(phi, e)`.
pub fn at<M: PlanarHamiltonian>(model: M, phi: f64, e: f64) -> f64 {
    model.hamiltonian(State::from_polar(phi, e))
}

/// Refuses a model whose contours are not known here.
///
/// # Errors
/// [`DrawError`] in words.
pub fn check_form(model: Planar) -> Result<(), DrawError> {
    match is_quadratic_in_cosine(|phi, e| at(model, phi, e)) {
        true => Ok(()),
        false => Err(DrawError(format!(
            "contours of the model \"{}\" are not drawn: its Hamiltonian is not quadratic in cos φ",
            model.name()
        ))),
    }
}

/// Whether the Hamiltonian has, at every eccentricity, the form from which contours follow here.
fn is_quadratic_in_cosine(hamiltonian: impl Fn(f64, f64) -> f64) -> bool {
    let fits = |phi: f64, e: f64| {
        let [h0, h1, h2] = coefficients(|phi| hamiltonian(phi, e));
        let cos = phi.cos();
        let right = hamiltonian(phi, e);
        (h0 + h1 * cos + h2 * cos * cos - right).abs() < 1e-12 * right.abs().max(1.0)
    };
    [0.7, 1.2, 2.3, 4.0].into_iter().all(|phi| [0.1, 0.45, 0.8].into_iter().all(|e| fits(phi, e)))
}

/// `h0`, `h1` and `h2` of the Hamiltonian on a circle of constant eccentricity.
fn coefficients(on_circle: impl Fn(f64) -> f64) -> [f64; 3] {
    let [ahead, aside, behind] = [0.0, FRAC_PI_2, PI].map(on_circle);
    [aside, 0.5 * (ahead - behind), 0.5 * (ahead + behind) - aside]
}

/// The cosines of the solar angle at which a contour meets the circle of eccentricity `e`: on the branch that is there
/// without `h2`, and on the other. NaN where there is none.
fn cosines<M: PlanarHamiltonian>(model: M, level: f64, e: f64) -> [f64; 2] {
    let [aside, h1, h2] = coefficients(|phi| at(model, phi, e));
    let h0 = aside - level;
    if h2.abs() < 8.0 * f64::EPSILON * aside.abs() {
        return [-h0 / h1, f64::NAN];
    }
    let q = -0.5 * (h1 + (h1 * h1 - 4.0 * h2 * h0).sqrt());
    [h0 / q, q / h2]
}

/// The pieces of the contour `H = level` with `phi` in `[0, π]`; its mirror images in `phi` belong to it too.
pub fn contour<M: PlanarHamiltonian>(model: M, level: f64) -> Vec<Vec<Point>> {
    if is_still(model) {
        return level_circles(model, level);
    }
    (0..2).flat_map(|branch| pieces(model, level, |e| cosines(model, level, e)[branch])).collect()
}

/// The pieces of a contour on which its solar angle has this cosine.
fn pieces<M: PlanarHamiltonian>(model: M, level: f64, cosine: impl Fn(f64) -> f64) -> Vec<Vec<Point>> {
    let is_on = |e: f64| cosine(e).abs() <= 1.0;
    let mut nodes: Vec<f64> = (0..=NODES).map(|i| 1e-6 + (HIGHEST - 1e-6) * i as f64 / NODES as f64).collect();
    // Contours turn sharply in a saddle; a piece ends there.
    let stationary = stationary_points(model);
    let corners: Vec<f64> = stationary.iter().filter(|p| (p.level - level).abs() < 1e-9).map(|p| p.e).collect();
    nodes.retain(|e| corners.iter().all(|corner| (e - corner).abs() > 1e-5));
    nodes.extend(corners.iter().flat_map(|corner| [corner - 1e-6, *corner, corner + 1e-6]));
    nodes.sort_by(f64::total_cmp);
    let is_on = |e: f64| is_on(e) && !corners.contains(&e);
    let mut pieces = Vec::new();
    let mut begin = nodes.first().copied().filter(|e| is_on(*e));
    for pair in nodes.windows(2) {
        let &[low, high] = pair else { continue };
        match (is_on(low), is_on(high), begin) {
            (false, true, _) => begin = Some(border(is_on, low, high)),
            (true, false, Some(start)) => {
                pieces.push(start..border(is_on, high, low));
                begin = None;
            }
            _ => {}
        }
    }
    pieces.extend(begin.map(|start| start..HIGHEST));
    let points = |piece: std::ops::Range<f64>| {
        let point = |k: usize| {
            let e = 0.5 * (piece.start + piece.end)
                - 0.5 * (piece.end - piece.start) * (PI * k as f64 / POINTS as f64).cos();
            (cosine(e).clamp(-1.0, 1.0).acos(), e)
        };
        (0..=POINTS).map(point).collect()
    };
    pieces.into_iter().map(points).collect()
}

/// The last place on the way from `inside`, where `is_on` holds, to `outside` at which it still holds.
pub(crate) fn border(is_on: impl Fn(f64) -> bool, outside: f64, inside: f64) -> f64 {
    let (mut outside, mut inside) = (outside, inside);
    for _ in 0..48 {
        let middle = outside.midpoint(inside);
        if is_on(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// Where nothing pulls, contours are circles of constant eccentricity.
fn level_circles<M: PlanarHamiltonian>(model: M, level: f64) -> Vec<Vec<Point>> {
    let excess = |e: f64| at(model, 0.0, e) - level;
    let node = |i: usize| HIGHEST * i as f64 / NODES as f64;
    let crossings = (0..NODES).filter(|&i| excess(node(i)) * excess(node(i + 1)) <= 0.0);
    crossings.map(|i| 0.5 * (node(i) + node(i + 1))).map(|e| vec![(0.0, e), (PI, e)]).collect()
}

/// A stationary point of the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stationary {
    /// Solar angle \[rad\].
    pub phi: f64,
    /// Eccentricity.
    pub e: f64,
    /// Whether contours around it are closed (a centre); otherwise they cross in it (a saddle).
    pub is_centre: bool,
    /// Its Hamiltonian.
    pub level: f64,
}

impl Stationary {
    /// Whether it lies on the axis `phi = 0` or `π`.
    pub fn is_on_axis(&self) -> bool {
        (self.e * self.phi.sin()).abs() < 1e-9
    }
}

/// Where nothing pulls: the eccentricity of the circle on which every point stands still, if there is one.
pub fn still_circle<M: PlanarHamiltonian>(model: M) -> Option<f64> {
    if !is_still(model) {
        return None;
    }
    let turning = |e: f64| model.polar_rates(0.0, e).0;
    let node = |i: usize| 1e-6 + (HIGHEST - 1e-6) * i as f64 / NODES as f64;
    let change = (0..NODES).find(|&i| turning(node(i)).signum() != turning(node(i + 1)).signum())?;
    Some(zero_between(turning, node(change), node(change + 1)))
}

/// The single stationary points of the flow; where nothing pulls that is `e = 0` alone.
pub fn stationary_points<M: PlanarHamiltonian>(model: M) -> Vec<Stationary> {
    let is_single = |state: &State| !is_still(model) || state.eccentricity() < 1e-6;
    let point = |state: State| {
        const H: f64 = 1e-4;
        let moved = |x1: f64, x2: f64| model.hamiltonian(State { x1: state.x1 + H * x1, x2: state.x2 + H * x2 });
        let curvature = |x1: f64, x2: f64| (moved(x1, x2) - 2.0 * moved(0.0, 0.0) + moved(-x1, -x2)) / (H * H);
        let (along_x1, along_x2) = (curvature(1.0, 0.0), curvature(0.0, 1.0));
        let mixed = 0.25 * (curvature(1.0, 1.0) - curvature(1.0, -1.0));
        Stationary {
            phi: state.solar_angle(),
            e: state.eccentricity(),
            is_centre: along_x1 * along_x2 > mixed * mixed,
            level: model.hamiltonian(state),
        }
    };
    let all = [model.stationary_points(), model.stationary_points_off_axis()].concat();
    let states = all.into_iter().filter(is_single);
    states.filter(|state| state.eccentricity() < HIGHEST).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::model::planar::SrpJ2;
    use density::model::sun_moon::SunMoon;

    const PAPER: SrpJ2 = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };

    #[test]
    fn every_point_of_a_contour_has_its_level() {
        for level in [0.98, 1.05, 1.1364, 1.151, 1.3] {
            let pieces = contour(PAPER, level);
            assert!(!pieces.is_empty(), "{level}");
            for &(phi, e) in pieces.iter().flatten() {
                assert!((at(PAPER, phi, e) - level).abs() < 1e-9, "{level} {phi} {e}");
            }
        }
    }

    #[test]
    fn contours_with_the_suns_gravity_have_their_level_on_both_branches_and_points_off_the_axis_are_found() {
        let weak = SunMoon { force: SrpJ2 { radiation: 0.02, oblateness: 0.40921 }, sun: 0.01, moon: 0.02 };
        let points = stationary_points(weak);
        let off_axis: Vec<_> = points.iter().filter(|point| !point.is_on_axis()).collect();
        assert_eq!(off_axis.len(), 2, "{points:?}");
        for level in off_axis.iter().map(|point| point.level).flat_map(|level| [level - 1e-4, level, level + 1e-4]) {
            for &(phi, e) in contour(weak, level).iter().flatten() {
                assert!((at(weak, phi, e) - level).abs() < 1e-9, "{level} {phi} {e}");
            }
        }
        let near = |level: f64| {
            contour(weak, level).concat().iter().any(|&(phi, e)| (phi - off_axis[0].phi).hypot(e - off_axis[0].e) < 0.1)
        };
        assert!(near(off_axis[0].level + 1e-4) || near(off_axis[0].level - 1e-4), "no contour goes round {off_axis:?}");
    }

    #[test]
    fn contours_are_drawn_of_hamiltonians_of_the_known_form_alone() {
        let all = SunMoon { force: PAPER, sun: 0.01, moon: 0.02 };
        assert!(check_form(PAPER.into()).is_ok() && check_form(all.into()).is_ok());
        assert!(!is_quadratic_in_cosine(|phi, e| at(PAPER, phi, e) + 1e-6 * e * (3.0 * phi).cos()));
        assert!(!is_quadratic_in_cosine(|phi, e| at(PAPER, phi, e) + 1e-6 * e * phi.sin()));
    }

    #[test]
    fn the_papers_portrait_has_two_centres_and_a_saddle() {
        let points = stationary_points(PAPER);
        assert_eq!(points.iter().map(|p| p.is_centre).collect::<Vec<_>>(), [true, true, false]);
        assert!((points[2].level - 1.150996).abs() < 1e-6, "{points:?}");
    }

    #[test]
    fn without_radiation_pressure_a_circle_stands_still_and_e_0_is_the_only_single_point() {
        let force = SrpJ2 { radiation: 0.0, oblateness: 0.40921 };
        let points = stationary_points(force);
        assert!(points.iter().all(|p| p.e < 1e-6 && p.is_centre) && points.len() == 1, "{points:?}");
        assert!((still_circle(force).unwrap() - (1.0 - 0.40921f64.sqrt()).sqrt()).abs() < 1e-12);
        assert_eq!(still_circle(SrpJ2 { radiation: 0.0, oblateness: 2.0 }), None);
    }

    #[test]
    fn without_radiation_pressure_contours_have_constant_eccentricity() {
        let force = SrpJ2 { radiation: 0.0, oblateness: 0.0 };
        let pieces = contour(force, 0.8);
        assert!(pieces.iter().flatten().all(|&(_, e)| (e - 0.6).abs() < 2e-3), "{pieces:?}");
    }
}
