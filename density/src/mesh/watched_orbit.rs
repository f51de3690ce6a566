//! How far above the critical eccentricity an orbit has been, step after step.
//!
//! Within a step the excess `f = e² - e_crit²` follows the quintic through value, slope and second derivative at both
//! ends, as in [`crate::first_passage::times`], so that a peak between the ends counts.

use crate::first_passage::Quintic;

/// Distance of the excess from zero beyond which no peak can reach zero within a step, so that the quintic is not
/// needed.
const NEAR: f64 = 0.5;
/// Error of a peak of the quintic, per unit by which the quintic over two steps misses the value between them. For
/// equal steps it is 1/64; four times as much is reported, to allow for unequal steps.
const PEAK_ERROR: f64 = 1.0 / 16.0;

/// An orbit between the two ends of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct WatchedOrbit {
    /// Excess `f`, `f'`, `f''` at both ends.
    ends: [[f64; 3]; 2],
    /// The largest excess before the step.
    reached: f64,
    /// Time from the start of the step and value of a peak within it, if one matters.
    peak: Option<(f64, f64)>,
    /// By how much the values of peaks may be off.
    pub(super) doubt: f64,
}

impl WatchedOrbit {
    pub(super) fn new(excess: [f64; 3]) -> Self {
        Self { ends: [excess; 2], reached: excess[0], peak: None, doubt: 0.0 }
    }

    /// Goes on by a step of `years` at whose end the orbit has this excess.
    /// The step before it took `before` years.
    pub(super) fn go_on(&mut self, before: f64, years: f64, excess: [f64; 3]) {
        let highest = self.reached.max(self.ends[1][0]).max(self.peak.map_or(f64::NEG_INFINITY, |(_, value)| value));
        let ends = [self.ends[1], excess];
        let [start, end] = ends;
        let may_matter = highest < 0.0 && start[1] > 0.0 && end[1] < 0.0 && start[0].max(end[0]) > -NEAR;
        let peak = || {
            let quintic = Quintic::new(start, end, years);
            quintic.peak().map(|time| (time, quintic.at(time)))
        };
        let peak = may_matter.then(peak).flatten();
        // The quintic over this step and the one before should have the value between them. One step is half as long,
        // and the quintic's error is of sixth order.
        let doubt = match peak {
            Some(_) if before > 0.0 => {
                let both = Quintic::new(self.ends[0], excess, before + years).at(before);
                PEAK_ERROR * (both - start[0]).abs()
            }
            _ => 0.0,
        };
        *self = Self { ends, reached: highest, peak, doubt: self.doubt.max(doubt) };
    }

    /// The largest excess up to the time `within` a step of the length `years`.
    pub(super) fn highest(&self, within: f64, years: f64) -> f64 {
        let [start, end] = self.ends;
        if self.reached >= 0.0 {
            return self.reached;
        }
        let here = if within < years { Quintic::new(start, end, years).at(within) } else { end[0] };
        let peak = self.peak.filter(|(time, _)| *time <= within).map_or(here, |(_, value)| value);
        self.reached.max(here).max(peak)
    }
}
