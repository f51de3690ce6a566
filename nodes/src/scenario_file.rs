//! Scenario files: the problem as a user writes it.

use std::path::Path;

use density::dynamics::Force;
use density::problem::{InitialGaussian, MOST_YEARS, Problem};
use density::problem_error::{Field, ProblemError};
use messages::layout::MOST_SNAPSHOTS;
use serde::Deserialize;
use toml::Spanned;

use crate::file_kind::FileKind;
use crate::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use crate::plain_number::plain;

/// A scenario as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioFile {
    /// Its name.
    pub name: String,
    /// The problem.
    pub problem: Problem,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: Spanned<String>,
    orbit: Spanned<Orbit>,
    initial: Initial,
    times: Spanned<Times>,
    disposal: Disposal,
}

/// Either both dimensionless parameters, or what Eq. 2 derives them from.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Orbit {
    radiation: Option<Spanned<f64>>,
    oblateness: Option<Spanned<f64>>,
    semi_major_axis: Option<Spanned<f64>>,
    area_to_mass: Option<Spanned<f64>>,
    reflectivity: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Initial {
    phi: Spanned<f64>,
    e: Spanned<f64>,
    delta_phi: Spanned<f64>,
    delta_e: Spanned<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Times {
    end: Option<Spanned<f64>>,
    step: Option<Spanned<f64>>,
    at: Option<Spanned<Vec<f64>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Disposal {
    critical_e: Spanned<f64>,
}

/// Reads and checks a scenario file.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn load(path: &Path) -> Result<ScenarioFile, InputError> {
    check(&InputFile::read(path)?)
}

/// Checks a scenario file that has been read.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn check(file: &InputFile) -> Result<ScenarioFile, InputError> {
    FileKind::Scenario.expect(file)?;
    let raw: Raw = file.parse()?;
    if !is_plain_name(raw.name.get_ref()) {
        return Err(file.error(&raw.name, &format!("\"{}\" is not allowed, {PLAIN_NAME}", raw.name.get_ref())));
    }
    let Initial { phi, e, delta_phi, delta_e } = &raw.initial;
    let initial = InitialGaussian {
        mean_phi: *phi.get_ref(),
        mean_e: *e.get_ref(),
        sigma_phi: 0.5 * delta_phi.get_ref(),
        sigma_e: 0.5 * delta_e.get_ref(),
    };
    let force = force(file, &raw.orbit)?;
    let times = times(file, &raw.times)?;
    let problem = Problem::new(force, initial, times, *raw.disposal.critical_e.get_ref());
    Ok(ScenarioFile { name: raw.name.get_ref().clone(), problem: problem.map_err(|error| raw.locate(file, &error))? })
}

/// The key of a scenario file that states a field of a problem.
pub fn key(field: Field) -> String {
    match field {
        Field::Parameter(name) => format!("orbit.{name}"),
        Field::MeanPhi => "initial.phi".into(),
        Field::MeanE => "initial.e".into(),
        Field::DeltaPhi => "initial.delta_phi".into(),
        Field::DeltaE => "initial.delta_e".into(),
        Field::Times => "times.at".into(),
        Field::CriticalE => "disposal.critical_e".into(),
    }
}

impl Raw {
    /// The line and key of what is wrong with the problem.
    fn locate(&self, file: &InputFile, error: &ProblemError) -> InputError {
        let problem = in_words(error);
        let number = |value: &Spanned<f64>| file.error(value, &problem);
        let Times { end, at, .. } = self.times.get_ref();
        match error.field {
            Field::Parameter(name) => self.orbit.get_ref().locate(file, name, &self.orbit, &problem),
            Field::MeanPhi => number(&self.initial.phi),
            Field::MeanE => number(&self.initial.e),
            Field::DeltaPhi => number(&self.initial.delta_phi),
            Field::DeltaE => number(&self.initial.delta_e),
            Field::CriticalE => number(&self.disposal.critical_e),
            Field::Times => match (at, end) {
                (Some(at), _) => file.error(at, &problem),
                (None, Some(end)) => number(end),
                (None, None) => file.error(&self.times, &problem),
            },
        }
    }
}

impl Orbit {
    /// The line and key of the parameter `name`; of the whole table if it follows from others.
    fn locate(&self, file: &InputFile, name: &str, table: &Spanned<Self>, problem: &str) -> InputError {
        let value = match name {
            "radiation" => &self.radiation,
            "oblateness" => &self.oblateness,
            "semi_major_axis" => &self.semi_major_axis,
            "area_to_mass" => &self.area_to_mass,
            "reflectivity" => &self.reflectivity,
            _ => &None,
        };
        match value {
            Some(value) => file.error(value, problem),
            None => file.error(table, &format!("gives {name}: {problem}")),
        }
    }
}

fn number(
    file: &InputFile,
    value: &Spanned<f64>,
    range: &str,
    is_right: impl Fn(f64) -> bool,
) -> Result<f64, InputError> {
    let x = *value.get_ref();
    if x.is_finite() && is_right(x) {
        Ok(x)
    } else {
        Err(file.error(value, &format!("{} is not allowed, it must be {range}", plain(x))))
    }
}

fn force(file: &InputFile, orbit: &Spanned<Orbit>) -> Result<Force, InputError> {
    match orbit.get_ref() {
        Orbit {
            radiation: Some(radiation),
            oblateness: Some(oblateness),
            semi_major_axis: None,
            area_to_mass: None,
            reflectivity: None,
        } => Ok(Force { radiation: *radiation.get_ref(), oblateness: *oblateness.get_ref() }),
        Orbit {
            radiation: None,
            oblateness: None,
            semi_major_axis: Some(a),
            area_to_mass: Some(ratio),
            reflectivity: Some(reflectivity),
        } => Force::from_orbit(*a.get_ref(), *ratio.get_ref(), *reflectivity.get_ref()).map_err(|error| {
            match error.field {
                Field::Parameter(name) => orbit.get_ref().locate(file, name, orbit, &in_words(&error)),
                _ => file.error(orbit, &in_words(&error)),
            }
        }),
        _ => Err(file.error(
            orbit,
            "must have either radiation and oblateness, or semi_major_axis, area_to_mass and reflectivity",
        )),
    }
}

/// What is wrong with a value, and what would be right.
fn in_words(error: &ProblemError) -> String {
    format!("{} is not allowed, it must be {}", plain(error.value), error.right)
}

/// Either the end and a step, or the times themselves.
fn times(file: &InputFile, times: &Spanned<Times>) -> Result<Vec<f64>, InputError> {
    match times.get_ref() {
        Times { end: Some(end), step: Some(step), at: None } => stepped_times(file, end, step),
        Times { end: None, step: None, at: Some(at) } => listed_times(file, at),
        _ => Err(file.error(times, "must have either end and step, or at")),
    }
}

/// How many snapshots a scenario may have: as many as a message holds.
pub fn is_right_number_of_times(times: usize) -> bool {
    (2..=MOST_SNAPSHOTS).contains(&times)
}

fn listed_times(file: &InputFile, at: &Spanned<Vec<f64>>) -> Result<Vec<f64>, InputError> {
    if !is_right_number_of_times(at.get_ref().len()) {
        return Err(file.error(at, &format!("must be 2 to {MOST_SNAPSHOTS} times")));
    }
    let list = at.get_ref();
    let is_close = |gap: f64| gap > 0.0 && gap < LEAST_GAP * (1.0 - ROUNDING);
    if let Some(close) = list.windows(2).find(|pair| is_close(pair[1] - pair[0])) {
        let [before, after] = [close[0], close[1]].map(plain);
        return Err(
            file.error(at, &format!("{before} and {after} are too close, times must be at least 1e-6 yr apart"))
        );
    }
    Ok(list.clone())
}

/// Least time between two snapshots \[yr\].
const LEAST_GAP: f64 = 1e-6;
/// What times that were written with few digits may miss that by.
const ROUNDING: f64 = 1e-6;

fn stepped_times(file: &InputFile, end_at: &Spanned<f64>, every: &Spanned<f64>) -> Result<Vec<f64>, InputError> {
    let end = number(file, end_at, "at least 1e-6 and at most 1000 yr", |x| (LEAST_GAP..=MOST_YEARS).contains(&x))?;
    let step = number(file, every, "at least 1e-6 yr and at most end", |x| (LEAST_GAP..=end).contains(&x))?;
    let steps = (end / step).round();
    if (steps * step - end).abs() > 1e-9 * end {
        let nearest = end / steps;
        return Err(file.error(every, &format!("{step} does not divide end = {end}; {nearest} would")));
    }
    let most = MOST_SNAPSHOTS as f64 - 1.0;
    if steps > most {
        let problem = format!(
            "{} snapshots are more than a message holds, {MOST_SNAPSHOTS}; step must be at least {}",
            steps + 1.0,
            end / most
        );
        return Err(file.error(every, &problem));
    }
    Ok((0..=steps as u32).map(|k| if f64::from(k) == steps { end } else { as_meant(f64::from(k) * step) }).collect())
}

/// A multiple of a step as a person would write it: six times 0.2 is 1.2, not 1.2000000000000002.
fn as_meant(multiple: f64) -> f64 {
    format!("{multiple:.11e}").parse().unwrap_or(multiple)
}

/// The text of a scenario file that says `problem`.
pub fn to_text(name: &str, problem: &Problem) -> String {
    let Problem { model: force, initial, times, critical_e } = problem;
    format!(
        "name = \"{name}\"\n\n[orbit]\nradiation = {:?}\noblateness = {:?}\n\n[initial]\nphi = {:?}\ne = {:?}\n\
         delta_phi = {:?}\ndelta_e = {:?}\n\n[times]\nat = {times:?}\n\n[disposal]\ncritical_e = {critical_e:?}\n",
        force.radiation,
        force.oblateness,
        initial.mean_phi,
        initial.mean_e,
        2.0 * initial.sigma_phi,
        2.0 * initial.sigma_e,
    )
}

#[cfg(test)]
mod tests {
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
    fn a_problem_survives_the_way_through_a_file() {
        let shortest = GOOD.replace("end = 2.0\nstep = 0.5", "end = 63e-6\nstep = 1e-6");
        for text in [GOOD, &shortest] {
            let scenario = load(text).unwrap();
            assert_eq!(load(&to_text(&scenario.name, &scenario.problem)).unwrap(), scenario);
        }
    }

    #[test]
    fn parameters_follow_from_the_orbit() {
        let orbit = "semi_major_axis = 2.5\narea_to_mass = 10.0\nreflectivity = 1.2";
        let scenario = load_with("radiation = 0.15\noblateness = 0.40921", orbit).unwrap();
        assert!((scenario.problem.model.oblateness - 0.40921).abs() < 1e-5);
        assert!(scenario.problem.model.radiation > 0.0);
    }

    #[test]
    fn every_mistake_is_told_with_line_and_key() {
        let cases = [
            ("delta_e = 0.05", "delta_e = 0.0", 9, "initial.delta_e", "at least 1e-9"),
            ("e = 0.145", "e = 1.0", 7, "initial.e", "between 0 and 1"),
            ("step = 0.5", "step = 0.3", 12, "times.step", "does not divide end = 2"),
            ("step = 0.5", "step = 0.01", 12, "times.step", "more than a message holds"),
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
            (
                "phi = 2.2069",
                "phi = 7.0",
                6,
                "initial.phi",
                "between -2π and 2π; if 7 degrees are meant, write 0.1221730",
            ),
            ("phi = 2.2069", "phi = 1e9", 6, "initial.phi", "between -2π and 2π"),
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
}
