//! The map by action and angle: motion in the plane is periodic, so a table of one period knows it for all times.
//!
//! Every orbit of the plane is a contour of `H` and is named by its least eccentric point `q` on the axis `x1 = 0`
//! ([`crate::exact`]), which is a function of `H` (the action is another). In the place of the angle is the time `θ`
//! since the orbit passed that point, `θ = n_sun t` \[rad\]. In these coordinates the motion is
//!
//! ```text
//! q(t) = q(0)      θ(t) = θ(0) + n_sun t   modulo the period T(q)
//! ```
//!
//! (Arnold, *Mathematical Methods of Classical Mechanics*, 1989, §50, with the angle `2π θ/T`). The map is three tables
//! over `q`: half the period, the states on the orbit, and when the orbit rises above the critical eccentricity. They
//! are made from orbits that are followed half round, a few hundred in all, whatever the horizon. A start is found in
//! them once; then a snapshot costs one evaluation of a polynomial, whether it is two years ahead or a hundred.
//!
//! An error of the period counts once for every turn, so the error of the map still grows with the horizon, and panels
//! of `q` are halved until their error at the last snapshot is below the setting, on three orbits in each from which
//! the panel was not made, at states all round them. What the finished map states as its error is then measured against
//! orbits that are propagated one by one to all snapshots, from starts in every panel. That includes what the orbits
//! are off, so over a hundred years it may be more than the setting. At a separatrix the period grows without bound.
//! The panels next to it are halved until less of the cloud is left than [`Settings::smallest_share`], and what is left
//! is propagated directly. At a centre nothing is singular. Where the model's eccentricity does not rise and fall once
//! in every period, the map is refused ([`Refused::TurnsBack`]).
//!
//! | file | idea |
//! |---|---|
//! | `patch` | states as polynomials, with their slopes |
//! | `panel` | an interval of orbits: where a state is on them, and where it is later |
//! | `rise` | when orbits rise above the critical eccentricity |
//! | `build` | how the panels are found |
//! | [`moved`] | a set of orbits that moves by the map |

mod build;
pub mod moved;
mod panel;
mod patch;
mod rise;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::exact::axis::Axis;
use crate::flow::Flow;
use crate::model::plane::{PlanarHamiltonian, State, density_growth};
use crate::problem::InitialGaussian;

use super::{Refused, Settings, Summary};
use panel::{Panel, Spot};

pub use moved::AngleOrbits;

/// The map from the starts of a cloud in the plane to their states at any time.
#[derive(Debug, Clone)]
pub struct AngleMap<M> {
    /// Propagates the orbits that are on no panel.
    flow: Flow<M>,
    axis: Axis<M>,
    times: Vec<f64>,
    critical: Option<f64>,
    /// In ascending order.
    panels: Vec<Panel>,
    summary: Summary,
}

impl<M: PlanarHamiltonian> AngleMap<M> {
    /// The map by `flow` of the cloud that starts as `initial`, good to [`Settings::error`] at the ascending `times`
    /// \[yr\]. With a critical eccentricity it also knows first passages. The accuracy of `flow` is that of orbits that
    /// are propagated directly. Of the settings, [`Settings::reach`] has no effect: the map reaches as far as the
    /// cloud.
    ///
    /// # Errors
    /// [`Refused`] if the setting is finer than the orbits, if the model's orbits have no such angle, or if the map
    /// covers too little.
    ///
    /// # Panics
    /// If there are no times.
    pub fn new(
        flow: Flow<M>,
        initial: &InitialGaussian,
        times: &[f64],
        critical: Option<f64>,
        settings: &Settings,
    ) -> Result<Self, Refused> {
        build::Builder::new(flow, initial, times, critical, settings)?.map(flow, initial)
    }

    /// What the map is made of and how far it is off: its cells are the panels.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The snapshot times \[yr\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The panel and the spot of a state; `None` if it has to be propagated directly.
    fn locate(&self, state: State) -> Option<(u32, Spot)> {
        let q = self.axis.orbit_of(state)?;
        let number = self.panels.partition_point(|panel| panel.high < q);
        let panel = self.panels.get(number).filter(|panel| panel.low <= q)?;
        panel.locate(state, q).map(|spot| (number as u32, spot))
    }

    /// The state `years` after it was this one, and the determinant of the flow's derivative, by the map alone; `None`
    /// if it has to be propagated directly. `years` may lie between and beyond the snapshot times.
    pub fn state(&self, start: State, years: f64) -> Option<(State, f64)> {
        let (number, spot) = self.locate(start)?;
        let panel = &self.panels[number as usize];
        let later = panel.later(spot, years);
        Some((panel.state(later), panel.area(later) / panel.area(spot)))
    }

    /// The largest error of a coordinate at any snapshot, from orbits that start in these states and are propagated by
    /// `flow` one by one. It includes what these orbits are off themselves.
    fn off(&self, flow: Flow<M>, starts: &[State]) -> f64 {
        let (x1, x2) = starts.iter().map(|state| (state.x1, state.x2)).unzip();
        let (mut columns, mut now, mut largest): ([Vec<f64>; 2], f64, f64) = ([x1, x2], 0.0, 0.0);
        let spots: Vec<Option<(u32, Spot)>> = starts.par_iter().map(|&start| self.locate(start)).collect();
        for &time in &self.times {
            let [x1, x2] = &mut columns;
            flow.advance_where_possible(x1, x2, time - now);
            now = time;
            for (i, (number, spot)) in spots.iter().enumerate().filter_map(|(i, spot)| Some((i, (*spot)?))) {
                let panel = &self.panels[number as usize];
                let there = panel.state(panel.later(spot, time));
                // An orbit that could not be followed is NaN, and says nothing.
                largest = largest.max((there.x1 - columns[0][i]).abs()).max((there.x2 - columns[1][i]).abs());
            }
        }
        largest
    }

    /// The factor by which a density per unit `phi`-`e` area has changed on the way: by the determinant of the map, or
    /// in closed form where the orbit is propagated directly.
    pub fn growth(&self, start: State, end: State, years: f64) -> f64 {
        match self.state(start, years) {
            Some((_, determinant)) => end.eccentricity() / (start.eccentricity() * determinant),
            None => density_growth(start, end),
        }
    }
}
