//! The estimation of a case, snapshot after snapshot, each by the method of its kind.

pub use kit::kind::Estimated;

use kit::assignment::Assignment;
use kit::kind::{self, Memory, Place, Snapshot};

/// What the estimator remembers of a case between its snapshots.
#[derive(Debug, Default)]
pub struct CaseEstimator {
    done: usize,
    memory: Memory,
}

impl CaseEstimator {
    /// How many snapshots have been estimated.
    pub fn snapshots_done(&self) -> usize {
        self.done
    }

    /// Estimates the next snapshot from its columns.
    ///
    /// # Errors
    /// What makes the numbers impossible.
    pub fn estimate(&mut self, snapshot: &Snapshot, assignment: &Assignment) -> Result<Estimated, String> {
        let kind = kind::of(&snapshot.content);
        let at = Place { assignment, index: self.done };
        let estimated = kind.estimate(snapshot, &mut self.memory, &at)?;
        check_finite(
            &estimated,
            kind.may_withhold(),
            kind.lacks_variables(snapshot.header.rows as usize, snapshot.items),
        )?;
        self.done += 1;
        Ok(estimated)
    }
}

/// Checks that densities and moments are finite: numbers that are each allowed, such as `phi` = 1e308, may still lead
/// to others that are not finite. NaN is allowed only if the method withholds figures (`withholds`), or if it says
/// nothing of some variables (`lacks`); a density is withheld as a whole.
fn check_finite(Estimated { values, densities, .. }: &Estimated, withholds: bool, lacks: bool) -> Result<(), String> {
    let is_good = |number: &f64| number.is_finite() || ((withholds || lacks) && number.is_nan());
    let is_withheld = |density: &Vec<f64>| density.iter().all(|density| density.is_nan());
    let is_stated = |density: &Vec<f64>| density.iter().all(|density| density.is_finite());
    let are_good = (withholds && is_withheld(&densities[0]))
        || densities.iter().all(|density| is_stated(density) || (lacks && is_withheld(density)));
    match are_good && values.iter().all(is_good) {
        true => Ok(()),
        false => Err("its density or moments are not finite".into()),
    }
}
