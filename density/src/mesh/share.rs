//! Divides the probability of carried triangles among the bins.
//!
//! Each triangle's probability is spread in proportion to the densities that its corners carry, and cut exactly along
//! the edges of the bins. Whatever the flow does to a triangle, all of its probability is counted somewhere.

use std::f64::consts::TAU;

use super::polygon::{BinUnits, Corner, Polygon, share_above, twice_area};
use super::readout::{Node, Part, for_each_part, polar};
use crate::angle::fold;
use crate::grid::Grid;

/// The contribution of some of the triangles to a snapshot.
pub(super) struct Share {
    units: BinUnits,
    branch_low: f64,
    critical_e: f64,
    /// Probability of each bin.
    pub(super) joint: Vec<f64>,
    /// Probability above the critical eccentricity.
    pub(super) above: f64,
}

impl Share {
    /// A contribution of zero.
    pub(super) fn new(grid: &Grid, critical_e: f64) -> Self {
        Self {
            units: BinUnits::new(grid),
            branch_low: grid.branch_low(),
            critical_e,
            joint: vec![0.0; grid.len()],
            above: 0.0,
        }
    }

    /// Divides the probability `mass` of a carried triangle among the bins.
    pub(super) fn add(&mut self, triangle: &[Node; 3], mass: f64) {
        if let Some(corners) = polar(triangle) {
            let integral = Polygon::new(&corners).integral().abs();
            if (mass / integral).is_finite() {
                return self.add_triangle(&corners, mass, mass / integral);
            }
        }
        let mut integral = 0.0;
        for_each_part(triangle, &mut |part| integral += part.integral());
        let scale = mass / integral;
        if scale.is_finite() {
            for_each_part(triangle, &mut |part| match part {
                Part::Triangle(corners) => self.add_triangle(corners, scale * part.integral(), scale),
                Part::Point { phi, e, .. } => self.add_point(*phi, *e, scale * part.integral()),
            });
        } else {
            self.add_point(triangle[0].phi, triangle[0].e, mass);
        }
    }

    /// Divides a triangle of probability `mass` among the bins; `scale` is `mass` over the integral of its density.
    fn add_triangle(&mut self, corners: &[Corner; 3], mass: f64, scale: f64) {
        self.above += mass * share_above(corners, self.critical_e);
        // A part that is turned over has a negative integral, but its probability is positive all the same.
        let scale = scale.copysign(twice_area(corners));
        let shift = fold(corners[0][0], self.branch_low) - corners[0][0];
        let shifted = corners.map(|[phi, e, n]| [phi + shift, e, n]);
        self.deposit(&shifted, scale);
        // A triangle across the cut of the circle appears at the other end as well.
        if shifted.iter().any(|corner| corner[0] < self.branch_low) {
            self.deposit(&shifted.map(|[phi, e, n]| [phi + TAU, e, n]), scale);
        }
        if shifted.iter().any(|corner| corner[0] >= self.branch_low + TAU) {
            self.deposit(&shifted.map(|[phi, e, n]| [phi - TAU, e, n]), scale);
        }
    }

    /// Deposits a triangle. Measured in bins, its integral changes by a factor that the bin area takes out again.
    fn deposit(&mut self, triangle: &[[f64; 3]; 3], scale: f64) {
        let measured = triangle.map(|corner| self.units.measure(corner));
        self.units.deposit(&measured, scale * self.units.bin_area(), &mut self.joint);
    }

    fn add_point(&mut self, phi: f64, e: f64, mass: f64) {
        if e > self.critical_e {
            self.above += mass;
        }
        let [x, y, _] = self.units.measure([fold(phi, self.branch_low), e, 0.0]);
        if let Some(bin) = self.units.bin(x, y) {
            self.joint[bin] += mass;
        }
    }
}
