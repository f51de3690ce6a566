//! The density evolution equation (DEE): characteristics that carry a density, and the meshes that turn them into one.
//!
//! Along a trajectory of the flow the density per `phi`-`e` area obeys the continuity equation, whose solution is
//! `n e^-1 s = const` with `s = sqrt(1 - e²)` (Sun et al. 2022, Eqs. 4-8, with the Jacobian of the polar coordinates that
//! the paper leaves out; see [`characteristics`]). Scattered values become a density on the comparison grid in two ways:
//!
//! - [`hull`]: Delaunay triangulation of the *final* points and linear interpolation of `n`, the paper's recipe
//!   (Eqs. 11-13). It fills the concave sides of a bent cloud, and slivers join points that were never neighbours.
//! - [`carried`]: triangulation of the *initial* points, carried along by the flow. Every triangle keeps the probability
//!   it started with, since that is what the continuity equation says; a diffeomorphism keeps the mesh valid. On a
//!   [`points::Placement::Lattice`] the flow between the points is interpolated to a high degree ([`lattice`]).
//!
//! | file | idea |
//! |---|---|
//! | [`points`] | where the characteristics start |
//! | [`characteristics`] | the density that each carries |
//! | [`delaunay`] | the one place that knows the triangulation crate |
//! | [`polygon`] | exact integrals of a linear density over convex pieces of a triangle |
//! | [`raster`] | the paper's fine grid of interpolation points, summed in closed form and never stored |
//! | [`gaussian`] | probability of a triangle under the initial Gaussian |
//! | [`lattice`] | high-degree interpolation of the flow between lattice points |
//! | `quadrature` | moments of the interpolated flow, also over `e = 0` and round the circle |
//! | `fine` | the interpolated flow as triangles fine enough for the bins |
//! | [`passage`] | first passages of the interpolated flow |
//! | [`readout`] | a carried triangle in the `(phi, e)` plane, also around `e = 0` |
//! | `share` | a triangle's probability, shared out to bins |
//! | [`diagnostics`] | whether a carried mesh resolved the flow |
//! | [`hull`], [`carried`] | the two methods |

pub mod carried;
pub mod characteristics;
pub mod delaunay;
pub mod diagnostics;
mod fine;
pub mod gaussian;
pub mod hull;
pub mod lattice;
pub mod passage;
pub mod points;
pub mod polygon;
mod quadrature;
pub mod raster;
pub mod readout;
mod share;

pub use carried::CarriedMesh;
pub use characteristics::characteristic_densities;
pub use diagnostics::MeshDiagnostics;
pub use hull::{Branch, hull_estimate};
pub use points::{Placement, Points, initial_points, lattice_points, unfold};

/// Why a mesh could not be built or read out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Columns of different length.
    #[error("column `{column}` has {found} rows where {expected} were expected")]
    Length {
        /// Which column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// A value that is no solar angle, eccentricity or density.
    #[error("row {row}: {column} = {value} is not {expected}")]
    Value {
        /// Which column.
        column: &'static str,
        /// Which row.
        row: usize,
        /// What was found.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// Fewer points than a mesh needs.
    #[error("{found} points cannot make a mesh; at least {needed} are needed")]
    TooFewPoints {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// All points on one line.
    #[error("the points all lie on one line, so they span no triangle")]
    Collinear,
    /// The interpolation grid is coarser than the bins.
    #[error(
        "{points} interpolation points a side leave some of the {bins} bins a side without any; use a multiple of the bins"
    )]
    CoarseGrid {
        /// Interpolation points a side.
        points: usize,
        /// Bins a side.
        bins: usize,
    },
    /// No density at all on the comparison grid.
    #[error("the mesh carries no density on the comparison grid")]
    NoDensity,
    /// Points announced as a lattice are none.
    #[error("point {row} is off the {side} x {side} lattice announced (solar angle outermost, both ascending)")]
    NotALattice {
        /// Side of the lattice announced.
        side: usize,
        /// First point that is off it.
        row: usize,
    },
    /// Interpolation degree out of range.
    #[error("interpolation of degree {degree} needs 1 <= degree <= {most} and degree < {side}, the points a side")]
    Degree {
        /// The degree asked for.
        degree: usize,
        /// The largest supported.
        most: usize,
        /// Points a side.
        side: usize,
    },
    /// An initial Gaussian that nothing can be drawn from.
    #[error("initial Gaussian: {0}")]
    Initial(&'static str),
}

/// Checks that `phi` and `e` are `rows` solar angles and eccentricities.
pub(crate) fn check_points(phi: &[f64], e: &[f64], rows: usize) -> Result<(), MeshError> {
    check_column("phi", phi, rows, "a finite angle", |phi| phi.is_finite())?;
    check_column("e", e, rows, "in [0, 1)", |e| (0.0..1.0).contains(&e))
}

/// Checks a column's length and each of its values.
pub(crate) fn check_column(
    column: &'static str,
    values: &[f64],
    rows: usize,
    expected: &'static str,
    valid: impl Fn(f64) -> bool,
) -> Result<(), MeshError> {
    if values.len() != rows {
        return Err(MeshError::Length { column, found: values.len(), expected: rows });
    }
    match values.iter().position(|&value| !valid(value)) {
        Some(row) => Err(MeshError::Value { column, row, value: values[row], expected }),
        None => Ok(()),
    }
}

/// How many parts `triangles` are split into so that each thread sums bins of its own. It depends on the data alone, so
/// sums come out the same for any number of threads; fine grids get fewer parts to bound the memory.
pub(crate) fn parts(triangles: usize, bins: usize) -> usize {
    const MOST: usize = 32;
    const MOST_BINS: usize = 1 << 23;
    (triangles / 512).clamp(1, MOST).min((MOST_BINS / bins.max(1)).max(1))
}
