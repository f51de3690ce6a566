//! The densities of pairs of variables, as the figures need them.

use std::collections::BTreeMap;
use std::path::Path;

use density::grid::Axis;
use results::arrays::{ArrayReader, Place, edges};
use results::description::Description;
use results::files::DENSITIES;
use results::{FolderError, MomentsRow};

/// The bins of a pair of variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The axis of the first variable; of an angle, on the branch that keeps the cloud whole.
    pub x: Axis,
    /// The axis of the second variable.
    pub y: Axis,
    /// Whether the first variable is an angle on the full circle.
    pub is_circle: bool,
}

/// The density of a case in a pair of variables at a snapshot.
#[derive(Debug, Clone)]
pub struct Density {
    /// Its bins.
    pub grid: Grid,
    /// The density of both variables, the first outermost.
    pub joint: Vec<f64>,
    /// The density of the first variable by itself.
    pub marginal_x: Vec<f64>,
    /// The density of the second variable by itself.
    pub marginal_y: Vec<f64>,
}

impl Density {
    /// Whether the case withholds its density here: its values are then NaN.
    pub fn is_withheld(&self) -> bool {
        [&self.joint, &self.marginal_x, &self.marginal_y].iter().any(|values| values.iter().any(|v| !v.is_finite()))
    }

    /// The highest density of both variables.
    pub fn peak(&self) -> f64 {
        self.joint.iter().copied().fold(0.0, f64::max)
    }
}

/// Densities by scenario and number of the pair of variables, then by case, one per snapshot.
pub type Densities = BTreeMap<(String, usize), BTreeMap<String, Vec<Density>>>;

/// Reads the densities of all snapshots that have a row in `moments`, in all pairs of variables of these scenarios.
///
/// # Errors
/// [`FolderError`] if a density is missing or does not fit its edges.
pub fn read<'a>(
    folder: &Path,
    scenarios: impl Iterator<Item = &'a Description>,
    moments: &[MomentsRow],
) -> Result<Densities, FolderError> {
    let mut archive = ArrayReader::open(&folder.join(DENSITIES))?;
    let mut densities = Densities::new();
    for scenario in scenarios {
        for (number, pair) in scenario.pairs().enumerate() {
            let cases = densities.entry((scenario.name.clone(), number)).or_default();
            for row in moments.iter().filter(|row| row.scenario == scenario.name) {
                let snapshots: &mut Vec<Density> = cases.entry(row.method.clone()).or_default();
                let place = Place::new(&row.scenario, &row.method, snapshots.len());
                snapshots.push(one(&mut archive, scenario, pair, &place)?);
            }
        }
    }
    Ok(densities)
}

/// Reads the density of a pair of variables at a snapshot.
fn one(
    archive: &mut ArrayReader,
    scenario: &Description,
    (density, [first, second]): (&str, [usize; 2]),
    place: &Place,
) -> Result<Density, FolderError> {
    let joint = archive.array(&place.name(density), 2)?;
    // A withheld density may come with withheld edges. Any edges will do then, because nothing is drawn on them.
    let is_withheld = joint.iter().all(|p| p.is_nan());
    let mut axis = |variable: usize| {
        let name = place.name(&edges(&scenario.variables[variable].symbol));
        let edges = archive.array(&name, 1)?;
        let stand_in = is_withheld.then_some(Axis { low: 0.0, high: 1.0, bins: edges.len().max(2) - 1 });
        axis(&edges).or(stand_in).ok_or_else(|| archive.failed(format!("{name} do not ascend")))
    };
    let (x, y) = (axis(first)?, axis(second)?);
    if joint.len() != x.bins * y.bins {
        let name = place.name(density);
        return Err(archive.failed(format!("{name}: {} values do not fit {} x {} bins", joint.len(), x.bins, y.bins)));
    }
    let mut marginal = |variable: usize, axis: &Axis, summed: Vec<f64>| match scenario.marginal(variable) {
        None => Ok(summed),
        Some(density) => {
            let values = archive.array(&place.name(density), 1)?;
            let problem = || format!("{}: {} values do not fit {} bins", place.name(density), values.len(), axis.bins);
            if values.len() == axis.bins { Ok(values) } else { Err(archive.failed(problem())) }
        }
    };
    let rows: Vec<f64> = joint.chunks(y.bins).map(|row| row.iter().sum::<f64>() * y.width()).collect();
    let columns = (0..y.bins).map(|j| joint.iter().skip(j).step_by(y.bins).sum::<f64>() * x.width()).collect();
    let (marginal_x, marginal_y) = (marginal(first, &x, rows)?, marginal(second, &y, columns)?);
    let grid = Grid { x, y, is_circle: scenario.variables[first].is_circle() };
    Ok(Density { grid, joint, marginal_x, marginal_y })
}

fn axis(edges: &[f64]) -> Option<Axis> {
    let (&low, &high) = (edges.first()?, edges.last()?);
    (low.is_finite() && high.is_finite() && low < high).then_some(Axis { low, high, bins: edges.len() - 1 })
}
