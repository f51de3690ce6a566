//! A first-passage curve that estimates its own error, as rows of its message.

use density::mesh::passage::PassageCurve;
use messages::layout::PASSAGE_COLUMNS;

/// A first-passage probability from which an end of its interval is farther than this is withheld: it would say little,
/// and the interval says what is known.
const LARGEST_PASSAGE_ERROR: f64 = 0.1;

/// The rows of a curve that estimates its own error. An orbit that has passed stays so: the lower end of an interval
/// is therefore not below that of an earlier time, and the upper end is not above that of a later time.
pub(super) fn rows(curve: &PassageCurve, times: &[f64]) -> Vec<[f64; PASSAGE_COLUMNS]> {
    let row = |((&time, &p), &error): ((&f64, &f64), &f64)| [time, p, (p - error).max(0.0), (p + error).min(1.0)];
    let mut rows: Vec<_> = times.iter().zip(&curve.probability).zip(&curve.error).map(row).collect();
    for k in 1..rows.len() {
        rows[k][2] = rows[k][2].max(rows[k - 1][2]);
    }
    for k in (1..rows.len()).rev() {
        rows[k - 1][3] = rows[k - 1][3].min(rows[k][3]);
    }
    for [_, probability, low, high] in &mut rows {
        if (*probability - *low).max(*high - *probability) > LARGEST_PASSAGE_ERROR {
            *probability = f64::NAN;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_that_is_hardly_known_is_withheld_and_its_interval_is_told() {
        let curve = PassageCurve { probability: vec![0.0, 0.3, 0.6], error: vec![0.0, 0.05, 0.4] };
        let [first, second, third] = rows(&curve, &[0.0, 1.0, 2.0])[..] else { panic!("three rows") };
        assert_eq!((first, second), ([0.0; 4], [1.0, 0.3, 0.25, 0.35]));
        assert!(third[1].is_nan(), "{third:?}");
        // What has passed by one year has passed by two.
        assert_eq!((third[2], third[3]), (0.25, 1.0));
    }
}
