//! Probability of a triangle under the initial Gaussian.
//!
//! In standard deviations `(u, v)` from the mean, with `q = (u² + v²)/2`, the field `(1 - e^-q)/(4π q) (-v, u)` has the
//! standard normal density as its curl. By Green's theorem the probability of a triangle is the circulation of that
//! field,
//!
//! ```text
//! P = sum over edges a -> b of (a x b)/(4π) ∫_0^1 (1 - e^-q)/q dt,     (u, v) = a + t (b - a)
//! ```
//!
//! whose integrand is entire. So a few Gauss-Legendre points per edge reach machine precision, and the probabilities of
//! triangles that share an edge fit together exactly: the triangles of a mesh add up to the probability within its
//! outline.
//!
//! Within a triangle the Gaussian's second moments in barycentric coordinates, `∫ p L_i L_j`, come from Dunavant's
//! seven-point rule (Int. J. Numer. Meth. Eng. 21, 1985, degree 5), scaled to the exact probability.

use std::f64::consts::PI;

/// A point in standard deviations from the mean.
pub type Standard = [f64; 2];

/// Standard normal density in two dimensions.
pub fn standard_density([u, v]: Standard) -> f64 {
    (-0.5 * (u * u + v * v)).exp() / (2.0 * PI)
}

/// Circulation along the edge from `a` to `b`.
fn circulation(a: Standard, b: Standard) -> f64 {
    // Edges longer than this are split; six points then leave an error of 1e-13.
    const LONGEST: f64 = 0.5;
    // Gauss-Legendre points and weights on (0, 1), Abramowitz & Stegun Table 25.4, n = 6.
    const POINTS: [(f64, f64); 6] = [
        (0.033_765_242_898_423_99, 0.085_662_246_189_585_17),
        (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
        (0.380_690_406_958_401_55, 0.233_956_967_286_345_52),
        (0.619_309_593_041_598_5, 0.233_956_967_286_345_52),
        (0.830_604_693_233_132_2, 0.180_380_786_524_069_3),
        (0.966_234_757_101_576, 0.085_662_246_189_585_17),
    ];
    let (du, dv) = (b[0] - a[0], b[1] - a[1]);
    let pieces = (du.hypot(dv) / LONGEST).ceil().clamp(1.0, 1e3);
    let mut sum = 0.0;
    for piece in 0..pieces as u32 {
        for (point, weight) in POINTS {
            let t = (f64::from(piece) + point) / pieces;
            let (u, v) = (a[0] + t * du, a[1] + t * dv);
            let q = 0.5 * (u * u + v * v);
            sum += weight * if q > 1e-9 { -(-q).exp_m1() / q } else { 1.0 - 0.5 * q };
        }
    }
    (a[0] * b[1] - a[1] * b[0]) / (4.0 * PI) * sum / pieces
}

/// Probability of a counter-clockwise triangle under the standard normal distribution.
pub fn triangle_probability([a, b, c]: &[Standard; 3]) -> f64 {
    circulation(*a, *b) + circulation(*b, *c) + circulation(*c, *a)
}

/// Like [`triangle_probability`], but by Dunavant's rule where that is as good and faster (small triangles) or better
/// (far out, where the circulation is a difference of nearly equal numbers). Never negative.
pub fn probability(triangle: &[Standard; 3]) -> f64 {
    const SMALL: f64 = 0.1;
    const CANCELLED: f64 = 1e-12;
    let [a, b, c] = triangle;
    let (du, dv) = ([b[0] - a[0], c[0] - a[0]], [b[1] - a[1], c[1] - a[1]]);
    let small = du.iter().chain(&dv).all(|side| side.abs() < SMALL);
    let exact = if small { 0.0 } else { triangle_probability(triangle) };
    if exact > CANCELLED {
        return exact;
    }
    let at = |l: [f64; 3]| standard_density(std::array::from_fn(|k| l[0] * a[k] + l[1] * b[k] + l[2] * c[k]));
    let mean: f64 = dunavant().iter().map(|&(point, weight)| weight * at(point)).sum();
    0.5 * (du[0] * dv[1] - du[1] * dv[0]).abs() * mean
}

/// Second moments of the standard normal density over a triangle in barycentric coordinates,
/// `∫ p L_i L_j` for `ij = 11, 22, 33, 12, 23, 31`; their sum with the last three doubled is its probability.
pub fn barycentric_moments(triangle: &[Standard; 3]) -> [f64; 6] {
    let mut moments = [0.0; 6];
    let mut total = 0.0;
    for ([l1, l2, l3], weight) in dunavant() {
        let point = std::array::from_fn(|k| l1 * triangle[0][k] + l2 * triangle[1][k] + l3 * triangle[2][k]);
        let share = weight * standard_density(point);
        total += share;
        let products = [l1 * l1, l2 * l2, l3 * l3, l1 * l2, l2 * l3, l3 * l1];
        moments.iter_mut().zip(products).for_each(|(moment, product)| *moment += share * product);
    }
    let probability = probability(triangle);
    if total > 0.0 { moments.map(|moment| moment * probability / total) } else { [0.0; 6] }
}

/// Barycentric points and weights; the weights sum to one.
fn dunavant() -> [([f64; 3], f64); 7] {
    let root = 15f64.sqrt();
    let (near, far) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (near_weight, far_weight) = ((155.0 - root) / 1200.0, (155.0 + root) / 1200.0);
    let third = 1.0 / 3.0;
    [
        ([third; 3], 9.0 / 40.0),
        ([1.0 - 2.0 * near, near, near], near_weight),
        ([near, 1.0 - 2.0 * near, near], near_weight),
        ([near, near, 1.0 - 2.0 * near], near_weight),
        ([1.0 - 2.0 * far, far, far], far_weight),
        ([far, 1.0 - 2.0 * far, far], far_weight),
        ([far, far, 1.0 - 2.0 * far], far_weight),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mass(triangle: &[Standard; 3]) -> f64 {
        let [a, b, c, ab, bc, ca] = barycentric_moments(triangle);
        a + b + c + 2.0 * (ab + bc + ca)
    }

    #[test]
    fn two_triangles_of_a_rectangle_have_the_product_of_two_error_functions() {
        let cdf = |sigmas: f64| 0.5 * libm::erfc(-sigmas / std::f64::consts::SQRT_2);
        for (low, high) in [([-1.0, 0.3], [2.0, 0.9]), ([3.0, -5.0], [4.5, 5.0]), ([0.0, 0.0], [0.01, 0.01])] {
            let [a, b, c, d] = [low, [high[0], low[1]], high, [low[0], high[1]]];
            let expected = (cdf(high[0]) - cdf(low[0])) * (cdf(high[1]) - cdf(low[1]));
            let found = triangle_probability(&[a, b, c]) + triangle_probability(&[a, c, d]);
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }

    #[test]
    fn rule_and_circulation_agree_on_small_triangles() {
        for [u, v] in [[0.1, 0.2], [-2.0, 1.0], [4.0, 3.0]] {
            let triangle = [[u, v], [u + 0.05, v + 0.01], [u + 0.01, v + 0.04]];
            let by_rule = dunavant().map(|([l1, l2, l3], weight)| {
                let at = std::array::from_fn(|k| l1 * triangle[0][k] + l2 * triangle[1][k] + l3 * triangle[2][k]);
                weight * standard_density(at)
            });
            let area = 0.5 * (0.05 * 0.04 - 0.01 * 0.01);
            let by_rule = area * by_rule.iter().sum::<f64>();
            assert!((triangle_probability(&triangle) / by_rule - 1.0).abs() < 1e-7);
            assert!((mass(&triangle) / by_rule - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn rule_is_exact_for_polynomials_of_degree_five() {
        // 2! a! b! c! / (a + b + c + 2)! with the area divided out.
        let rule = |a: i32, b: i32, c: i32| {
            dunavant().iter().map(|([x, y, z], w)| w * x.powi(a) * y.powi(b) * z.powi(c)).sum::<f64>()
        };
        assert!((rule(0, 0, 0) - 1.0).abs() < 1e-15);
        assert!((rule(1, 1, 0) - 1.0 / 12.0).abs() < 1e-15);
        assert!((rule(2, 2, 1) - 2.0 * 4.0 / 5040.0).abs() < 1e-15);
        assert!((rule(5, 0, 0) - 240.0 / 5040.0).abs() < 1e-15);
    }
}
