//! The points of a quadrature as places that fill the plane, from which a density can be counted.
//!
//! A point stands for a part of its cell. Where the other places of the part lie follows from the points around it:
//! along each direction by the polynomial of the third degree through four of them, and by the twist of the cell. It is
//! taken in solar angle and eccentricity, in which a cloud that is wound up is straight, and near `e = 0` in
//! `(x1, x2)`.

use super::{Point, Quadrature, Samples, Whole};
use crate::angle::nearest;
use crate::model::plane::State;

/// Pieces to the length of a bin.
const PIECES_A_BIN: f64 = 3.0;
/// By how much the places of neighbouring rows differ, as a share of a piece: the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// Most pieces into which the part of a line is divided.
const MOST_PIECES: usize = 16;
/// Farthest neighbour, in radians and in shares of the eccentricity, that is compared in solar angle and eccentricity.
const FAR_FROM_ORIGIN: f64 = 0.5;

impl Quadrature {
    /// Calls `visit` with solar angles, eccentricities and weights. The part for which a point stands is divided into
    /// three times as many pieces along each direction as it is bins long, which have the widths `bin` in solar angle
    /// and eccentricity, and each piece counts at the fraction `share` of itself, shifted from row to row. Lattices
    /// that are averaged have different shares, so that their places do not coincide. Points that were propagated as
    /// orbits stay where they are.
    ///
    /// Returns the sum of the weights times the distances, in bins and at most one, by which the terms of the third
    /// degree move the ends of the parts: an upper estimate of what the polynomials misplace.
    pub(in crate::mesh) fn spread(
        &self,
        whole: &Whole,
        share: [f64; 2],
        bin: [f64; 2],
        mut visit: impl FnMut(f64, f64, f64),
    ) -> f64 {
        let points = Points { whole, n: self.points_a_cell, cells: self.lines[0].len() - 1 };
        let [outer, inner] = [0, 1].map(|axis| self.parts(axis));
        let Samples { phi, e, weights } = &whole.samples;
        let mut misplaced = 0.0;
        for (k, l) in (0..outer.len()).flat_map(|k| (0..inner.len()).map(move |l| (k, l))) {
            let row = points.row(k, l);
            if weights[row] == 0.0 {
                continue;
            }
            if points.is_direct(k, l) {
                visit(phi[row], e[row], weights[row]);
                continue;
            }
            let map = LocalMap::around(&points, [&outer, &inner], (k, l));
            let (u, v) = (outer[k], inner[l]);
            misplaced += weights[row] * map.end_term([u, v], bin).min(1.0);
            let [by, across] = map.bins_a_deviation(bin);
            let pieces = [u.pieces(by), v.pieces(across)];
            let weight = weights[row] / (pieces[0] * pieces[1]) as f64;
            // Where a row of points coincides with an edge of the bins, its neighbours must not.
            let share = [(share[0] + l as f64 * GOLDEN).fract(), (share[1] + k as f64 * GOLDEN).fract()];
            for by in u.places(pieces[0], share[0]) {
                for across in v.places(pieces[1], share[1]) {
                    let (phi, e) = map.at(by, across);
                    // The Gaussian at that place instead of at the point: its exponent is quadratic in the distance.
                    let thinner = (-by * (u.at + 0.5 * by) - across * (v.at + 0.5 * across)).exp();
                    visit(phi, e, thinner * weight);
                }
            }
        }
        misplaced
    }

    /// The parts of the line for which the points along an axis stand.
    fn parts(&self, axis: usize) -> Vec<PartOfLine> {
        let mut start = self.lines[axis][0];
        let one = |&Point { at, width, .. }: &Point| {
            let part = PartOfLine { at, width, from_point: start - at };
            start += width;
            part
        };
        self.axes[axis].iter().map(one).collect()
    }
}

/// The points of all cells by their numbers along the two directions.
struct Points<'a> {
    whole: &'a Whole,
    /// Points in a cell along a direction.
    n: usize,
    /// Cells along a direction.
    cells: usize,
}

impl Points<'_> {
    fn cell(&self, k: usize, l: usize) -> usize {
        (k / self.n) * self.cells + l / self.n
    }

    fn row(&self, k: usize, l: usize) -> usize {
        self.cell(k, l) * self.n * self.n + (k % self.n) * self.n + l % self.n
    }

    fn is_direct(&self, k: usize, l: usize) -> bool {
        self.whole.is_direct(self.cell(k, l))
    }

    /// Whether there is a point with these numbers that the polynomials reach.
    fn has(&self, k: Option<usize>, l: Option<usize>) -> bool {
        let side = self.n * self.cells;
        k.zip(l).is_some_and(|(k, l)| k < side && l < side && !self.is_direct(k, l))
    }

    /// Of a point with the number `k` along a direction: the neighbour in its cell, the one on the other side, and the
    /// one beyond the first of these, or beyond the second. `has` says which there are.
    fn neighbours(&self, k: usize, has: impl Fn(Option<usize>) -> bool) -> (usize, Option<usize>, Option<usize>) {
        let steps: [isize; 2] = if k % self.n + 1 < self.n { [1, -1] } else { [-1, 1] };
        let at = |step: isize| k.checked_add_signed(step).filter(|&k| has(Some(k)));
        let inside = k.wrapping_add_signed(steps[0]);
        (inside, at(steps[1]), at(2 * steps[0]).or_else(|| at(2 * steps[1])))
    }
}

/// The part of a line for which a point stands, in standard deviations.
#[derive(Debug, Clone, Copy)]
struct PartOfLine {
    /// Where the point is.
    at: f64,
    /// How long the part is.
    width: f64,
    /// From the point to the beginning of the part.
    from_point: f64,
}

impl PartOfLine {
    /// Into how many pieces it is divided, if it is so many bins long to the length of a standard deviation.
    fn pieces(&self, bins: f64) -> usize {
        ((PIECES_A_BIN * bins * self.width) as usize + 1).min(MOST_PIECES)
    }

    /// The place at the fraction `share` of each of so many pieces, from the point.
    fn places(self, pieces: usize, share: f64) -> impl Iterator<Item = f64> {
        (0..pieces).map(move |piece| self.from_point + self.width * ((piece as f64 + share) / pieces as f64))
    }

    /// The end that is farther from the point.
    fn far_end(&self) -> f64 {
        let other = self.from_point + self.width;
        if other > -self.from_point { other } else { self.from_point }
    }
}

/// A polynomial along a direction that is zero at the point, in Newton's form.
#[derive(Debug, Clone, Copy, Default)]
struct Newton {
    nodes: [f64; 2],
    coefficients: [[f64; 2]; 3],
}

impl Newton {
    /// Through up to three neighbours: their distances, and their coordinates less those of the point.
    fn through(first: (f64, [f64; 2]), second: Option<(f64, [f64; 2])>, third: Option<(f64, [f64; 2])>) -> Self {
        let (d1, f1) = first;
        let c1 = f1.map(|f| f / d1);
        let mut found = Self { nodes: [d1, 0.0], coefficients: [c1, [0.0; 2], [0.0; 2]] };
        let Some((d2, f2)) = second else { return found };
        let c2 = [0, 1].map(|c| (f2[c] / d2 - c1[c]) / (d2 - d1));
        (found.nodes[1], found.coefficients[1]) = (d2, c2);
        if let Some((d3, f3)) = third {
            found.coefficients[2] = [0, 1].map(|c| ((f3[c] / d3 - c1[c]) / (d3 - d1) - c2[c]) / (d3 - d2));
        }
        found
    }

    fn at(&self, d: f64) -> [f64; 2] {
        let [c1, c2, c3] = self.coefficients;
        let [a, b] = self.nodes.map(|node| d - node);
        [0, 1].map(|c| d * (c1[c] + a * (c2[c] + b * c3[c])))
    }

    /// The term of the third degree.
    fn third(&self, d: f64) -> [f64; 2] {
        let [a, b] = self.nodes.map(|node| d - node);
        self.coefficients[2].map(|c| c * d * a * b)
    }
}

/// Where the places around a point lie.
struct LocalMap {
    phi: f64,
    e: f64,
    /// Whether coordinates are solar angle and eccentricity; else they are `(x1, x2)`.
    is_polar: bool,
    along: [Newton; 2],
    twist: [f64; 2],
    /// Solar angle and eccentricity of the neighbours in the cell, less those of the point, to a standard deviation.
    slopes: [[f64; 2]; 2],
}

impl LocalMap {
    fn around(points: &Points<'_>, [outer, inner]: [&[PartOfLine]; 2], (k, l): (usize, usize)) -> Self {
        let Samples { phi, e, .. } = &points.whole.samples;
        let here = points.row(k, l);
        let (k1, k2, k3) = points.neighbours(k, |k| points.has(k, Some(l)));
        let (l1, l2, l3) = points.neighbours(l, |l| points.has(Some(k), l));
        let polar = |row: usize| [nearest(phi[row] - phi[here], 0.0), e[row] - e[here]];
        let by_k = [Some(k1), k2, k3].map(|k| k.map(|k| (k, points.row(k, l))));
        let by_l = [Some(l1), l2, l3].map(|l| l.map(|l| (l, points.row(k, l))));
        let diagonal = points.row(k1, l1);
        let rows = by_k.iter().chain(&by_l).flatten().map(|(_, row)| *row).chain([diagonal]);
        let is_polar = rows
            .map(polar)
            .all(|[turned, raised]| turned.abs() < FAR_FROM_ORIGIN && raised.abs() < FAR_FROM_ORIGIN * e[here]);
        let state = |row: usize| State::from_polar(phi[row], e[row]);
        let origin = state(here);
        let away = |row: usize| match is_polar {
            true => polar(row),
            false => [state(row).x1 - origin.x1, state(row).x2 - origin.x2],
        };
        let newton = |found: [Option<(usize, usize)>; 3], line: &[PartOfLine], own: usize| {
            let [first, second, third] = found.map(|one| one.map(|(k, row)| (line[k].at - line[own].at, away(row))));
            first.map_or_else(Newton::default, |first| Newton::through(first, second, third))
        };
        let (by, across) = (outer[k1].at - outer[k].at, inner[l1].at - inner[l].at);
        let [a, b, both] = [points.row(k1, l), points.row(k, l1), diagonal].map(away);
        Self {
            phi: phi[here],
            e: e[here],
            is_polar,
            along: [newton(by_k, outer, k), newton(by_l, inner, l)],
            twist: [0, 1].map(|c| (both[c] - a[c] - b[c]) / (by * across)),
            slopes: [polar(points.row(k1, l)).map(|f| f / by), polar(points.row(k, l1)).map(|f| f / across)],
        }
    }

    /// The solar angle and eccentricity at a place, which is so far from the point in the two directions.
    fn at(&self, by: f64, across: f64) -> (f64, f64) {
        let [a, b] = [self.along[0].at(by), self.along[1].at(across)];
        let [first, second] = [0, 1].map(|c| a[c] + b[c] + by * across * self.twist[c]);
        if self.is_polar {
            return (self.phi + first, self.e + second);
        }
        let origin = State::from_polar(self.phi, self.e);
        let (x1, x2) = (origin.x1 + first, origin.x2 + second);
        (x1.atan2(x2), x1.hypot(x2))
    }

    /// Bins to the length of a standard deviation along the two directions.
    fn bins_a_deviation(&self, bin: [f64; 2]) -> [f64; 2] {
        self.slopes.map(|slope| (slope[0] / bin[0]).abs().max((slope[1] / bin[1]).abs()))
    }

    /// The distance in bins by which the terms of the third degree move the ends of a point's part.
    fn end_term(&self, parts: [PartOfLine; 2], bin: [f64; 2]) -> f64 {
        let widths = if self.is_polar { bin } else { [(bin[0] * self.e).min(bin[1]); 2] };
        let terms = [0, 1].map(|k| self.along[k].third(parts[k].far_end()));
        terms.iter().map(|term| (term[0] / widths[0]).abs() + (term[1] / widths[1]).abs()).sum()
    }
}
