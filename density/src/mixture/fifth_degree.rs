//! Sigma points that carry a component's covariance as well as the unscented transform carries its mean.
//!
//! The `2n + 1` points of the unscented transform lie on the axes. They do not see mixed derivatives of the flow: the
//! twist `∂²x/∂p_i ∂p_j` adds `(∂²x/∂p_i ∂p_j)²` to a variance, and `∂³x/∂p_i ∂p_j²` adds as much times the slope
//! `∂x/∂p_i`. The fully symmetric rule of the fifth degree (McNamee & Stenger, Numer. Math. 10, 1967; Lerner, *Hybrid
//! Bayesian Networks*, Stanford 2002, Sect. 4.3) sees both:
//!
//! ```text
//! x_0 = m                                w_0 = 1 + (n² - 7n)/18
//! x = m ± √3 S_i                         w_1 = (4 - n)/18
//! x = m ± √3 S_i ± √3 S_j,  i < j        w_2 = 1/36
//! ```
//!
//! It integrates every polynomial up to the fifth degree under the Gaussian exactly, so that mean and covariance of a
//! component that is `h` wide are right to `h⁴` included. Two such sets are carried, one of them turned against the
//! other ([`turned`]). Each component has the moments of both together; by how much the mixture's moments differ
//! between the two is an estimate of their error.

use super::component::Component;
use crate::angle::nearest;
use crate::model::Variable;
use crate::variable_moments::VariableMoments;

/// The most variables for which no weight is negative.
pub(super) const MOST_VARIABLES: usize = 4;

/// Distance of the outermost points from the centre, `√6`, in standard deviations.
pub(super) const REACH: f64 = 2.449_489_742_783_178;

/// Points of one set besides the centre.
const fn outer_points(n: usize) -> usize {
    2 * n * n
}

/// Points of both sets, which share the centre.
pub(super) const fn points(n: usize) -> usize {
    1 + 2 * outer_points(n)
}

/// The points of both sets in the component's own axes: the centre, the first set, the second.
pub(super) fn places<const N: usize>() -> Vec<[f64; N]> {
    let distance = 3f64.sqrt();
    let unit =
        |k: usize, sign: f64| -> [f64; N] { std::array::from_fn(|j| if j == k { sign * distance } else { 0.0 }) };
    let signs = [1.0, -1.0];
    let mut set: Vec<[f64; N]> = (0..N).flat_map(|i| signs.map(|sign| unit(i, sign))).collect();
    for (i, j) in (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j))) {
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let (along, across) = (unit(i, a), unit(j, b));
            set.push(std::array::from_fn(|k| along[k] + across[k]));
        }
    }
    let other: Vec<[f64; N]> = set.iter().map(turned).collect();
    [[0.0; N]].into_iter().chain(set).chain(other).collect()
}

/// A point of the second set: that of the first, reflected on the plane across `(1, 2, .., n)`, a direction with no
/// symmetry of the set.
fn turned<const N: usize>(point: &[f64; N]) -> [f64; N] {
    let normal: [f64; N] = std::array::from_fn(|k| (k + 1) as f64);
    let square: f64 = normal.iter().map(|x| x * x).sum();
    let along: f64 = normal.iter().zip(point).map(|(n, x)| n * x).sum();
    std::array::from_fn(|k| point[k] - 2.0 * along * normal[k] / square)
}

/// Which of the two sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    First,
    Second,
    Both,
}

/// The weight of point number `p` of [`places`].
fn weight(n: usize, p: usize, which: Which) -> f64 {
    let n_f = n as f64;
    if p == 0 {
        return 1.0 + (n_f * n_f - 7.0 * n_f) / 18.0;
    }
    let (set, within) = ((p - 1) / outer_points(n), (p - 1) % outer_points(n));
    let share = match which {
        Which::Both => 0.5,
        Which::First => f64::from(set == 0),
        Which::Second => f64::from(set == 1),
    };
    share * if within < 2 * n { (4.0 - n_f) / 18.0 } else { 1.0 / 36.0 }
}

/// The component whose points have been carried to these places; angles are taken on the branch nearest to that of the
/// centre.
pub(super) fn component<const N: usize>(
    variables: &[Variable],
    share: f64,
    carried: &[[f64; N]],
    which: Which,
) -> Component<N> {
    let centre = carried[0];
    let off = |p: usize| -> [f64; N] {
        std::array::from_fn(|v| {
            let value = carried[p][v];
            if variables[v].is_circle() { nearest(value, centre[v]) - centre[v] } else { value - centre[v] }
        })
    };
    let (mut shift, mut square) = ([0.0; N], [[0.0; N]; N]);
    for p in 1..carried.len() {
        let (weight, off) = (weight(N, p, which), off(p));
        for a in 0..N {
            shift[a] += weight * off[a];
            (0..N).for_each(|b| square[a][b] += weight * off[a] * off[b]);
        }
    }
    let covariance = std::array::from_fn(|a| std::array::from_fn(|b| square[a][b] - shift[a] * shift[b]));
    Component { weight: share, mean: std::array::from_fn(|v| centre[v] + shift[v]), covariance }
}

/// The largest difference of two clouds' means, standard deviations and covariances, in standard deviations and
/// products of them.
pub(super) fn apart<const N: usize>(variables: &[Variable], a: &VariableMoments<N>, b: &VariableMoments<N>) -> f64 {
    let deviations: [f64; N] = std::array::from_fn(|v| (a.covariance[v][v] * b.covariance[v][v]).abs().powf(0.25));
    let mut largest = 0.0f64;
    for v in (0..N).filter(|&v| deviations[v] > 0.0) {
        let off =
            if variables[v].is_circle() { nearest(a.mean[v], b.mean[v]) - b.mean[v] } else { a.mean[v] - b.mean[v] };
        largest = largest.max(off.abs() / deviations[v]);
        for u in (0..=v).filter(|&u| deviations[u] > 0.0) {
            // A standard deviation differs by half as much as its square.
            let share = if u == v { 0.5 } else { 1.0 };
            let off = share * (a.covariance[v][u] - b.covariance[v][u]).abs();
            largest = largest.max(off / (deviations[v] * deviations[u]));
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Kind;

    const REAL: Variable = Variable { name: "", symbol: "", unit: "", kind: Kind::Interval { low: -9.0, high: 9.0 } };

    /// The mean of a monomial under the standard Gaussian: the product of the double factorials of odd numbers.
    fn of_gaussian(powers: &[u32]) -> f64 {
        let one = |power: u32| if power % 2 == 1 { 0.0 } else { (1..power).step_by(2).map(f64::from).product() };
        powers.iter().map(|&power| one(power)).product()
    }

    fn integrates_up_to_the_fifth_degree<const N: usize>() {
        let places = places::<N>();
        assert_eq!(places.len(), points(N));
        for number in 0..6usize.pow(N as u32) {
            let powers: Vec<u32> = (0..N).map(|k| (number / 6usize.pow(k as u32) % 6) as u32).collect();
            if powers.iter().sum::<u32>() > 5 {
                continue;
            }
            for which in [Which::First, Which::Second, Which::Both] {
                let term = |p: usize| {
                    let product: f64 = (0..N).map(|k| places[p][k].powi(powers[k] as i32)).product();
                    weight(N, p, which) * product
                };
                let sum: f64 = (0..places.len()).map(term).sum();
                assert!((sum - of_gaussian(&powers)).abs() < 1e-12, "{powers:?} {which:?}: {sum}");
            }
        }
    }

    #[test]
    fn every_polynomial_up_to_the_fifth_degree_has_its_mean() {
        integrates_up_to_the_fifth_degree::<2>();
        integrates_up_to_the_fifth_degree::<3>();
        integrates_up_to_the_fifth_degree::<4>();
    }

    #[test]
    fn no_weight_is_negative_in_up_to_four_variables() {
        for n in 1..=MOST_VARIABLES {
            assert!((0..points(n)).all(|p| weight(n, p, Which::Both) >= 0.0), "{n}");
        }
    }

    #[test]
    fn a_quadratic_flow_has_the_covariance_that_its_twist_adds() {
        let carried: Vec<[f64; 3]> =
            places::<3>().into_iter().map(|[x, y, z]| [x + 0.2 * x * y, y, z + 0.1 * y * y]).collect();
        let found = component(&[REAL; 3], 1.0, &carried, Which::Both);
        // The variance of x y is 1, and that of y² is 2.
        assert!((found.covariance[0][0] - 1.04).abs() < 1e-12 && (found.covariance[2][2] - 1.02).abs() < 1e-12);
        assert!((found.mean[2] - 0.1).abs() < 1e-12);
    }
}
