//! Points of a map, in the plane or in space.

use crate::exact::Estimated;
use crate::in_space::SpaceProblem;
use crate::problem_error::ProblemError;

use super::cloud::Cloud;
use super::difference::{Other, less, monte_carlo, space_less_plane};
use super::quantity::Quantity;
use super::rows::{self, Point, Row};
use super::{UNKNOWN, in_space};

/// A point of a map.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyPoint {
    /// In the plane.
    InPlane(Point),
    /// In space.
    InSpace(Box<SpaceProblem>),
}

impl AnyPoint {
    /// The radiation parameter, or its mean; 0 where the model has none.
    pub fn radiation(&self) -> f64 {
        match self {
            Self::InPlane(Point { problem, .. }) => problem.model.value("radiation").unwrap_or(0.0),
            Self::InSpace(problem) => in_space::radiation(problem),
        }
    }

    /// The orbits of its cloud.
    ///
    /// # Errors
    /// Why there is no map of it.
    pub fn cloud(&self) -> Result<Cloud, ProblemError> {
        match self {
            Self::InPlane(Point { problem, spread }) => Cloud::in_plane(problem, *spread),
            Self::InSpace(problem) => Cloud::in_space(problem),
        }
    }

    /// The point without what the quantity does not depend on.
    #[must_use]
    pub fn reduced_to(&self, quantity: Quantity) -> Self {
        let mut reduced = self.clone();
        let (times, critical_e) = match &mut reduced {
            Self::InPlane(Point { problem, .. }) => (&mut problem.times, &mut problem.critical_e),
            Self::InSpace(problem) => (&mut problem.times, &mut problem.critical_e),
        };
        times.clear();
        if matches!(quantity, Quantity::MeanEccentricity { .. }) {
            *critical_e = 0.0;
        }
        if matches!(quantity, Quantity::RequiredFactor { .. }) {
            reduced.set_radiation(1.0);
        }
        reduced
    }

    fn set_radiation(&mut self, radiation: f64) {
        match self {
            Self::InPlane(Point { problem, .. }) => {
                problem.model = problem.model.with("radiation", radiation).unwrap_or(problem.model);
            }
            Self::InSpace(problem) => problem.model.forces_mut().force.radiation = radiation,
        }
    }
}

/// Whether two points share what is computed of them.
pub fn are_alike(one: &AnyPoint, other: &AnyPoint) -> bool {
    match (one, other) {
        (AnyPoint::InPlane(one), AnyPoint::InPlane(other)) => rows::are_alike(one, other),
        // In space every point has orbits of its own.
        _ => false,
    }
}

/// The quantity at each of the points of a row, which must be alike ([`are_alike`]), less that of another model or
/// method, to about `tolerance`.
pub fn evaluate(row: &[AnyPoint], quantity: Quantity, other: Option<Other>, tolerance: f64) -> Row {
    let in_plane: Vec<Point> = row.iter().filter_map(AnyPoint::in_plane).cloned().collect();
    let in_space: Vec<SpaceProblem> = row.iter().filter_map(AnyPoint::in_space).cloned().collect();
    let itself = || match in_space.is_empty() {
        true => rows::evaluate(&in_plane, quantity, tolerance),
        false => in_space::evaluate(&in_space, quantity, tolerance),
    };
    match other {
        None => itself(),
        Some(Other::Planar) if in_space.is_empty() => vec![UNKNOWN; row.len()],
        Some(Other::Planar) => space_less_plane(&in_space, quantity, tolerance),
        Some(Other::MonteCarlo { samples, seed }) => {
            let by_sample = |point: &AnyPoint| -> Estimated {
                point.cloud().map_or(UNKNOWN, |cloud| monte_carlo(&cloud, quantity, samples, seed))
            };
            itself().into_iter().zip(row).map(|(found, point)| less(found, by_sample(point))).collect()
        }
    }
}

impl AnyPoint {
    fn in_plane(&self) -> Option<&Point> {
        match self {
            Self::InPlane(point) => Some(point),
            Self::InSpace(_) => None,
        }
    }

    fn in_space(&self) -> Option<&SpaceProblem> {
        match self {
            Self::InPlane(_) => None,
            Self::InSpace(problem) => Some(problem),
        }
    }
}
