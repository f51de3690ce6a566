//! Axes of probabilities: from 0 to 1, or logarithmic where probabilities are small.
//!
//! A logarithm has no place for 0, but many curves are 0 for a while. A line below the powers of ten is reserved for 0.

use crate::axis::{Axis, Labels, power_label};
use crate::elements::{Element, Point};
use crate::palette::{Ink, Stroke};

/// Probabilities below this cannot be distinguished from 0 on an axis from 0 to 1.
const RARE: f64 = 1e-2;
/// Probabilities below this are numerical noise in every method, and count as 0.
const LEAST: f64 = 1e-15;
/// A logarithmic axis shows values of at least this share of the highest value.
const DEEPEST: f64 = 1e-12;

/// An axis of probabilities.
#[derive(Debug, Clone)]
pub struct ProbabilityAxis {
    /// The axis to draw.
    pub axis: Axis,
    /// For a logarithmic axis: the lowest value with a place of its own, and the place of smaller values including 0.
    floor: Option<(f64, f64)>,
}

impl ProbabilityAxis {
    /// The axes that a figure needs: a linear one; a logarithmic one if all of `values` are rare; or both if some of
    /// `decisive`, the values that a reader looks for, are rare and others are not.
    pub fn all(label: &str, values: &[f64], decisive: &[f64]) -> Vec<Self> {
        let is_positive = |p: &f64| p.is_finite() && *p > LEAST;
        let highest = values.iter().copied().filter(is_positive).fold(0.0, f64::max);
        let has_rare = decisive.iter().copied().filter(is_positive).any(|p| p < RARE);
        match (highest > 0.0 && highest < RARE, has_rare) {
            (true, _) => vec![Self::logarithmic(label, values, highest)],
            (false, true) => vec![Self::linear(label, highest), Self::logarithmic(label, values, highest)],
            (false, false) => vec![Self::linear(label, highest)],
        }
    }

    fn linear(label: &str, highest: f64) -> Self {
        let highest = if highest > 0.0 { highest } else { 1.0 };
        Self { axis: Axis::linear(label, -0.03 * highest..1.05 * highest, 5), floor: None }
    }

    fn logarithmic(label: &str, values: &[f64], highest: f64) -> Self {
        let least = (DEEPEST * highest).max(LEAST);
        let shown = values.iter().copied().filter(|p| *p >= least).fold(highest, f64::min);
        let has_less = values.iter().any(|p| *p > 0.0 && *p < least);
        let bottom = (shown.log10() + 1e-9).floor();
        let top = (2.0 * highest).min(1.2).log10();
        let zero = bottom - 0.12 * (top - bottom);
        let mut axis = Axis::logarithmic(label, 10f64.powf(bottom), 10f64.powf(top), 6);
        axis.ticks.insert(0, zero);
        axis.range.start = zero - 0.04 * (top - bottom);
        let words = if has_less { format!("< {}", power_label(bottom, false)) } else { "0".to_owned() };
        axis.labels = Labels::PowersFrom(bottom - 1e-6, words);
        Self { axis, floor: Some((10f64.powf(bottom), zero)) }
    }

    /// Whether the axis is logarithmic.
    pub fn is_logarithmic(&self) -> bool {
        self.floor.is_some()
    }

    /// The place of a probability on the axis; `None` if it is not finite.
    pub fn place(&self, p: f64) -> Option<f64> {
        match self.floor {
            _ if !p.is_finite() => None,
            None => Some(p),
            Some((floor, zero)) => Some(if p < floor * (1.0 - 1e-6) { zero } else { p.log10() }),
        }
    }

    /// The line between 0 and the powers of ten.
    pub fn divider(&self, x: &Axis) -> Option<Element> {
        let (floor, zero) = self.floor?;
        let y = 0.5 * (floor.log10() + zero);
        let stroke = Stroke { ink: Ink::Faint, width: 0.6, dashes: &[2.0, 3.0] };
        Some(Element::curve(vec![(x.range.start, y), (x.range.end, y)], stroke))
    }

    /// A curve in pieces: a piece ends where a value is missing, and between 0 and the powers of ten.
    pub fn curve(&self, points: &[Point], stroke: Stroke) -> Vec<Element> {
        let mut pieces: Vec<Vec<Point>> = vec![Vec::new()];
        let mut was_zero = None;
        for &(t, p) in points {
            let place = self.place(p);
            let is_zero = self.floor.zip(place).is_some_and(|((_, zero), y)| y == zero);
            if place.is_none() || was_zero.is_some_and(|was| was != is_zero) {
                pieces.push(Vec::new());
            }
            was_zero = place.map(|_| is_zero);
            if let (Some(y), Some(piece)) = (place, pieces.last_mut()) {
                piece.push((t, y));
            }
        }
        let seen = |mut piece: Vec<Point>| {
            // A single point becomes a line of length 0, which is visible because lines have round ends.
            if let [only] = piece[..] {
                piece.push(only);
            }
            Element::curve(piece, stroke)
        };
        pieces.into_iter().filter(|piece| !piece.is_empty()).map(seen).collect()
    }

    /// The region between two curves, divided into pieces where a limit is missing.
    pub fn band(&self, limits: &[(f64, f64, f64)], ink: Ink) -> Vec<Element> {
        let placed = limits.iter().map(|&(t, low, high)| Some((t, self.place(low)?, self.place(high)?)));
        let placed: Vec<Option<(f64, f64, f64)>> = placed.collect();
        let pieces = placed.split(Option::is_none).filter(|piece| !piece.is_empty());
        pieces.map(|piece| Element::band(&piece.iter().copied().flatten().collect::<Vec<_>>(), ink)).collect()
    }
}

/// What a caption says about the axes.
pub fn in_words(axes: &[ProbabilityAxis]) -> &'static str {
    match axes {
        [only] if only.is_logarithmic() => {
            " The axis is logarithmic; its lowest line is 0 (or less than the axis shows)."
        }
        [_, _] => " Below the same on a logarithmic axis; its lowest line is 0 (or less than the axis shows).",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rare_probabilities_have_a_logarithmic_axis_on_which_0_is_called_0() {
        let axes = ProbabilityAxis::all("P", &[0.0, 2e-6, 3e-4], &[3e-4]);
        let [axis] = &axes[..] else { panic!("{axes:?}") };
        let labels: Vec<String> = axis.axis.ticks.iter().map(|tick| axis.axis.tick_label(*tick)).collect();
        assert_eq!(labels, ["0", "10⁻⁶", "10⁻⁵", "10⁻⁴"]);
        assert!(axis.place(0.0).unwrap() < axis.place(2e-6).unwrap());
        assert!((axis.place(3e-4).unwrap() - 3e-4f64.log10()).abs() < 1e-12);
        assert_eq!(axis.place(f64::NAN), None);
    }

    #[test]
    fn what_is_too_small_for_the_axis_is_not_called_0() {
        let axes = ProbabilityAxis::all("P", &[1e-57, 1e-3], &[]);
        let axis = &axes[0].axis;
        assert_eq!(axis.tick_label(axis.ticks[0]), "< 10⁻³");
    }

    #[test]
    fn probabilities_of_every_size_are_drawn_twice_and_large_ones_once() {
        let count = |values: &[f64]| ProbabilityAxis::all("P", values, values).len();
        assert_eq!(count(&[0.5, 1e-5]), 2);
        assert_eq!(count(&[0.0, 0.5, 1.0]), 1);
        assert_eq!(count(&[0.0, 0.0]), 1);
        assert!(!ProbabilityAxis::all("P", &[0.0, f64::NAN], &[])[0].is_logarithmic());
    }

    #[test]
    fn a_curve_is_not_drawn_where_a_value_is_missing_nor_between_0_and_the_powers_of_ten() {
        let stroke = Stroke { ink: Ink::Text, width: 1.0, dashes: &[] };
        let axes = ProbabilityAxis::all("P", &[1e-5, 1e-3], &[]);
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 1e-5), (3.0, f64::NAN), (4.0, 1e-3)];
        assert_eq!(axes[0].curve(&points, stroke).len(), 3);
        assert_eq!(axes[0].band(&[(0.0, 0.0, 1e-3), (1.0, f64::NAN, 1e-3), (2.0, 0.0, 1e-3)], Ink::Text).len(), 2);
    }
}
