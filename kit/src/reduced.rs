//! Samples that were reduced to counts and sums, as the numbers of a snapshot of kind `REDUCED`.
//!
//! [`SampleSums`] holds whole numbers, and so does a snapshot: a count is one number, and a sum is two numbers,
//! `high * 2^52 + low`, since a number of a payload holds 53 bits. Sectors of the circle without samples are left
//! out.
//!
//! ```text
//! samples, above, sectors, then the common sums, then for each sector its number, samples and sums, then the bins' counts
//! ```

use density::sample_sums::{COMMON_SUMS, SECTOR_SUMS, SECTORS, SampleSums};

use crate::assignment::{Assignment, Plane};
use crate::failure::Failure;

/// Numbers before the sectors.
const HEAD: usize = 3 + 2 * COMMON_SUMS;
/// Numbers of a sector.
const SECTOR: usize = 2 + 2 * SECTOR_SUMS;
/// Bits of the lower number of a sum.
const LOW_BITS: u32 = 52;
/// Largest whole number up to which a payload holds all whole numbers exactly.
const LARGEST: i128 = 1 << 53;

/// The scenario in the plane on whose grids samples are reduced.
///
/// # Errors
/// If it is no such scenario.
pub fn plane_of(assignment: &Assignment) -> Result<&Plane, Failure> {
    let why =
        "samples can be reduced in the plane alone, with a radiation parameter that is certain; leave out `reduce`";
    assignment.plane.as_ref().ok_or_else(|| Failure::Refused(why.into()))
}

/// The most numbers that a snapshot can have, on a grid of `bins` bins.
pub fn most_numbers(bins: usize) -> usize {
    (HEAD + SECTORS * SECTOR).saturating_add(bins)
}

/// The numbers of a snapshot.
///
/// # Errors
/// If a sum is too large for two numbers, which takes more samples than fit into memory.
pub fn to_numbers(sums: &SampleSums) -> Result<Vec<f64>, Failure> {
    let sectors: Vec<_> = sums.sectors.iter().enumerate().filter(|(_, sector)| sector.samples > 0).collect();
    let mut numbers = vec![sums.samples as f64, sums.above as f64, sectors.len() as f64];
    push_sums(&mut numbers, &sums.common)?;
    for (number, sector) in sectors {
        numbers.extend([number as f64, sector.samples as f64]);
        push_sums(&mut numbers, &sector.sums)?;
    }
    numbers.extend(sums.counts.iter().map(|&count| count as f64));
    Ok(numbers)
}

fn push_sums(numbers: &mut Vec<f64>, sums: &[i128]) -> Result<(), Failure> {
    for sum in sums {
        let (high, low) = (sum >> LOW_BITS, sum & ((1 << LOW_BITS) - 1));
        if high.abs() > LARGEST {
            return Err(Failure::Refused("too many samples to be reduced in one piece; take more shards".into()));
        }
        numbers.extend([high as f64, low as f64]);
    }
    Ok(())
}

/// Reads one snapshot's numbers from the front of `numbers`, on a grid of `bins` bins; also returns the numbers that
/// follow.
///
/// # Errors
/// What cannot be right.
pub fn from_numbers(numbers: &[f64], bins: usize) -> Result<(SampleSums, &[f64]), String> {
    let mut reader = Reader(numbers);
    let mut sums = SampleSums::empty(bins);
    sums.samples = reader.count("samples")?;
    sums.above = reader.count("samples above the critical eccentricity")?;
    let sectors = reader.count("sectors")?;
    sums.common = reader.sums()?;
    let mut next = 0;
    for _ in 0..sectors {
        let number = reader.count("a sector's number")? as usize;
        let Some(sector) = sums.sectors.get_mut(number).filter(|_| number >= next) else {
            return Err(format!("sector {number} after {next} of {SECTORS}: they must ascend"));
        };
        sector.samples = reader.count("samples of a sector")?;
        sector.sums = reader.sums()?;
        next = number + 1;
    }
    for count in &mut sums.counts {
        *count = reader.count("samples of a bin")?;
    }
    let in_sectors = sum(sums.sectors.iter().map(|sector| sector.samples));
    let on_grid = sum(sums.counts.iter().copied());
    let SampleSums { samples, above, .. } = sums;
    if samples == 0 || in_sectors != u128::from(samples) || on_grid > in_sectors || above > samples {
        return Err(format!(
            "of {samples} samples {in_sectors} lie on the circle, {on_grid} on the grid, {above} above"
        ));
    }
    Ok((sums, reader.0))
}

fn sum(counts: impl Iterator<Item = u64>) -> u128 {
    counts.map(u128::from).sum()
}

/// The numbers that are still to be read.
struct Reader<'a>(&'a [f64]);

impl Reader<'_> {
    fn whole(&mut self, what: &str) -> Result<i128, String> {
        let Some((&number, rest)) = self.0.split_first() else { return Err(format!("it ends before {what}")) };
        self.0 = rest;
        match number.fract() == 0.0 && number.abs() <= LARGEST as f64 {
            true => Ok(number as i128),
            false => Err(format!("{what}: {number} is no whole number below 2^53")),
        }
    }

    fn count(&mut self, what: &str) -> Result<u64, String> {
        u64::try_from(self.whole(what)?).map_err(|_| format!("{what}: a count below 0"))
    }

    fn sums<const N: usize>(&mut self) -> Result<[i128; N], String> {
        let mut sums = [0; N];
        for sum in &mut sums {
            *sum = (self.whole("a sum")? << LOW_BITS) + self.whole("a sum")?;
        }
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use density::grid::{Axis, Grid};

    use super::*;

    const GRID: Grid = Grid { phi: Axis { low: 1.0, high: 2.0, bins: 4 }, e: Axis { low: 0.1, high: 0.3, bins: 3 } };

    fn example() -> SampleSums {
        let phi: Vec<f64> = (0..1000).map(|i| 1.0 + f64::from(i % 97) / 60.0).collect();
        let e: Vec<f64> = (0..1000).map(|i| 0.1 + f64::from(i % 89) / 500.0).collect();
        SampleSums::reduce(&phi, &e, &GRID, 0.2).unwrap()
    }

    #[test]
    fn sums_survive_the_way_through_a_message() {
        let mut numbers = to_numbers(&example()).unwrap();
        assert!(numbers.len() < most_numbers(GRID.len()));
        numbers.push(7.0);
        assert_eq!(from_numbers(&numbers, GRID.len()).unwrap(), (example(), &[7.0][..]));
    }

    #[test]
    fn numbers_that_cannot_be_right_are_refused() {
        let good = to_numbers(&example()).unwrap();
        let refused = |place: usize, number: f64, words: &str| {
            let mut numbers = good.clone();
            numbers[place] = number;
            let why = from_numbers(&numbers, GRID.len()).unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        refused(0, 999.0, "of 999 samples 1000 lie on the circle");
        refused(0, 999.5, "no whole number");
        refused(1, 1001.0, "1001 above");
        refused(HEAD, 256.0, "sector 256");
        refused(good.len() - 1, -1.0, "below 0");
        assert!(from_numbers(&good[..good.len() - 1], GRID.len()).unwrap_err().contains("ends before"));
    }
}
