//! The range of the solar angle that a figure shows: the circle cut open where no cloud is.
//!
//! Each density of a scenario comes on the branch that keeps its own cloud whole. In a figure of several snapshots the
//! clouds share an axis: `[0, 2π)` as in the paper if no cloud crosses 0, else `[-π, π)`, else the circle cut open in
//! the middle of the widest gap between clouds. If the clouds together cover the circle, the axis is as long as they
//! need; if a single cloud covers it, the axis is `[0, 2π)`.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use density::angle::fold;
use density::grid::Axis;

/// Bins below this share of the peak do not count as part of the cloud: they are not visible in any figure either.
const VISIBLE: f64 = 1e-3;

/// The part of `axis` where a marginal density is visible.
pub fn visible(axis: &Axis, marginal: &[f64]) -> Range<f64> {
    let least = VISIBLE * marginal.iter().copied().fold(0.0, f64::max);
    let first = marginal.iter().position(|&p| p >= least).unwrap_or(0);
    let last = marginal.iter().rposition(|&p| p >= least).unwrap_or(axis.bins.saturating_sub(1));
    axis.edge(first)..axis.edge(last + 1)
}

/// The same for a solar angle. If the axis is a whole turn and the cloud reaches over its ends, the cloud is joined
/// there, and the circle is cut open in the widest stretch that the cloud leaves free.
pub fn visible_angle(axis: &Axis, marginal: &[f64]) -> Range<f64> {
    let plain = visible(axis, marginal);
    let is_turn = (axis.high - axis.low - TAU).abs() < 1e-6;
    let is_across = plain.start <= axis.low + 0.5 * axis.width() && plain.end >= axis.high - 0.5 * axis.width();
    if !(is_turn && is_across) {
        return plain;
    }
    let least = VISIBLE * marginal.iter().copied().fold(0.0, f64::max);
    let mut widest = 0..0;
    let mut free = 0;
    for (i, &p) in marginal.iter().enumerate() {
        free = if p >= least { 0 } else { free + 1 };
        if free > widest.len() {
            widest = i + 1 - free..i + 1;
        }
    }
    if widest.is_empty() { plain } else { axis.edge(widest.end)..axis.edge(widest.start) + TAU }
}

/// The axis that keeps all `clouds` (intervals of the solar angle, on any branch) whole.
pub fn common(clouds: &[Range<f64>]) -> Range<f64> {
    let is_free =
        |cut: f64| clouds.iter().all(|cloud| fold(cut, cloud.start) >= cloud.end.min(cloud.start + TAU) - 1e-9);
    let ends = clouds.iter().map(|cloud| fold(cloud.end, 0.0));
    let gap_after = |end: f64| {
        let starts = clouds.iter().map(|cloud| fold(cloud.start, end) - end);
        (end, starts.fold(TAU, f64::min))
    };
    let gaps = ends.filter(|&end| is_free(end)).map(gap_after);
    let widest = gaps.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(end, width)| fold(end + 0.5 * width, -PI));
    // A ring has no gap in which it could be cut, and can be followed over the ends of the axis.
    if clouds.iter().any(|cloud| cloud.end - cloud.start >= TAU - 1e-6) {
        return 0.0..TAU;
    }
    match [Some(0.0), Some(-PI), widest].into_iter().flatten().find(|&cut| is_free(cut)) {
        Some(cut) => cut..cut + TAU,
        None => {
            let centre = clouds.first().map_or(PI, |cloud| 0.5 * (cloud.start + cloud.end));
            let near = |cloud: &Range<f64>| {
                let shift = shift_into(&(centre - PI..centre + PI), cloud);
                cloud.start + shift..cloud.end + shift
            };
            clouds
                .iter()
                .map(near)
                .fold(centre - PI..centre + PI, |all, cloud| all.start.min(cloud.start)..all.end.max(cloud.end))
        }
    }
}

/// The shift of `cloud` by whole turns \[rad\] that puts at least its middle on `axis`.
pub fn shift_into(axis: &Range<f64>, cloud: &Range<f64>) -> f64 {
    let middle = 0.5 * (cloud.start + cloud.end);
    let around = 0.5 * (axis.start + axis.end) - PI;
    fold(middle, around) - middle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_is_the_papers_unless_a_cloud_crosses_its_end() {
        assert_eq!(common(&[1.0..2.0, 3.0..6.2]), 0.0..TAU);
        assert_eq!(common(&[TAU + 1.0..TAU + 2.0]), 0.0..TAU);
        assert_eq!(common(&[-0.5..0.5, 1.0..2.0]), -PI..PI);
        assert_eq!(common(&[TAU - 0.5..TAU + 0.5]), -PI..PI);
    }

    #[test]
    fn clouds_across_both_ends_are_cut_in_the_widest_gap() {
        let axis = common(&[-0.5..0.5, 3.0..3.5]);
        assert!((axis.start - (-1.6415926)).abs() < 1e-6 || (axis.start - 1.75).abs() < 1e-6, "{axis:?}");
        for cloud in [-0.5..0.5, 3.0..3.5] {
            let shift = shift_into(&axis, &cloud);
            assert!(cloud.start + shift >= axis.start && cloud.end + shift <= axis.end, "{axis:?} {cloud:?}");
        }
    }

    #[test]
    fn a_ring_is_drawn_once_round() {
        assert_eq!(common(&[-1.0..-1.0 + TAU, 3.0..7.0]), 0.0..TAU);
    }

    #[test]
    fn a_cloud_across_the_ends_of_a_whole_turn_is_joined_there() {
        let axis = Axis { low: 0.0, high: TAU, bins: 8 };
        let quarter = TAU / 8.0;
        let cloud = visible_angle(&axis, &[1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0]);
        assert!((cloud.start - 5.0 * quarter).abs() < 1e-9 && (cloud.end - 10.0 * quarter).abs() < 1e-9, "{cloud:?}");
        assert_eq!(visible_angle(&axis, &[1.0; 8]), 0.0..TAU, "a whole ring stays as it is");
        assert_eq!(visible_angle(&axis, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), quarter..2.0 * quarter);
    }

    #[test]
    fn clouds_that_cover_the_circle_get_a_longer_axis() {
        let clouds = [0.5..4.0, 3.0..7.0];
        let axis = common(&clouds);
        assert!(axis.end - axis.start >= TAU);
        for cloud in clouds {
            let shift = shift_into(&axis, &cloud);
            assert!(cloud.start + shift >= axis.start - 1e-12 && cloud.end + shift <= axis.end + 1e-12, "{axis:?}");
        }
    }
}
