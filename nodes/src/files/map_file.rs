//! Map files: a quantity of one scenario, over one or two of its numbers.

use std::path::{Path, PathBuf};

use density::reliability::{Point, Quantity};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;

use crate::files::file_kind::FileKind;
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;
use crate::files::sweep::{Sweep, Varied};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[schemars(with = "PathBuf")]
    scenario: Spanned<PathBuf>,
    #[schemars(with = "std::collections::BTreeMap<String, crate::files::sweep_values::Values>")]
    vary: Spanned<Varied>,
    #[schemars(with = "RawQuantity")]
    quantity: Spanned<RawQuantity>,
    #[schemars(with = "Option<f64>")]
    tolerance: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawQuantity {
    #[schemars(with = "String", extend("enum" = ["reentry", "time-of-reentry", "required-area-to-mass", "required-radiation", "mean-e"]))]
    name: Spanned<String>,
    #[schemars(with = "Option<f64>")]
    within: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    after: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    probability: Option<Spanned<f64>>,
}

/// What is shown, with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The quantity itself.
    Itself,
    /// The factor on the radiation parameter, times that parameter.
    Radiation,
    /// The factor on the radiation parameter, times the area-to-mass ratio \[m²/kg\].
    AreaToMass,
}

/// A map that is to be drawn.
#[derive(Debug)]
pub struct MapFile {
    /// The scenarios of its points.
    pub sweep: Sweep,
    /// What is computed of each.
    pub quantity: Quantity,
    /// What is shown of it.
    pub shown: Shown,
    /// Which error is aimed at: of the figures from which a point follows, and of the interpolation between points.
    pub tolerance: f64,
    /// The keys along the axes: the horizontal one first, which is the first in the file.
    pub axes: Vec<String>,
    /// The text of the file.
    text: String,
}

const NAMES: &str = "\"reentry\", \"time-of-reentry\", \"required-area-to-mass\", \"required-radiation\", \"mean-e\"";

/// The schema of a map file.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    Raw::json_schema(generator)
}

impl MapFile {
    /// Reads a map file, and checks the scenarios of all its points.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        Self::check(&InputFile::read(path)?)
    }

    /// Checks a map file that has been read.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check(file: &InputFile) -> Result<Self, InputError> {
        file.expect(FileKind::Map)?;
        let raw: Raw = file.parse()?;
        let sweep = Sweep::varied(file, &raw.scenario, &raw.vary)?;
        let keys = raw.vary.get_ref().len();
        if keys > 2 {
            return Err(file.error(&raw.vary, &format!("names {keys} keys; a map has one or two axes")));
        }
        let mut axes: Vec<&Spanned<String>> = raw.vary.get_ref().keys().collect();
        axes.sort_by_key(|key| key.span().start);
        let axes = axes.into_iter().map(|key| key.get_ref().clone()).collect();
        let (quantity, shown) = raw.quantity.get_ref().read(file, &raw.quantity)?;
        if shown == Shown::AreaToMass && sweep.number(0, AREA_TO_MASS).is_none() {
            let problem = "needs a scenario that gives its orbit by the satellite, with orbit.area_to_mass; \
                           \"required-radiation\" does not";
            return Err(file.error(&raw.quantity.get_ref().name, problem));
        }
        let tolerance = tolerance(file, raw.tolerance.as_ref())?;
        let map = Self { sweep, quantity, shown, tolerance, axes, text: file.text().into() };
        map.check_spacing(file, &raw.vary)?;
        for index in 0..map.sweep.len() {
            map.point(index)?;
        }
        Ok(map)
    }

    /// The axes of a figure are even.
    fn check_spacing(&self, file: &InputFile, vary: &Spanned<Varied>) -> Result<(), InputError> {
        let (width, height) = self.size();
        for (axis, key) in self.axes.iter().enumerate() {
            let at = |k: usize| self.place(if axis == 0 { (k, 0) } else { (0, k) })[axis];
            let count = if axis == 0 { width } else { height };
            let step = if count > 1 { (at(count - 1) - at(0)) / (count - 1) as f64 } else { 0.0 };
            let is_even = (0..count).all(|k| (at(k) - at(0) - step * k as f64).abs() <= 1e-9 * step);
            if !(step > 0.0 && is_even) {
                let place = vary.get_ref().keys().find(|known| known.get_ref() == key);
                let problem =
                    "must have at least two values, ascending and evenly spaced: { from = 1, to = 2, count = 5 }";
                return Err(place.map_or_else(|| file.error(vary, problem), |place| file.error(place, problem)));
            }
        }
        Ok(())
    }

    /// The texts of the map file and of its scenario file.
    pub fn texts(&self) -> [&str; 2] {
        [&self.text, self.sweep.base_text()]
    }

    /// How many points there are along each axis: the horizontal, and the vertical one, which has a single point if there is one axis.
    pub fn size(&self) -> (usize, usize) {
        let count = |axis: usize| {
            let position = self.axes.get(axis).and_then(|key| self.sweep.keys().position(|known| known == key));
            position.map_or(1, |position| self.sweep.counts()[position])
        };
        (count(0), count(1))
    }

    /// The number of the combination at a place of the map.
    pub fn index(&self, (x, y): (usize, usize)) -> usize {
        let (width, height) = self.size();
        // The last key of the sweep varies fastest; its keys are in alphabetical order.
        let is_in_order = self.sweep.keys().next() == self.axes.first().map(String::as_str);
        if is_in_order { x * height + y } else { y * width + x }
    }

    /// The values of the axes at a place of the map.
    pub fn place(&self, place: (usize, usize)) -> Vec<f64> {
        let values = self.sweep.values(self.index(place));
        let of = |key: &String| self.sweep.keys().zip(&values).find(|(known, _)| known == key).map(|(_, value)| *value);
        self.axes.iter().filter_map(of).collect()
    }

    /// A point of the map.
    ///
    /// # Errors
    /// If its values are not allowed.
    pub fn point(&self, index: usize) -> Result<Point, InputError> {
        let scenario = self.sweep.in_plane(index)?;
        Ok(Point { problem: scenario.problem, spread: scenario.spread })
    }

    /// By what a computed quantity is multiplied to be what is shown, at a point.
    pub fn scale(&self, index: usize, point: &Point) -> f64 {
        match self.shown {
            Shown::Itself => 1.0,
            Shown::Radiation => point.problem.model.value("radiation").unwrap_or(f64::NAN),
            Shown::AreaToMass => self.sweep.number(index, AREA_TO_MASS).unwrap_or(f64::NAN),
        }
    }

    /// The name of what is shown, with its unit.
    pub fn label(&self) -> String {
        let percent = |p: f64| plain((1e9 * p).round() / 1e7);
        match (self.quantity, self.shown) {
            (Quantity::Reentry { within }, _) => format!("probability of re-entry within {} yr", plain(within)),
            (Quantity::TimeOfReentry { probability, .. }, _) => {
                format!("time by which re-entry is {} % probable [yr]", percent(probability))
            }
            (Quantity::RequiredFactor { probability, within }, shown) => {
                let what = if shown == Shown::AreaToMass { "area-to-mass ratio" } else { "radiation parameter C" };
                let unit = if shown == Shown::AreaToMass { " [m²/kg]" } else { "" };
                format!("{what} for {} % within {} yr{unit}", percent(probability), plain(within))
            }
            (Quantity::MeanEccentricity { after }, _) => format!("mean eccentricity after {} yr", plain(after)),
        }
    }
}

const AREA_TO_MASS: &str = "orbit.area_to_mass";

impl RawQuantity {
    fn read(&self, file: &InputFile, table: &Spanned<Self>) -> Result<(Quantity, Shown), InputError> {
        let name = self.name.get_ref().as_str();
        let uses: &[&str] = match name {
            "reentry" => &["within"],
            "time-of-reentry" | "required-area-to-mass" | "required-radiation" => &["within", "probability"],
            "mean-e" => &["after"],
            _ => return Err(file.error(&self.name, &format!("\"{name}\" is no quantity, there are {NAMES}"))),
        };
        let given = [("within", &self.within), ("after", &self.after), ("probability", &self.probability)];
        for (key, value) in given {
            match value {
                Some(value) if !uses.contains(&key) => {
                    let right = uses.join(" and ");
                    return Err(file.error(value, &format!("has no effect on \"{name}\", which has {right}")));
                }
                None if uses.contains(&key) => {
                    return Err(file.error(table, &format!("must have {key} for \"{name}\"")));
                }
                _ => {}
            }
        }
        let years = |value: &Option<Spanned<f64>>| ranged(file, value.as_ref(), (0.0, MOST_YEARS), "a number of years");
        let (within, after) = (years(&self.within)?, years(&self.after)?);
        let probability = ranged(file, self.probability.as_ref(), (0.0, 1.0), "a probability")?;
        let required = Quantity::RequiredFactor { probability, within };
        Ok(match name {
            "reentry" => (Quantity::Reentry { within }, Shown::Itself),
            "time-of-reentry" => (Quantity::TimeOfReentry { probability, within }, Shown::Itself),
            "required-area-to-mass" => (required, Shown::AreaToMass),
            "required-radiation" => (required, Shown::Radiation),
            _ => (Quantity::MeanEccentricity { after }, Shown::Itself),
        })
    }
}

/// Most years of a quantity.
const MOST_YEARS: f64 = 1000.0;

/// A number between two others, both excluded; 0 if it is not given.
fn ranged(
    file: &InputFile,
    value: Option<&Spanned<f64>>,
    (low, high): (f64, f64),
    what: &str,
) -> Result<f64, InputError> {
    let Some(value) = value else { return Ok(0.0) };
    let number = *value.get_ref();
    if number > low && number < high {
        return Ok(number);
    }
    let problem = format!(
        "{} is not allowed, it must be {what} between {} and {}, both excluded",
        plain(number),
        plain(low),
        plain(high)
    );
    Err(file.error(value, &problem))
}

/// Which error is aimed at.
fn tolerance(file: &InputFile, given: Option<&Spanned<f64>>) -> Result<f64, InputError> {
    const DEFAULT: f64 = 1e-3;
    const ALLOWED: std::ops::RangeInclusive<f64> = 1e-6..=0.1;
    match given {
        None => Ok(DEFAULT),
        Some(value) if ALLOWED.contains(value.get_ref()) => Ok(*value.get_ref()),
        Some(value) => {
            let (low, high) = (plain(*ALLOWED.start()), plain(*ALLOWED.end()));
            let problem =
                format!("{} is not allowed, it must be at least {low} and at most {high}", plain(*value.get_ref()));
            Err(file.error(value, &problem))
        }
    }
}

#[cfg(test)]
mod tests {
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
        let radiation = |point: &Point| point.problem.model.value("radiation").unwrap();
        assert!((radiation(&point) / radiation(&other) - 3.0).abs() < 1e-12);
        assert!(point.problem.critical_e > map.point(0).unwrap().problem.critical_e);
        let one = load(&GOOD.replace("\"orbit.area_to_mass\" = [1, 2, 3]\n", "")).unwrap();
        assert_eq!((one.size(), one.place((3, 0))), ((5, 1), vec![2.75]));
    }

    #[test]
    fn a_required_ratio_is_the_factor_times_the_ratio_of_the_point() {
        let map = load(&GOOD.replace("\"reentry\"", "\"required-area-to-mass\"\nprobability = 0.9")).unwrap();
        let index = map.index((1, 2));
        assert_eq!(map.scale(index, &map.point(index).unwrap()), 3.0);
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
            (
                "[1, 2, 3]",
                "[1, 2, 4]",
                7,
                "orbit.area_to_mass: must have at least two values, ascending and evenly spaced",
            ),
            ("[1, 2, 3]", "[1]", 7, "must have at least two values"),
            ("[1, 2, 3]", "[1]\n\"initial.e\" = [0.1]", 5, "vary: names 3 keys; a map has one or two axes"),
            ("\"orbit.area_to_mass\" = [1, 2, 3]", "\"initial.e\" = [0.1, 1.5]", 7, "1.5 is not allowed"),
            (
                "[quantity]\nname = \"reentry\"\nwithin = 10\n",
                "",
                1,
                "this is a sweep file, but a map file belongs here",
            ),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let error = load(&GOOD.replace(from, to)).unwrap_err();
            assert!(error.line == line && error.to_string().contains(words), "{error}");
        }
        let sweep = crate::files::sweep::Sweep::check(&InputFile::from_text(Path::new("m.toml"), GOOD)).unwrap_err();
        assert!(
            sweep.to_string().contains("this is a map file, but a sweep file belongs here; `phasecloud map m.toml`"),
            "{sweep}"
        );
    }
}
