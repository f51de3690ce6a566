//! Where an orbit passes the lines of a grid.

use std::f64::consts::TAU;

use crate::angle::nearest;
use crate::grid::Grid;
use crate::model::PlanarHamiltonian;

use super::contour::Contour;
use super::trail::{OrbitPoint, Trail};

/// A piece of an orbit between two grid lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    /// Time on the orbit at which it begins \[rad\].
    pub from: f64,
    /// Time at which it ends.
    pub to: f64,
    /// The bin in which it lies; `None` outside the grid.
    pub bin: Option<usize>,
}

/// A cubic on `[0, 1]`.
#[derive(Debug, Clone, Copy)]
struct Cubic([f64; 4]);

impl Cubic {
    /// From the values and slopes at the ends.
    fn new(start: f64, end: f64, start_slope: f64, end_slope: f64) -> Self {
        let rise = end - start;
        Self([start, start_slope, 3.0 * rise - 2.0 * start_slope - end_slope, start_slope + end_slope - 2.0 * rise])
    }

    fn at(self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }

    fn slope(self, x: f64) -> f64 {
        let [_, b, c, d] = self.0;
        b + x * (2.0 * c + x * 3.0 * d)
    }

    /// The argument at which the cubic has the value `value`, which lies between the values at the ends.
    fn solve(self, value: f64) -> f64 {
        let [a, b, c, d] = self.0;
        let (start, end) = (a, a + b + c + d);
        let (mut low, mut high) = (0.0, 1.0);
        let mut x = (value - start) / (end - start);
        for _ in 0..8 {
            let miss = self.at(x) - value;
            if (miss < 0.0) == (start < end) {
                low = x
            } else {
                high = x
            }
            let newton = x - miss / self.slope(x);
            let next = if newton > low && newton < high { newton } else { f64::midpoint(low, high) };
            if (next - x).abs() < 1e-9 {
                return next;
            }
            x = next;
        }
        x
    }
}

/// Visits the pieces of an orbit, once round; `holds(from, to)` says whether there is anything between two times.
///
/// Crossings are found by cubic interpolation, and then moved to where the orbit itself passes the line: the bins may
/// be so narrow that the error of the interpolation matters.
pub(super) fn pieces(
    contour: &Contour,
    trail: &Trail,
    model: &impl PlanarHamiltonian,
    grid: &Grid,
    holds: impl Fn(f64, f64) -> bool,
    mut visit: impl FnMut(Piece),
) {
    let (low, width, height) = (grid.phi.low, grid.phi.width(), grid.e.width());
    let turn = TAU / width;
    let mut cuts: Vec<f64> = Vec::new();
    for pair in trail.points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if !holds(a.theta, b.theta) {
            continue;
        }
        let length = b.theta - a.theta;
        // Coordinates in units of bins; `phi` is continued from the grid's branch at the first point.
        let folded = grid.fold(a.phi);
        let x = |point: OrbitPoint| (folded + (point.phi - a.phi) - low) / width;
        let y = |point: OrbitPoint| (point.e - grid.e.low) / height;
        let ((phi_a, e_a), (phi_b, e_b)) = (a.rates(model), b.rates(model));
        // Where e is nearly 0 the rate of the angle says little about what lies between two points.
        let steep = (b.phi - a.phi).abs() * 3.0;
        let slope = |rate: f64| (rate * length).clamp(-steep, steep) / width;
        let xs = Cubic::new(x(a), x(b), slope(phi_a), slope(phi_b));
        let ys = Cubic::new(y(a), y(b), e_a * length / height, e_b * length / height);
        let exactly = |part: f64| {
            let state = contour.at(a.theta + part * length);
            OrbitPoint { theta: 0.0, phi: nearest(state.solar_angle(), a.phi), e: state.eccentricity() }
        };
        cuts.clear();
        for shift in [-turn, 0.0, turn] {
            lines(xs, |part| x(exactly(part)), (x(a), x(b)), (grid.phi.bins, shift), &mut cuts);
        }
        lines(ys, |part| y(exactly(part)), (y(a), y(b)), (grid.e.bins, 0.0), &mut cuts);
        cuts.sort_by(f64::total_cmp);
        let mut from = 0.0;
        for &to in cuts.iter().chain(&[1.0]) {
            if to > from {
                let middle = f64::midpoint(from, to);
                let there = exactly(middle);
                let bin = bin(grid, x(there), y(there), turn);
                visit(Piece { from: a.theta + from * length, to: a.theta + to * length, bin });
                from = to;
            }
        }
    }
}

/// Adds to `cuts` the parameters at which a coordinate passes the whole numbers from 0 to `bins`, less `shift`. The
/// coordinate is known `exactly` and as a cubic; its values at the ends are `from` and `to`.
fn lines(
    cubic: Cubic,
    exactly: impl Fn(f64) -> f64,
    (from, to): (f64, f64),
    (bins, shift): (usize, f64),
    cuts: &mut Vec<f64>,
) {
    let (low, high) = (from.min(to) + shift, from.max(to) + shift);
    let (first, last) = (low.ceil().max(0.0), high.floor().min(bins as f64));
    let mut line = first;
    while line <= last {
        if line > low && line < high {
            let part = cubic.solve(line - shift);
            let moved = part - (exactly(part) - (line - shift)) / cubic.slope(part);
            // Where the curve only touches the line, the slope vanishes and the crossing cannot be moved.
            cuts.push(if (moved - part).abs() < 0.1 { moved.clamp(0.0, 1.0) } else { part });
        }
        line += 1.0;
    }
}

fn bin(grid: &Grid, x: f64, y: f64, turn: f64) -> Option<usize> {
    let within = |value: f64, bins: usize| (value >= 0.0 && value < bins as f64).then_some(value as usize);
    let column = [0.0, turn, -turn].iter().find_map(|shift| within(x + shift, grid.phi.bins))?;
    Some(column * grid.e.bins + within(y, grid.e.bins)?)
}
