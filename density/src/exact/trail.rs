//! An orbit as points close enough together for cubic interpolation of solar angle and eccentricity.
//!
//! Both are monotone between two points: there is a point wherever the solar angle turns back, so that no line can be
//! passed twice unseen.

use crate::angle::nearest;
use crate::model::plane::{PlanarHamiltonian, State};

use super::contour::Contour;

/// Number of points per integrator step.
const POINTS: u32 = 6;
/// Largest turn of the solar angle between two points \[rad\].
const TURN: f64 = 0.25;
/// Number of halvings after which two points are left as they are.
const DEEPEST: u32 = 24;

/// A point of an orbit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OrbitPoint {
    /// Time on the orbit \[rad\].
    pub theta: f64,
    /// Solar angle, continued without jumps \[rad\].
    pub phi: f64,
    pub e: f64,
}

/// The points of an orbit, from minus to plus half a period.
#[derive(Debug, Clone)]
pub(crate) struct Trail {
    pub points: Vec<OrbitPoint>,
}

impl Trail {
    pub(crate) fn new(contour: &Contour, model: &impl PlanarHamiltonian) -> Self {
        let first = contour.at(0.0);
        let mut half = vec![OrbitPoint { theta: 0.0, phi: first.solar_angle(), e: first.eccentricity() }];
        let knots: Vec<f64> = contour.knots().collect();
        for pair in knots.windows(2) {
            for k in 1..=POINTS {
                let theta = pair[0] + (pair[1] - pair[0]) * f64::from(k) / f64::from(POINTS);
                extend(&mut half, contour, theta, DEEPEST);
            }
        }
        let half = with_turning_points(half, contour, model);
        // On the axis, phi is 0 or π, and the other half is the mirror image about it.
        let axis = half[0].phi;
        let mirrored = half.iter().skip(1).rev();
        let mirrored = mirrored.map(|p| OrbitPoint { theta: -p.theta, phi: 2.0 * axis - p.phi, e: p.e });
        let points = mirrored.collect::<Vec<_>>().into_iter().chain(half.iter().copied()).collect();
        Self { points }
    }
}

fn extend(points: &mut Vec<OrbitPoint>, contour: &Contour, theta: f64, depth: u32) {
    let Some(&last) = points.last() else { return };
    let state: State = contour.at(theta);
    let phi = nearest(state.solar_angle(), last.phi);
    let middle = last.theta.midpoint(theta);
    let halfway = nearest(contour.at(middle).solar_angle(), last.phi);
    // Near e = 0 half a turn may pass between two points.
    let turned = (halfway - last.phi).abs() + (phi - halfway).abs();
    if turned > TURN && depth > 0 && middle > last.theta && middle < theta {
        extend(points, contour, middle, depth - 1);
        extend(points, contour, theta, depth - 1);
    } else {
        points.push(OrbitPoint { theta, phi, e: state.eccentricity() });
    }
}

/// Adds the points at which the solar angle turns back.
fn with_turning_points(points: Vec<OrbitPoint>, contour: &Contour, model: &impl PlanarHamiltonian) -> Vec<OrbitPoint> {
    let mut all: Vec<OrbitPoint> = Vec::with_capacity(points.len() + 4);
    let grows = |point: &OrbitPoint| point.rates(model).0 > 0.0;
    for point in points {
        if let Some(last) = all.last().copied().filter(|last| grows(last) != grows(&point)) {
            let at = |theta: f64| {
                let state = contour.at(theta);
                OrbitPoint { theta, phi: nearest(state.solar_angle(), last.phi), e: state.eccentricity() }
            };
            let (mut low, mut high) = (last.theta, point.theta);
            for _ in 0..40 {
                let middle = low.midpoint(high);
                if grows(&at(middle)) == grows(&last) { low = middle } else { high = middle }
            }
            if low > last.theta {
                all.push(at(low));
            }
        }
        all.push(point);
    }
    all
}

impl OrbitPoint {
    /// Rates of solar angle and eccentricity per unit of time on the orbit.
    pub(crate) fn rates(&self, model: &impl PlanarHamiltonian) -> (f64, f64) {
        model.polar_rates(self.phi, self.e)
    }
}
