//! Samples that their propagator has reduced to counts and sums, which are added up over all shards.

use density::sample_sums::SampleSums;
use messages::content::{Content, Reduced};

use super::{Estimated, Kind, Memory, Place, Snapshot, not_finite};
use crate::breach::Breach;
use crate::reduced::from_numbers;
use crate::shard::Shard;
use crate::space::Space;

impl Kind for Reduced {
    fn breach(&self, _: &Space, rows: usize, items: &[f64]) -> Option<Breach> {
        not_finite(rows, items)
    }

    /// The snapshot holds the counts and sums of all shards, one shard after the other.
    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let (header, (_, grid)) = (snapshot.header, at.in_plane()?);
        let [mut rest] = snapshot.columns()?;
        let mut whole = SampleSums::empty(grid.len());
        for shard in Shard::all(header.shards) {
            let (sums, others) =
                from_numbers(rest, grid.len()).map_err(|why| format!("shard {}: {why}", shard.index))?;
            let range = shard.range(header.total as usize);
            if !shard.is_whole() && sums.samples != range.len() as u64 {
                let (samples, total) = (sums.samples, header.total);
                return Err(format!(
                    "shard {}: it has {samples} samples, but its range of {total} is {range:?}",
                    shard.index
                ));
            }
            whole.add(&sums);
            rest = others;
        }
        match u32::try_from(whole.samples) {
            Ok(samples) if rest.is_empty() => Ok(Estimated { reduced: Some(samples), ..whole.finish(grid).into() }),
            _ => Err(format!("{} numbers follow {} reduced samples", rest.len(), whole.samples)),
        }
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Ok(Self.into())
    }

    /// The number of samples is in the numbers themselves, so it is checked when they are read.
    fn has_a_row_for_each(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use messages::layout::SnapshotHeader;

    use super::*;
    use crate::reduced::to_numbers;

    #[test]
    fn reduced_samples_that_are_not_of_the_shards_range_are_refused_and_the_shard_named() {
        let assignment = crate::example::assignment();
        let grid = assignment.plane().unwrap().grids[0];
        let samples = |count: usize| {
            let sums = SampleSums::reduce(&vec![1.5; count], &vec![0.2; count], &grid, 0.6).unwrap();
            to_numbers(&sums).unwrap()
        };
        let estimate = |numbers: &[f64]| {
            let rows = numbers.len() as u32;
            let header = SnapshotHeader { shards: 2, total: 5, rows, ..SnapshotHeader::default() }.with(Reduced);
            let snapshot = Snapshot { header: &header, content: Reduced.into(), items: numbers };
            Reduced.estimate(&snapshot, &mut Memory::default(), &Place { assignment: &assignment, index: 0 })
        };
        let estimated = estimate(&[samples(2), samples(3)].concat()).unwrap();
        assert_eq!((estimated.reduced, estimated.mass_on_grid), (Some(5), 1.0));
        let refused = |numbers: &[f64], words: &str| {
            let why = estimate(numbers).unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        refused(&[samples(2), samples(2)].concat(), "shard 1: it has 2 samples, but its range of 5 is 2..5");
        refused(&samples(2), "shard 1: it ends before");
        refused(&[samples(2), samples(3), samples(1)].concat(), "follow 5 reduced samples");
    }
}
