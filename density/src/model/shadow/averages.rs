//! What sunlight does over a revolution of which a part is dark.
//!
//! The pressure `-p s` acts on the sunlit part alone. With `R = r/a`, `V = dR/dF` and the differences `Δ` over every
//! dark stretch, whose share of the period is `w`, the averages over a revolution are exactly
//!
//! ```text
//! e' = c n_sun [(1 - w) h × s + Δ(R × (R × s))/(6π)]
//! h' = c n_sun [(1 - w) e × s + ΔB × s/(3π)] - (h/2) a'/a        B = -[(1 + r/a) V + (r·v/(n a²)) e]/2
//! a' = c n_sun (2 a/(3π)) s·ΔR
//! ```
//!
//! with `c = C` at the present semi-major axis. They follow from Gauss's equations `μ e' = f × H + v × (r × f)`, `H' =
//! r × f`, `a' = (2 a²/μ) v·f` for a constant force per mass `f`, by `r × (f·dr) = ½ d(r (f·r)) + ½ f × H dt` and `∫ r
//! dt = -(3/2) a e Δt + (a/n) ΔB` (the last is the primitive of `(cos E - e)(1 - e cos E)` and `η sin E (1 - e cos
//! E)`). Without a dark stretch they are those of [`crate::model::vectorial`]. Kozai (SAO Special Report 56, 1961) and
//! Hubaux & Lemaître (Celest. Mech. Dyn. Astron. 116, 2013) give the same in elements.

use std::f64::consts::{PI, TAU};

use super::edges::{Dark, Edge, Ellipse, Kind};
use crate::model::Quantity;
use crate::model::elements::equinoctial_axes;
use crate::model::vector::{Vector, cross, dot, plus, times};

/// An orbit as sunlight meets it.
#[derive(Debug, Clone, Copy)]
pub struct Lit<T> {
    e: Vector<T>,
    h: Vector<T>,
    to_sun: Vector<T>,
    /// Radius of the Earth, in semi-major axes.
    radius: T,
    axes: (Vector<T>, Vector<T>),
    /// `ĥ × e`, and `1/(1 + η)`.
    across: Vector<T>,
    share: T,
}

/// The rates of an orbit's elements, in units of `c n_sun`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates<T> {
    /// Rate of the eccentricity vector.
    pub e: Vector<T>,
    /// Rate of the angular momentum vector, in units of `sqrt(mu a)` at the present `a`.
    pub h: Vector<T>,
    /// Rate of the semi-major axis, in units of `a`.
    pub axis: T,
}

/// A place on the ellipse, with the terms whose differences between two places are the averages.
#[derive(Debug, Clone, Copy)]
struct Place<T> {
    mean_longitude: T,
    position: Vector<T>,
    turned: Vector<T>,
    moment: Vector<T>,
}

impl<T: Quantity> Lit<T> {
    /// From the vectors of an orbit, the direction to the Sun, and the Earth's radius in semi-major axes.
    pub fn new(e: Vector<T>, h: Vector<T>, to_sun: Vector<T>, radius: T) -> Self {
        let eta = dot(h, h).sqrt();
        let across = times(cross(h, e), T::from(1.0) / eta);
        Self { e, h, to_sun, radius, axes: equinoctial_axes(h), across, share: T::from(1.0) / (eta + 1.0) }
    }

    /// Unit vectors to a place of the auxiliary circle, and across.
    fn directions(&self, longitude: T) -> (Vector<T>, Vector<T>) {
        let ((sin, cos), (first, second)) = (longitude.sin_cos(), self.axes);
        (plus(times(first, cos), times(second, sin)), plus(times(first, -sin), times(second, cos)))
    }

    /// A vector of the auxiliary circle, shrunk to the ellipse.
    fn shrunk(&self, vector: Vector<T>) -> Vector<T> {
        plus(vector, times(self.across, -(dot(vector, self.across) * self.share)))
    }

    /// Position `R` and `V = dR/dF` at an eccentric longitude.
    fn position(&self, longitude: T) -> (Vector<T>, Vector<T>) {
        let (toward, across) = self.directions(longitude);
        (plus(self.shrunk(toward), times(self.e, T::from(-1.0))), self.shrunk(across))
    }

    /// The place of an edge of the shadow, by one step of Newton's method from where it nearly is. The derivatives of
    /// the result are exact whatever the start.
    fn edge(&self, Edge { longitude, kind }: Edge) -> T {
        let start = T::from(longitude);
        let (position, velocity) = self.position(start);
        let (toward, closing) = (dot(position, self.to_sun), dot(velocity, self.to_sun));
        let (value, slope) = match kind {
            Kind::Face => (toward, closing),
            Kind::Cylinder => (
                dot(position, position) - toward * toward - self.radius * self.radius,
                (dot(position, velocity) - toward * closing) * 2.0,
            ),
        };
        // A step of Newton's method; the value is 0 to rounding, but its derivatives are not.
        start - value / slope.number()
    }

    fn place(&self, longitude: T) -> Place<T> {
        let (toward, across) = self.directions(longitude);
        let position = plus(self.shrunk(toward), times(self.e, T::from(-1.0)));
        let velocity = self.shrunk(across);
        let radial = dot(self.e, across);
        let distance = -dot(self.e, toward) + 1.0;
        Place {
            mean_longitude: longitude + radial,
            position,
            turned: cross(position, cross(position, self.to_sun)),
            moment: times(plus(times(velocity, distance + 1.0), times(self.e, -radial)), T::from(-0.5)),
        }
    }

    /// The rates over a revolution of which some stretches are dark.
    pub fn rates(&self, dark: &Dark) -> Rates<T> {
        let zero = [T::from(0.0); 3];
        let (mut share, mut position, mut turned, mut moment) = (T::from(0.0), zero, zero, zero);
        let less = |a: Vector<T>, b: Vector<T>| plus(a, times(b, T::from(-1.0)));
        for &(begin, end) in dark.stretches() {
            let [begin, end] = [begin, end].map(|edge| self.place(self.edge(edge)));
            share = share + (end.mean_longitude - begin.mean_longitude) / TAU;
            position = plus(position, less(end.position, begin.position));
            turned = plus(turned, less(end.turned, begin.turned));
            moment = plus(moment, less(end.moment, begin.moment));
        }
        let lit = -share + 1.0;
        let axis = dot(self.to_sun, position) * (2.0 / (3.0 * PI));
        let by_moment = times(cross(moment, self.to_sun), T::from(1.0 / (3.0 * PI)));
        let e = plus(times(cross(self.h, self.to_sun), lit), times(turned, T::from(1.0 / (6.0 * PI))));
        let h = plus(plus(times(cross(self.e, self.to_sun), lit), by_moment), times(self.h, axis * -0.5));
        Rates { e, h, axis }
    }

    /// Distance from the shadow's axis at an eccentric longitude, in Earth radii.
    pub fn distance(&self, longitude: f64) -> T {
        let (position, _) = self.position(T::from(longitude));
        let toward = dot(position, self.to_sun);
        (dot(position, position) - toward * toward).sqrt() / self.radius
    }
}

impl Lit<f64> {
    /// The ellipse, for the search of its edges.
    pub fn ellipse(&self) -> Ellipse {
        Ellipse::new(self.e, self.h, self.to_sun, self.radius)
    }
}
