//! Exact integrals of a linear density over triangles and over the convex pieces that bins cut from them.
//!
//! With barycentric coordinates `L1, L2, L3` on a triangle of area `A`, `∫ L1^a L2^b L3^c = 2A a! b! c!/(a + b + c +
//! 2)!` (Zienkiewicz, *The Finite Element Method*, eq. for area coordinates), which gives every moment of a linear
//! density in closed form. Pieces are cut edge by edge (Sutherland & Hodgman, Comm. ACM 17, 1974), the density being
//! interpolated at each cut; for a linear function that is exact.

use crate::grid::{Axis, Grid};

/// A corner: solar angle \[rad\], eccentricity, density. The first two may be in any unit that all corners share.
pub type Corner = [f64; 3];

/// Twice the signed area of a triangle, positive if counter-clockwise.
pub fn twice_area([a, b, c]: &[Corner; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

/// Integrals over a triangle of the density times `1, x, y, x², y², xy`, where `x, y` are measured from `origin`;
/// negative for a clockwise triangle.
pub fn moments(triangle: &[Corner; 3], origin: [f64; 2]) -> [f64; 6] {
    let area = 0.5 * twice_area(triangle);
    let x = triangle.map(|corner| corner[0] - origin[0]);
    let y = triangle.map(|corner| corner[1] - origin[1]);
    let n = triangle.map(|corner| corner[2]);
    let sum = |a: [f64; 3]| a[0] + a[1] + a[2];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let first = |a: [f64; 3]| area / 12.0 * (sum(n) * sum(a) + dot(n, a));
    let second = |a: [f64; 3], b: [f64; 3]| {
        let thrice = (0..3).map(|k| n[k] * a[k] * b[k]).sum::<f64>();
        let pairs = sum(n) * dot(a, b) + sum(a) * dot(n, b) + sum(b) * dot(n, a);
        area / 60.0 * (sum(n) * sum(a) * sum(b) + pairs + 2.0 * thrice)
    };
    [area / 3.0 * sum(n), first(x), first(y), second(x, x), second(y, y), second(x, y)]
}

/// A convex piece of a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Polygon {
    corners: [Corner; Self::MOST],
    len: usize,
}

impl Polygon {
    /// A triangle cut by the four sides of a bin has at most seven corners.
    const MOST: usize = 8;

    /// The whole triangle.
    pub fn new(triangle: &[Corner; 3]) -> Self {
        let mut polygon = Self { corners: [[0.0; 3]; Self::MOST], len: 3 };
        polygon.corners[..3].copy_from_slice(triangle);
        polygon
    }

    /// Its corners, in the triangle's sense of rotation.
    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: Corner) {
        // Rounding can only double a corner; a piece with more corners than geometry allows has no area to lose.
        if self.len < Self::MOST {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The pieces below and above `at` along `axis` (0 for the solar angle, 1 for the eccentricity).
    pub fn split(&self, axis: usize, at: f64) -> (Self, Self) {
        let empty = Self { corners: [[0.0; 3]; Self::MOST], len: 0 };
        let (mut below, mut above) = (empty, empty);
        for (k, &from) in self.corners().iter().enumerate() {
            let to = self.corners[if k + 1 == self.len { 0 } else { k + 1 }];
            let (start, end) = (from[axis] - at, to[axis] - at);
            if start <= 0.0 {
                below.push(from);
            }
            if start >= 0.0 {
                above.push(from);
            }
            if (start < 0.0 && end > 0.0) || (start > 0.0 && end < 0.0) {
                let share = start / (start - end);
                let mut cut: Corner = std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
                cut[axis] = at;
                below.push(cut);
                above.push(cut);
            }
        }
        (below, above)
    }

    /// Integral of the density, negative for a clockwise piece.
    pub fn integral(&self) -> f64 {
        let [first, rest @ ..] = self.corners() else { return 0.0 };
        rest.windows(2)
            .map(|pair| {
                let triangle = [*first, pair[0], pair[1]];
                twice_area(&triangle) / 6.0 * (first[2] + pair[0][2] + pair[1][2])
            })
            .sum()
    }

    fn range(&self, axis: usize) -> (f64, f64) {
        self.corners().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
            (low.min(corner[axis]), high.max(corner[axis]))
        })
    }

    /// Calls `visit` with each bin along `axis` that the polygon reaches into, and the piece in it. Coordinates along
    /// `axis` are in bins from the grid's lower edge.
    fn for_each_slab(mut self, axis: usize, bins: usize, mut visit: impl FnMut(usize, Self)) {
        let (low, high) = self.range(axis);
        if !(high > 0.0 && low < bins as f64) {
            return;
        }
        if low < 0.0 {
            self = self.split(axis, 0.0).1;
        }
        let first = low.max(0.0) as usize;
        for slab in first..bins {
            let upper = (slab + 1) as f64;
            if high <= upper {
                return visit(slab, self);
            }
            let (inside, rest) = self.split(axis, upper);
            visit(slab, inside);
            self = rest;
        }
    }
}

/// Share of a triangle's integral that lies above `at` along the eccentricity axis.
pub fn share_above(triangle: &[Corner; 3], at: f64) -> f64 {
    let lies_above = triangle.map(|corner| corner[1] > at);
    if lies_above == [true; 3] {
        return 1.0;
    }
    if lies_above == [false; 3] {
        return 0.0;
    }
    let whole = Polygon::new(triangle);
    let share = whole.split(1, at).1.integral() / whole.integral();
    if share.is_finite() { share.clamp(0.0, 1.0) } else { f64::from(triangle[0][1] > at) }
}

/// Measures positions on a grid in bins from its lower edges.
#[derive(Debug, Clone, Copy)]
pub struct BinUnits {
    low: [f64; 2],
    per_unit: [f64; 2],
    bins: [usize; 2],
}

impl BinUnits {
    /// The units of `grid`.
    pub fn new(grid: &Grid) -> Self {
        let per_unit = |axis: &Axis| axis.bins as f64 / (axis.high - axis.low);
        Self {
            low: [grid.phi.low, grid.e.low],
            per_unit: [per_unit(&grid.phi), per_unit(&grid.e)],
            bins: [grid.phi.bins, grid.e.bins],
        }
    }

    /// A corner `(phi, e, n)` in bins.
    pub fn measure(&self, corner: Corner) -> Corner {
        [(corner[0] - self.low[0]) * self.per_unit[0], (corner[1] - self.low[1]) * self.per_unit[1], corner[2]]
    }

    /// Area of a bin in the units of the grid \[rad\].
    pub fn bin_area(&self) -> f64 {
        1.0 / (self.per_unit[0] * self.per_unit[1])
    }

    /// Adds to each bin `scale` times the integral of the density of a triangle, given in bins, over that bin.
    pub fn deposit(&self, triangle: &[Corner; 3], scale: f64, joint: &mut [f64]) {
        let [phi_bins, e_bins] = self.bins;
        let polygon = Polygon::new(triangle);
        if let Some(bin) = self.common_bin(triangle) {
            joint[bin] += scale * polygon.integral();
            return;
        }
        polygon.for_each_slab(0, phi_bins, |i, column| {
            let row = &mut joint[i * e_bins..(i + 1) * e_bins];
            column.for_each_slab(1, e_bins, |j, piece| row[j] += scale * piece.integral());
        });
    }

    /// The bin that a point, given in bins, lies in; the grid's upper edges belong to its last bins.
    pub fn bin(&self, x: f64, y: f64) -> Option<usize> {
        let [phi_bins, e_bins] = self.bins;
        let along = |position: f64, bins: usize| {
            (0.0..=bins as f64).contains(&position).then(|| (position as usize).min(bins.saturating_sub(1)))
        };
        Some(along(x, phi_bins)? * e_bins + along(y, e_bins)?)
    }

    fn common_bin(&self, [a, b, c]: &[Corner; 3]) -> Option<usize> {
        let bin = self.bin(a[0], a[1])?;
        (self.bin(b[0], b[1])? == bin && self.bin(c[0], c[1])? == bin).then_some(bin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `n = 2 + x - y/2` on a triangle that crosses several unit bins.
    const TRIANGLE: [Corner; 3] = [[0.3, 0.2, 2.2], [3.6, 0.9, 5.15], [1.1, 2.7, 1.75]];

    fn unit_bins() -> BinUnits {
        let axis = |bins| Axis { low: 0.0, high: bins as f64, bins };
        BinUnits::new(&Grid { phi: axis(4), e: axis(3) })
    }

    #[test]
    fn the_upper_edges_of_the_grid_belong_to_its_last_bins() {
        assert_eq!(unit_bins().bin(4.0, 3.0), Some(11));
        assert_eq!((unit_bins().bin(4.0f64.next_up(), 1.0), unit_bins().bin(0.0, 0.0)), (None, Some(0)));
    }

    /// Midpoint sum over the reference triangle, `steps²` points.
    fn numerically(f: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let steps = 600u32;
        let node = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
        let [a, b, c] = TRIANGLE;
        let value = |i: u32, j: u32| {
            // Square to triangle: (s, t) -> barycentric (1 - s, s (1 - t), s t), with Jacobian 2 A s.
            let (s, t) = (node(i), node(j));
            let at = |k: usize| (1.0 - s) * a[k] + s * (1.0 - t) * b[k] + s * t * c[k];
            s * f(at(0), at(1), at(2))
        };
        let sum: f64 = (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))).map(|(i, j)| value(i, j)).sum();
        sum * twice_area(&TRIANGLE) / f64::from(steps * steps)
    }

    #[test]
    fn closed_form_moments_are_the_integrals_of_the_linear_density() {
        let origin = [0.7, -0.4];
        let [mass, x, y, xx, yy, xy] = moments(&TRIANGLE, origin);
        let expected = |f: fn(f64, f64) -> f64| numerically(|x, y, n| n * f(x - origin[0], y - origin[1]));
        let pairs = [
            (mass, expected(|_, _| 1.0)),
            (x, expected(|x, _| x)),
            (y, expected(|_, y| y)),
            (xx, expected(|x, _| x * x)),
            (yy, expected(|_, y| y * y)),
            (xy, expected(|x, y| x * y)),
        ];
        for (closed, numeric) in pairs {
            assert!((closed - numeric).abs() < 1e-5 * numeric.abs(), "{closed} {numeric}");
        }
    }

    #[test]
    fn bins_share_out_a_triangle_without_loss() {
        let mut joint = vec![0.0; 12];
        unit_bins().deposit(&TRIANGLE, 1.0, &mut joint);
        let whole = Polygon::new(&TRIANGLE).integral();
        assert!((joint.iter().sum::<f64>() - whole).abs() < 1e-14 * whole);
        // Bin (1, 0) lies between the lower edge and y = 1, and is cut by the edges from the first corner.
        let expected = numerically(|x, y, n| if (1.0..2.0).contains(&x) && y < 1.0 { n } else { 0.0 });
        assert!((joint[3] - expected).abs() < 1e-3 * expected, "{} {expected}", joint[3]);
    }

    #[test]
    fn what_lies_outside_the_grid_is_left_out() {
        let outside = TRIANGLE.map(|[x, y, n]| [x + 1.0, y - 1.0, n]);
        let mut joint = vec![0.0; 12];
        unit_bins().deposit(&outside, 1.0, &mut joint);
        let expected = numerically(|x, y, n| if x < 3.0 && y > 1.0 { n } else { 0.0 });
        assert!((joint.iter().sum::<f64>() - expected).abs() < 1e-3 * expected);
    }

    #[test]
    fn share_above_a_line_is_exact_for_a_uniform_triangle() {
        // Above y = 1 - h a triangle of height one keeps h² of its area.
        let triangle = [[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.2, 1.0, 3.0]];
        for height in [0.1, 0.5, 0.9] {
            assert!((share_above(&triangle, 1.0 - height) - height * height).abs() < 1e-14);
        }
        assert_eq!((share_above(&triangle, -0.1), share_above(&triangle, 1.0)), (1.0, 0.0));
    }

    #[test]
    fn a_clockwise_triangle_counts_negative() {
        let [a, b, c] = TRIANGLE;
        assert_eq!(moments(&[a, c, b], [0.0; 2])[0], -moments(&TRIANGLE, [0.0; 2])[0]);
    }
}
