//! When the satellite re-enters, as a scenario file says it.

use density::model::earth;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::measure::{self, Dimension, Measure};
use crate::files::input::{InputError, InputFile};

/// The table `[disposal]`: the critical eccentricity, or the height of the pericentre from which it follows.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Disposal {
    #[schemars(with = "Option<Measure>")]
    critical_e: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    altitude: Option<Spanned<Measure>>,
}

impl Disposal {
    /// The eccentricity at which the satellite re-enters, of an orbit with this semi-major axis \[Earth radii\] if it
    /// is known: `e = 1 - (1 + h/R)/a` for the pericentre's height `h`.
    pub(super) fn read(
        file: &InputFile,
        table: &Spanned<Self>,
        semi_major_axis: Option<f64>,
    ) -> Result<f64, InputError> {
        match table.get_ref() {
            Self { critical_e: Some(critical), altitude: None } => measure::read(file, critical, Dimension::Number),
            Self { critical_e: None, altitude: Some(altitude) } => {
                let height = measure::read(file, altitude, Dimension::Height)? * 1_000.0 / earth::RADIUS;
                let Some(axis) = semi_major_axis else {
                    let problem = "needs the semi-major axis or the altitude in [orbit]; give critical_e instead";
                    return Err(file.error(altitude, problem));
                };
                let critical = 1.0 - (1.0 + height) / axis;
                if height <= -1.0 {
                    return Err(file.error(altitude, "must be above the Earth's centre, which is at -6378.1 km"));
                }
                if critical <= 0.0 {
                    let most = (axis - 1.0) * earth::RADIUS / 1_000.0;
                    return Err(file.error(altitude, &format!("must be below that of the orbit, {most:.1} km")));
                }
                Ok(critical)
            }
            _ => Err(file.error(table, "must have either critical_e or altitude")),
        }
    }

    /// The height of the pericentre above the equator at which the satellite re-enters \[Earth radii\], if the table
    /// gives that.
    pub(super) fn reentry_altitude(&self, file: &InputFile) -> Result<Option<f64>, InputError> {
        let height = |altitude| Ok(measure::read(file, altitude, Dimension::Height)? * 1_000.0 / earth::RADIUS);
        self.altitude.as_ref().map(height).transpose()
    }

    /// The line and key of what is wrong with it.
    pub(super) fn locate(table: &Spanned<Self>, file: &InputFile, problem: &str) -> InputError {
        let Self { critical_e, altitude } = table.get_ref();
        let value = critical_e.as_ref().or(altitude.as_ref());
        value.map_or_else(|| file.error(table, problem), |value| file.error(value, problem))
    }
}
