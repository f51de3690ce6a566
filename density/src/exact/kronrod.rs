//! The 15-point Gauss-Kronrod rule and the 7-point Gauss rule embedded in it (Piessens et al., *QUADPACK*, 1983, `qk15`),
//! as a product rule on cells of the plane.

/// Points of the rule in one direction.
pub(super) const POINTS: usize = 15;
/// Points of the product rule.
pub(super) const CELL: usize = POINTS * POINTS;

/// Abscissa, Kronrod weight and Gauss weight (0 where the Gauss rule has no node), positive half.
const HALF: [(f64, f64, f64); 8] = [
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_225, 0.0),
];

/// Abscissae, Kronrod weights and Gauss weights on `[-1, 1]`.
pub(super) fn rule() -> [(f64, f64, f64); POINTS] {
    std::array::from_fn(|i| {
        let (x, kronrod, gauss) = HALF[i.abs_diff(7)];
        (if i < 7 { -x } else { x }, kronrod, gauss)
    })
}

/// A rectangle in standard deviations of the initial Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    /// Range of the solar angle.
    pub u: (f64, f64),
    /// Range of the eccentricity.
    pub v: (f64, f64),
}

/// Which way a cell is to be halved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Split {
    U,
    V,
    Both,
}

fn halves((low, high): (f64, f64)) -> [(f64, f64); 2] {
    [(low, low.midpoint(high)), (low.midpoint(high), high)]
}

impl Cell {
    /// The nodes of the product rule, `u` outermost, with Kronrod weights.
    pub(super) fn nodes(self) -> impl Iterator<Item = (f64, f64, f64)> {
        let at = |(low, high): (f64, f64), x: f64| low.midpoint(high) + 0.5 * (high - low) * x;
        let area = 0.25 * (self.u.1 - self.u.0) * (self.v.1 - self.v.0);
        rule().into_iter().flat_map(move |(x, wx, _)| {
            rule().into_iter().map(move |(y, wy, _)| (at(self.u, x), at(self.v, y), area * wx * wy))
        })
    }

    /// The distance of the cell from the centre of the Gaussian.
    pub(super) fn distance(self) -> f64 {
        let from_zero = |(low, high): (f64, f64)| low.max(-high).max(0.0);
        from_zero(self.u).hypot(from_zero(self.v))
    }

    /// The parts of the cell.
    pub(super) fn split(self, split: Split) -> Vec<Self> {
        let us = if split == Split::V { vec![self.u] } else { halves(self.u).to_vec() };
        let vs = if split == Split::U { vec![self.v] } else { halves(self.v).to_vec() };
        us.iter().flat_map(|&u| vs.iter().map(move |&v| Self { u, v })).collect()
    }
}

/// Integrals of `F` functions over a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Integrals<const F: usize> {
    /// Kronrod values.
    pub values: [f64; F],
    /// Error estimates (QUADPACK's, which raises the difference to the Gauss rule to the power 3/2).
    pub errors: [f64; F],
    /// How much of the error the rule in `u` and the rule in `v` have, unscaled.
    pub directions: [[f64; 2]; F],
}

/// Integrates over a cell from the functions' values at its nodes, already multiplied by the Kronrod weights.
pub(super) fn integrate<const F: usize>(terms: impl Iterator<Item = [f64; F]>) -> Integrals<F> {
    let rule = rule();
    let (mut kronrod, mut gauss_u, mut gauss_v, mut size) = ([0.0; F], [0.0; F], [0.0; F], [0.0; F]);
    for (i, term) in terms.enumerate() {
        let ratio = |(_, kronrod, gauss): (f64, f64, f64)| gauss / kronrod;
        let (ratio_u, ratio_v) = (ratio(rule[i / POINTS]), ratio(rule[i % POINTS]));
        for f in 0..F {
            kronrod[f] += term[f];
            gauss_u[f] += term[f] * ratio_u;
            gauss_v[f] += term[f] * ratio_v;
            size[f] += term[f].abs();
        }
    }
    let directions = std::array::from_fn(|f| [(kronrod[f] - gauss_u[f]).abs(), (kronrod[f] - gauss_v[f]).abs()]);
    let errors = std::array::from_fn(|f| {
        let raw = directions[f][0] + directions[f][1];
        if size[f] > 0.0 { size[f] * (200.0 * raw / size[f]).powf(1.5).min(1.0) } else { 0.0 }
    });
    Integrals { values: kronrod, errors, directions }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_rule_is_exact_for_monomials_up_to_degree_22() {
        let cell = Cell { u: (-1.0, 2.0), v: (0.5, 1.0) };
        let monomial = |low: f64, high: f64, n: i32| (high.powi(n + 1) - low.powi(n + 1)) / f64::from(n + 1);
        for (n, m) in [(0, 0), (1, 22), (22, 3), (13, 13)] {
            let sum: f64 = cell.nodes().map(|(u, v, w)| w * u.powi(n) * v.powi(m)).sum();
            let exact = monomial(-1.0, 2.0, n) * monomial(0.5, 1.0, m);
            assert!((sum / exact - 1.0).abs() < 1e-13, "{n} {m} {sum} {exact}");
        }
    }

    #[test]
    fn embedded_gauss_rule_is_exact_up_to_degree_13_and_not_beyond() {
        let raw = |n: i32| {
            let cell = Cell { u: (0.0, 1.0), v: (0.0, 1.0) };
            integrate(cell.nodes().map(|(u, _, w)| [w * u.powi(n)])).directions[0]
        };
        assert!(raw(13)[0] < 1e-15 && raw(14)[0] > 1e-10 && raw(14)[1] < 1e-15);
    }
}
