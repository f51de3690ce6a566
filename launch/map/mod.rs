//! A map: its points are computed, kept as they come so that an interrupted map goes on where it was, and written with their figure.

mod computed;
mod output;
mod progress;

use std::path::Path;

use density::exact::Estimated;
use density::reliability::refinement::{Cell, Known, fill};
use density::reliability::{AnyPoint, are_alike, evaluate};
use nodes::files::input::InputError;
use nodes::files::map_file::MapFile;
use rayon::prelude::*;

use computed::Computed;
use progress::Progress;

pub use computed::prepare;
pub use output::{FIGURE, PAGE, TABLE, write};

/// How many points are computed before they are kept.
const BATCH: usize = 16;

/// Which points are computed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    /// All points above one another: they differ in the radiation parameter or its uncertainty alone.
    Column,
    /// All points beside one another.
    Row,
    /// Each point by itself.
    Point,
}

/// Computes a map, and keeps its points in `folder`.
///
/// # Errors
/// What is wrong with a point, or which file cannot be written.
pub fn compute(map: &MapFile, folder: &Path, quiet: bool) -> Result<Vec<Cell>, String> {
    let (width, height) = map.size();
    let unit = unit(map).map_err(|error| error.to_string())?;
    let units = match unit {
        Unit::Column => (width, 1),
        Unit::Row => (height, 1),
        Unit::Point => (width, height),
    };
    let mut kept = Computed::open(folder)?;
    let mut known = kept.known().clone();
    let progress = Progress::new(units.0 * units.1, known.len(), quiet);
    let batch = if unit == Unit::Point { BATCH } else { 1 };
    let cells = fill(units, map.tolerance, &mut known, |missing, known: &mut Known| {
        for some in missing.chunks(batch) {
            let found: Vec<_> = some.par_iter().map(|&at| unit_at(map, unit, at)).collect::<Result<_, _>>()?;
            for (&at, values) in some.iter().zip(found) {
                kept.add(at, &values)?;
                known.insert(at, values);
            }
            progress.reached(known.len());
        }
        Ok::<(), String>(())
    })?;
    progress.end(known.len());
    let at = |(x, y): (usize, usize)| match unit {
        Unit::Column => cells[x][y],
        Unit::Row => cells[y][x],
        Unit::Point => cells[x * height + y][0],
    };
    Ok((0..width).flat_map(|x| (0..height).map(move |y| (x, y))).map(at).collect())
}

/// Which points share a table.
fn unit(map: &MapFile) -> Result<Unit, InputError> {
    let (width, height) = map.size();
    let at = |place| map.point(map.index(place));
    let corner = at((0, 0))?;
    Ok(match () {
        () if height > 1 && are_alike(&corner, &at((0, height - 1))?) => Unit::Column,
        () if width > 1 && are_alike(&corner, &at((width - 1, 0))?) => Unit::Row,
        () => Unit::Point,
    })
}

/// What is shown at the points of a unit.
fn unit_at(map: &MapFile, unit: Unit, (x, y): (usize, usize)) -> Result<Vec<Estimated>, String> {
    let (width, height) = map.size();
    let places: Vec<(usize, usize)> = match unit {
        Unit::Column => (0..height).map(|y| (x, y)).collect(),
        Unit::Row => (0..width).map(|column| (column, x)).collect(),
        Unit::Point => vec![(x, y)],
    };
    let indices: Vec<usize> = places.into_iter().map(|place| map.index(place)).collect();
    let points: Vec<AnyPoint> =
        indices.iter().map(|&index| map.point(index)).collect::<Result<_, _>>().map_err(|error| error.to_string())?;
    let scales: Vec<f64> = indices.iter().zip(&points).map(|(&index, point)| map.scale(index, point)).collect();
    let found = evaluate(&points, map.quantity, map.other, map.tolerance);
    let scaled =
        |(found, scale): (Estimated, f64)| Estimated { value: found.value * scale, error: found.error * scale };
    Ok(found.into_iter().zip(scales).map(scaled).collect())
}
