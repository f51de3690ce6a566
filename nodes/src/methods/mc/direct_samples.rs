//! Samples that are propagated one by one, watched for their first passages.

use density::first_passage::empirical::point;
use density::flow::Passages;
use density::in_space::cloud::Cloud;
use kit::failure::Failure;
use messages::layout::PASSAGE_TIMES;

use crate::methods::radiation::Radiation;

/// The samples of the scenario under way, and when each first had the critical eccentricity.
#[derive(Debug)]
pub(super) struct DirectSamples {
    /// Number of the first orbit in the case.
    pub first: usize,
    pub cloud: Box<dyn Cloud>,
    /// Position in `curve_times` of the time by which each orbit had passed, or [`PENDING`]. It takes one byte per
    /// orbit, since there may be many orbits.
    pub points: Vec<u8>,
    pub curve_times: Vec<f64>,
    pub times: Vec<f64>,
    pub critical: f64,
    /// Which variable is an uncertain radiation parameter, if any is.
    pub radiation: Option<Radiation>,
    /// Where the orbits are \[yr\].
    pub now: f64,
}

impl DirectSamples {
    /// Moves all samples to `time` \[yr\] and notes which of them pass.
    pub fn advance_to(&mut self, time: f64) -> Result<(), Failure> {
        let Self { first, cloud, points, curve_times, critical, now, .. } = self;
        let note = |time| point(time, curve_times) as u8;
        let passages = Passages { passages: points, pending: PENDING, note: &note };
        let moved = cloud.advance_watching(time, *critical, passages);
        moved.map_err(|lost| lost.counted_from(*first))?;
        *now = time;
        Ok(())
    }
}

/// Stands for an orbit that has not passed. No time of the curve has this position.
pub(super) const PENDING: u8 = u8::MAX;
const _: () = assert!(PASSAGE_TIMES < PENDING as usize);
