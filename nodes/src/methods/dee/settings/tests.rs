use super::*;
use crate::methods::Method;

fn settings(text: &str) -> Settings {
    toml::from_str(text).unwrap()
}

#[test]
fn a_setting_that_changes_nothing_is_refused_by_name() {
    for (text, key) in [
        ("seed = 2", "seed"),
        ("resolution = 500", "resolution"),
        ("placement = \"random\"\ndegree = 3", "degree"),
        ("mode = \"as-printed\"\ndegree = 3", "degree"),
        ("mode = \"as-printed\"\nmesh = \"carried\"\nresolution = 500", "resolution"),
        ("mode = \"as-printed\"\nmesh = \"carried\"\nplacement = \"lattice\"", "mode"),
    ] {
        let misfit = settings(text).check().unwrap_err();
        assert!(misfit.key == key && misfit.problem.contains("has no effect"), "{text}: {misfit}");
    }
    for good in
        ["placement = \"random\"\nseed = 2", "mesh = \"hull\"\nresolution = 500\ndegree = 3", "mode = \"as-printed\""]
    {
        settings(good).check().unwrap();
    }
}

#[test]
fn what_is_recorded_is_what_has_an_effect_and_means_the_same() {
    for (text, lines) in [
        ("", "samples = 100000\nplacement = \"lattice\"\nmesh = \"carried\"\ndegree = 7\nmode = \"corrected\"\n"),
        (
            "mode = \"as-printed\"",
            "samples = 100000\nseed = 1\nplacement = \"random\"\nmesh = \"hull\"\nresolution = 5000\nmode = \"as-printed\"\n",
        ),
        (
            "mode = \"as-printed\"\nmesh = \"carried\"",
            "samples = 100000\nseed = 1\nplacement = \"random\"\nmesh = \"carried\"\nmode = \"corrected\"\n",
        ),
    ] {
        let resolved = settings(text).resolved();
        assert_eq!(toml::to_string(&resolved).unwrap(), lines);
        resolved.check().unwrap();
        assert_eq!(settings(lines).resolved(), resolved);
    }
}

#[test]
fn the_degree_that_is_not_set_is_the_largest_that_fits_up_to_the_usual_one() {
    for (samples, degree) in [(4, 1), (9, 2), (16, 3), (63, 6), (64, 7), (1_000_000, 7)] {
        let small = settings(&format!("samples = {samples}"));
        small.check().unwrap();
        assert_eq!(small.resolved().degree, Some(degree), "{samples}");
    }
    for (text, words) in [
        (
            "samples = 16\ndegree = 7",
            "does not fit a lattice of 4 points per side; it must be at most 3, or samples at least 64",
        ),
        ("degree = 12", "12 is not allowed, it must be at most 11"),
    ] {
        let misfit = settings(text).check().unwrap_err();
        assert!(misfit.key == "degree" && misfit.problem.contains(words), "{misfit}");
    }
    assert_eq!(settings("samples = 3").check().unwrap_err().key, "samples");
}

#[test]
fn a_hull_is_not_read_more_finely_than_it_is_interpolated() {
    let hull = settings("mesh = \"hull\"\nresolution = 120");
    assert!(hull.check_bins((120, 100)).is_ok() && hull.check_bins((100, 121)).is_err());
    assert!(settings("").check_bins((2000, 2000)).is_ok());
}
