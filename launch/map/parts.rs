//! The parts of a map: the points that are computed together.

use density::exact::Estimated;
use density::reliability::refinement::Cell;
use density::reliability::{AnyPoint, are_alike, evaluate};
use nodes::files::input::InputError;
use nodes::files::map_file::MapFile;
use rayon::prelude::*;

/// Most points that a host takes at a time.
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

/// Which part of a map: the number of its column or row and 0, or the place of its point.
pub(super) type Place = (usize, usize);

/// A part that has been computed: what is shown at its points, or what is wrong with one of them.
pub(super) type Found = Result<Vec<Estimated>, String>;

/// A map in parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts<'a> {
    map: &'a MapFile,
    unit: Unit,
}

impl<'a> Parts<'a> {
    /// Divides a map.
    ///
    /// # Errors
    /// What is wrong with a point.
    pub(super) fn of(map: &'a MapFile) -> Result<Self, String> {
        Ok(Self { map, unit: unit(map).map_err(|error| error.to_string())? })
    }

    /// How many parts there are in each direction.
    pub(super) fn size(self) -> (usize, usize) {
        let (width, height) = self.map.size();
        match self.unit {
            Unit::Column => (width, 1),
            Unit::Row => (height, 1),
            Unit::Point => (width, height),
        }
    }

    /// How many points a part has.
    pub(super) fn points(self) -> usize {
        let (width, height) = self.map.size();
        match self.unit {
            Unit::Column => height,
            Unit::Row => width,
            Unit::Point => 1,
        }
    }

    /// Most parts that a host takes at a time. All points of a row are computed at the same time already.
    pub(super) fn batch(self) -> usize {
        if self.unit == Unit::Point { BATCH } else { 1 }
    }

    /// Computes parts, and has each brought as soon as it is there.
    pub(super) fn compute(self, places: &[Place], bring: impl Fn(Place, Found) + Sync) {
        places.par_iter().for_each(|&place| bring(place, self.part(place)));
    }

    /// What is shown at the points of a part.
    fn part(self, (x, y): Place) -> Found {
        let (map, (width, height)) = (self.map, self.map.size());
        let places: Vec<(usize, usize)> = match self.unit {
            Unit::Column => (0..height).map(|y| (x, y)).collect(),
            Unit::Row => (0..width).map(|column| (column, x)).collect(),
            Unit::Point => vec![(x, y)],
        };
        let indices: Vec<usize> = places.into_iter().map(|place| map.index(place)).collect();
        let points: Vec<AnyPoint> = indices
            .iter()
            .map(|&index| map.point(index))
            .collect::<Result<_, _>>()
            .map_err(|error| error.to_string())?;
        let scales: Vec<f64> = indices.iter().zip(&points).map(|(&index, point)| map.scale(index, point)).collect();
        let found = evaluate(&points, map.quantity, map.other, map.tolerance);
        let scaled =
            |(found, scale): (Estimated, f64)| Estimated { value: found.value * scale, error: found.error * scale };
        Ok(found.into_iter().zip(scales).map(scaled).collect())
    }

    /// The cells of the whole map in the order of its table, from those of its parts.
    pub(super) fn join(self, cells: &[Vec<Cell>]) -> Vec<Cell> {
        let (width, height) = self.map.size();
        let at = |(x, y): (usize, usize)| match self.unit {
            Unit::Column => cells[x][y],
            Unit::Row => cells[y][x],
            Unit::Point => cells[x * height + y][0],
        };
        (0..width).flat_map(|x| (0..height).map(move |y| (x, y))).map(at).collect()
    }
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
