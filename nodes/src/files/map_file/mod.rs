//! Map files: a quantity of one scenario, over one or two of its numbers.

mod difference;
mod effect;
mod quantity;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use density::problem_error::ProblemError;
use density::reliability::{AnyPoint, Other, Point, Quantity};
use kit::problem_key::by_key;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;

use crate::files::file_kind::FileKind;
use crate::files::hosts_table::HostsTable;
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;
use crate::files::scenario_file::AnyScenario;
use crate::files::sweep::{Sweep, Varied};

use difference::RawDifference;
use quantity::RawQuantity;

pub use quantity::Shown;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[schemars(with = "PathBuf")]
    scenario: Spanned<PathBuf>,
    #[schemars(with = "std::collections::BTreeMap<String, crate::files::sweep_values::Values>")]
    vary: Spanned<Varied>,
    #[schemars(with = "RawQuantity")]
    quantity: Spanned<RawQuantity>,
    #[schemars(with = "Option<RawDifference>")]
    difference: Option<Spanned<RawDifference>>,
    #[schemars(with = "Option<f64>")]
    tolerance: Option<Spanned<f64>>,
    hosts: Option<HostsTable>,
}

/// A map that is to be drawn.
#[derive(Debug)]
pub struct MapFile {
    /// The scenarios of its points.
    pub sweep: Sweep,
    /// The quantity that is computed at each point.
    pub quantity: Quantity,
    /// What is subtracted from it.
    pub other: Option<Other>,
    /// How the map is drawn.
    pub shown: Shown,
    /// Which error is aimed at: of the figures from which a point follows, and of the interpolation between points.
    pub tolerance: f64,
    /// The keys along the axes: the horizontal one first, which is the first in the file.
    pub axes: Vec<String>,
    /// The hosts that help to compute it, as the file names them.
    pub hosts: Option<HostsTable>,
    /// The text of the file.
    text: String,
}

/// The schema of a map file.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    Raw::json_schema(generator)
}

/// Most points of a map, each of which is checked before any is computed.
const MOST_POINTS: usize = 100_000;

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
        Self::check_with(file, |raw| Sweep::varied(file, &raw.scenario, &raw.vary))
    }

    /// Checks a map file of another host, whose scenario file has come with it.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check_with_scenario(file: &InputFile, scenario: &InputFile) -> Result<Self, InputError> {
        Self::check_with(file, |raw| Sweep::varied_of(file, &raw.scenario, &raw.vary, scenario))
    }

    fn check_with(file: &InputFile, sweep: impl FnOnce(&Raw) -> Result<Sweep, InputError>) -> Result<Self, InputError> {
        file.expect(FileKind::Map)?;
        let mut raw: Raw = file.parse()?;
        let hosts = raw.hosts.take();
        let sweep = sweep(&raw)?;
        let keys = raw.vary.get_ref().len();
        if keys > 2 {
            return Err(file.error(&raw.vary, &format!("names {keys} keys; a map has one or two axes")));
        }
        if sweep.len() > MOST_POINTS {
            let problem = format!("has {} points; a map must have at most {MOST_POINTS}", sweep.len());
            return Err(file.error(&raw.vary, &problem));
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
        let is_in_space = sweep.scenario(0)?.in_plane().is_none();
        let other = raw.difference.as_ref().map(|table| table.get_ref().read(file, table, (quantity, is_in_space)));
        let other = other.transpose()?;
        let tolerance = tolerance(file, raw.tolerance.as_ref())?;
        let map = Self { sweep, quantity, other, shown, tolerance, axes, hosts, text: file.text().into() };
        map.check_spacing(file, &raw.vary)?;
        for index in 0..map.sweep.len() {
            map.check_point(file, index, &raw)?;
        }
        map.check_effect(file, &raw.vary)?;
        Ok(map)
    }

    /// Refuses a point whose model, or whose quantity, has no map.
    fn check_point(&self, file: &InputFile, index: usize, raw: &Raw) -> Result<(), InputError> {
        let point = self.point(index)?;
        let told = |error: ProblemError| file.error(&raw.scenario, &by_key(&error));
        if matches!(point, AnyPoint::InSpace(_)) {
            point.cloud().map_err(told)?;
            if self.shown != Shown::Itself {
                let problem = "is not computed in space, where more radiation pressure may make re-entry less probable; draw \"reentry\" over orbit.area_to_mass";
                return Err(file.error(&raw.quantity.get_ref().name, problem));
            }
        }
        if self.shown != Shown::Itself && point.radiation() <= 0.0 {
            let problem = format!(
                "needs radiation pressure, which is absent from {} ({})",
                self.sweep.name(index),
                self.sweep.combination(index)
            );
            return Err(file.error(&raw.quantity.get_ref().name, &problem));
        }
        Ok(())
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

    /// The path of the map file.
    pub fn path(&self) -> &Path {
        self.sweep.path()
    }

    /// The texts of the map file and of its scenario file.
    pub fn texts(&self) -> [&str; 2] {
        [&self.text, self.sweep.base_text()]
    }

    /// How many points there are along each axis: the horizontal, and the vertical one, which has a single point if
    /// there is one axis.
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
    pub fn point(&self, index: usize) -> Result<AnyPoint, InputError> {
        match self.sweep.scenario(index)? {
            AnyScenario::InPlane { scenario, .. } => {
                Ok(AnyPoint::InPlane(Point { problem: scenario.problem, spread: scenario.spread }))
            }
            AnyScenario::InSpace(scenario) => match scenario.cloud {
                Some(cloud) => Ok(AnyPoint::InSpace(cloud)),
                // A scenario of a sweep has been checked to have one.
                None => Err(self.sweep.without_cloud(index)),
            },
        }
    }

    /// By what a computed quantity is multiplied to be what is shown, at a point.
    pub fn scale(&self, index: usize, point: &AnyPoint) -> f64 {
        match self.shown {
            Shown::Itself => 1.0,
            Shown::Radiation => point.radiation(),
            Shown::AreaToMass => self.sweep.number(index, AREA_TO_MASS).unwrap_or(f64::NAN),
        }
    }

    /// The name of what is shown, with its unit.
    pub fn label(&self) -> String {
        let itself = self.shown.label(self.quantity);
        match self.other {
            None => itself,
            Some(Other::Planar) => format!("{itself}, in space less in the plane"),
            Some(Other::MonteCarlo { samples, .. }) => {
                format!("{itself}, less that of {samples} samples by Monte Carlo")
            }
        }
    }
}

const AREA_TO_MASS: &str = "orbit.area_to_mass";

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
