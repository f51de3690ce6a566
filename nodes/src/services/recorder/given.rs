//! What re-entry says of an uncertain radiation parameter: put together from shards, and written down.

use density::exact::Estimated;
use density::first_passage::empirical::FEW;
use density::first_passage::given::{Given, pooled};
use kit::passage::given_row;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_COLUMNS};
use results::rows::{GivenRow, NONE, RE_ENTRY};

use super::RecordedPassage;

/// The row of a message: given re-entry, and given none.
fn of_numbers(row: &[f64]) -> [Given; 2] {
    let four = |numbers: &[f64]| Given {
        mean: Estimated { value: numbers[0], error: numbers[2] },
        deviation: Estimated { value: numbers[1], error: numbers[3] },
    };
    [four(&row[..4]), four(&row[4..GIVEN_COLUMNS])]
}

/// What all shards of a case say together, which have counted their curves; nothing unless all say something.
pub(super) fn add_up(parts: &[&RecordedPassage]) -> Vec<f64> {
    let rows = parts.first().map_or(0, |part| part.values.len() / PASSAGE_COLUMNS);
    if parts.iter().any(|part| part.given.len() != rows * GIVEN_COLUMNS) {
        return Vec::new();
    }
    let row = |k: usize| {
        let of_part = |part: &&RecordedPassage| {
            let samples = part.header.samples as f64;
            let passed = (part.values[k * PASSAGE_COLUMNS + 1] * samples).round();
            ([passed, samples - passed], of_numbers(&part.given[k * GIVEN_COLUMNS..]))
        };
        let parts: Vec<_> = parts.iter().map(of_part).collect();
        let event = |event: usize| pooled(&parts.iter().map(|(n, given)| (n[event], given[event])).collect::<Vec<_>>());
        given_row([event(0), event(1)])
    };
    (0..rows).flat_map(row).collect()
}

/// The rows of `given_re_entry.csv` of a case. Where fewer than [`FEW`] samples have seen an event, nothing is said of
/// it.
pub(super) fn rows(scenario: &str, method: &str, passage: &RecordedPassage) -> Vec<GivenRow> {
    let samples = passage.header.samples as f64;
    let lines = passage.values.chunks_exact(PASSAGE_COLUMNS).zip(passage.given.chunks_exact(GIVEN_COLUMNS));
    let of_line = |(row, numbers): (&[f64], &[f64])| {
        let shares = [row[1], 1.0 - row[1]];
        let one = |event: usize| {
            let is_known = samples == 0.0 || shares[event] * samples >= FEW;
            let Given { mean, deviation } = if is_known { of_numbers(numbers)[event] } else { Given::UNKNOWN };
            let errors = match (mean.error.is_nan(), samples > 0.0) {
                (true, _) => "",
                (_, true) => "standard errors",
                (_, false) => "error estimates",
            };
            GivenRow {
                scenario: scenario.into(),
                method: method.into(),
                t_yr: row[0],
                given: [RE_ENTRY, NONE][event].into(),
                mean_C: mean.value,
                std_C: deviation.value,
                error_mean_C: mean.error,
                error_std_C: deviation.error,
                errors: errors.into(),
            }
        };
        [one(0), one(1)]
    };
    lines.flat_map(of_line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::first_passage::given::of_sample;
    use messages::layout::PassageHeader;

    /// A part of a sample of which every third orbit passes by the second of two times.
    fn part(numbers: std::ops::Range<u32>) -> RecordedPassage {
        let orbits: Vec<(f64, usize)> =
            numbers.map(|i| (0.1 + 1e-3 * f64::from(i * 37 % 101), if i % 3 == 0 { 1 } else { 2 })).collect();
        let given = of_sample(orbits.iter().copied(), 2).into_iter().flat_map(given_row).collect();
        let passed = orbits.iter().filter(|(_, point)| *point == 1).count() as f64 / orbits.len() as f64;
        let header = PassageHeader { samples: orbits.len() as u64, rows: 2, given: 1, ..PassageHeader::default() };
        RecordedPassage { header, values: vec![0.0, 0.0, 0.0, 0.1, 1.0, passed, 0.2, 0.4], given }
    }

    #[test]
    fn shards_together_say_what_the_whole_says() {
        let whole = rows("s", "mc", &part(0..900));
        let parts = [part(0..10), part(10..500), part(500..900)];
        let mut together = part(0..900);
        together.given = add_up(&parts.each_ref());
        for (right, found) in whole.iter().zip(rows("s", "mc", &together)) {
            let same = |a: f64, b: f64, by: f64| a.is_nan() && b.is_nan() || (a / b - 1.0).abs() < by;
            assert!(same(found.mean_C, right.mean_C, 1e-13) && same(found.std_C, right.std_C, 1e-10), "{found:?}");
            assert!(same(found.error_mean_C, right.error_mean_C, 1e-9), "{found:?}");
            assert!(same(found.error_std_C, right.error_std_C, 0.05), "{found:?}");
        }
        let mut silent = part(0..10);
        silent.given.clear();
        assert!(add_up(&[&parts[0], &silent]).is_empty());
    }

    #[test]
    fn nothing_is_said_of_what_few_samples_have_seen() {
        let rows = rows("s", "mc", &part(0..120));
        let [none_passed, all_still, few_passed, rest] = &rows[..] else { panic!("{rows:?}") };
        assert!(none_passed.mean_C.is_nan() && none_passed.errors.is_empty());
        assert!((all_still.mean_C - 0.15).abs() < 0.01 && all_still.errors == "standard errors");
        assert!(few_passed.mean_C.is_nan(), "40 have passed: {few_passed:?}");
        assert!(rest.mean_C.is_finite() && rest.given == NONE && rest.t_yr == 1.0);
    }
}
