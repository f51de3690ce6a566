//! Axes: range, ticks and how they are labelled.
//!
//! A logarithmic axis is a linear axis of `log10` of the quantity, so that one kind of panel serves all figures.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// An axis of a panel.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The quantity on the axis, with its unit.
    pub label: String,
    /// Range of the axis, in `log10` of the quantity if the axis is logarithmic.
    pub range: Range<f64>,
    /// Places of the ticks, in `log10` of the quantity if the axis is logarithmic.
    pub ticks: Vec<f64>,
    /// How ticks are labelled.
    pub labels: Labels,
}

/// How ticks are labelled.
#[derive(Debug, Clone, PartialEq)]
pub enum Labels {
    /// With this many decimals.
    Decimals(usize),
    /// As powers of ten.
    Powers,
    /// As powers of ten from this place on; ticks below it have these words.
    PowersFrom(f64, String),
    /// With these names, one per tick.
    Names(Vec<String>),
    /// Without labels: the neighbouring panel has them.
    None,
}

impl Axis {
    /// A linear axis with about `count` ticks.
    pub fn linear(label: &str, range: Range<f64>, count: usize) -> Self {
        let range = widened(range);
        let step = nice_step((range.end - range.start) / count.max(1) as f64);
        let first = (range.start / step - 1e-9).ceil() as i64;
        let last = (range.end / step + 1e-9).floor() as i64;
        let ticks = (first..=last).map(|k| k as f64 * step).collect();
        let decimals = (-step.log10()).ceil().max(0.0) as usize;
        Self { label: label.into(), range, ticks, labels: Labels::Decimals(decimals) }
    }

    /// A logarithmic axis from `low` to `high` (values of the quantity, greater than 0) with at most about `count`
    /// ticks.
    pub fn logarithmic(label: &str, low: f64, high: f64, count: usize) -> Self {
        let range = widened(low.log10()..high.log10());
        let (first, last) = ((range.start - 1e-9).ceil() as i64, (range.end + 1e-9).floor() as i64);
        let stride = ((last - first) as usize / count.max(1) + 1) as i64;
        let mut ticks: Vec<f64> = (first..=last).filter(|k| k.rem_euclid(stride) == 0).map(|k| k as f64).collect();
        if ticks.len() < 2 {
            // Less than two powers of ten: 1, 2, 5 of each.
            ticks = (first - 1..=last)
                .flat_map(|k| [1.0, 2.0, 5.0].map(|m: f64| k as f64 + m.log10()))
                .filter(|tick| (range.start - 1e-9..=range.end + 1e-9).contains(tick))
                .collect();
        }
        Self { label: label.into(), range, ticks, labels: Labels::Powers }
    }

    /// An axis of names, at 0, 1, 2, ...
    pub fn names(names: Vec<String>) -> Self {
        let ticks: Vec<f64> = (0..names.len()).map(|k| k as f64).collect();
        Self { label: String::new(), range: -0.5..names.len() as f64 - 0.5, ticks, labels: Labels::Names(names) }
    }

    /// The same axis without words.
    pub fn bare(self) -> Self {
        Self { label: String::new(), labels: Labels::None, ..self }
    }

    /// The label of a tick.
    pub fn tick_label(&self, tick: f64) -> String {
        match &self.labels {
            Labels::Decimals(decimals) => {
                let text = format!("{tick:.decimals$}");
                if text.trim_start_matches(['-', '0', '.']).is_empty() {
                    text.replace('-', "")
                } else {
                    text.replace('-', "−")
                }
            }
            Labels::Powers => {
                let is_plain = self.ticks.iter().all(|tick| (-2.01..4.0).contains(tick));
                power_label(tick, is_plain)
            }
            Labels::PowersFrom(first, words) if tick < *first => words.clone(),
            Labels::PowersFrom(first, _) => {
                let is_plain = self.ticks.iter().filter(|tick| *tick >= first).all(|tick| (-2.01..4.0).contains(tick));
                power_label(tick, is_plain)
            }
            Labels::Names(names) => names.get(tick.round().max(0.0) as usize).cloned().unwrap_or_default(),
            Labels::None => String::new(),
        }
    }

    /// The label of a tick that has the most characters.
    pub fn longest_label(&self) -> String {
        let labels = self.ticks.iter().map(|&tick| self.tick_label(tick));
        labels.max_by_key(|label| label.chars().count()).unwrap_or_default()
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        // The clamp keeps a point far outside in the range of the integers.
        (f64::from(first) + share.clamp(-100.0, 100.0) * f64::from(last - first)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, tick: &f64) -> String {
        self.tick_label(*tick)
    }
}

/// `10^logarithm`, written out or as a power.
pub(crate) fn power_label(logarithm: f64, is_plain: bool) -> String {
    let power = (logarithm + 1e-9).floor() as i64;
    let mantissa = 10f64.powf(logarithm - power as f64).round();
    if is_plain {
        let decimals = (-power).max(0) as usize;
        return format!("{:.decimals$}", mantissa * 10f64.powi(power as i32));
    }
    let superscript: String = power.to_string().chars().map(raised).collect();
    if mantissa > 1.5 { format!("{mantissa}·10{superscript}") } else { format!("10{superscript}") }
}

fn raised(digit: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    digit.to_digit(10).and_then(|d| DIGITS.get(d as usize).copied()).unwrap_or('⁻')
}

/// The next of 1, 2, 5 times a power of ten.
fn nice_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|&nice| nice >= step * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A range that is not empty, even if all values are the same.
fn widened(range: Range<f64>) -> Range<f64> {
    if range.start.is_finite() && range.end.is_finite() && range.start < range.end {
        let least = 1e-9 * range.start.abs().max(range.end.abs());
        return range.start..range.end.max(range.start + least);
    }
    let middle = if range.start.is_finite() { range.start } else { 0.0 };
    let half = 0.5 * middle.abs().max(1.0);
    middle - half..middle + half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        let axis = Axis::linear("", -0.31..0.62, 5);
        assert_eq!(
            axis.ticks.iter().map(|&t| axis.tick_label(t)).collect::<Vec<_>>(),
            ["−0.2", "0.0", "0.2", "0.4", "0.6"]
        );
        let axis = Axis::logarithmic("", 2e-7, 0.3, 4);
        assert_eq!(axis.ticks.iter().map(|&t| axis.tick_label(t)).collect::<Vec<_>>(), ["10⁻⁶", "10⁻⁴", "10⁻²"]);
        let axis = Axis::logarithmic("", 0.4, 3.0, 4);
        assert_eq!(axis.ticks.iter().map(|&t| axis.tick_label(t)).collect::<Vec<_>>(), ["0.5", "1", "2"]);
    }

    #[test]
    fn an_empty_or_unknown_range_still_makes_an_axis() {
        for range in [1.0..1.0, f64::NAN..f64::NAN, 0.0..f64::INFINITY, 2.0..1.0] {
            let axis = Axis::linear("", range, 4);
            assert!(axis.range.start < axis.range.end && !axis.ticks.is_empty());
        }
    }
}
