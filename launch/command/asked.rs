//! What `phasecloud ask` is asked for, in the plane and in space.

/// Probabilities of re-entry for which a time and a radiation parameter are looked for.
pub(super) const PROBABILITIES: [f64; 3] = [0.5, 0.9, 0.99];
/// Most times at which the probability is printed.
const MOST_TIMES: usize = 20;

/// Every year up to the horizon, or every few years of a long one, or parts of a year of a short one; the horizon
/// itself comes last.
pub(super) fn years(end: f64) -> Vec<f64> {
    let steps = [0.001, 0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
    let step = steps.into_iter().find(|step| end / step <= MOST_TIMES as f64).unwrap_or(end);
    // As a person would write them: three times 0.1 is 0.3.
    let written = |k: i32| format!("{:.9e}", f64::from(k) * step).parse().unwrap_or(f64::from(k) * step);
    let before = (1..).map(written).take_while(|t: &f64| *t < end * (1.0 - 1e-9));
    before.chain([end]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_horizon_is_divided_into_at_most_twenty_parts_and_comes_last() {
        for end in [1e-3, 0.3, 1.0, 2.0, 5.5, 20.0, 30.0, 1000.0] {
            let years = years(end);
            assert!(years.len() <= MOST_TIMES + 1 && *years.last().unwrap() == end, "{end}: {years:?}");
            assert!(years.is_sorted_by(|a, b| a < b), "{years:?}");
        }
        assert_eq!(years(5.0)[..2], [0.25, 0.5]);
        assert_eq!(years(2.0)[2], 0.3);
    }
}
