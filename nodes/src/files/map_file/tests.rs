use super::*;

const BASE: &str = "name = \"s\"\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 2.2\n\
     e = 0.145\ndelta_phi = 0.39\ndelta_e = 0.05\n[times]\nat = [0.0, 1.0]\n[disposal]\naltitude = \"120 km\"\n";
const GOOD: &str = "scenario = \"base.toml\"\n[quantity]\nname = \"reentry\"\nwithin = 10\n[vary]\n\
     \"orbit.semi_major_axis\" = { from = 2, to = 3, count = 5 }\n\"orbit.area_to_mass\" = [1, 2, 3]\n";

fn load(text: &str) -> Result<MapFile, InputError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), BASE).unwrap();
    std::fs::write(folder.path().join("map.toml"), text).unwrap();
    MapFile::load(&folder.path().join("map.toml"))
}

#[test]
fn the_first_key_of_the_file_is_the_horizontal_axis() {
    let map = load(GOOD).unwrap();
    assert_eq!((map.size(), map.tolerance), ((5, 3), 1e-3));
    assert_eq!(map.quantity, Quantity::Reentry { within: 10.0 });
    assert_eq!((map.place((0, 0)), map.place((4, 1))), (vec![2.0, 1.0], vec![3.0, 2.0]));
    let point = map.point(map.index((4, 2))).unwrap();
    let other = map.point(map.index((4, 0))).unwrap();
    let radiation = |point: &AnyPoint| point.radiation();
    assert!((radiation(&point) / radiation(&other) - 3.0).abs() < 1e-12);
    let critical = |point: &AnyPoint| match point {
        AnyPoint::InPlane(point) => point.problem.critical_e,
        AnyPoint::InSpace(problem) => problem.critical_e,
    };
    assert!(critical(&point) > critical(&map.point(0).unwrap()));
    let one = load(&GOOD.replace("\"orbit.area_to_mass\" = [1, 2, 3]\n", "")).unwrap();
    assert_eq!((one.size(), one.place((3, 0))), ((5, 1), vec![2.75]));
}

#[test]
fn a_required_ratio_is_the_factor_times_the_ratio_of_the_point() {
    let required = GOOD.replace("\"reentry\"", "\"required-area-to-mass\"\nprobability = 0.9");
    let refused = load(&required).unwrap_err();
    assert!(refused.line == 8 && refused.to_string().contains("orbit.area_to_mass: has no effect"), "{refused}");
    let map = load(&required.replace("area_to_mass\" = [1, 2, 3]", "reflectivity\" = [1.1, 1.2, 1.3]")).unwrap();
    let index = map.index((1, 2));
    assert_eq!(map.scale(index, &map.point(index).unwrap()), 10.0);
    assert_eq!(map.label(), "area-to-mass ratio for 90 % within 10 yr [m²/kg]");
}

#[test]
fn a_mistake_is_told_with_line_and_key() {
    for (from, to, line, words) in [
        ("\"reentry\"", "\"density\"", 3, "quantity.name: \"density\" is no quantity, there are \"reentry\","),
        ("within = 10", "", 2, "quantity: must have within for \"reentry\""),
        ("within = 10", "within = -1", 4, "quantity.within: -1 is not allowed, it must be a number of years"),
        (
            "within = 10",
            "within = 10\nprobability = 0.5",
            5,
            "probability: has no effect on \"reentry\", which has within",
        ),
        ("\"reentry\"", "\"time-of-reentry\"\nprobability = 1", 4, "1 is not allowed, it must be a probability"),
        (
            "scenario",
            "tolerance = 0.5\nscenario",
            1,
            "0.5 is not allowed, it must be at least 0.000001 and at most 0.1",
        ),
        ("[1, 2, 3]", "[1, 2, 4]", 7, "orbit.area_to_mass: must have at least two values, ascending and evenly spaced"),
        ("[1, 2, 3]", "[1]", 7, "must have at least two values"),
        ("[1, 2, 3]", "[1]\n\"initial.e\" = [0.1]", 5, "vary: names 3 keys; a map has one or two axes"),
        ("\"orbit.area_to_mass\" = [1, 2, 3]", "\"initial.e\" = [0.1, 1.5]", 7, "1.5 is not allowed"),
        ("[quantity]\nname = \"reentry\"\nwithin = 10\n", "", 1, "this is a sweep file, but a map file belongs here"),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let error = load(&GOOD.replace(from, to)).unwrap_err();
        assert!(error.line == line && error.to_string().contains(words), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), BASE).unwrap();
    let path = folder.path().join("map.toml");
    let sweep = crate::files::sweep::Sweep::check(&InputFile::from_text(&path, GOOD)).unwrap();
    assert_eq!(sweep.len(), 15, "a map file is a sweep as well");
}

#[test]
fn a_map_file_may_name_hosts_and_is_no_other_kind_of_file_for_it() {
    let hosts = "tolerance = 1e-3\nscenario = \"base.toml\"\n[hosts]\nnames = [\"worker-a\"]\nlisten = \"tcp/127.0.0.1:7447\"\n";
    let text = GOOD.replace("scenario = \"base.toml\"\n", hosts);
    let table = load(&text).unwrap().hosts.unwrap();
    assert_eq!((table.names.get_ref().len(), table.listen.get_ref().as_str()), (1, "tcp/127.0.0.1:7447"));
    assert!(load(GOOD).unwrap().hosts.is_none());
    let error = load(&text.replace("listen", "at")).unwrap_err();
    assert!(error.line == 5 && error.to_string().contains("hosts.at"), "{error}");
    let error = load(&text.replace("scenario = \"base.toml\"\n", "")).unwrap_err();
    assert!(error.to_string().contains("the map file lacks the key `scenario`"), "{error}");
}

#[test]
fn a_map_is_the_same_if_its_scenario_has_come_with_it() {
    let input = |text| InputFile::from_text(Path::new("elsewhere/map.toml"), text);
    let map = MapFile::check_with_scenario(&input(GOOD), &input(BASE)).unwrap();
    assert_eq!((map.size(), map.texts()), ((5, 3), [GOOD, BASE]));
    assert_eq!(map.point(7).unwrap(), load(GOOD).unwrap().point(7).unwrap());
}

const IN_SPACE: &str = "name = \"s\"\n[model]\nname = \"vectorial\"\nforces = [\"srp\", \"j2\"]\n[epoch]\nsun_longitude = 0.0\n[orbit]\n\
    semi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 2.2\ne = 0.1\ninclination = 0.2\nnode = 1.0\n\
    sigma_phi = 0.1\nsigma_e = 0.01\n[times]\nat = [0.0, 1.0]\n[disposal]\ncritical_e = 0.6\n";
const OF_SPACE: &str = "scenario = \"base.toml\"\n[quantity]\nname = \"reentry\"\nwithin = 10\n[vary]\n\
    \"initial.inclination\" = { from = \"0 deg\", to = \"60 deg\", count = 4 }\n\"orbit.area_to_mass\" = [1, 2, 3]\n";

fn load_in_space(base: &str, text: &str) -> Result<MapFile, InputError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), base).unwrap();
    std::fs::write(folder.path().join("map.toml"), text).unwrap();
    MapFile::load(&folder.path().join("map.toml"))
}

#[test]
fn an_inclination_in_degrees_is_an_axis_of_a_map_in_space() {
    let map = load_in_space(IN_SPACE, OF_SPACE).unwrap();
    assert_eq!(
        (map.size(), map.place((3, 1)), map.sweep.unit("initial.inclination")),
        ((4, 3), vec![60.0, 2.0], Some("deg"))
    );
    let AnyPoint::InSpace(point) = map.point(map.index((1, 2))).unwrap() else { panic!("it is in space") };
    assert!((point.initial.mean[2] - 20f64.to_radians()).abs() < 1e-15);
    assert!(map.sweep.combination(0).contains("initial.inclination = 0 deg"), "{}", map.sweep.combination(0));
}

#[test]
fn a_model_without_a_map_is_refused_by_name() {
    for (from, to, words) in [
        (
            "[\"srp\", \"j2\"]",
            "[\"srp\", \"j2\", \"shadow\"]",
            "scenario: model.forces: \"shadow\" makes the semi-major axis a variable",
        ),
        ("\"vectorial\"", "\"osculating\"", "scenario: model.name: \"osculating\" is not averaged"),
    ] {
        let error = load_in_space(&IN_SPACE.replace(from, to), OF_SPACE).unwrap_err();
        assert!(error.line == 1 && error.to_string().contains(words), "{error}");
    }
    let required = OF_SPACE.replace("\"reentry\"", "\"required-area-to-mass\"\nprobability = 0.9");
    let error = load_in_space(IN_SPACE, &required).unwrap_err();
    assert!(error.line == 3 && error.to_string().contains("is not computed in space"), "{error}");
    let unit = load_in_space(IN_SPACE, &OF_SPACE.replace(" deg\"", " grad\"")).unwrap_err();
    assert!(unit.line == 6 && unit.to_string().contains("one of the units rad, deg"), "{unit}");
}

#[test]
fn what_has_no_effect_on_the_quantity_is_no_axis() {
    let required = GOOD.replace("\"reentry\"", "\"required-area-to-mass\"\nprobability = 0.9");
    let error = load(&required).unwrap_err();
    let words = "orbit.area_to_mass: has no effect on the area-to-mass ratio for 90 % within 10 yr [m²/kg]";
    assert!(error.line == 8 && error.to_string().contains(words), "{error}");
    let reflectivity = required.replace("orbit.area_to_mass\" = [1, 2, 3]", "orbit.reflectivity\" = [1.1, 1.2, 1.3]");
    assert!(load(&reflectivity).is_ok(), "a sail that reflects more needs less area");
    let radiation = reflectivity.replace("required-area-to-mass", "required-radiation");
    assert!(
        load(&radiation)
            .unwrap_err()
            .to_string()
            .contains("orbit.reflectivity: has no effect on the radiation parameter")
    );
    let far_too_many = load(&GOOD.replace("count = 5", "count = 40_000")).unwrap_err();
    assert!(far_too_many.to_string().contains("has 120000 points; a map must have at most 100000"), "{far_too_many}");
    let times = load(&GOOD.replace("orbit.semi_major_axis", "times.at"));
    assert!(times.is_err());
    let mean = IN_SPACE.replace("critical_e = 0.6", "critical_e = 0.6\n");
    let of_mean = OF_SPACE
        .replace("\"reentry\"\nwithin", "\"mean-e\"\nafter")
        .replace("\"orbit.area_to_mass\" = [1, 2, 3]", "\"disposal.critical_e\" = [0.5, 0.6]");
    let error = load_in_space(&mean, &of_mean).unwrap_err();
    assert!(
        error.to_string().contains("disposal.critical_e: has no effect on the mean eccentricity after 10 yr"),
        "{error}"
    );
}

#[test]
fn a_difference_is_between_models_or_methods_that_there_are() {
    let with = |table: &str| OF_SPACE.replace("[vary]", &format!("[difference]\n{table}\n[vary]"));
    let map = load_in_space(IN_SPACE, &with("model = \"planar\"")).unwrap();
    assert_eq!(
        (map.other, map.label().as_str()),
        (Some(Other::Planar), "probability of re-entry within 10 yr, in space less in the plane")
    );
    let map = load_in_space(IN_SPACE, &with("method = \"mc\"\nsamples = 500")).unwrap();
    assert_eq!(map.other, Some(Other::MonteCarlo { samples: 500, seed: 1 }));
    for (table, line, words) in [
        ("model = \"planar\"\nseed = 3", 7, "difference.seed: has no effect on a difference between models"),
        ("model = \"vectorial\"", 6, "\"vectorial\" is not allowed, it must be \"planar\""),
        ("method = \"exact\"", 6, "\"exact\" is not allowed, it must be \"mc\""),
        ("method = \"mc\"\nsamples = 3", 7, "3 is not allowed, it must be at least 100"),
        ("method = \"mc\"\nmodel = \"planar\"", 5, "must have either model = \"planar\" or method = \"mc\""),
    ] {
        let error = load_in_space(IN_SPACE, &with(table)).unwrap_err();
        assert!(error.line == line && error.to_string().contains(words), "{error}");
    }
    let time = with("model = \"planar\"").replace("\"reentry\"", "\"time-of-reentry\"\nprobability = 0.5");
    assert!(
        load_in_space(IN_SPACE, &time)
            .unwrap_err()
            .to_string()
            .contains("is computed of \"reentry\" and \"mean-e\" alone")
    );
    let plane = load(&GOOD.replace("[vary]", "[difference]\nmodel = \"planar\"\n[vary]")).unwrap_err();
    assert!(plane.line == 6 && plane.to_string().contains("the scenario is in the plane already"), "{plane}");
}
