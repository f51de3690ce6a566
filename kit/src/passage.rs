//! First-passage curves as a propagator states them.

use density::first_passage::empirical::EmpiricalCurve;
use density::first_passage::given::Given;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_COLUMNS};

/// A method's answer to the question when the eccentricity first reaches its critical value.
#[derive(Debug, Clone, PartialEq)]
pub enum Passage {
    /// One row per time: time \[yr\], probability, lower and upper end of its interval (NaN without one). If the case
    /// has shards, only the curve of the first shard is used, and it must be that of the whole case.
    Curve(Vec<[f64; PASSAGE_COLUMNS]>),
    /// A curve that was counted from equal samples of this process; the counts of shards are added up.
    Counted {
        /// The rows, in the form of the rows of a curve.
        rows: Vec<[f64; PASSAGE_COLUMNS]>,
        /// How many samples there are.
        samples: u64,
        /// Whether they are independent of one another. Only then is the interval of a count known from the count
        /// alone.
        independent: bool,
    },
    /// The method has no curve, for the given reason.
    Cannot(String),
}

impl Passage {
    /// The rows of an estimate from a sample of trajectories.
    pub fn rows(curve: &EmpiricalCurve) -> Vec<[f64; PASSAGE_COLUMNS]> {
        let interval = |k: usize| curve.interval.as_ref().map_or((f64::NAN, f64::NAN), |interval| interval[k]);
        let row = |k: usize| [curve.times[k], curve.probability[k], interval(k).0, interval(k).1];
        (0..curve.times.len()).map(row).collect()
    }
}

/// What a row of a first-passage curve goes on with: the radiation parameter given re-entry, and given none.
pub fn given_row(events: [Given; 2]) -> [f64; GIVEN_COLUMNS] {
    let four = |Given { mean, deviation }: Given| [mean.value, deviation.value, mean.error, deviation.error];
    let mut row = [f64::NAN; GIVEN_COLUMNS];
    row.iter_mut().zip(events.into_iter().flat_map(four)).for_each(|(place, number)| *place = number);
    row
}

/// Raises the rows of a first-passage curve to what they have reached before. The true curve never falls; rounding and
/// quadrature may make an estimate do so.
pub fn never_falling(rows: &mut [[f64; PASSAGE_COLUMNS]]) {
    let mut least = 0.0f64;
    for row in rows.iter_mut().filter(|row| !row[1].is_nan()) {
        least = least.max(row[1]);
        row[1] = least;
        // An estimate that was raised stays within its interval; of a withheld one only the interval is known.
        row[3] = if row[3].is_nan() { row[3] } else { row[3].max(least) };
    }
}
