//! Puts together the first-passage curve of a case from those of its shards.
//!
//! A curve that was counted from independent samples gets Wilson's interval if its sender gave none. A probability that
//! was counted is a number of samples divided by the number of all samples, so the counts of the shards add up to those
//! of the whole case. Its probabilities and intervals are therefore the same as those of a case without shards, to the
//! last bit.

use density::first_passage::empirical::wilson_interval;
use messages::layout::PASSAGE_COLUMNS;
use messages::text::pack;

use super::{RecordedPassage, given};

/// The curve of a case whose shards sent `parts`, in their order; `None` if there are none.
pub(super) fn merged(parts: &[&RecordedPassage]) -> Option<RecordedPassage> {
    let first = *parts.first()?;
    let shards = first.header.shards as usize;
    // If shard 0 has not counted its curve from samples, that curve is the curve of the whole case.
    if shards <= 1 || (first.header.shard == 0 && first.header.samples == 0) {
        return Some(with_interval(first.clone()));
    }
    let values = if parts.len() == shards { add_up(parts) } else { None };
    let given = values.as_ref().map(|_| given::add_up(parts)).unwrap_or_default();
    let mut header = first.header;
    if values.is_some() {
        header.samples = parts.iter().map(|part| part.header.samples).sum();
    } else {
        header.reason = pack("the first passages that its shards have sent do not fit together");
    }
    Some(RecordedPassage { header, values: values.unwrap_or_default(), given })
}

/// Adds Wilson's interval to those rows of a curve counted from independent samples that have no interval.
fn with_interval(mut passage: RecordedPassage) -> RecordedPassage {
    let samples = passage.header.samples as f64;
    let is_known = samples > 0.0 && passage.header.dependent == 0;
    for row in passage.values.chunks_exact_mut(PASSAGE_COLUMNS).filter(|_| is_known) {
        if row[2].is_nan() && row[3].is_nan() && (0.0..=1.0).contains(&row[1]) {
            (row[2], row[3]) = wilson_interval(row[1], samples);
        }
    }
    passage
}

/// The sum of counted curves; `None` if they are not of the same times, or one was not counted.
fn add_up(parts: &[&RecordedPassage]) -> Option<Vec<f64>> {
    let first = parts.first()?;
    let times = |part: &RecordedPassage| part.values.iter().step_by(PASSAGE_COLUMNS).map(|t| t.to_bits()).collect();
    let expected: Vec<u64> = times(first);
    let fits = |part: &&RecordedPassage| part.header.samples > 0 && times(part) == expected;
    if !parts.iter().all(fits) {
        return None;
    }
    let total = parts.iter().map(|part| part.header.samples as f64).sum::<f64>();
    let row = |start: usize| {
        let rows =
            || parts.iter().map(|part| (&part.values[start..start + PASSAGE_COLUMNS], part.header.samples as f64));
        let passed: f64 = rows().map(|(row, samples)| (row[1] * samples).round()).sum();
        let probability = passed / total;
        let is_known = parts.iter().all(|part| part.header.dependent == 0);
        let (low, high) = if is_known { wilson_interval(probability, total) } else { (f64::NAN, f64::NAN) };
        [first.values[start], probability, low, high]
    };
    Some((0..first.values.len()).step_by(PASSAGE_COLUMNS).flat_map(row).collect())
}

#[cfg(test)]
mod tests {
    use density::first_passage::empirical::empirical_curve;
    use messages::layout::PassageHeader;

    use super::*;
    use kit::Passage;
    use kit::shard::Shard;

    const TIMES: [f64; 4] = [0.0, 0.3, 0.5, 1.0];

    fn part(passages: &[f64], Shard { index, count }: Shard) -> RecordedPassage {
        let values = Passage::rows(&empirical_curve(passages, None, &TIMES)).concat();
        let (rows, samples) = (TIMES.len() as u32, passages.len() as u64);
        let header = PassageHeader { samples, rows, shard: index, shards: count, ..PassageHeader::default() };
        RecordedPassage::new(header, &values)
    }

    /// Pairs of opposites, or points of a sequence, do not scatter as independent draws do.
    #[test]
    fn counts_of_dependent_samples_get_no_interval_neither_whole_nor_in_shards() {
        let dependent = |shard: Shard| {
            let mut part = part(&[0.2, 0.4, f64::NAN, 0.9], shard);
            part.header.dependent = 1;
            part.values.chunks_exact_mut(PASSAGE_COLUMNS).for_each(|row| row[2..].fill(f64::NAN));
            part
        };
        let whole = merged(&[&dependent(Shard::WHOLE)]).unwrap();
        let halves = [0, 1].map(|index| dependent(Shard { index, count: 2 }));
        let of_shards = merged(&halves.each_ref()).unwrap();
        for curve in [whole, of_shards] {
            assert!(
                curve
                    .values
                    .chunks_exact(PASSAGE_COLUMNS)
                    .all(|row| row[1].is_finite() && row[2].is_nan() && row[3].is_nan())
            );
        }
    }

    #[test]
    fn counts_of_shards_add_up_to_those_of_the_whole_to_the_last_bit() {
        let passages: Vec<f64> = (0..1237).map(|i| f64::from(i * 7919 % 1237) / 900.0).collect();
        let whole = part(&passages, Shard::WHOLE);
        for count in [2, 3, 7] {
            let parts: Vec<_> = Shard::all(count).map(|shard| part(&passages[shard.range(1237)], shard)).collect();
            let merged = merged(&parts.iter().collect::<Vec<_>>()).unwrap();
            let bits = |passage: &RecordedPassage| passage.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!((bits(&merged), merged.header.samples), (bits(&whole), 1237));
        }
    }

    #[test]
    fn a_counted_curve_without_an_interval_gets_the_one_that_its_counts_have() {
        let whole = part(&[0.1, 0.2, 0.7, 2.0], Shard::WHOLE);
        let mut bare = whole.clone();
        bare.values.chunks_exact_mut(PASSAGE_COLUMNS).for_each(|row| row[2..].fill(f64::NAN));
        assert_eq!(merged(&[&bare]).unwrap().values, whole.values);
        bare.header.samples = 0;
        assert!(merged(&[&bare]).unwrap().values[2].is_nan(), "nobody knows what it was made of");
    }

    #[test]
    fn a_missing_or_unfit_part_leaves_no_curve_but_a_reason() {
        let mut parts: Vec<_> = Shard::all(2).map(|shard| part(&[0.1, 0.7, 2.0], shard)).collect();
        assert!(merged(&[&parts[0]]).unwrap().values.is_empty());
        parts[1].values[4] = 0.31;
        let merged = merged(&[&parts[0], &parts[1]]).unwrap();
        assert!(merged.values.is_empty() && merged.header.reason != [0; 192]);
    }

    #[test]
    fn the_first_shards_curve_is_the_cases_if_it_was_not_counted() {
        let mut parts: Vec<_> = Shard::all(2).map(|shard| part(&[0.1, 0.7, 2.0], shard)).collect();
        parts[0].header.samples = 0;
        assert_eq!(merged(&[&parts[0], &parts[1]]).unwrap().values, parts[0].values);
    }
}
