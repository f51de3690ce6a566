//! The settings, and cases beside those of other methods.

use super::*;
use crate::in_process::{Computed, Outcome, Wanted, compute};
use crate::methods::BuiltIn;
use kit::example::assignment;

fn settings(text: &str) -> Settings {
    toml::from_str(text).unwrap()
}

#[test]
fn a_setting_that_changes_nothing_or_does_not_fit_is_refused_by_name() {
    for (text, key) in [
        ("sends = \"characteristics\"\nseed = 2", "seed"),
        ("degree = 3", "degree"),
        ("sends = \"characteristics\"\nsamples = 16\ndegree = 7", "degree"),
        ("map_error = 1e-12", "map_error"),
        ("sends = \"characteristics\"\nsamples = 3", "samples"),
    ] {
        assert_eq!(settings(text).check().unwrap_err().key, key, "{text}");
    }
    for few in [0, 1] {
        let refused = toml::from_str::<Settings>(&format!("samples = {few}")).unwrap_err().to_string();
        assert!(refused.contains("it must be at least 2"), "{refused}");
    }
    for good in ["", "by = \"action-angle\"\nseed = 4", "sends = \"characteristics\"\nsamples = 16"] {
        settings(good).check().unwrap();
    }
}

#[test]
fn what_is_recorded_is_what_has_an_effect() {
    let lines = |text: &str| toml::to_string(&settings(text).resolved()).unwrap();
    assert_eq!(lines(""), "sends = \"samples\"\nby = \"cells\"\nsamples = 100000\nseed = 1\nmap_error = 0.000000001\n");
    assert!(lines("sends = \"characteristics\"\nsamples = 16").contains("degree = 3"));
}

/// A case by its settings, in the plane.
fn outcome(name: &str, settings: &str) -> Outcome {
    let case = BuiltIn::from_settings(name, toml::de::Deserializer::parse(settings).unwrap()).unwrap().unwrap();
    compute(case, &assignment(), Wanted::ALL, &mut || Ok(())).unwrap()
}

/// The largest difference of two cases' rows: of the angles, which stand in the first column, by their sine.
fn apart(case: &[Computed], other: &[Computed]) -> f64 {
    assert!(!case.is_empty() && case.len() == other.len());
    let of = |(a, b): (&Computed, &Computed)| {
        assert_eq!((a.rows, a.columns.len()), (b.rows, b.columns.len()));
        let rows = a.rows;
        let differences = a.columns.iter().zip(&b.columns).enumerate().map(|(i, (a, b))| match i / rows {
            0 => (a - b).sin().abs(),
            _ => (a - b).abs() / b.abs().max(1.0),
        });
        differences.fold(0.0, f64::max)
    };
    case.iter().zip(other).map(of).fold(0.0, f64::max)
}

#[test]
fn samples_are_those_of_mc_and_so_is_their_curve_by_both_maps() {
    let right = outcome("mc", "samples = 2500\nseed = 3");
    for by in ["cells", "action-angle"] {
        let found = outcome("flow-map", &format!("by = \"{by}\"\nsamples = 2500\nseed = 3"));
        let off = apart(&found.snapshots, &right.snapshots);
        assert!(off < 1e-7, "{by}: {off:e}");
        assert_eq!(found.passage, right.passage, "{by}");
        assert!(found.snapshots[0].trajectories > 100, "{by}: the orbits of the map");
    }
}

#[test]
fn characteristics_are_those_of_dee_with_the_density_by_the_determinant_of_either_map() {
    let right = outcome("dee", "samples = 2500");
    for by in ["cells", "action-angle"] {
        let found = outcome("flow-map", &format!("sends = \"characteristics\"\nby = \"{by}\"\nsamples = 2500"));
        let off = apart(&found.snapshots, &right.snapshots);
        // A slope of a polynomial is off by more than the polynomial, see `density/src/flow_map/determinant.rs`.
        assert!(off < 1e-4, "{by}: {off:e}");
        for (found, right) in found.snapshots.iter().zip(&right.snapshots) {
            let (found, right) = (found.estimated.as_ref().unwrap(), right.estimated.as_ref().unwrap());
            assert!(found.carried_density_error < 1e-5, "{by}: {:e}", found.carried_density_error);
            for (a, b) in found.values.iter().zip(&right.values) {
                assert!((a - b).abs() < 1e-7, "{by}: {a} {b}");
            }
        }
    }
}

#[test]
fn characteristics_of_a_cloud_that_reaches_e_0_keep_their_lattice_and_their_density_by_both_maps() {
    let mut near_zero = assignment();
    let plane = near_zero.plane.as_mut().unwrap();
    (plane.problem.initial.mean_e, plane.problem.initial.sigma_e) = (0.05, 0.01);
    let carried = |name: &str, settings: &str| {
        let case = BuiltIn::from_settings(name, toml::de::Deserializer::parse(settings).unwrap()).unwrap().unwrap();
        compute(case, &near_zero, Wanted::ALL, &mut || Ok(())).unwrap().snapshots
    };
    let right = carried("dee", "samples = 961");
    for by in ["cells", "action-angle"] {
        let found = carried("flow-map", &format!("by = \"{by}\"\nsends = \"characteristics\"\nsamples = 961"));
        let largest = |columns: &[f64]| columns[2 * 961..].iter().copied().fold(0.0, f64::max);
        for (found, right) in found.iter().zip(&right) {
            let scale = largest(&right.columns);
            for row in 0..961 {
                let column = |computed: &Computed, k: usize| computed.columns[k * 961 + row];
                assert!((column(found, 0) - column(right, 0)).sin().abs() * column(right, 1) < 1e-8, "{by}, row {row}");
                assert!((column(found, 1) - column(right, 1)).abs() < 1e-8, "{by}, row {row}");
                let off = (column(found, 2) - column(right, 2)).abs();
                assert!(off < 1e-3 * column(right, 2) + 1e-9 * scale, "{by}, row {row}: {off:e} of {scale:e}");
            }
        }
        for row in 0..961 {
            let off = (found[0].columns[row] - right[0].columns[row]).sin().abs();
            assert!(off < 1e-9, "{by}, row {row}: at the start the angle is off by {off:e}, also at e = 1e-12");
        }
    }
}
