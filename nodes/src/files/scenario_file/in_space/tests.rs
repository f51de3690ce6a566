//! What a scenario file in space may say, and how it is refused.

use std::path::Path;

use super::*;
use crate::files::scenario_file::{AnyScenario, check_any};

const GOOD: &str = "name = \"mine\"\n[model]\nname = \"osculating\"\nforces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n\
    [epoch]\nsun_longitude = \"138.01 deg\"\nmoon_longitude = \"40 deg\"\n[orbit]\nsemi_major_axis = 2.0\nradiation = 0.207\n\
    [initial]\ne = 0.489\ninclination = \"62.08 deg\"\nnode = \"102.89 deg\"\nargument_of_pericentre = \"19.42 deg\"\n\
    mean_anomaly = \"75 deg\"\n[times]\nat = [0.0, 0.1, 1.0]\n";

fn load(text: &str) -> Result<ScenarioInSpace, InputError> {
    match check_any(&InputFile::from_text(Path::new("s.toml"), text))? {
        AnyScenario::InSpace(scenario) => Ok(scenario),
        AnyScenario::InPlane { .. } => panic!("in the plane"),
    }
}

#[test]
fn a_good_file_gives_the_model_and_the_orbit() {
    let scenario = load(GOOD).unwrap();
    let [phi, e, inclination, _] = scenario.start;
    let SpaceModel::Osculating { model, mean_anomaly: Some(anomaly) } = scenario.model else { panic!("another model") };
    assert!((phi - (102.89f64 + 19.42 - 138.01).to_radians()).abs() < 1e-14);
    assert_eq!((e, inclination, anomaly), (0.489, 62.08f64.to_radians(), 75f64.to_radians()));
    assert_eq!(model.semi_major_axis, 2.0);
    assert!((model.forces.force.oblateness - 0.893_562).abs() < 1e-6 && model.forces.force.radiation == 0.207);
    assert!((model.obliquity - 23.4393f64.to_radians()).abs() < 1e-15);
}

#[test]
fn a_wrong_file_is_refused_at_its_line_and_key() {
    for (from, to, line, key, words) in [
        ("\"osculating\"", "\"kepler\"", 3, "model.name", "\"kepler\" is no model, there are \"planar\""),
        ("\"osculating\"", "\"vectorial\"", 16, "initial.mean_anomaly", "averaged over the satellite's revolution"),
        ("mean_anomaly = \"75 deg\"\n", "", 11, "initial", "must have mean_anomaly"),
        ("moon_longitude = \"40 deg\"\n", "", 5, "epoch", "must have moon_longitude"),
        (", \"moon\"]", "]", 7, "epoch.moon_longitude", "has no effect"),
        ("semi_major_axis = 2.0\n", "", 8, "orbit", "must have either radiation, oblateness, sun and moon"),
        ("radiation = 0.207", "radiation = 0.207\nsun = 0.1", 11, "orbit.sun", "follows from the semi-major axis"),
        (
            "radiation = 0.207",
            "radiation = -1",
            10,
            "orbit.radiation",
            "-1 is not allowed, it must be 0 or greater, at most 100",
        ),
        ("semi_major_axis = 2.0", "semi_major_axis = 0.5", 9, "orbit.semi_major_axis", "more than 1 Earth radius"),
        ("e = 0.489", "e = 1.0", 12, "initial.e", "at least 0 and below 1"),
        ("\"62.08 deg\"", "62.08", 13, "initial.inclination", "an angle in radians, at least 0 and below π - 0.001"),
        ("\"138.01 deg\"", "138.01", 6, "epoch.sun_longitude", "write \"138.01 deg\""),
        ("mean_anomaly", "sigma_q = 0.1\nmean_anomaly", 16, "initial.sigma_q", "is unknown"),
        ("e = 0.489", "e = 0.489\nphi = 1.0", 13, "initial.phi", "leave out one of them"),
        ("[0.0, 0.1, 1.0]", "[0.5, 1.0]", 18, "times.at", "0.0 for the first"),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let error = load(&GOOD.replacen(from, to, 1)).unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn where_clouds_are_propagated_a_model_in_space_is_refused_in_words() {
    let error = crate::files::scenario_file::check(&InputFile::from_text(Path::new("s.toml"), GOOD)).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (3, "model.name"));
    assert!(error.to_string().contains("which this command cannot do yet"), "{error}");
}

#[test]
fn a_date_says_where_the_sun_and_the_moon_are() {
    let dated = GOOD.replace("sun_longitude = \"138.01 deg\"\nmoon_longitude = \"40 deg\"", "date = 1992-10-13");
    let of = |text: &str| match load(text).unwrap() {
        ScenarioInSpace { model: SpaceModel::Osculating { model, .. }, epoch, times, .. } => (model, epoch, times),
        _ => panic!("another model"),
    };
    let (model, epoch, _) = of(&dated);
    // Meeus (1998), example 25.a, has the same day.
    assert!((model.sun_longitude - 201.80720f64.to_radians()).abs() < 1e-6);
    assert_eq!(epoch.unwrap().date_after(0.0), "1992-10-13");
    let with_sun = dated.replace("date =", "sun_longitude = 1.0\ndate =");
    assert_eq!((of(&with_sun).0.sun_longitude, of(&with_sun).0.moon_longitude), (1.0, model.moon_longitude));
    let until = dated.replace("at = [0.0, 0.1, 1.0]", "until = 1993-10-13\nstep = 0.5");
    let (.., times) = of(&until);
    assert!(times.len() == 3 && (times[2] - 365.0 / 365.256363).abs() < 1e-9, "{times:?}");
    let nowhere = load(&dated.replace("date = 1992-10-13\n", "")).unwrap_err();
    assert!(nowhere.to_string().contains("must have sun_longitude, or a date"), "{nowhere}");
}
