//! The text of a scenario file in space.

use density::in_space::acting::SHADOW;
use density::in_space::{InitialInSpace, PAIR_NAMES, SpaceProblem};
use density::model::parameter::Parameter;
use density::model::planar::RADIATION;
use density::model::space_registry::SpaceModel;
use density::model::vectorial::Vectorial;
use density::uncertain::{Distribution, Spread};

/// The text of a scenario file that states a problem in space.
pub fn to_text(name: &str, problem: &SpaceProblem) -> String {
    let SpaceProblem { model, initial, spread, times, critical_e, shadow, reentry_altitude } = problem;
    let Vectorial { obliquity, sun_longitude, .. } = model.averaged();
    let (mut forces, orbit) = orbit(model);
    forces.extend(shadow.then_some(SHADOW));
    let disposal = match reentry_altitude {
        Some(altitude) => format!("altitude = \"{altitude:?} R_E\""),
        None => format!("critical_e = {critical_e:?}"),
    };
    let epoch = match model.moon_longitude() {
        Some(longitude) if model.forces().moon != 0.0 => format!("moon_longitude = {longitude:?}\n"),
        _ => String::new(),
    };
    let anomaly = model.mean_anomaly().map_or(String::new(), |anomaly| format!("mean_anomaly = {anomaly:?}\n"));
    format!(
        "name = \"{name}\"\n\n[model]\nname = \"{}\"\nforces = {forces:?}\nobliquity = {obliquity:?}\n\n[epoch]\nsun_longitude = \
         {sun_longitude:?}\n{epoch}\n[orbit]\n{orbit}\n[initial]\n{}{anomaly}{}{}\n[times]\nat = {times:?}\n\n[disposal]\n{disposal}\n",
        model.name(),
        variables(initial),
        radiation(*spread),
        correlation(initial),
    )
}

/// The forces that act, and the lines of the table `[orbit]`.
fn orbit(model: &SpaceModel) -> (Vec<&'static str>, String) {
    // The radiation parameter is given even where it is 0: with the semi-major axis, all others follow from it.
    let is_named = |(parameter, value): &(Parameter, f64)| *parameter == RADIATION || *value != 0.0;
    let acting = model.force_parameters().into_iter().filter(is_named);
    let names = acting.clone().map(|(parameter, _)| parameter.force).collect();
    let given = acting.filter(|(parameter, _)| *parameter == RADIATION || model.axis().is_none());
    let lines: String = given.map(|(parameter, value)| format!("{} = {value:?}\n", parameter.name)).collect();
    let axis = model.axis().map_or(String::new(), |axis| format!("semi_major_axis = {axis:?}\n"));
    (names, lines + &axis)
}

fn variables(InitialInSpace { mean: [phi, e, inclination, node], sigma, .. }: &InitialInSpace) -> String {
    let [sigma_phi, sigma_e, sigma_inclination, sigma_node] = sigma;
    let certain = |key: &str, sigma: f64| if sigma == 0.0 { String::new() } else { format!("{key} = {sigma:?}\n") };
    format!(
        "phi = {phi:?}\ne = {e:?}\ninclination = {inclination:?}\nnode = {node:?}\nsigma_phi = {sigma_phi:?}\nsigma_e = {sigma_e:?}\n{}{}",
        certain("sigma_inclination", *sigma_inclination),
        certain("sigma_node", *sigma_node),
    )
}

fn radiation(spread: Option<Spread>) -> String {
    spread.map_or(String::new(), |Spread { relative, distribution }| {
        let distribution = match distribution {
            Distribution::Gaussian => "",
            Distribution::LogNormal => "radiation_distribution = \"log-normal\"\n",
        };
        format!("sigma_radiation = {relative:?}\n{distribution}")
    })
}

fn correlation(initial: &InitialInSpace) -> String {
    let pairs = PAIR_NAMES.iter().zip(initial.correlation).filter(|(_, correlation)| *correlation != 0.0);
    let lines: String = pairs.map(|(name, correlation)| format!("{name} = {correlation:?}\n")).collect();
    if lines.is_empty() { lines } else { format!("\n[initial.correlation]\n{lines}") }
}
