//! Shards: processes that share a case. Each computes a range of its rows.
//!
//! A row depends only on the settings and on its number, so the whole case has the same bytes for any number of
//! shards.

use std::ops::Range;

use messages::reporter::Reporter;

use crate::failure::Failure;

/// Environment variable that holds which shard of its case a process is, from 0; not set for a case without shards.
pub const SHARD_VARIABLE: &str = "PHASECLOUD_SHARD";
/// Environment variable that holds how many shards the case has; not set for a case without shards.
pub const SHARDS_VARIABLE: &str = "PHASECLOUD_SHARDS";
/// Most shards of a case.
pub const MOST_SHARDS: u32 = 64;

/// A shard of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 0.
    pub index: u32,
    /// Number of shards of the case; 1 if the case is not split.
    pub count: u32,
}

impl Shard {
    /// The only process of a case that is not split.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Whether the case is not split.
    pub fn is_whole(self) -> bool {
        self.count <= 1
    }

    /// Shard `index` of `count`.
    ///
    /// # Errors
    /// If there is no such shard.
    pub fn new(index: u32, count: u32) -> Result<Self, String> {
        if index < count && count <= MOST_SHARDS {
            return Ok(Self { index, count });
        }
        Err(format!("there is no shard {index} of {count}; shards are numbered from 0, and at most {MOST_SHARDS}"))
    }

    /// The shard that the environment names.
    ///
    /// # Errors
    /// [`Failure::Refused`] if that is no valid shard.
    pub fn from_environment() -> Result<Self, Failure> {
        let variables = [SHARD_VARIABLE, SHARDS_VARIABLE].map(|name| std::env::var(name).ok());
        match &variables {
            [None, None] => Ok(Self::WHOLE),
            [Some(index), Some(count)] => match (index.parse(), count.parse()) {
                (Ok(index), Ok(count)) => Self::new(index, count).map_err(Failure::Refused),
                _ => {
                    Err(Failure::Refused(format!("{SHARD_VARIABLE}={index}, {SHARDS_VARIABLE}={count} are no numbers")))
                }
            },
            _ => Err(Failure::Refused(format!("{SHARD_VARIABLE} and {SHARDS_VARIABLE} go together"))),
        }
    }

    /// The rows of the shard, of `total` rows of the case.
    pub fn range(self, total: usize) -> Range<usize> {
        let edge = |k: u32| (total as u128 * u128::from(k) / u128::from(self.count.max(1))) as usize;
        edge(self.index)..edge(self.index + 1)
    }

    /// The rows of [`Shard::range`], provided that every shard has at least one row.
    ///
    /// # Errors
    /// [`Failure::Refused`] if there are fewer rows than shards.
    pub fn part(self, total: usize) -> Result<Range<usize>, Failure> {
        if total >= self.count as usize {
            return Ok(self.range(total));
        }
        Err(Failure::Refused(format!("{total} rows are too few for {} shards; take fewer shards", self.count)))
    }

    /// The number of the shard; `None` if the case is not split.
    pub fn number(self) -> Option<u32> {
        (!self.is_whole()).then_some(self.index)
    }

    /// The process of the case `label` that computes the shard.
    pub fn process_of(self, label: &str) -> Reporter {
        Reporter::Propagator { label: label.into(), shard: self.number() }
    }

    /// All shards of a case.
    pub fn all(count: u32) -> impl Iterator<Item = Self> {
        (0..count.max(1)).map(move |index| Self { index, count: count.max(1) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_the_rows_one_after_the_other_and_about_equally_many() {
        for (total, count) in [(10, 1), (10, 3), (7, 7), (1_000_003, 64), (2, 5)] {
            let ranges: Vec<_> = Shard::all(count).map(|shard| shard.range(total)).collect();
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, total));
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
            let (least, most) = (ranges.iter().map(Range::len).min(), ranges.iter().map(Range::len).max());
            assert!(most.unwrap() - least.unwrap() <= 1);
        }
        assert!(Shard { index: 0, count: 5 }.part(4).is_err());
    }
}
