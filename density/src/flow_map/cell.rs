//! Boxes of the standardised coordinates of the initial Gaussian, and the tree of their halvings.

use std::f64::consts::FRAC_1_SQRT_2;

/// A box; all numbers are in standard deviations from the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell<const N: usize> {
    low: [f64; N],
    high: [f64; N],
}

impl<const N: usize> Cell<N> {
    /// The box that reaches so far from the mean along every axis.
    pub fn around_the_mean(reach: f64) -> Self {
        Self { low: [-reach; N], high: [reach; N] }
    }

    /// The point at local coordinates, each of which runs from -1 to 1.
    pub fn point(&self, local: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|k| self.low[k].midpoint(self.high[k]) + 0.5 * (self.high[k] - self.low[k]) * local[k])
    }

    /// From points to local coordinates.
    pub fn locals(&self) -> Locals<N> {
        let scale = std::array::from_fn(|k| 2.0 / (self.high[k] - self.low[k]));
        Locals { middle: std::array::from_fn(|k| self.middle(k)), scale }
    }

    fn middle(&self, axis: usize) -> f64 {
        self.low[axis].midpoint(self.high[axis])
    }

    /// The lower and the upper half along an axis.
    pub fn halves(&self, axis: usize) -> [Self; 2] {
        let (mut lower, mut upper) = (*self, *self);
        (lower.high[axis], upper.low[axis]) = (self.middle(axis), self.middle(axis));
        [lower, upper]
    }

    /// The axis along which it is longest, in standard deviations.
    pub fn longest_axis(&self) -> usize {
        let length = |k: &usize| self.high[*k] - self.low[*k];
        (0..N).max_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0)
    }

    /// The probability of the box.
    pub fn probability(&self) -> f64 {
        (0..N).map(|k| normal_between(self.low[k], self.high[k])).product()
    }

    fn holds(&self, point: &[f64; N]) -> bool {
        (0..N).all(|k| (self.low[k]..=self.high[k]).contains(&point[k]))
    }
}

/// From points to the local coordinates of a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Locals<const N: usize> {
    middle: [f64; N],
    scale: [f64; N],
}

impl<const N: usize> Locals<N> {
    /// The local coordinates of a point.
    #[inline(always)]
    pub fn of(&self, point: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|k| (point[k] - self.middle[k]) * self.scale[k])
    }
}

/// The probability that a standard normal variable lies between two numbers.
fn normal_between(low: f64, high: f64) -> f64 {
    let beyond = |z: f64| 0.5 * libm::erfc(z * FRAC_1_SQRT_2);
    // The tails on the side of the interval keep their digits.
    if low < 0.0 && high <= 0.0 { beyond(-high) - beyond(-low) } else { beyond(low) - beyond(high) }
}

/// The number of the cell of a leaf without a map.
pub(super) const UNMAPPED: u32 = u32::MAX;

#[derive(Debug, Clone, Copy)]
struct Node {
    /// The axis along which it is halved.
    axis: u32,
    /// The first of its two children, or itself if it is a leaf.
    next: u32,
    /// Where it is halved: beyond all points if it is a leaf.
    middle: f64,
    /// The number of the leaf's cell.
    cell: u32,
    /// How many halvings lead to it.
    depth: u32,
}

impl Node {
    /// A leaf without a map at the place `at`.
    fn leaf(at: usize, depth: u32) -> Self {
        Self { axis: 0, next: at as u32, middle: f64::INFINITY, cell: UNMAPPED, depth }
    }
}

/// A box that has been halved again and again.
#[derive(Debug, Clone)]
pub(super) struct Tree<const N: usize> {
    whole: Cell<N>,
    nodes: Vec<Node>,
    /// How many halvings lead to the smallest boxes.
    depth: u32,
}

impl<const N: usize> Tree<N> {
    /// The whole, without a map.
    pub fn new(whole: Cell<N>) -> Self {
        Self { whole, nodes: vec![Node::leaf(0, 0)], depth: 0 }
    }

    /// Gives a leaf the number of its cell.
    pub fn assign(&mut self, leaf: usize, cell: usize) {
        self.nodes[leaf].cell = cell as u32;
    }

    /// Halves a leaf and returns its halves.
    pub fn halve(&mut self, leaf: usize, cell: &Cell<N>, axis: usize) -> [(usize, Cell<N>); 2] {
        let first = self.nodes.len();
        let depth = self.nodes[leaf].depth;
        self.nodes[leaf] =
            Node { axis: axis as u32, next: first as u32, middle: cell.middle(axis), depth, cell: UNMAPPED };
        self.nodes.extend([first, first + 1].map(|at| Node::leaf(at, depth + 1)));
        self.depth = self.depth.max(depth + 1);
        let [lower, upper] = cell.halves(axis);
        [(first, lower), (first + 1, upper)]
    }

    /// The number of the cell that holds a point, [`UNMAPPED`] if there is none. Every point goes down as many steps as
    /// lead to the smallest boxes, staying in its leaf once it is there: where the way ends cannot be foreseen, and a
    /// processor loses more by a wrong guess.
    #[inline]
    pub fn locate(&self, point: &[f64; N]) -> u32 {
        if !self.whole.holds(point) {
            return UNMAPPED;
        }
        let mut node = self.nodes[0];
        for _ in 0..self.depth {
            let upper = point[node.axis as usize] >= node.middle;
            node = self.nodes[node.next as usize + usize::from(upper)];
        }
        node.cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_share_the_probability_of_the_whole() {
        let whole = Cell::<2>::around_the_mean(6.0);
        let [lower, upper] = whole.halves(1);
        let [left, right] = upper.halves(0);
        assert!((whole.probability() - 1.0).abs() < 5e-9);
        let sum = lower.probability() + left.probability() + right.probability();
        assert!((sum - whole.probability()).abs() < 1e-15);
    }

    #[test]
    fn a_point_is_found_in_the_half_in_which_it_lies_and_none_outside_the_whole() {
        let whole = Cell::<2>::around_the_mean(2.0);
        let mut tree = Tree::new(whole);
        let [(below, _), (above, cell)] = tree.halve(0, &whole, 1);
        let [(left, _), _] = tree.halve(above, &cell, 0);
        tree.assign(below, 7);
        tree.assign(left, 8);
        assert_eq!(tree.locate(&[1.0, -1.0]), 7);
        assert_eq!(tree.locate(&[-1.0, 1.0]), 8);
        assert_eq!(tree.locate(&[1.0, 1.0]), UNMAPPED, "a leaf without a map");
        assert_eq!(tree.locate(&[0.0, 2.1]), UNMAPPED);
    }
}
