//! Which density method belongs to which kind of snapshot.

use density::binning;
use density::estimate::Estimate;
use messages::layout::{SnapshotHeader, kind};

use crate::assignment::Assignment;

/// What the estimator remembers of a case between its snapshots.
#[derive(Debug, Default)]
pub struct Case {
    done: usize,
}

impl Case {
    /// How many snapshots have been estimated.
    pub fn snapshots_done(&self) -> usize {
        self.done
    }

    /// Estimates the next snapshot.
    ///
    /// # Errors
    /// What makes the numbers impossible.
    pub fn estimate(
        &mut self,
        header: &SnapshotHeader,
        items: &[f64],
        assignment: &Assignment,
    ) -> Result<Estimate, String> {
        let grid = assignment.grids[self.done];
        let critical_e = assignment.problem.critical_e;
        let rows = header.rows as usize;
        let estimate = match header.kind {
            kind::SAMPLES => {
                let (phi, e) = items.split_at(rows);
                check_eccentricities(e)?;
                binning::estimate(phi, e, grid, critical_e)
            }
            other => return Err(format!("kind {other} has no density method")),
        };
        self.done += 1;
        Ok(estimate)
    }
}

fn check_eccentricities(e: &[f64]) -> Result<(), String> {
    match e.iter().position(|e| !(0.0..1.0).contains(e)) {
        Some(row) => Err(format!("row {row} has e = {}, outside [0, 1)", e[row])),
        None => Ok(()),
    }
}
