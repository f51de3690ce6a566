//! The paper's interpolation grid, never stored.
//!
//! The paper interpolates `n` linearly on `Ngrid x Ngrid` points and averages those that fall into each bin (Eqs.
//! 11-12): 25 million values for `Ngrid = 5000`. Within one triangle `n` is linear, so the points of a grid line inside
//! both the triangle and a bin contribute an arithmetic series, whose sum has a closed form. The cost of a triangle is
//! its number of grid lines rather than its number of grid points.
//!
//! Points are cell-centred over the comparison grid. Each belongs to exactly one triangle: spans are half open, and two
//! triangles compute the crossing of their common edge from the same numbers in the same order.

use rayon::prelude::*;

use super::polygon::Corner;
use super::{MeshError, parts};
use crate::grid::{Axis, Grid};

/// Cell-centred points along one axis, `low + (i + 1/2) spacing`, and the bins they fall into.
#[derive(Debug, Clone)]
struct Line {
    low: f64,
    per_unit: f64,
    bin: Vec<u32>,
    /// The first point past each bin.
    end: Vec<i32>,
}

impl Line {
    fn new(axis: &Axis, points: usize) -> Result<Self, MeshError> {
        const MOST: usize = 1 << 24;
        if points < axis.bins || points > MOST || axis.bins == 0 {
            return Err(MeshError::CoarseGrid { points, bins: axis.bins });
        }
        let bin: Vec<u32> = (0..points).map(|i| ((2 * i + 1) * axis.bins / (2 * points)) as u32).collect();
        let end = (0..axis.bins).map(|b| bin.partition_point(|&of| of as usize <= b) as i32).collect();
        Ok(Self { low: axis.low, per_unit: points as f64 / (axis.high - axis.low), bin, end })
    }

    /// Position in point spacings from the first point.
    fn measure(&self, value: f64) -> f64 {
        (value - self.low) * self.per_unit - 0.5
    }

    fn points(&self) -> i32 {
        self.bin.len() as i32
    }

    /// The first point at or above `position`.
    fn first_from(&self, position: f64) -> i32 {
        (position.ceil() as i32).clamp(0, self.points())
    }

    fn points_in(&self, bin: usize) -> i32 {
        self.end[bin] - if bin == 0 { 0 } else { self.end[bin - 1] }
    }
}

/// The interpolation points over a comparison grid.
#[derive(Debug, Clone)]
pub struct PointGrid {
    phi: Line,
    e: Line,
}

impl PointGrid {
    /// `points` x `points` points over `grid`. If `points` is a multiple of the number of bins, every bin has the same
    /// number of points; otherwise each bin averages over the points that it has.
    ///
    /// # Errors
    /// [`MeshError::CoarseGrid`] with fewer points than bins, without bins, or with more than 2^24 points per side.
    pub fn new(grid: &Grid, points: usize) -> Result<Self, MeshError> {
        Ok(Self { phi: Line::new(&grid.phi, points)?, e: Line::new(&grid.e, points)? })
    }

    /// Mean over the points of each bin of the function that is linear on each of the triangles `triangle(0..count)`
    /// and zero elsewhere. Triangles may overhang the grid but must not overlap.
    pub fn bin_means(&self, count: usize, triangle: impl Fn(usize) -> [Corner; 3] + Sync) -> Vec<f64> {
        let (phi_bins, e_bins) = (self.phi.end.len(), self.e.end.len());
        let parts = parts(count, phi_bins * e_bins);
        let sums: Vec<Vec<f64>> = (0..parts)
            .into_par_iter()
            .map(|part| {
                let mut sums = vec![0.0; phi_bins * e_bins];
                for k in count * part / parts..count * (part + 1) / parts {
                    self.add_triangle(&triangle(k), &mut sums);
                }
                sums
            })
            .collect();
        let mean = |bin: usize| {
            let points = i64::from(self.phi.points_in(bin / e_bins)) * i64::from(self.e.points_in(bin % e_bins));
            sums.iter().map(|part| part[bin]).sum::<f64>() / points as f64
        };
        (0..phi_bins * e_bins).map(mean).collect()
    }

    /// Adds the values at the points inside a triangle to their bins. Grid lines of constant `phi` are the scanlines.
    fn add_triangle(&self, triangle: &[Corner; 3], sums: &mut [f64]) {
        let mut corners = triangle.map(|[phi, e, n]| [self.phi.measure(phi), self.e.measure(e), n]);
        corners.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let [a, b, c] = corners;
        let (first, last) = (self.phi.first_from(a[0]), self.phi.first_from(c[0]));
        let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if first >= last || twice_area == 0.0 {
            return;
        }
        let (nb, nc) = (b[2] - a[2], c[2] - a[2]);
        let per_line = (nb * (c[1] - a[1]) - nc * (b[1] - a[1])) / twice_area;
        let per_point = (nc * (b[0] - a[0]) - nb * (c[0] - a[0])) / twice_area;
        let slope = |from: Corner, to: Corner| (to[1] - from[1]) / (to[0] - from[0]);
        let (long, lower, upper) = (slope(a, c), slope(a, b), slope(b, c));
        let turn = self.phi.first_from(b[0]);
        let e_bins = self.e.end.len();
        for line in first..last {
            let x = f64::from(line);
            let on_long = a[1] + long * (x - a[0]);
            let on_short = if line < turn { a[1] + lower * (x - a[0]) } else { b[1] + upper * (x - b[0]) };
            let (low, high) = if twice_area > 0.0 { (on_short, on_long) } else { (on_long, on_short) };
            let row = self.phi.bin[line as usize] as usize * e_bins;
            // Measured from the corner, so that no large numbers cancel.
            let at_corner = a[2] + per_line * (x - a[0]) - per_point * a[1];
            self.add_span(low, high, at_corner, per_point, &mut sums[row..row + e_bins]);
        }
    }

    /// Adds `base + slope j` for every point `j` in `[low, high)` to its bin.
    #[inline]
    fn add_span(&self, low: f64, high: f64, base: f64, slope: f64, row: &mut [f64]) {
        let (mut start, end) = (self.e.first_from(low), self.e.first_from(high));
        if start >= end {
            return;
        }
        let mut bin = self.e.bin[start as usize] as usize;
        while start < end {
            let stop = self.e.end[bin].min(end);
            let points = f64::from(stop - start);
            row[bin] += points * (base + slope * (0.5 * f64::from(start + stop - 1)));
            start = stop;
            bin += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(phi_bins: usize, e_bins: usize) -> Grid {
        Grid { phi: Axis { low: 1.0, high: 3.0, bins: phi_bins }, e: Axis { low: 0.2, high: 0.6, bins: e_bins } }
    }

    fn plane(phi: f64, e: f64) -> Corner {
        [phi, e, 3.0 + 2.0 * phi - 4.0 * e]
    }

    /// A fan of triangles around a point, that covers the grid and overhangs it.
    fn fan() -> Vec<[Corner; 3]> {
        let corners = [(0.5, 0.1), (2.0, 0.05), (3.4, 0.12), (3.3, 0.9), (0.7, 0.7)];
        let middle = plane(1.913, 0.377);
        (0..5)
            .map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 5]);
                [middle, plane(a.0, a.1), plane(b.0, b.1)]
            })
            .collect()
    }

    #[test]
    fn a_linear_function_over_any_mesh_has_its_centre_value_as_mean_of_each_bin() {
        let (grid, fan) = (grid(10, 8), fan());
        for points in [40, 400, 200] {
            let means = PointGrid::new(&grid, points).unwrap().bin_means(fan.len(), |k| fan[k]);
            for (bin, mean) in means.iter().enumerate() {
                let expected = plane(grid.phi.centre(bin / 8), grid.e.centre(bin % 8))[2];
                assert!((mean - expected).abs() < 1e-11, "{points} {bin} {mean} {expected}");
            }
        }
    }

    #[test]
    fn every_point_is_counted_once_though_edges_run_through_points() {
        // Corners on points, edges along and across lines of points.
        let grid = Grid { phi: Axis { low: 0.0, high: 8.0, bins: 2 }, e: Axis { low: 0.0, high: 8.0, bins: 2 } };
        let one = |x: f64, y: f64| [x + 0.5, y + 0.5, 1.0];
        let corners = [one(-1.0, -1.0), one(9.0, -1.0), one(9.0, 9.0), one(-1.0, 9.0)];
        let middle = one(3.0, 4.0);
        let means = PointGrid::new(&grid, 8).unwrap().bin_means(4, |k| [middle, corners[k], corners[(k + 1) % 4]]);
        assert_eq!(means, [1.0; 4]);
    }

    #[test]
    fn spans_agree_with_visiting_every_point() {
        let grid = grid(7, 5);
        let triangle = [[1.2, 0.25, 1.0], [2.7, 0.3, 4.0], [1.9, 0.55, 2.0]];
        let points = 101; // no multiple of the bins
        let raster = PointGrid::new(&grid, points).unwrap().bin_means(1, |_| triangle);
        let (mut sums, mut counts) = (vec![0.0; 35], vec![0.0; 35]);
        for i in 0..points {
            for j in 0..points {
                let at = |axis: &Axis, i: usize| axis.low + (axis.high - axis.low) * (i as f64 + 0.5) / points as f64;
                let (phi, e) = (at(&grid.phi, i), at(&grid.e, j));
                let bin = grid.bin(phi, e).unwrap();
                counts[bin] += 1.0;
                let twice = |a: Corner, b: Corner| (b[0] - a[0]) * (e - a[1]) - (phi - a[0]) * (b[1] - a[1]);
                let [a, b, c] = triangle;
                let shares = [twice(b, c), twice(c, a), twice(a, b)];
                if shares.iter().all(|&share| share >= 0.0) {
                    let total: f64 = shares.iter().sum();
                    sums[bin] += (shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2]) / total;
                }
            }
        }
        for bin in 0..35 {
            assert!((raster[bin] - sums[bin] / counts[bin]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_grid_coarser_than_the_bins_is_refused() {
        let error = PointGrid::new(&grid(100, 100), 99).unwrap_err();
        assert_eq!(error, MeshError::CoarseGrid { points: 99, bins: 100 });
    }
}
