//! Figures of quasi-random samples that are independent of one another, and what they are off by.

use std::ops::Range;

use crate::exact::Estimated;

/// Independent samples of starts.
pub const REPLICATES: usize = 8;
/// Starts of each at first.
pub const FIRST_STARTS: usize = 256;
/// Number of standard errors that an error estimate has. With [`REPLICATES`] replicates, a Gaussian figure is farther
/// off once in 50 times (Student's distribution with 7 degrees of freedom).
pub const STANDARD_ERRORS: f64 = 3.0;

/// The numbers of starts that are added one after another: as many as at first, and then as many again as there are.
#[derive(Debug)]
pub struct Numbers {
    next: Range<usize>,
    most: usize,
}

impl Numbers {
    /// Until there are so many, which must be a power of two.
    pub fn up_to(most: usize) -> Self {
        Self { next: 0..FIRST_STARTS.min(most), most }
    }
}

impl Iterator for Numbers {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let now = self.next.clone();
        self.next = now.end..2 * now.end;
        (now.end <= self.most).then_some(now)
    }
}

/// The mean of a figure of each replicate, such as a probability, that are of so many starts together. Each of those
/// stands for a part of the cloud of which nothing else is known; of those that are `lost` nothing at all is known.
pub fn estimated(figures: &[f64], starts: usize, lost: usize) -> Estimated {
    let count = figures.len() as f64;
    let mean = figures.iter().sum::<f64>() / count;
    let variance = figures.iter().map(|figure| (figure - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let of_sampling = STANDARD_ERRORS * (variance / count).sqrt();
    Estimated { value: mean, error: of_sampling + (0.5 + lost as f64) / starts.max(1) as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_start_is_added_once_and_their_number_doubles() {
        let all: Vec<Range<usize>> = Numbers::up_to(2048).collect();
        assert_eq!(all, [0..256, 256..512, 512..1024, 1024..2048]);
        assert!(Numbers::up_to(100).eq(std::iter::once(0..100)));
    }

    #[test]
    fn a_lost_start_counts_as_an_error_of_its_own_size() {
        let (none, one) = (estimated(&[0.5; 8], 2048, 0), estimated(&[0.5; 8], 2048, 1));
        assert_eq!(none, Estimated { value: 0.5, error: 0.5 / 2048.0 });
        assert!((one.error - none.error - 1.0 / 2048.0).abs() < 1e-15);
    }
}
