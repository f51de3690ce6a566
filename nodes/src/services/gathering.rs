//! The shards of a case, put together snapshot by snapshot.
//!
//! Each shard sends the rows of its range. Once all have sent theirs, their columns, one range after the other, form
//! the snapshot that a case without shards would have sent. A shard that was restarted sends the scenario anew. It
//! sends the same bytes again, so snapshots that have been put together stay as they are.

use std::collections::BTreeMap;

use messages::content::Content;
use messages::layout::SnapshotHeader;

use kit::assignment::Assignment;
use kit::kind::{self, Snapshot};
use kit::shard::{MOST_SHARDS, Shard};
use kit::snapshot_rules::decode;

/// The snapshots that have come from the shards of a case.
#[derive(Debug, Default)]
pub struct Gathering {
    /// The header of the first snapshot that came, and the content of the whole snapshot. All others must agree with
    /// it.
    first: Option<(SnapshotHeader, Content)>,
    shards: BTreeMap<u32, Progress>,
    /// The parts that have not been put together yet, by snapshot and shard.
    waiting: BTreeMap<usize, BTreeMap<u32, (SnapshotHeader, Vec<f64>)>>,
    done: usize,
}

/// How far a shard is since it was last restarted.
#[derive(Debug, Default)]
struct Progress {
    attempt: u32,
    next: usize,
}

/// A snapshot of all shards.
#[derive(Debug, PartialEq)]
pub struct Whole {
    /// The header that a case without shards would have sent.
    pub header: SnapshotHeader,
    /// Its kind and the fields of this kind.
    pub content: Content,
    /// Its columns.
    pub items: Vec<f64>,
}

impl Whole {
    /// The same as a snapshot of a case without shards.
    pub fn as_snapshot(&self) -> Snapshot<'_> {
        Snapshot { header: &self.header, content: self.content, items: &self.items }
    }
}

impl Gathering {
    /// Adds the snapshot of a shard; returns the whole snapshot if this was the last part that was missing.
    ///
    /// # Errors
    /// What is wrong with it, naming the shard.
    pub fn take(
        &mut self,
        header: &SnapshotHeader,
        items: &[f64],
        assignment: &Assignment,
    ) -> Result<Option<Whole>, String> {
        let progress = self.shards.entry(header.shard).or_default();
        if header.attempt < progress.attempt {
            return Ok(None);
        }
        if header.attempt > progress.attempt {
            *progress = Progress { attempt: header.attempt, next: 0 };
        }
        let of_shard = |why: String| format!("shard {}: {why}", header.shard);
        let snapshot = decode(header, items, assignment, progress.next).map_err(|breach| of_shard(breach.what))?;
        let whole = whole_of(&snapshot).map_err(of_shard)?;
        let first = *self.first.get_or_insert((*header, whole));
        check(&snapshot, whole, &first).map_err(of_shard)?;
        let index = progress.next;
        progress.next += 1;
        if index < self.done {
            return Ok(None);
        }
        let parts = self.waiting.entry(index).or_default();
        parts.insert(header.shard, (*header, items.to_vec()));
        if parts.len() < first.0.shards as usize {
            return Ok(None);
        }
        // Shards send in order: a shard that has sent this snapshot has sent all before.
        self.done = index + 1;
        Ok(self.waiting.remove(&index).map(|parts| put_together(first, parts.into_values().collect())))
    }
}

/// The content of the whole snapshot to which a shard's snapshot belongs.
fn whole_of(Snapshot { header, content, .. }: &Snapshot) -> Result<Content, String> {
    let SnapshotHeader { shard, shards, .. } = **header;
    if shard >= shards || shards > MOST_SHARDS {
        return Err(format!("there is no shard {shard} of {shards}"));
    }
    kind::of(content).of_all_shards()
}

/// Checks that a shard's snapshot has the rows of its range, and belongs to the same whole as the `first` one that
/// came.
fn check(
    Snapshot { header, content, .. }: &Snapshot,
    whole: Content,
    (first, first_whole): &(SnapshotHeader, Content),
) -> Result<(), String> {
    let SnapshotHeader { shard, shards, total, rows, .. } = **header;
    // Contents are compared by their bytes, since NaN is not equal to itself.
    let form = |content: Content| (content.kind(), content.details());
    if (shards, total, form(whole)) != (first.shards, first.total, form(*first_whole)) {
        return Err(format!(
            "it is of another form than what shard {} has sent: {total} rows of {shards} shards in all, {whole:?}, for {} rows of \
             {} shards in all, {first_whole:?}",
            first.shard, first.total, first.shards
        ));
    }
    if !kind::of(content).has_a_row_for_each() {
        return Ok(());
    }
    let range = usize::try_from(total).map(|total| Shard { index: shard, count: shards }.range(total));
    match range {
        Ok(range) if range.len() == rows as usize && total <= u32::MAX.into() => Ok(()),
        Ok(range) => Err(format!("it has {rows} rows, but its range of {total} is {range:?}")),
        Err(_) => Err(format!("{total} rows in all are too many")),
    }
}

/// One snapshot of all `parts`, which are in the order of the shards.
fn put_together((first, content): (SnapshotHeader, Content), parts: Vec<(SnapshotHeader, Vec<f64>)>) -> Whole {
    let columns = first.columns as usize;
    let rows: usize = parts.iter().map(|(part, _)| part.rows as usize).sum();
    let mut items = Vec::with_capacity(rows * columns);
    for column in 0..columns {
        for (header, part) in &parts {
            items.extend_from_slice(&part[column * header.rows as usize..][..header.rows as usize]);
        }
    }
    let header = SnapshotHeader { rows: rows as u32, ..first }.with(content);
    let mut header = SnapshotHeader { columns: first.columns, ..header };
    if let Some((part, _)) = parts.first() {
        (header.index, header.time) = (part.index, part.time);
    }
    header.trajectories = parts.iter().map(|(part, _)| part.trajectories).sum();
    header.trajectory_error = parts.iter().map(|(part, _)| part.trajectory_error).fold(0.0, f64::max);
    header.seconds = parts.iter().map(|(part, _)| part.seconds).sum();
    Whole { header, content, items }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::example::assignment;
    use messages::content::Samples;

    /// Shard `shard` of two that share five rows: the first has two.
    fn header(shard: u32, index: u32) -> SnapshotHeader {
        let header = SnapshotHeader {
            run_id: 7,
            time: 0.5 * f64::from(index),
            seconds: 1.5,
            index,
            count: 2,
            rows: 2 + shard,
            total: 5,
            shard,
            shards: 2,
            ..SnapshotHeader::default()
        };
        header.with(Samples::INDEPENDENT)
    }

    const FIRST: [f64; 4] = [1.0, 2.0, 0.1, 0.2];
    const SECOND: [f64; 6] = [3.0, 4.0, 5.0, 0.3, 0.4, 0.5];

    #[test]
    fn the_columns_of_all_shards_are_those_of_the_whole() {
        let mut gathering = Gathering::default();
        let mut take = |shard, index| {
            let items = if shard == 0 { &FIRST[..] } else { &SECOND[..] };
            gathering.take(&header(shard, index), items, &assignment()).unwrap()
        };
        assert_eq!((take(1, 0), take(1, 1)), (None, None));
        let whole = take(0, 0).unwrap();
        assert_eq!(whole.items, [1.0, 2.0, 3.0, 4.0, 5.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!((whole.header.rows, whole.header.seconds, whole.header.time), (5, 3.0, 0.0));
        assert_eq!(take(0, 1).unwrap().header.time, 0.5);
    }

    #[test]
    fn a_restarted_shard_begins_anew_for_itself_alone() {
        let mut gathering = Gathering::default();
        let mut take = |shard, index, attempt| {
            let items = if shard == 0 { &FIRST[..] } else { &SECOND[..] };
            gathering.take(&SnapshotHeader { attempt, ..header(shard, index) }, items, &assignment())
        };
        take(1, 0, 0).unwrap();
        assert!(take(0, 0, 0).unwrap().is_some());
        take(0, 1, 0).unwrap();
        assert_eq!(take(1, 0, 1), Ok(None), "it is there already");
        assert_eq!(take(1, 1, 0), Ok(None), "of the attempt before");
        assert_eq!(take(1, 1, 1).unwrap().unwrap().header.index, 1);
        assert!(take(1, 1, 2).unwrap_err().starts_with("shard 1: it comes out of order"));
    }

    #[test]
    fn what_is_not_the_shards_range_is_refused_and_the_shard_named() {
        let refused = |second: SnapshotHeader, items: &[f64], words: &str| {
            let mut gathering = Gathering::default();
            gathering.take(&header(0, 0), &FIRST, &assignment()).unwrap();
            let why = gathering.take(&second, items, &assignment()).unwrap_err();
            assert!(why.starts_with(&format!("shard {}: ", second.shard)) && why.contains(words), "{why}");
        };
        let good = header(1, 0);
        refused(SnapshotHeader { rows: 2, ..good }, &FIRST, "2 rows, but its range of 5 is 2..5");
        refused(SnapshotHeader { total: 6, ..good }, &SECOND, "6 rows of 2 shards in all");
        refused(SnapshotHeader { shards: 3, ..good }, &SECOND, "another form");
        refused(good.with(Samples { replicates: 2 }), &SECOND, "another form");
        refused(SnapshotHeader { shard: 2, ..good }, &SECOND, "no shard 2 of 2");
        refused(SnapshotHeader { index: 1, time: 0.5, ..good }, &SECOND, "out of order");
    }
}
