use super::*;

const GOOD: &str = "name = \"mine\"\n[orbit]\nradiation = 0.15\noblateness = 0.40921\n[initial]\nphi = 2.2069\ne = 0.145\n\
     delta_phi = 0.39\ndelta_e = 0.05\n[times]\nend = 2.0\nstep = 0.5\n[disposal]\ncritical_e = 0.6\n";

fn load(text: &str) -> Result<ScenarioFile, InputError> {
    check(&InputFile::from_text(Path::new("s.toml"), text))
}

fn load_with(from: &str, to: &str) -> Result<ScenarioFile, InputError> {
    assert!(GOOD.contains(from));
    load(&GOOD.replace(from, to))
}

#[test]
fn a_good_file_gives_half_of_each_delta_and_all_times() {
    let scenario = load(GOOD).unwrap();
    assert_eq!(scenario.problem.times, [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(scenario.problem.initial.sigma_e, 0.025);
}

#[test]
fn times_by_a_step_are_as_a_person_would_write_them() {
    let stepped = load_with("step = 0.5", "step = 0.2").unwrap().problem.times;
    assert_eq!(stepped, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0]);
    let thirds = load_with("step = 0.5", "step = 0.6666666666666666").unwrap().problem.times;
    assert_eq!(thirds, [0.0, 0.666666666667, 1.33333333333, 2.0]);
}

#[test]
fn times_may_be_listed() {
    let listed = load_with("end = 2.0\nstep = 0.5", "at = [0.0, 0.1, 3.0]").unwrap();
    assert_eq!(listed.problem.times, [0.0, 0.1, 3.0]);
}

#[test]
fn an_epoch_gives_dates_and_the_horizon_may_be_one() {
    let epoch = "[epoch]\ndate = 2027-03-01\n[orbit]";
    let until = GOOD.replace("[orbit]", epoch).replace("end = 2.0", "until = 2029-03-01");
    let ScenarioFile { problem, epoch, .. } = load(&until).unwrap();
    // 2028 is a leap year: 731 days.
    assert_eq!(problem.times[..4], [0.0, 0.5, 1.0, 1.5]);
    assert!(problem.times.len() == 5 && (problem.times[4] - 731.0 / 365.256363).abs() < 1e-6, "{:?}", problem.times);
    let dates = [0.0, 1.0, problem.times[4]].map(|years| epoch.unwrap().date_after(years));
    assert_eq!(dates, ["2027-03-01", "2028-02-29", "2029-03-01"]);
    for (text, words) in [
        (GOOD.replace("end = 2.0", "until = 2029-03-01"), "needs the date at t = 0"),
        (until.replace("until = 2029", "until = 2026"), "is not after the epoch, 2027-03-01"),
        (until.replace("until = 2029", "until = 2027"), "it must be later"),
        (until.replace("until = 2029-03-01", "until = 07:32:00"), "must be a date from 1970 on"),
        (until.replace("until = 2029-03-01", "until = \"2029-03-01\""), "it must be a date without quotation marks"),
        (until.replace("date = 2027", "date = 1957"), "must be a date from 1970 on"),
        (until.replace("until = 2029", "end = 2.0\nuntil = 2029"), "either end and step"),
    ] {
        let problem = load(&text).unwrap_err().to_string();
        assert!(problem.contains(words), "{problem}");
    }
}

#[test]
fn a_problem_survives_the_way_through_a_file() {
    let shortest = GOOD.replace("end = 2.0\nstep = 0.5", "end = 63e-6\nstep = 1e-6");
    let forces = "[model]\nforces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n[orbit]\nsun = 4.76e-4\nmoon = 0.001\n";
    let correlated = GOOD.replace("[times]", "correlation = -0.7\n[times]");
    let uncertain = GOOD.replace("[times]", "sigma_radiation = 0.05\nradiation_distribution = \"log-normal\"\n[times]");
    for text in [GOOD, &shortest, &GOOD.replace("[orbit]\n", forces), &correlated, &uncertain] {
        let scenario = load(text).unwrap();
        assert_eq!(load(&to_text(&scenario.name, &scenario.problem, scenario.spread)).unwrap(), scenario);
    }
}

#[test]
fn parameters_follow_from_the_orbit() {
    let orbit = "semi_major_axis = 2.5\narea_to_mass = 10.0\nreflectivity = 1.2";
    let scenario = load_with("radiation = 0.15\noblateness = 0.40921", orbit).unwrap();
    let parameters = scenario.problem.model.parameters();
    assert!((parameters[1].1 - 0.40921).abs() < 1e-5 && parameters[0].1 > 0.0, "{parameters:?}");
}

#[test]
fn a_file_names_the_forces_that_act_with_a_parameter_each_or_the_satellite() {
    let orbit = "radiation = 0.15\noblateness = 0.40921\n";
    let with = |forces: &str, parameters: &str| {
        let model =
            load_with("[orbit]\n", &format!("[model]\nforces = {forces}\n[orbit]\n{parameters}"))?.problem.model;
        let values: Vec<f64> = model.parameters().into_iter().map(|(_, value)| value).collect();
        Ok::<_, InputError>((model.name(), values))
    };
    assert_eq!(with("[\"j2\", \"srp\"]", "").unwrap(), ("planar", vec![0.15, 0.40921]));
    let all = "[\"srp\", \"j2\", \"sun\", \"moon\"]";
    let (name, values) = with(all, "sun = 4.76e-4\nmoon = 1.037e-3\n").unwrap();
    assert_eq!((name, values), ("planar-sun-moon", vec![0.15, 0.40921, 4.76e-4, 1.037e-3]));
    let (name, values) = with("[\"srp\", \"j2\", \"sun\"]", "sun = 4.76e-4\n").unwrap();
    assert_eq!((name, values[3]), ("planar-sun-moon", 0.0));
    let satellite = GOOD.replace(orbit, "semi_major_axis = 2.5\narea_to_mass = 10.0\nreflectivity = 1.2\n");
    let sun = satellite.replace("[orbit]", "[model]\nforces = [\"j2\", \"sun\"]\n[orbit]");
    let values: Vec<f64> = load(&sun).unwrap().problem.model.parameters().into_iter().map(|(_, value)| value).collect();
    assert!(values[0] == 0.0 && (values[2] - 4.76224e-4).abs() < 1e-8 && values[3] == 0.0, "{values:?}");
    let told = |forces: &str, parameters: &str| with(forces, parameters).unwrap_err().to_string();
    let refused = |forces: &str, parameters: &str, words: &str| {
        let told = told(forces, parameters);
        assert!(told.contains(words), "{told}");
    };
    refused(
        "[\"drag\"]",
        "",
        "s.toml:3: model.forces: \"drag\" is no force, there are \"srp\", \"j2\", \"sun\", \"moon\"",
    );
    refused("[\"srp\", \"srp\"]", "", "for the second time");
    refused("[]", "", "names no force");
    refused(all, "", "s.toml:4: orbit: must have either radiation, oblateness, sun and moon, or semi_major_axis");
    refused(
        "[\"srp\", \"j2\"]",
        "sun = 1e-4\n",
        "s.toml:5: orbit.sun: has no effect: its force \"sun\" is not in model.forces",
    );
    refused(all, "sun = 2.0\nmoon = 0.0\n", "orbit.sun: 2 is not allowed, it must be 0 or greater, at most 1");
    let mixed = satellite.replace("[orbit]", "[orbit]\nradiation = 0.1");
    assert!(load(&mixed).unwrap_err().to_string().contains("orbit.radiation: follows from the satellite"));
}

#[test]
fn a_file_may_say_it_in_the_units_of_a_person() {
    let in_degrees = load_with("phi = 2.2069", "phi = \"126.446 deg\"").unwrap().problem.initial.mean_phi;
    assert!((in_degrees - 126.446f64.to_radians()).abs() < 1e-15);
    let one = load_with("delta_phi = 0.39\ndelta_e = 0.05", "sigma_phi = \"10 deg\"\nsigma_e = 0.025")
        .unwrap()
        .problem
        .initial;
    assert!((one.sigma_phi - 10f64.to_radians()).abs() < 1e-15 && one.sigma_e == 0.025);
    let times =
        load_with("end = 2.0\nstep = 0.5", "end = \"730.512726 d\"\nstep = \"182.6281815 d\"").unwrap().problem.times;
    assert!((times[4] - 2.0).abs() < 1e-12 && times.len() == 5, "{times:?}");
    let satellite = |axis: &str| format!("{axis}\narea_to_mass = 10.0\nreflectivity = 1.2");
    let orbit = "radiation = 0.15\noblateness = 0.40921";
    let model = |axis: &str| load_with(orbit, &satellite(axis)).unwrap().problem.model;
    let axis = model("semi_major_axis = 2.5");
    for other in ["semi_major_axis = \"15945.3425 km\"", "altitude = 9567.2055", "altitude = \"1.5 R_E\""] {
        let close = axis.parameters().into_iter().zip(model(other).parameters());
        assert!(close.into_iter().all(|((_, a), (_, b))| (a / b - 1.0).abs() < 1e-12), "{other}");
    }
    let by_height =
        GOOD.replace(orbit, &satellite("altitude = 9567.2055")).replace("critical_e = 0.6", "altitude = \"120 km\"");
    let critical = load(&by_height).unwrap().problem.critical_e;
    assert!((critical - (1.0 - (1.0 + 120.0 / 6378.137) / 2.5)).abs() < 1e-12, "{critical}");
    let told = |from: &str, to: &str| load_with(from, to).unwrap_err().to_string();
    assert!(told("critical_e = 0.6", "altitude = 120").contains("disposal.altitude: needs the semi-major axis"));
    assert!(told("critical_e = 0.6", "").contains("disposal: must have either critical_e or altitude"));
    assert!(
        told("delta_e = 0.05", "delta_e = 0.05\nsigma_e = 0.025").contains("initial.sigma_e: stands beside delta_e")
    );
    assert!(told("delta_e = 0.05", "").contains("initial: must have either sigma_e or delta_e"));
    assert!(told("delta_e = 0.05", "sigma_e = 0.7").contains("initial.sigma_e: two of it: 1.4 is not allowed"));
    let too_high = by_height.replace("\"120 km\"", "10_000");
    assert!(load(&too_high).unwrap_err().to_string().contains("must be below that of the orbit, 9567.2 km"));
    let twice = GOOD.replace(orbit, &satellite("altitude = 9567.2055\nsemi_major_axis = 2.5"));
    assert!(load(&twice).unwrap_err().to_string().contains("orbit.altitude: stands beside semi_major_axis"));
}

#[test]
fn every_mistake_is_told_with_line_and_key() {
    let cases = [
        ("delta_e = 0.05", "delta_e = 0.0", 9, "initial.delta_e", "at least 1e-9"),
        ("e = 0.145", "e = 1.0", 7, "initial.e", "between 0 and 1"),
        ("step = 0.5", "step = 0.3", 12, "times.step", "does not divide end = 2"),
        ("step = 0.5", "step = 1e-4", 12, "times.step", "more than a message holds"),
        ("step = 0.5", "", 10, "times", "either end and step, or at"),
        ("end = 2.0\nstep = 0.5", "at = [0.0, 2.0, 1.0]", 11, "times.at", "ascend"),
        (
            "step = 0.5",
            "step = 1e-300",
            12,
            "times.step",
            "1e-300 is not allowed, it must be at least 1e-6 yr and at most end",
        ),
        (
            "end = 2.0\nstep = 0.5",
            "at = [0, 1e-300]",
            11,
            "times.at",
            "0 and 1e-300 are too close, times must be at least 1e-6 yr",
        ),
        ("end = 2.0\nstep = 0.5", "at = [0, 1.0, 1.0000001]", 11, "times.at", "1 and 1.0000001 are too close"),
        ("phi = 2.2069", "phi = \"x\"", 6, "initial.phi", "\"x\" is not allowed, it must be a number"),
        ("phi = 2.2069", "phi = 1e300", 6, "initial.phi", "1e300 is not allowed"),
        ("phi = 2.2069", "phi = nan", 6, "initial.phi", "an angle in radians"),
        ("phi = 2.2069", "phi = 100", 6, "initial.phi", "if 100 degrees are meant, write 1.7453293"),
        ("phi = 2.2069", "phi = 7.0", 6, "initial.phi", "between -2π and 2π; if 7 degrees are meant, write 0.1221730"),
        ("phi = 2.2069", "phi = 1e9", 6, "initial.phi", "between -2π and 2π"),
        (
            "phi = 2.2069",
            "phi = \"361 deg\"",
            6,
            "initial.phi",
            "initial.phi: \"361 deg\" is not allowed, it must be an angle in radians, between -2π and 2π",
        ),
        (
            "delta_e = 0.05",
            "delta_e = 0.05\nsigma_radiation = 5",
            10,
            "initial.sigma_radiation",
            "5 is not allowed, it must be at least 1e-6 and at most 1, a share of the radiation parameter",
        ),
        (
            "delta_e = 0.05",
            "delta_e = 0.05\nradiation_distribution = \"log-normal\"",
            10,
            "initial.radiation_distribution",
            "has no effect without sigma_radiation",
        ),
        (
            "delta_e = 0.05",
            "delta_e = 0.05\ncorrelation = 1.0",
            10,
            "initial.correlation",
            "1 is not allowed, it must be between -0.999 and 0.999",
        ),
        ("delta_phi = 0.39", "delta_phi = 20", 8, "initial.delta_phi", "if 20 degrees are meant, write 0.3490659"),
        (
            "critical_e",
            "critical_q",
            14,
            "disposal.critical_q",
            "is unknown, did you mean `critical_e`? There may be `critical_e`",
        ),
        ("radiation = 0.15", "area_to_mass = 1.0", 2, "orbit", "either radiation and oblateness"),
        ("mine", "../mine", 1, "name", "letters, digits"),
        ("[times]", "[times", 10, "times", ""),
    ];
    for (from, to, line, key, words) in cases {
        let error = load_with(from, to).unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}
