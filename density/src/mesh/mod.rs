//! The density evolution equation (DEE): characteristics that carry a density, and meshes that make a joint density of
//! it.
//!
//! Along a trajectory of the flow the density per `phi`-`e` area obeys the continuity equation, whose solution is `n
//! e^-1 s = const` with `s = sqrt(1 - e²)` (Sun et al. 2022, Eqs. 4-8, with the Jacobian of the polar coordinates that
//! the paper leaves out; see [`characteristics`]). Scattered values become a density on the comparison grid in two
//! ways:
//!
//! - [`hull`]: Delaunay triangulation of the *final* points and linear interpolation of `n`, the paper's recipe
//!   (Eqs. 11-13). It fills the concave sides of a bent cloud, and slivers join points that were never neighbours.
//! - [`carried`]: triangulation of the *initial* points, carried along by the flow. By the continuity equation, every
//!   triangle keeps its initial probability; the flow is a diffeomorphism, which keeps the mesh valid. On a
//!   [`points::Placement::Lattice`] the flow between the points is interpolated to a high degree ([`lattice`]).
//!
//! | file | idea |
//! |---|---|
//! | [`points`] | where the characteristics start |
//! | [`characteristics`] | the density that each characteristic carries |
//! | [`delaunay`] | the only file that uses the triangulation crate |
//! | [`polygon`] | exact integrals of a linear density over convex pieces of a triangle |
//! | [`raster`] | the paper's fine grid of interpolation points, summed in closed form and never stored |
//! | [`gaussian`] | probability of a triangle under the initial Gaussian |
//! | [`lattice`] | high-degree interpolation of the flow between lattice points |
//! | `quadrature` | moments of the interpolated flow, also across `e = 0` and round the circle |
//! | `fine` | the interpolated flow as triangles fine enough for the bins |
//! | [`passage`] | first passages of the interpolated flow |
//! | `watched_lattice`, `watched_orbit` | what a refined lattice, and an orbit of it, note of passages |
//! | [`readout`] | a carried triangle in the `(phi, e)` plane, also around `e = 0` |
//! | `share` | dividing a triangle's probability among the bins |
//! | [`diagnostics`] | whether a carried mesh resolved the flow |
//! | [`hull`], [`carried`] | the two methods |
//! | [`stack`] | carried meshes on top of one another, where the radiation parameter is uncertain |

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
pub mod stack;
mod watched_lattice;
mod watched_orbit;

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
        /// The column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length that it should have.
        expected: usize,
    },
    /// A value that is not a solar angle, eccentricity or density.
    #[error("row {row}: {column} = {value} is not {expected}")]
    Value {
        /// The column.
        column: &'static str,
        /// The row.
        row: usize,
        /// The value found.
        value: f64,
        /// Which values are allowed.
        expected: &'static str,
    },
    /// Fewer points than a mesh needs.
    #[error("{found} points cannot make a mesh; at least {needed} are needed")]
    TooFewPoints {
        /// The number of points given.
        found: usize,
        /// The number of points needed.
        needed: usize,
    },
    /// All points lie on one line.
    #[error("the points all lie on one line, so they span no triangle")]
    Collinear,
    /// The interpolation grid is coarser than the bins.
    #[error(
        "with {points} interpolation points per side, some of the {bins} bins per side contain none; use a multiple of the number of bins"
    )]
    CoarseGrid {
        /// Interpolation points per side.
        points: usize,
        /// Bins per side.
        bins: usize,
    },
    /// No density at all on the comparison grid.
    #[error("the mesh carries no density on the comparison grid")]
    NoDensity,
    /// Points announced as a lattice do not form one.
    #[error("point {row} is off the {side} x {side} lattice announced (solar angle outermost, both ascending)")]
    NotALattice {
        /// Side of the lattice announced.
        side: usize,
        /// First point that is off it.
        row: usize,
    },
    /// Interpolation degree out of range.
    #[error(
        "interpolation of degree {degree} needs 1 <= degree <= {most} and degree < {side}, the number of points per side"
    )]
    Degree {
        /// The degree that was asked for.
        degree: usize,
        /// The largest degree supported.
        most: usize,
        /// Points per side.
        side: usize,
    },
    /// An initial Gaussian from which no points can be placed.
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

/// Number of parts into which `triangles` are split so that each thread sums into its own bins. It depends on the data
/// alone, so that sums are the same for any number of threads; fine grids get fewer parts to bound the memory.
pub(crate) fn parts(triangles: usize, bins: usize) -> usize {
    const MOST: usize = 32;
    const MOST_BINS: usize = 1 << 23;
    (triangles / 512).clamp(1, MOST).min((MOST_BINS / bins.max(1)).max(1))
}
