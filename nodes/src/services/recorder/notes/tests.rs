use messages::layout::{DensityHeader, diagnostic};

use super::*;

/// A snapshot of the plane with these moments, on a grid of phi from 0 to 6 and e from 0 to 0.9.
fn reading(moments: [f64; 6], header: DensityHeader) -> Reading {
    let assignment = kit::example::assignment();
    let mut numbers = vec![0.5; Reading::numbers_of(&assignment)];
    numbers[..6].copy_from_slice(&moments);
    numbers[6..8].copy_from_slice(&[0.5, 0.9]);
    Reading::new(DensityHeader { quantities: 8, ..header }, &numbers, &assignment).unwrap()
}

fn exact(moments: [f64; 6], mass_on_grid: f64, diagnostics: [f64; 4]) -> Reading {
    let diagnostic = diagnostic::NUMERICAL;
    reading(moments, DensityHeader { mass_on_grid, diagnostics, diagnostic, ..DensityHeader::default() })
}

#[test]
fn an_estimate_that_nobody_would_care_for_causes_no_warning_and_one_of_the_size_of_a_small_probability_does() {
    let estimates = |probability| [2e-5, 2e-5, probability, 1e-5];
    let with = |above, error| of_density(&exact([0.5, 0.5, 0.5, 0.5, 0.5, above], 1.0, estimates(error))).len();
    assert_eq!([with(0.5, 2e-5), with(0.5, 2e-4), with(1e-4, 2e-5), with(1e-9, 1e-6)], [0, 1, 1, 0]);
}

#[test]
fn each_of_the_four_error_estimates_is_looked_at_and_infinity_or_nan_is_never_good_enough() {
    let good = [1e-9, 1e-9, 1e-9, 1e-5];
    assert!(of_density(&exact([0.5; 6], 1.0, good)).is_empty());
    let names = ["in the moments", "resultant vector", "critical eccentricity", "in L1"];
    for (k, name) in names.iter().enumerate() {
        for bad in [0.1, f64::INFINITY, f64::NAN] {
            let mut estimates = good;
            estimates[k] = bad;
            let said = of_density(&exact([0.5; 6], 1.0, estimates));
            assert!(said.len() == 1 && said[0].starts_with("warning: ") && said[0].contains(name), "{said:?}");
        }
    }
    for bad in [0.5, f64::NAN] {
        let mesh = DensityHeader {
            diagnostic: diagnostic::MESH,
            diagnostics: [bad, 0.0, 0.0, f64::NAN],
            mass_on_grid: 1.0,
            ..DensityHeader::default()
        };
        assert_eq!(of_density(&reading([0.5; 6], mesh)).len(), 1);
    }
}

#[test]
fn what_is_withheld_is_named_with_what_was_reached_and_is_no_warning_about_a_number() {
    let said = of_density(&exact([0.5, 0.5, f64::NAN, 0.5, 0.5, 0.5], f64::NAN, [0.2, 0.0, 0.0, f64::INFINITY]));
    assert!(said[0].contains("2.0e-1 standard deviations in the moments"), "{said:?}");
    assert!(!said[0].contains("L1"), "nothing is stated of the joint density: {said:?}");
    assert_eq!(said[1], "withheld: the mean of e (error estimate 2.0e-1) and the joint density (error unknown)");
    assert_eq!(said.len(), 2);
}

#[test]
fn a_cloud_that_is_off_the_grid_and_densities_that_do_not_fit_their_points_draw_a_word() {
    let off = |phi: f64, e: f64| {
        let moments = [phi, 0.1, e, 0.01, 0.0, 0.0];
        let header = DensityHeader { mass_on_grid: 0.4, ..DensityHeader::default() };
        let mut reading = reading(moments, header);
        reading.axes = vec![Axis { low: 6.0, high: 7.0, bins: 4 }, Axis { low: 0.1, high: 0.3, bins: 3 }];
        of_density(&reading)[0].clone()
    };
    assert!(off(372.4, 0.2).contains("only 40.0 % of its probability is on the comparison grid"));
    assert!(off(372.4, 0.2).contains("are its angles in radians?"), "{}", off(372.4, 0.2));
    assert!(off(0.2, 0.5).contains("its mean eccentricity 0.50000 is outside the grid, which is 0.10000 to 0.30000"));
    assert!(off(0.2, 0.2).contains("lie well on the grid"), "the same angle on another branch: {}", off(0.2, 0.2));
    assert!(off(0.2, 0.29).contains("mean eccentricity, 0.27000 to 0.31000, reach beyond"), "{}", off(0.2, 0.29));
    assert!(off(6.9, 0.2).contains("mean solar angle, 6.70000 to 7.10000, reach beyond"), "{}", off(6.9, 0.2));
    let header = DensityHeader { mass_on_grid: 1.05, ..DensityHeader::default() };
    assert!(of_density(&reading([0.5; 6], header))[0].contains("a mass of 1.0500"));
    let header = DensityHeader {
        diagnostic: diagnostic::MESH,
        diagnostics: [0.0; 4],
        carried_density_error: 0.5,
        mass_on_grid: 1.0,
        ..DensityHeader::default()
    };
    assert!(of_density(&reading([0.5; 6], header))[0].contains("off by 50.00 % on average"));
}
