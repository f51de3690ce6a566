use super::*;
use crate::files::scenario_file::ScenarioFile;
use density::model::PlanarHamiltonian;

const BASE: &str = "name = \"s\"\n[orbit]\nradiation = 0.15\noblateness = 0.4\n[initial]\nphi = 2.2\ne = 0.145\n\
     delta_phi = 0.39\ndelta_e = 0.05\n[times]\nend = 2.0\nstep = 0.5\n[disposal]\ncritical_e = 0.6\n";

/// A scenario that gives its orbit by the satellite and lists its times.
const SATELLITE: &str = "name = \"s\"\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 2.2\n\
     e = 0.145\ndelta_phi = 0.39\ndelta_e = 0.05\n[times]\nat = [0.0, 1.0]\n[disposal]\ncritical_e = 0.6\n";

fn load(text: &str) -> Result<Sweep, InputError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), BASE).unwrap();
    std::fs::write(folder.path().join("satellite.toml"), SATELLITE).unwrap();
    let path = folder.path().join("sweep.toml");
    std::fs::write(&path, text).unwrap();
    Sweep::load(&path)
}

#[test]
fn every_combination_comes_once_and_the_last_key_varies_fastest() {
    let sweep = load(
        "scenario = \"base.toml\"\n[vary]\n\"initial.e\" = [0.1, 0.2]\n\
         \"orbit.radiation\" = { from = 0.1, to = 0.3, count = 3 }\n",
    )
    .unwrap();
    assert_eq!(sweep.len(), 6);
    let found: Vec<_> = (0..6)
        .map(|index| {
            let scenario = sweep.scenario(index).unwrap();
            let ScenarioFile { name, problem, .. } = scenario.in_plane().unwrap().clone();
            assert_eq!(name, format!("s-{index}"));
            assert_eq!(sweep.index_of(&name), Some(index));
            assert_eq!(sweep.values(index)[0], problem.initial.mean_e);
            (problem.initial.mean_e, (problem.model.parameters()[0].1 * 1e9).round() / 1e9)
        })
        .collect();
    assert_eq!(sweep.combination(3), "initial.e = 0.2, orbit.radiation = 0.1");
    assert_eq!((sweep.index_of("s-6"), sweep.index_of("s-03"), sweep.index_of("t-3")), (None, None, None));
    assert_eq!(found, [(0.1, 0.1), (0.1, 0.2), (0.1, 0.3), (0.2, 0.1), (0.2, 0.2), (0.2, 0.3)]);
}

/// A table within a table, as the correlations of a cloud in space.
#[test]
fn a_correlation_in_space_is_varied() {
    let folder = tempfile::tempdir().unwrap();
    let base = include_str!("../../../../launch/scenarios/three-dimensional.toml");
    std::fs::write(folder.path().join("base.toml"), base).unwrap();
    let path = folder.path().join("sweep.toml");
    std::fs::write(&path, "scenario = \"base.toml\"\n[vary]\n\"initial.correlation.phi_node\" = [-0.5, 0.25]\n")
        .unwrap();
    let sweep = Sweep::load(&path).unwrap();
    assert_eq!(sweep.combination(1), "initial.correlation.phi_node = 0.25");
    for (index, right) in [-0.5, 0.25].into_iter().enumerate() {
        let AnyScenario::InSpace(scenario) = sweep.scenario(index).unwrap() else { panic!("it is in space") };
        assert_eq!(scenario.cloud.unwrap().initial.correlation[2], right);
    }
}

#[test]
fn scenarios_of_a_long_name_have_names_of_their_own_that_are_allowed() {
    let base = BASE.replace("\"s\"", "\"a-name-of-thirty-one-characters\"");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), base).unwrap();
    let text = "scenario = \"base.toml\"\n[vary]\n\"initial.e\" = { from = 0.1, to = 0.2, count = 11 }\n";
    std::fs::write(folder.path().join("sweep.toml"), text).unwrap();
    let sweep = Sweep::load(&folder.path().join("sweep.toml")).unwrap();
    assert_eq!(sweep.scenario(10).unwrap().name(), "a-name-of-thirty-one-charact-10");
    assert_eq!(sweep.index_of("a-name-of-thirty-one-charact-10"), Some(10));
}

#[test]
fn a_mistake_is_told_with_line_and_key() {
    let vary = |text: &str| format!("scenario = \"base.toml\"\n[vary]\n{text}\n");
    for (text, line, words) in [
        (
            vary("\"initial.eccentricity\" = [0.1]"),
            3,
            "not a number of the scenario; what can be varied is disposal.critical_e,",
        ),
        (vary("\"initial.e\" = []"), 3, "names no value"),
        (vary("\"initial.e\" = \"x\""), 3, "a list of numbers"),
        (
            vary("initial.e = [0.1, 0.2]"),
            3,
            "vary.initial: the whole key needs quotation marks under [vary]: \"initial.e\" = ",
        ),
        (vary("[vary.initial]\ne = [0.1, 0.2]"), 3, "needs quotation marks"),
        (
            vary("\"disposal.critical_e\" = [0.5]\n\"initial.e\" = [1.5]"),
            4,
            "sweep.toml:4: vary.initial.e: 1.5 is not allowed, it must be between 0 and 1, both excluded, in s-0 \
             (disposal.critical_e = 0.5, initial.e = 1.5)",
        ),
        (
            vary("\"times.end\" = [1.75, 2.0]"),
            3,
            "vary.times.end: times.step: 0.5 does not divide end = 1.75; 0.4375 would, in s-0 (times.end = 1.75)",
        ),
        (vary("\"initial.e\" = [0.1]\n\"initial.e\" = [0.2]"), 4, "for the second time"),
        (vary("\"initial.e\" = { from = 0.1, to = 0.2, count = 0 }"), 3, "count = 0 leaves no value"),
        (vary("\"initial.e\" = { from = 0.1, to = 0.2, count = 1 }"), 3, "initial.e: to = 0.2 has no effect"),
        (vary("\"initial.e\" = [0.1, 0.2, 0.10]"), 3, "initial.e: takes the value 0.1 twice"),
        (vary("\"initial.phi\" = [0.0, -0.0]"), 3, "twice"),
        (vary("\"initial.e\" = { from = 0.1, to = 0.1, count = 3 }"), 3, "takes the value 0.1 twice"),
        (vary("\"orbit.reflectivity\" = [1]"), 3, "gives its orbit by radiation and oblateness"),
        (vary("\"times.at\" = [1]"), 3, "gives its times by end and step"),
        (vary(""), 2, "names no key"),
        ("scenario = \"none.toml\"\n[vary]\n".into(), 1, "cannot be read"),
    ] {
        let error = load(&text).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    assert_eq!(load(&vary("\"initial.e\" = { from = 0.1, to = 0.1, count = 1 }")).unwrap().len(), 1);
}

#[test]
fn a_combination_that_is_impossible_is_told_at_the_line_of_the_key_that_makes_it_so() {
    let text = "scenario = \"base.toml\"\n[vary]\n\"initial.e\" = [0.145, 0.2]\n\"times.step\" = [0.5, 0.3]\n";
    let error = load(text).unwrap().scenario(1).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (4, "vary.times.step"), "{error}");
    assert!(error.to_string().contains("sweep.toml:4: vary.times.step: 0.3 does not divide end = 2;"), "{error}");
    assert!(error.to_string().ends_with(", in s-1 (initial.e = 0.145, times.step = 0.3)"), "{error}");
}

#[test]
fn a_combination_that_another_key_of_the_scenario_does_not_fit_is_told_at_the_line_of_the_varied_one() {
    let folder = tempfile::tempdir().unwrap();
    let base = SATELLITE.replace("critical_e = 0.6", "altitude = 120");
    std::fs::write(folder.path().join("base.toml"), base).unwrap();
    let text = "scenario = \"base.toml\"\n\n[vary]\n\"orbit.semi_major_axis\" = [2.5, 1.01]\n";
    std::fs::write(folder.path().join("sweep.toml"), text).unwrap();
    let error = Sweep::load(&folder.path().join("sweep.toml")).unwrap().scenario(1).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (4, "vary.orbit.semi_major_axis"), "{error}");
    assert!(error.to_string().contains("disposal.altitude: must be below that of the orbit, 63.8 km"), "{error}");
}

#[test]
fn a_key_that_the_scenario_gives_otherwise_is_refused_with_those_that_it_has() {
    for (key, words) in [
        (
            "orbit.radiation",
            "orbit.radiation: is not in the scenario, which gives its orbit by the satellite; what can be varied is ",
        ),
        ("orbit.oblateness", "initial.phi, orbit.area_to_mass, orbit.reflectivity, orbit.semi_major_axis"),
        ("times.end", "which lists its times in times.at"),
        ("times.at", "a list or in one"),
        ("times.at[1]", "a list or in one"),
        ("name", "not a number of the scenario"),
    ] {
        let error = load(&format!("scenario = \"satellite.toml\"\n[vary]\n\"{key}\" = [1]\n")).unwrap_err();
        assert!(error.line == 3 && error.to_string().contains(words), "{error}");
    }
}

#[test]
fn scenarios_in_space_are_varied_too() {
    let base = "name = \"s\"\n[model]\nname = \"vectorial\"\nforces = [\"srp\", \"j2\"]\n[epoch]\nsun_longitude = 0.0\n[orbit]\n\
        semi_major_axis = 2.5\nradiation = 0.1\n[initial]\nphi = 2.2\ne = 0.1\ninclination = 0.2\nnode = 1.0\nsigma_phi = 0.1\n\
        sigma_e = 0.01\n[times]\nat = [0.0, 1.0]\n[disposal]\ncritical_e = 0.6\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), base).unwrap();
    let text = "scenario = \"base.toml\"\n[vary]\n\"initial.inclination\" = [0.1, 0.3]\n";
    std::fs::write(folder.path().join("sweep.toml"), text).unwrap();
    let sweep = Sweep::load(&folder.path().join("sweep.toml")).unwrap();
    let AnyScenario::InSpace(scenario) = sweep.scenario(1).unwrap() else { panic!("it is in space") };
    assert_eq!((scenario.name.as_str(), scenario.cloud.unwrap().initial.mean[2]), ("s-1", 0.3));
}
