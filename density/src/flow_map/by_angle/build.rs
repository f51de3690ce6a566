//! How the panels are found: an interval of orbits is fitted and kept, halved, or given up.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::exact::axis::Axis;
use crate::exact::contour::{Contour, angle_of};
use crate::exact::hamiltonian_range::cloud_range;
use crate::exact::measure::Measure;
use crate::flow::{Accuracy, Flow};
use crate::flow_map::build::accuracy_for;
use crate::flow_map::chebyshev::{Basis, MOST_NODES};
use crate::flow_map::refused::{Cause, Limit, rounded_place};
use crate::flow_map::{Refused, Settings, Summary, Unresolved};
use crate::model::plane::{PlanarHamiltonian, State, VARIABLES};
use crate::problem::InitialGaussian;
use crate::sampling::{Draws, SamplingPlan};

use super::AngleMap;
use super::panel::{Panel, Spot, patch_of};
use super::patch::Patch;
use super::rise::{Rise, rise_of};

/// Number of starts from which the probability of an interval is counted.
const PILOTS: usize = 1 << 14;
/// Largest number of patches of half a period.
const MOST_PARTS: usize = 256;
/// The error that the series along an orbit has at most, as far as the integrator allows: an error of the states
/// misplaces the orbit of a start, whose angle then runs ahead or behind for the rest of the horizon. It takes a few
/// coefficients more than the error of the map would.
const ALONG: f64 = 1e-13;
/// Where that accuracy is not reached, the series may contribute at most this share of the map's error.
const SHARE_ALONG: f64 = 0.1;
/// Coefficients below this are left out.
const NEGLIGIBLE: f64 = 1e-16;
/// An error below so many times the setting, and below this, that does not fall by this factor when an interval is
/// halved is not one of interpolation but of the orbits, and further halves would not help. (A larger one may stay as
/// it is for some halves: states whose orbit has run round by a turn too many are off by the size of the orbit.)
const FLOOR: f64 = 1e3;
const LARGEST_FLOOR: f64 = 1e-5;
const FALLS: f64 = 0.5;
/// The orbits by which a panel is checked: where a polynomial through Chebyshev nodes is furthest off, short of the
/// edges, at which the orbit may be the separatrix or a point.
const CHECKS: [f64; 3] = [-0.980_785_280_403_230_4, 0.0, 0.980_785_280_403_230_4];

/// Starts of a panel from which the map is compared with orbits.
const COMPARED: usize = 8;
/// Radii of the ellipses on which there are more such starts, in standard deviations, and how many there are on each.
const ELLIPSES: [f64; 4] = [2.0, 4.0, 6.0, 8.0];
const ON_ELLIPSE: u32 = 32;

/// What a map is made from.
pub(super) struct Builder<'a, M> {
    /// The flow of the orbits from which the map is made.
    flow: Flow<M>,
    axis: Axis<M>,
    times: &'a [f64],
    critical: Option<f64>,
    settings: &'a Settings,
    basis: Basis,
    /// Starts of the cloud and the least eccentric points of their orbits, in the order of the latter.
    pilots: Vec<(f64, [f64; 2])>,
}

/// An interval, with the error of the last attempt to fit it, or to fit the interval of which it is a half.
#[derive(Debug, Clone, Copy)]
struct Tried {
    interval: (f64, f64),
    error: f64,
    /// The snapshot at which the error was found \[yr\].
    years: f64,
}

/// The outcome of an attempt to fit an interval.
enum Fit {
    Fitted { panel: Box<Panel>, passage_error: f64 },
    Unfitted { years: f64, error: f64 },
}

impl<'a, M: PlanarHamiltonian> Builder<'a, M> {
    /// Checks what is asked for.
    pub fn new(
        flow: Flow<M>,
        initial: &InitialGaussian,
        times: &'a [f64],
        critical: Option<f64>,
        settings: &'a Settings,
    ) -> Result<Self, Refused> {
        if !flow.model.eccentricity_follows_x1() {
            return Err(Refused::TurnsBack);
        }
        accuracy_for(settings.error, times[times.len() - 1])?;
        let axis = Axis::new(flow.model);
        let plan = SamplingPlan { draws: Draws::Sobol, seed: 1, replicates: std::num::NonZeroUsize::MIN };
        let polar = plan.polar(initial);
        let pilot = |number: usize| {
            let (phi, e) = polar(number);
            axis.orbit_of(State::from_polar(phi, e)).map(|q| (q, [phi, e]))
        };
        let mut pilots: Vec<(f64, [f64; 2])> = (0..PILOTS).into_par_iter().filter_map(pilot).collect();
        pilots.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        // A few hundred orbits may be as accurate as they can.
        Ok(Self {
            flow: Flow { accuracy: Accuracy::Fine, ..flow },
            axis,
            times,
            critical,
            settings,
            basis: Basis::of(2),
            pilots,
        })
    }

    /// Finds the panels.
    pub fn map(self, direct: Flow<M>, initial: &InitialGaussian) -> Result<AngleMap<M>, Refused> {
        let parts = self.axis.within(cloud_range(&self.flow.model, &Measure::new(*initial)));
        let special = self.axis.special_points(self.critical.unwrap_or(0.0));
        let cuts = parts.iter().flat_map(|&part| cut(part, &special));
        let mut level: Vec<Tried> = cuts.map(|interval| Tried { interval, error: f64::INFINITY, years: 0.0 }).collect();
        let mut panels: Vec<Panel> = Vec::new();
        let mut summary = Summary::empty();
        while !level.is_empty() {
            summary.orbits += level.len() * self.orbits_of_a_panel();
            let fits: Vec<Fit> = level.par_iter().map(|tried| self.fit(tried.interval)).collect();
            let mut bent = Vec::new();
            for (&Tried { interval, error: before, .. }, fit) in level.iter().zip(fits) {
                match fit {
                    Fit::Fitted { panel, passage_error } => {
                        summary.passage_error = summary.passage_error.max(passage_error);
                        summary.mapped += self.share(interval);
                        summary.coefficients += panel.patches.iter().map(Patch::len).sum::<usize>();
                        panels.push(*panel);
                    }
                    Fit::Unfitted { years, error } => bent.push((Tried { interval, years, error }, before)),
                }
            }
            level = self.halve(bent, &mut summary);
        }
        panels.sort_by(|a, b| a.low.total_cmp(&b.low));
        summary.cells = panels.len();
        summary.check(self.settings)?;
        let starts = self.starts_to_compare(&panels, initial);
        let (axis, times, critical) = (self.axis, self.times.to_vec(), self.critical);
        let mut map = AngleMap { flow: direct, axis, times, critical, panels, summary };
        map.summary.orbits += starts.len();
        map.summary.error = map.off(self.flow, &starts);
        Ok(map)
    }

    /// Starts from which the map is compared with orbits: in each panel some of the cloud's, from the first to the last
    /// in the order of their orbits, and points on ellipses about the mean, out to where hardly any start lies.
    fn starts_to_compare(&self, panels: &[Panel], initial: &InitialGaussian) -> Vec<State> {
        let of_panel = |panel: &Panel| {
            let pilots = self.pilots_in((panel.low, panel.high));
            let number = COMPARED.min(pilots.len());
            let pick = move |k: usize| pilots[k * (pilots.len() - 1) / (number - 1).max(1)].1;
            (0..number).map(pick).collect::<Vec<_>>()
        };
        let on_ellipses = ELLIPSES.into_iter().flat_map(|radius| {
            (0..ON_ELLIPSE).map(move |k| {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(ON_ELLIPSE)).sin_cos();
                initial.point(radius * cos, radius * sin).into()
            })
        });
        let starts = panels.iter().flat_map(of_panel).chain(on_ellipses);
        starts.filter(|[_, e]| *e > 0.0 && *e < 1.0).map(|[phi, e]| State::from_polar(phi, e)).collect()
    }

    fn orbits_of_a_panel(&self) -> usize {
        self.basis.count + CHECKS.len()
    }

    /// The pilots whose orbits lie in an interval.
    fn pilots_in(&self, (low, high): (f64, f64)) -> &[(f64, [f64; 2])] {
        let before = |end: f64| self.pilots.partition_point(|(q, _)| *q < end);
        &self.pilots[before(low)..before(high)]
    }

    fn share(&self, interval: (f64, f64)) -> f64 {
        self.pilots_in(interval).len() as f64 / PILOTS as f64
    }

    /// Halves the intervals that are worth it, the most probable first, as far as orbits are left; the others are given
    /// up. With each comes the error before it was halved last.
    fn halve(&self, mut bent: Vec<(Tried, f64)>, summary: &mut Summary) -> Vec<Tried> {
        let share = |tried: &Tried| self.share(tried.interval);
        bent.sort_by(|(a, _), (b, _)| share(b).total_cmp(&share(a)).then(a.interval.0.total_cmp(&b.interval.0)));
        let mut left = self.settings.most_orbits.saturating_sub(summary.orbits);
        let mut halves = Vec::new();
        for (tried, before) in bent {
            let Tried { interval: (low, high), years, error } = tried;
            let (pilots, cost) = (self.pilots_in((low, high)), 2 * self.orbits_of_a_panel());
            let (share, middle) = (share(&tried), low.midpoint(high));
            let is_wide = high - low > 1e3 * f64::EPSILON;
            let floor = (FLOOR * self.settings.error).min(LARGEST_FLOOR);
            let may_fall = error > floor || error < FALLS * before;
            let is_worth_it = share > self.settings.smallest_share;
            if is_worth_it && cost <= left && is_wide && may_fall {
                left -= cost;
                halves.extend([(low, middle), (middle, high)].map(|interval| Tried { interval, ..tried }));
            } else if let Some((_, start)) = pilots.get(pilots.len() / 2)
                && summary.unresolved.is_none_or(|found| found.share < share)
            {
                let limit = match () {
                    () if !is_worth_it => Limit::Share,
                    () if is_wide && may_fall => Limit::Orbits,
                    () => Limit::NoGain,
                };
                let (place, cause) = (rounded_place(&VARIABLES, |k| start[k]), Cause::Bends { years, error });
                summary.unresolved = Some(Unresolved { place, share, cause, limit });
            }
        }
        halves
    }

    /// Follows the orbits of an interval half round and interpolates between them.
    fn fit(&self, (low, high): (f64, f64)) -> Fit {
        let unfitted = |years: f64, error: f64| Fit::Unfitted { years, error };
        let count = self.basis.count;
        let nodes = (0..count).map(|j| (PI * (j as f64 + 0.5) / count as f64).cos());
        let points: Vec<f64> = nodes.chain(CHECKS).map(|a| low.midpoint(high) + 0.5 * (high - low) * a).collect();
        let traced = Contour::trace(&self.flow, &points);
        let Some(orbits) = traced.iter().map(Option::as_ref).collect::<Option<Vec<&Contour>>>() else {
            return unfitted(0.0, f64::INFINITY);
        };
        let (nodes, checks) = orbits.split_at(count);
        let checks: Vec<(f64, &Contour)> = CHECKS.into_iter().zip(checks.iter().copied()).collect();
        let Some(patches) = self.patches(nodes) else { return unfitted(0.0, f64::INFINITY) };
        let mut half: Vec<f64> = nodes.iter().map(|orbit| orbit.half).collect();
        self.basis.transform::<1>(&mut half);
        let half: [f64; MOST_NODES] = std::array::from_fn(|k| half.get(k).copied().unwrap_or(0.0));
        let (rise, passage_error) =
            self.critical.map_or((Rise::Never, 0.0), |critical| rise_of(&self.basis, nodes, &checks, critical));
        let panel = Panel { low, high, half, patches, rise };
        match self.checked(&panel, &checks) {
            Ok(()) => Fit::Fitted { panel: Box::new(panel), passage_error },
            Err((years, error)) => unfitted(years, error),
        }
    }

    /// The patches of half a period, as many as the orbits need along themselves.
    fn patches(&self, nodes: &[&Contour]) -> Option<Vec<Patch>> {
        let (mut parts, mut before) = (1, f64::INFINITY);
        while parts <= MOST_PARTS {
            let columns: Vec<[Vec<f64>; 2]> =
                (0..parts).map(|part| patch_of(&self.basis, nodes, part, parts)).collect();
            let tail = |column: &Vec<f64>| self.basis.tails::<2>(column)[1].next;
            let worst = columns.iter().flatten().map(tail).fold(0.0, f64::max);
            let is_at_the_floor = worst <= SHARE_ALONG * self.settings.error && worst > FALLS * before;
            if worst <= ALONG || is_at_the_floor {
                let patch = |columns: &[Vec<f64>; 2]| {
                    Patch::new(&self.basis, columns.each_ref().map(Vec::as_slice), NEGLIGIBLE)
                };
                return Some(columns.iter().map(patch).collect());
            }
            (parts, before) = (2 * parts, worst);
        }
        None
    }

    /// Whether the map is good for states on orbits that it was not made from, at all snapshots; else the first
    /// snapshot at which it is off by too much, and by how much.
    fn checked(&self, panel: &Panel, checks: &[(f64, &Contour)]) -> Result<(), (f64, f64)> {
        let parts = panel.patches.len();
        for &(a, orbit) in checks {
            let q = panel.low.midpoint(panel.high) + 0.5 * (panel.high - panel.low) * a;
            for step in 0..=2 * parts {
                let theta = step as f64 / (2 * parts) as f64 * orbit.half;
                let found = panel.locate(orbit.at(theta), q);
                for &time in self.times {
                    let error = found.map_or(f64::INFINITY, |spot: Spot| {
                        let there = panel.state(panel.later(spot, time));
                        let right = orbit.at(orbit.wrap(theta + angle_of(time)));
                        (there.x1 - right.x1).abs().max((there.x2 - right.x2).abs())
                    });
                    if error.is_nan() || error > self.settings.error {
                        return Err((time, error));
                    }
                }
            }
        }
        Ok(())
    }
}

/// An interval, cut at the special points in it.
fn cut((low, high): (f64, f64), special: &[f64]) -> Vec<(f64, f64)> {
    let mut ends = vec![low];
    ends.extend(special.iter().copied().filter(|&q| low < q && q < high));
    ends.push(high);
    ends.windows(2).map(|pair| (pair[0], pair[1])).collect()
}
