//! The direction that a criterion prefers for a Gaussian and the times at which it will be looked at.

use super::super::error::MixtureError;
use super::criteria::Criterion;
use super::local_flow::{LocalFlow, Probe};
use super::spectral::Preferred;
use crate::flow::{Accuracy, Flow};
use crate::gaussian::Gaussian;
use crate::model::{Coordinates, Model};

/// What a criterion prefers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found<const N: usize> {
    /// The direction in standardised coordinates, of unit length, and the measure in it.
    pub preferred: Preferred<N>,
    /// Number of orbits propagated to find it.
    pub orbits: usize,
}

/// The direction that a criterion prefers at that of the times \[yr\] at which its measure is largest, for a Gaussian
/// at `t = 0`. Orbits are propagated as accurately as possible, whatever the accuracy of the flow, since second
/// derivatives are taken from them.
///
/// # Errors
/// [`MixtureError::Time`], [`MixtureError::NothingInside`] if an orbit that is needed starts where the model does not
/// hold, or [`MixtureError::Escaped`].
pub fn search<M: Model<Variables = [f64; N]>, const N: usize>(
    criterion: Criterion,
    flow: Flow<M>,
    initial: &Gaussian<N>,
    times: &[f64],
) -> Result<Found<N>, MixtureError> {
    let flow = Flow { accuracy: Accuracy::Fine, ..flow };
    let probe = Probe::new(initial);
    let mut columns = vec![Vec::with_capacity(probe.places.len()); M::State::<f64>::COUNT];
    for &place in &probe.places {
        let state = flow.model.state(0.0, initial.point(place));
        if !flow.model.is_inside(state) {
            return Err(MixtureError::NothingInside);
        }
        columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
    }
    let mut best: Option<Preferred<N>> = None;
    let mut now = 0.0;
    for &time in times {
        if !time.is_finite() {
            return Err(MixtureError::Time(time));
        }
        flow.carry(&mut columns.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>(), now, time)?;
        now = time;
        let read = |row: usize| flow.model.read_out(time, Coordinates::from_fn(|k| columns[k][row]));
        let carried: Vec<[f64; N]> = (0..probe.places.len()).map(read).collect();
        let found = criterion.preferred(&LocalFlow::new(initial, M::VARIABLES, &probe, &carried));
        if best.is_none_or(|best| found.measure > best.measure) {
            best = Some(found);
        }
    }
    let first_axis = Preferred { direction: std::array::from_fn(|k| f64::from(k == 0)), measure: 0.0 };
    Ok(Found { preferred: best.unwrap_or(first_axis), orbits: probe.places.len() })
}
