//! The criteria against PyEst 0.7.2 and closed forms.

use super::criteria::Criterion;
use super::local_flow::{LocalFlow, Probe};
use super::search::search;
use super::spectral::{Preferred, longest_bend};
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::mixture::MixtureError;
use crate::model::{Kind, Variable};
use crate::problem::paper::scenario;

const REAL: Variable = Variable { name: "", symbol: "", unit: "", kind: Kind::Interval { low: -99.0, high: 99.0 } };

fn local<const N: usize>(initial: &Gaussian<N>, map: impl Fn([f64; N]) -> [f64; N]) -> LocalFlow<N> {
    let probe = Probe::new(initial);
    let carried: Vec<[f64; N]> = probe.places.iter().map(|&place| map(initial.point(place))).collect();
    LocalFlow::new(initial, &[REAL; N], &probe, &carried)
}

fn assert_along<const N: usize>(found: Preferred<N>, right: [f64; N], tolerance: f64, what: &str) {
    let cosine: f64 = (0..N).map(|k| found.direction[k] * right[k]).sum();
    let off = (0..N).map(|k| (found.direction[k] - cosine.signum() * right[k]).abs()).fold(0.0, f64::max);
    assert!(off < tolerance, "{what}: {:?} for {right:?}", found.direction);
}

/// A correlated Gaussian, and a map with all first and second derivatives but few symmetries.
fn correlated() -> Gaussian<3> {
    Gaussian::new([0.0; 3], [[0.04, 0.01, -0.005], [0.01, 0.09, 0.02], [-0.005, 0.02, 0.16]]).unwrap()
}

fn quadratic([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        x + 0.5 * y - 0.2 * z + 0.35 * x * x - 0.3 * x * y + 0.1 * z * z,
        0.3 * x + 2.0 * y + 0.4 * z + 0.55 * y * y + 0.5 * x * z - 0.2 * y * z,
        -0.6 * x + 0.1 * y + 0.8 * z - 0.2 * x * x + 0.45 * z * z + 0.6 * x * y,
    ]
}

fn cubic([x, y, z]: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = quadratic([x, y, z]);
    [a + 2.0 * x.powi(3), b + y.powi(3) - z.powi(3), c + 3.0 * z.powi(3) + x.powi(3)]
}

/// The directions are those of PyEst 0.7.2 (`id_variance` and so on, `SigmaPointOptions(alpha=1, beta=0, kappa=1)`),
/// multiplied by the inverse of the Cholesky factor of the covariance and scaled. PyEst 0.7.2 solves with the transpose
/// of `S_z` where it whitens; the four criteria that are whitened were computed with its `triangularize` replaced by a
/// function that returns the transposed upper factor of `P_z`, which makes of that solution the one for `P_z^{-1}`.
#[test]
fn directions_are_those_of_pyest() {
    let quadratic = local(&correlated(), quadratic);
    for (criterion, right) in [
        (Criterion::Variance, [-0.0371853764, 0.355763559, 0.9338359266]),
        (Criterion::Fos, [0.4239499459, 0.9054436545, -0.0209339866]),
        (Criterion::Safos, [0.0936713033, 0.7934817489, 0.6013421664]),
        (Criterion::Usfos, [0.2455780836, 0.9277226642, 0.2811086323]),
        (Criterion::Sos, [0.7549403972, -0.6077979303, 0.2462654514]),
        (Criterion::Wussos, [-0.1781734911, 0.1886648272, 0.9657431284]),
        (Criterion::Solc, [-0.636211966, 0.7209808757, -0.2746286788]),
        (Criterion::Ussolc, [-0.0527880009, 0.1869896657, 0.9809425528]),
        (Criterion::Wussolc, [-0.1814597364, 0.1915361846, 0.9645653187]),
        (Criterion::Sasos, [0.003277145, 0.2508055276, 0.9680319456]),
        (Criterion::Wsasos, [-0.1540370439, 0.2074655154, 0.9660386374]),
        (Criterion::Alodt, [-0.0371853764, 0.355763559, 0.9338359266]),
    ] {
        assert_along(criterion.preferred(&quadratic), right, 2e-6, criterion.name());
    }
    // The slopes of a cubic map are off by the square of the step over which they are taken.
    let cubic = local(&correlated(), cubic);
    for (criterion, right) in [
        (Criterion::Sadl, [0.0393239222, -0.0371024043, 0.9985374508]),
        (Criterion::Wussadl, [0.1325351917, -0.0570043596, 0.9895377335]),
    ] {
        assert_along(criterion.preferred(&cubic), right, 1e-4, criterion.name());
    }
}

#[test]
fn a_linear_flow_has_no_preferred_direction_but_for_its_stretching() {
    let linear = local(&correlated(), |[x, y, z]| [2.0 * x + y, y - 0.5 * z, 3.0 * z - x]);
    for criterion in Criterion::ALL {
        let measure = criterion.preferred(&linear).measure;
        let stretches = ["variance", "fos", "safos", "usfos"].contains(&criterion.name());
        assert_eq!(measure > 1e-9, stretches, "{}: {measure}", criterion.name());
    }
}

#[test]
fn criteria_in_standard_deviations_find_the_direction_along_which_alone_the_flow_bends() {
    let initial = correlated();
    let unit = [0.48, -0.6, 0.64];
    let bent = local(&initial, |x| {
        let standard = initial.standardise(&x);
        let along: f64 = (0..3).map(|k| unit[k] * standard[k]).sum();
        [x[0] + 0.3 * along * along, x[1] - 0.1 * along * along, x[2]]
    });
    for (criterion, bend) in
        [(Criterion::Wussos, None), (Criterion::Wussolc, None), (Criterion::Ussolc, Some(0.4f64.sqrt()))]
    {
        let found = criterion.preferred(&bent);
        assert_along(found, unit, 1e-9, criterion.name());
        assert!(bend.is_none_or(|bend| (found.measure - bend).abs() < 1e-9), "{}: {}", criterion.name(), found.measure);
    }
}

#[test]
fn whitened_criteria_do_not_depend_on_units() {
    let factors = [100.0, 1.0, 0.01];
    let scaled = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| factors[k] * x[k]) };
    let covariance = |a: usize, b: usize| {
        let steps = |k: usize| correlated().direction(k);
        factors[a] * factors[b] * (0..3).map(|k| steps(k)[a] * steps(k)[b]).sum::<f64>()
    };
    let covariance = std::array::from_fn(|a| std::array::from_fn(|b| covariance(a, b)));
    let initial = Gaussian::new([0.0; 3], covariance).unwrap();
    let inverse = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| x[k] / factors[k]) };
    let (there, here) = (local(&initial, |x| scaled(cubic(inverse(x)))), local(&correlated(), cubic));
    for criterion in [Criterion::Wussos, Criterion::Wussolc, Criterion::Wussadl] {
        let (there, here) = (criterion.preferred(&there), criterion.preferred(&here));
        assert_along(there, here.direction, 1e-6, criterion.name());
    }
}

#[test]
fn the_longest_bend_is_the_longest_of_all_directions_in_the_plane() {
    let second = [[[1.0, -0.3], [0.4, 0.2]], [[0.4, 0.2], [-0.9, 0.7]]];
    let length = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let bend =
            |v: usize| cos * cos * second[0][0][v] + 2.0 * sin * cos * second[0][1][v] + sin * sin * second[1][1][v];
        f64::hypot(bend(0), bend(1))
    };
    let longest = (0..100_000).map(|k| length(std::f64::consts::PI * f64::from(k) * 1e-5)).fold(0.0, f64::max);
    let found = longest_bend(&second);
    assert!((found.measure - longest).abs() < 1e-8, "{found:?} for {longest}");
}

#[test]
fn the_time_of_the_largest_measure_decides() {
    let problem = scenario(1);
    let initial = Gaussian::from(problem.initial);
    let of = |times: &[f64]| search(Criterion::Wussolc, Flow::new(problem.model), &initial, times).unwrap().preferred;
    let each = [0.5, 1.0, 1.5, 2.0].map(|time| of(&[time]));
    let strongest = each.iter().copied().max_by(|a, b| a.measure.total_cmp(&b.measure)).unwrap();
    let all = of(&[0.0, 0.5, 1.0, 1.5, 2.0]);
    assert!((all.measure / strongest.measure - 1.0).abs() < 1e-6);
    assert_along(all, strongest.direction, 1e-6, "all times");
}

#[test]
fn what_cannot_be_searched_is_refused() {
    let problem = scenario(1);
    let flow = Flow::new(problem.model);
    let refused = |initial: &Gaussian<2>, time: f64| search(Criterion::Fos, flow, initial, &[time]).unwrap_err();
    let initial = Gaussian::from(problem.initial);
    assert!(matches!(refused(&initial, f64::NAN), MixtureError::Time(_)));
    assert_eq!(refused(&Gaussian::independent([0.0, 0.9], [0.1, 0.1]), 1.0), MixtureError::NothingInside);
}
