//! Which points of a map are computed: those between which the quantity bends.
//!
//! The map is divided into blocks. In each the middles of its sides and its centre are computed; where one of them is
//! farther from the interpolation between the corners than half the tolerance, the block is divided into four,
//! otherwise all of its points are interpolated. A cliff may pass between the points of a block that it leaves next to
//! the border. So blocks that touch differ by a factor of two at most, as is usual in adaptive meshes: a block more
//! than twice as large as one that it touches is divided as well. And the error of an interpolation follows from what
//! was seen in the block and in all that it touches. The same points are computed whatever was known before, so a map
//! that was interrupted and goes on is the same as one that was not.

use std::collections::{BTreeMap, BTreeSet};

use crate::exact::Estimated;

use super::UNKNOWN;

/// Distance of the points that are computed first.
const FIRST: usize = 8;

/// The error of an interpolation, as a multiple of the largest distance that was seen in its block and in those that it
/// touches: the middles of a block need not be where that is largest.
const MARGIN: f64 = 1.5;

/// A cell of a finished map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// The quantity and its error.
    pub quantity: Estimated,
    /// Whether it was interpolated.
    pub is_interpolated: bool,
}

/// A rectangle of points: first and last of each direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Block {
    x: (usize, usize),
    y: (usize, usize),
}

impl Block {
    /// Its longer side in steps of the map.
    fn extent(self) -> usize {
        (self.x.1 - self.x.0).max(self.y.1 - self.y.0)
    }

    fn is_divisible(self) -> bool {
        self.extent() > 1
    }

    /// All of its points. Blocks that touch share those of their common border.
    fn points(self) -> impl Iterator<Item = (usize, usize)> {
        (self.x.0..=self.x.1).flat_map(move |x| (self.y.0..=self.y.1).map(move |y| (x, y)))
    }

    /// The two ends of each direction and the middle between them, each once.
    fn ends_and_middle((first, last): (usize, usize)) -> BTreeSet<usize> {
        BTreeSet::from([first, first.midpoint(last), last])
    }

    fn corners(self) -> [(usize, usize); 4] {
        [(self.x.0, self.y.0), (self.x.0, self.y.1), (self.x.1, self.y.0), (self.x.1, self.y.1)]
    }

    /// Corners, middles of the sides, and centre.
    fn probes(self) -> Vec<(usize, usize)> {
        let ys = Self::ends_and_middle(self.y);
        Self::ends_and_middle(self.x).into_iter().flat_map(|x| ys.iter().map(move |&y| (x, y))).collect()
    }

    /// The parts between neighbouring probes.
    fn parts(self) -> Vec<Self> {
        let (xs, ys) = (spans(&Self::ends_and_middle(self.x)), spans(&Self::ends_and_middle(self.y)));
        xs.into_iter().flat_map(|x| ys.iter().map(move |&y| Self { x, y })).collect()
    }
}

/// The spans between neighbouring numbers, or the number by itself.
fn spans(ends: &BTreeSet<usize>) -> Vec<(usize, usize)> {
    let ends: Vec<usize> = ends.iter().copied().collect();
    match ends[..] {
        [only] => vec![(only, only)],
        _ => ends.windows(2).map(|pair| (pair[0], pair[1])).collect(),
    }
}

/// The first blocks of `count` points in a direction.
fn first_spans(count: usize) -> Vec<(usize, usize)> {
    spans(&(0..count).step_by(FIRST).chain(count.checked_sub(1)).collect())
}

/// The points that are known, each with one or more quantities.
pub type Known = BTreeMap<(usize, usize), Vec<Estimated>>;

/// Fills a map of `size` points, each of which has one or more quantities, to about `tolerance`. `compute` gets the
/// points that are needed next and adds them to those that are known, or says why it stops.
///
/// # Errors
/// What `compute` says.
pub fn fill<E>(
    size: (usize, usize),
    tolerance: f64,
    known: &mut Known,
    mut compute: impl FnMut(&[(usize, usize)], &mut Known) -> Result<(), E>,
) -> Result<Vec<Vec<Cell>>, E> {
    let ys = first_spans(size.1);
    let mut blocks: Vec<Block> =
        first_spans(size.0).into_iter().flat_map(|x| ys.iter().map(move |&y| Block { x, y })).collect();
    let mut settled: Vec<Settled> = Vec::new();
    while !blocks.is_empty() {
        let needed: BTreeSet<(usize, usize)> = blocks.iter().flat_map(|block| block.probes()).collect();
        let missing: Vec<_> = needed.into_iter().filter(|point| !known.contains_key(point)).collect();
        if !missing.is_empty() {
            compute(&missing, known)?;
        }
        let mut next = Vec::new();
        for block in blocks {
            let bend = bend(block, known);
            match block.is_divisible() && bend > 0.5 * tolerance {
                true => next.extend(block.parts()),
                false => settled.push(Settled { block, bend: if block.is_divisible() { bend } else { 0.0 } }),
            }
        }
        if next.is_empty() {
            next = too_large(&mut settled, size);
        }
        blocks = next;
    }
    Ok(cells(size, known, &settled))
}

/// A block that is not divided, and how far its points are from the interpolation.
#[derive(Debug, Clone, Copy)]
struct Settled {
    block: Block,
    bend: f64,
}

/// For each point of the map, the best of the values that `of` gives for the blocks that hold it; `start` where there
/// is none.
fn at_points(
    settled: &[Settled],
    size: (usize, usize),
    start: f64,
    of: impl Fn(&Settled) -> f64,
    best: fn(f64, f64) -> f64,
) -> Vec<f64> {
    let mut found = vec![start; size.0 * size.1];
    for one in settled {
        let value = of(one);
        one.block.points().for_each(|(x, y)| found[x * size.1 + y] = best(found[x * size.1 + y], value));
    }
    found
}

/// Takes out the blocks that are more than twice as large as one that they touch, and returns their parts.
fn too_large(settled: &mut Vec<Settled>, size: (usize, usize)) -> Vec<Block> {
    let least = at_points(settled, size, f64::INFINITY, |one| one.block.extent() as f64, f64::min);
    let is_right = |one: &Settled| {
        let smallest = one.block.points().map(|(x, y)| least[x * size.1 + y]).fold(f64::INFINITY, f64::min);
        !one.block.is_divisible() || one.block.extent() as f64 <= 2.0 * smallest.max(1.0)
    };
    let (right, large): (Vec<_>, Vec<_>) = settled.drain(..).partition(is_right);
    *settled = right;
    large.into_iter().flat_map(|one| one.block.parts()).collect()
}

/// How far the points that are known in a block are from the interpolation between its corners.
fn bend(block: Block, known: &Known) -> f64 {
    let of = |point: (usize, usize)| {
        let differs = |(k, found): (usize, &Estimated)| {
            let line = interpolated(block, known, point, k);
            if found.value == line.value { 0.0 } else { (found.value - line.value).abs() }
        };
        known[&point].iter().enumerate().map(differs).fold(0.0, larger)
    };
    block.probes().into_iter().map(of).fold(0.0, larger)
}

/// The larger number, where one that is unknown is the largest.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Quantity `k` between the corners of a block.
fn interpolated(block: Block, known: &Known, (x, y): (usize, usize), k: usize) -> Estimated {
    let share = |at: usize, (first, last): (usize, usize)| {
        if last > first { (at - first) as f64 / (last - first) as f64 } else { 0.0 }
    };
    let (u, v) = (share(x, block.x), share(y, block.y));
    let weights = [(1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v];
    let corners = block.corners().map(|corner| known[&corner].get(k).copied().unwrap_or(UNKNOWN));
    // A corner without weight has no part in it, even if it is infinite.
    let parts: Vec<(f64, Estimated)> = weights.into_iter().zip(corners).filter(|(weight, _)| *weight > 0.0).collect();
    let error = parts.iter().map(|(_, corner)| corner.error).fold(0.0, larger);
    let first = parts[0].1.value;
    let value = match parts.iter().all(|(_, corner)| corner.value == first) {
        true => first,
        // Between a finite and an infinite value there is no interpolation.
        false if parts.iter().any(|(_, corner)| corner.value.is_infinite()) => f64::NAN,
        false => parts.iter().map(|(weight, corner)| weight * corner.value).sum(),
    };
    Estimated { value, error }
}

fn cells(size: (usize, usize), known: &Known, settled: &[Settled]) -> Vec<Vec<Cell>> {
    let computed = |found: &Vec<Estimated>| -> Vec<Cell> {
        found.iter().map(|&quantity| Cell { quantity, is_interpolated: false }).collect()
    };
    let mut cells: BTreeMap<(usize, usize), Vec<Cell>> =
        known.iter().map(|(&point, found)| (point, computed(found))).collect();
    let bends = at_points(settled, size, 0.0, |one| one.bend, larger);
    for one in settled {
        let bend = one.block.points().map(|(x, y)| bends[x * size.1 + y]).fold(0.0, larger);
        let count = known[&one.block.corners()[0]].len();
        for point in one.block.points() {
            cells.entry(point).or_insert_with(|| {
                let cell = |k| {
                    let found = interpolated(one.block, known, point, k);
                    let quantity = Estimated { error: found.error + MARGIN * bend, ..found };
                    Cell { quantity, is_interpolated: true }
                };
                (0..count).map(cell).collect()
            });
        }
    }
    (0..size.0).flat_map(|x| (0..size.1).map(move |y| (x, y))).filter_map(|point| cells.remove(&point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(size: (usize, usize), tolerance: f64, of: impl Fn(f64, f64) -> f64) -> (Vec<Vec<Cell>>, usize) {
        let mut computed = 0;
        let mut known = Known::new();
        let cells = fill(size, tolerance, &mut known, |points, known| {
            computed += points.len();
            for &(x, y) in points {
                known.insert((x, y), vec![Estimated { value: of(x as f64, y as f64), error: 0.0 }]);
            }
            Ok::<(), ()>(())
        });
        (cells.unwrap(), computed)
    }

    #[test]
    fn every_cell_is_within_its_error_and_a_cliff_gets_the_points() {
        let of = |x: f64, y: f64| 1.0 / (1.0 + (0.7 * (x + 0.5 * y) - 40.0).exp());
        let (cells, computed) = filled((90, 70), 1e-3, of);
        assert_eq!(cells.len(), 90 * 70);
        assert!((500..4000).contains(&computed), "{computed}");
        for (k, cell) in cells.iter().enumerate() {
            let expected = of((k / 70) as f64, (k % 70) as f64);
            let Cell { quantity, is_interpolated } = cell[0];
            assert!((quantity.value - expected).abs() <= quantity.error.max(1e-5), "{k}: {quantity:?} {expected}");
            assert!(is_interpolated || quantity.error == 0.0);
        }
    }

    #[test]
    fn a_cliff_that_passes_between_the_points_of_a_block_is_found_from_its_neighbour() {
        // It bends away from the border of two blocks and passes the probes of the second, at steps of two, without
        // touching one.
        let of = |x: f64, y: f64| {
            let wave = (-0.5 * ((x - 9.0) / 0.45).powi(2)).exp() * (-0.5 * ((y - 16.0) / 1.4).powi(2)).exp();
            (-0.5 * ((y - 18.0 - 0.02 * x) / 0.8).powi(2)).exp() + 0.2 * wave
        };
        let (cells, _) = filled((17, 25), 0.05, of);
        for (k, cell) in cells.iter().enumerate() {
            let off = (cell[0].quantity.value - of((k / 25) as f64, (k % 25) as f64)).abs();
            assert!(off <= cell[0].quantity.error.max(1e-12), "{k}: {cell:?} is off by {off}");
        }
    }

    #[test]
    fn blocks_that_touch_differ_by_a_factor_of_two_at_most() {
        let block = |x, y| Settled { block: Block { x, y }, bend: 0.0 };
        let mut settled = vec![block((0, 8), (0, 8)), block((8, 10), (0, 2)), block((8, 12), (4, 8))];
        assert_eq!(too_large(&mut settled, (17, 9)).len(), 4);
        assert_eq!(settled.len(), 2);
        assert!(too_large(&mut settled, (17, 9)).is_empty(), "these do not touch");
    }

    #[test]
    fn a_single_row_and_a_map_that_is_infinite_in_part_are_filled() {
        let (cells, computed) = filled((60, 1), 1e-3, |x, _| if x > 33.5 { f64::INFINITY } else { 2.0 });
        assert!(computed < 30, "{computed}");
        for (k, cell) in cells.iter().enumerate() {
            assert_eq!(cell[0].quantity.value, if k > 33 { f64::INFINITY } else { 2.0 });
        }
        assert_eq!(filled((1, 1), 1e-3, |_, _| 0.5).0.len(), 1);
    }

    #[test]
    fn what_was_known_before_changes_nothing() {
        let of = |x: f64, y: f64| (0.1 * x).sin() * (0.07 * y).cos();
        let compute = |points: &[(usize, usize)], known: &mut Known, most: usize| {
            let fresh = points
                .iter()
                .take(most)
                .map(|&(x, y)| ((x, y), vec![Estimated { value: of(x as f64, y as f64), error: 0.0 }]));
            known.extend(fresh);
            if most < points.len() { Err(()) } else { Ok(()) }
        };
        let mut known = Known::new();
        assert!(fill((40, 40), 1e-3, &mut known, |points, known| compute(points, known, 17)).is_err());
        let resumed = fill((40, 40), 1e-3, &mut known, |points, known| compute(points, known, usize::MAX)).unwrap();
        assert_eq!(resumed, filled((40, 40), 1e-3, of).0);
    }
}
