//! Circulation of the initial measure along a piece of curve that is known as a polynomial.
//!
//! A [`ChebyshevCurve`] holds the Chebyshev coefficients of `x1`, `x2` along the backward image of a piece of curve.
//! That image is smooth on the scale of the dynamics, however narrow the cloud, so the flow is called at a few nodes
//! only. The one-form `F(phi, e) dphi` ([`super::measure`]) varies on the scale of the cloud and is integrated by
//! Gauss-Legendre rules on pieces of the polynomial that are short in standard deviations.

use std::f64::consts::PI;

use super::measure::{Measure, REACH};

/// Abscissae and weights of Gauss-Legendre rules on `[-1, 1]`, positive half (Abramowitz & Stegun 1964, Table 25.4).
const GAUSS_4: [(f64, f64); 2] =
    [(0.339_981_043_584_856_3, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_8)];
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Number of halvings after which a piece is integrated whatever its length.
const DEEPEST: u32 = 40;
/// Length in the `(x1, x2)` plane below which a piece is mere rounding; a piece at the origin would otherwise be halved
/// without end.
const SHORTEST: f64 = 1e-13;

/// Largest length of a piece, in standard deviations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Resolution {
    /// For the four-point rule.
    four: f64,
    /// For the eight-point rule.
    eight: f64,
}

impl Resolution {
    pub(super) const COARSE: Self = Self { four: 0.8, eight: 3.0 };
    pub(super) const FINE: Self = Self { four: 0.4, eight: 1.5 };
}

/// The `N` Chebyshev points on `[-1, 1]`.
pub(super) fn chebyshev_nodes<const N: usize>() -> [f64; N] {
    std::array::from_fn(|k| (PI * (k as f64 + 0.5) / N as f64).cos())
}

/// The matrix that turns values at [`chebyshev_nodes`] into Chebyshev coefficients, row by row.
pub(super) fn chebyshev_transform<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|j| {
        let scale = if j == 0 { 1.0 } else { 2.0 } / N as f64;
        std::array::from_fn(|k| scale * (j as f64 * PI * (k as f64 + 0.5) / N as f64).cos())
    })
}

/// A polynomial piece of curve with its parameter in `[-1, 1]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChebyshevCurve<const N: usize> {
    /// Chebyshev coefficients of `x1`.
    pub x1: [f64; N],
    /// Chebyshev coefficients of `x2`.
    pub x2: [f64; N],
}

/// A point of a curve and its velocity, in standard deviations of the initial Gaussian.
#[derive(Clone, Copy)]
struct CurvePoint {
    u: f64,
    v: f64,
    du: f64,
    dv: f64,
    /// Speed in the `(x1, x2)` plane.
    speed: f64,
    /// Distance from the origin, about which `u` turns.
    e: f64,
}

impl<const N: usize> ChebyshevCurve<N> {
    fn point(&self, measure: &Measure, xi: f64) -> CurvePoint {
        let (mut t, mut t_next, mut d, mut d_next) = (1.0, xi, 0.0, 1.0);
        let (mut x1, mut x2, mut dx1, mut dx2) = (0.0, 0.0, 0.0, 0.0);
        for (c1, c2) in self.x1.iter().zip(&self.x2) {
            x1 += c1 * t;
            x2 += c2 * t;
            dx1 += c1 * d;
            dx2 += c2 * d;
            let after = 2.0 * xi * t_next - t;
            let d_after = 2.0 * t_next + 2.0 * xi * d_next - d;
            (t, t_next, d, d_next) = (t_next, after, d_next, d_after);
        }
        let e_squared = (x1 * x1 + x2 * x2).max(f64::MIN_POSITIVE);
        let e = e_squared.sqrt();
        CurvePoint {
            u: measure.phi_sigmas(x1.atan2(x2)),
            v: measure.e_sigmas(e),
            du: (x2 * dx1 - x1 * dx2) / (e_squared * measure.gaussian.sigma_phi),
            dv: (x1 * dx1 + x2 * dx2) / (e * measure.gaussian.sigma_e),
            speed: dx1.hypot(dx2),
            e,
        }
    }

    /// `∫ F dphi` along the curve from parameter `from` to `to`.
    pub(super) fn circulation(&self, measure: &Measure, resolution: Resolution, (from, to): (f64, f64)) -> f64 {
        self.piece(measure, resolution, from, to, 0)
    }

    fn piece(&self, measure: &Measure, resolution: Resolution, from: f64, to: f64, depth: u32) -> f64 {
        let (middle, half) = (from.midpoint(to), 0.5 * (to - from));
        let points = GAUSS_4.map(|(x, _)| [-x, x].map(|x| self.point(measure, middle + half * x)));
        let reach = Extent::of(measure, points.as_flattened(), half);
        if reach.empty {
            return 0.0;
        }
        if reach.length > resolution.eight && depth < DEEPEST {
            let first = self.piece(measure, resolution, from, middle, depth + 1);
            return first + self.piece(measure, resolution, middle, to, depth + 1);
        }
        if reach.length <= resolution.four {
            let pairs = GAUSS_4.iter().zip(&points);
            let terms = pairs.map(|(&(_, w), pair)| w * pair.map(|p| p.form(measure)).iter().sum::<f64>());
            return half * terms.sum::<f64>();
        }
        self.gauss(measure, from, to)
    }

    fn gauss(&self, measure: &Measure, from: f64, to: f64) -> f64 {
        let (middle, half) = (from.midpoint(to), 0.5 * (to - from));
        let at = |x: f64| self.point(measure, middle + half * x).form(measure);
        half * GAUSS_8.iter().map(|&(x, w)| w * (at(-x) + at(x))).sum::<f64>()
    }
}

impl CurvePoint {
    fn form(&self, measure: &Measure) -> f64 {
        measure.below(self.u, self.v) * self.du
    }
}

/// The extent of a piece of curve relative to the cloud.
struct Extent {
    /// Whether the one-form is zero along the piece.
    empty: bool,
    /// Length of the piece in standard deviations, counting only the directions in which the one-form varies there.
    length: f64,
}

impl Extent {
    fn of(measure: &Measure, points: &[CurvePoint], half: f64) -> Self {
        let most = |f: fn(&CurvePoint) -> f64| points.iter().map(f).fold(0.0, f64::max);
        let (du, dv) = (2.0 * half * most(|p| p.du.abs()), 2.0 * half * most(|p| p.dv.abs()));
        let least = |f: fn(&CurvePoint) -> f64| points.iter().map(f).fold(f64::INFINITY, f64::min);
        let beside = least(|p| p.u.abs()) > REACH + du;
        let above = least(|p| p.v) > REACH + dv;
        let below = least(|p| -p.v) > REACH + dv;
        // A piece that is not short compared with its distance from the origin may turn about the origin between its
        // nodes.
        let (length_in_plane, farness) = (2.0 * half * most(|p| p.speed), least(|p| p.e));
        let hidden_turn = length_in_plane > farness;
        let length = if length_in_plane < SHORTEST {
            0.0
        } else if hidden_turn {
            f64::INFINITY
        } else if above || below {
            du
        } else {
            // The density varies over a shorter length across the cloud's axis than along the coordinates.
            du.max(dv) / (1.0 - measure.gaussian.correlation.powi(2)).sqrt()
        };
        // A piece of more than a fraction of a turn may pass the cloud between its nodes.
        let beside = beside && !hidden_turn && 4.0 * du < measure.turn_sigmas();
        Self { empty: beside || below, length }
    }
}
