//! Delaunay triangulation; only this module uses the crate `spade`.

use rayon::prelude::*;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::MeshError;

/// A point that remembers its row.
struct Site {
    position: Point2<f64>,
    row: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The Delaunay triangles of the points `(x, y)`, counter-clockwise, as indices of rows. Of points that coincide only
/// one is used.
///
/// # Errors
/// [`MeshError::TooFewPoints`] or [`MeshError::Collinear`] if there is no triangle; [`MeshError::Value`] for a
/// coordinate that is not finite.
///
/// # Panics
/// If the slices differ in length or have 2^32 points or more.
pub fn triangulate(x: &[f64], y: &[f64]) -> Result<Vec<[u32; 3]>, MeshError> {
    assert_eq!(x.len(), y.len(), "one x for every y");
    if x.len() < 3 {
        return Err(MeshError::TooFewPoints { found: x.len(), needed: 3 });
    }
    let rows = 0..u32::try_from(x.len()).expect("fewer than 2^32 points");
    let site = |row: u32| Site { position: Point2::new(regular(x[row as usize]), regular(y[row as usize])), row };
    let triangulation: DelaunayTriangulation<Site> =
        DelaunayTriangulation::bulk_load(rows.map(site).collect()).map_err(|_| not_finite(x, y))?;
    let mut triangles: Vec<[u32; 3]> = triangulation
        .inner_faces()
        .map(|face| {
            let corners = face.vertices().map(|vertex| vertex.data().row);
            let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
            [corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]]
        })
        .collect();
    if triangles.is_empty() {
        return Err(MeshError::Collinear);
    }
    // An order that depends on the mesh alone, and keeps neighbours near each other where the points are ordered.
    triangles.par_sort_unstable();
    Ok(triangles)
}

/// Spade refuses coordinates so small that its exact predicates would underflow; they are as good as zero.
fn regular(coordinate: f64) -> f64 {
    if coordinate.abs() < 1e-40 { 0.0 } else { coordinate }
}

fn not_finite(x: &[f64], y: &[f64]) -> MeshError {
    let bad = |column, values: &[f64]| {
        let row = values.iter().position(|value| !value.is_finite() || value.abs() > 1e50)?;
        Some(MeshError::Value { column, row, value: values[row], expected: "a finite coordinate below 1e50" })
    };
    bad("x", x).or_else(|| bad("y", y)).unwrap_or(MeshError::Collinear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_its_middle_has_four_counter_clockwise_triangles() {
        let (x, y) = ([0.0, 1.0, 1.0, 0.0, 0.5], [0.0, 0.0, 1.0, 1.0, 0.5]);
        let triangles = triangulate(&x, &y).unwrap();
        assert_eq!(triangles, [[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 3, 4]]);
    }

    #[test]
    fn no_point_lies_inside_the_circumcircle_of_a_triangle() {
        let coordinate = |i: u32, factor: f64| (f64::from(i) * factor).fract();
        let x: Vec<f64> = (0..300).map(|i| coordinate(i, 0.754_877)).collect();
        let y: Vec<f64> = (0..300).map(|i| coordinate(i, 0.569_840)).collect();
        for triangle in triangulate(&x, &y).unwrap() {
            let corners = triangle.map(|row| (x[row as usize], y[row as usize]));
            for (&px, &py) in x.iter().zip(&y) {
                let rows = corners.map(|(x, y)| [x - px, y - py, (x - px).powi(2) + (y - py).powi(2)]);
                let [[a, b, c], [d, e, f], [g, h, i]] = rows;
                assert!(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 1e-9);
            }
        }
    }

    #[test]
    fn points_without_a_triangle_are_refused() {
        assert_eq!(triangulate(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0]), Err(MeshError::Collinear));
        assert!(matches!(triangulate(&[0.0], &[0.0]), Err(MeshError::TooFewPoints { .. })));
        assert!(matches!(triangulate(&[0.0, f64::NAN, 1.0], &[0.0; 3]), Err(MeshError::Value { row: 1, .. })));
    }

    #[test]
    fn coinciding_points_are_used_once() {
        let triangles = triangulate(&[0.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 1.0, 1.0]).unwrap();
        assert_eq!(triangles.len(), 1);
    }
}
