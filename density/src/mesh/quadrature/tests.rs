use super::*;

fn lines(count: u32, reach: f64) -> Vec<f64> {
    (0..count).map(|i| reach * (2.0 * f64::from(i) / f64::from(count - 1) - 1.0)).collect()
}

/// Moments of a round cloud of standard deviation `sigma` about `(x1, x2)`, by a lattice of 21 points per side.
fn round_cloud(x1: f64, x2: f64, sigma: f64) -> (Moments, Circular) {
    let nodes = lines(21, 5.0);
    let quadrature = Quadrature::new([nodes.clone(), nodes.clone()], 7);
    let all = || nodes.iter().flat_map(|&u| nodes.iter().map(move |&v| (u, v)));
    let (a, b): (Vec<f64>, Vec<f64>) = all().map(|(u, v)| (x1 + sigma * u, x2 + sigma * v)).unzip();
    quadrature.moments(&a, &b, 0.5)
}

#[test]
fn a_round_cloud_over_the_origin_has_the_moments_of_rayleighs_distribution() {
    // A hair off the origin, so that its circular mean is defined.
    let (moments, circular) = round_cloud(0.0, 1e-4, 0.02);
    assert!((moments.mean_e / (0.02 * (PI / 2.0).sqrt()) - 1.0).abs() < 1e-4, "{moments:?}");
    assert!((moments.std_e / (0.02 * (2.0 - PI / 2.0).sqrt()) - 1.0).abs() < 1e-4, "{moments:?}");
    // Even round the circle, except for the effect of the small offset.
    assert!((moments.std_phi / (PI / 3f64.sqrt()) - 1.0).abs() < 0.01, "{moments:?} {circular:?}");
}

#[test]
fn a_cloud_far_from_the_origin_is_read_out_as_a_smooth_one() {
    let (moments, _) = round_cloud(0.0, 0.4, 0.002);
    // e = r + (dx)²/(2 r), phi = dx/r to leading orders.
    assert!((moments.mean_e - (0.4 + 0.5 * 0.002f64.powi(2) / 0.4)).abs() < 1e-9, "{moments:?}");
    assert!((moments.std_phi / (0.002 / 0.4) - 1.0).abs() < 1e-4, "{moments:?}");
}
