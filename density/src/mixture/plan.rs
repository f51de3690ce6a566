//! Which lattice a problem needs: a look ahead with a few hundred pilot points.
//!
//! A pilot lattice of spacing 0.5 is carried through all snapshots. At each of its nodes the nine points around it give the
//! first and second derivatives of the flow map, from which the disagreement `D` of [`super::linearity`] follows for a component
//! of any width and orientation:
//!
//! ```text
//! a_i = d_i ∂x/∂p_i,   b_i = ½ d_i² ∂²x/∂p_i²,   d_i the spacing along direction i
//! ```
//!
//! without propagating anything again. The twist `d_1 d_2 ∂²x/∂p_1∂p_2`, which sigma points on the axes do not see, is added as a
//! third bend. The plan is the lattice with the fewest points whose `D` is below the tolerance at
//! every snapshot; if that is more than allowed, the lattice with the least `D` among those that are allowed.
//!
//! One lattice serves the whole cloud and all snapshots. Refining only where the flow bends would save points, but breaks the
//! lattice: splitting a component again by a small library costs two to four times the components that an even lattice of the
//! same width has, and its sigma points are its own, five times as many. The lattice won at every snapshot of the three scenarios.

use std::f64::consts::{FRAC_PI_2, PI};

use super::MixtureError;
use super::lattice::Lattice;
use super::linearity::{Bends, RESOLUTION};
use super::split::{Axes, is_inside, state};
use super::unscented::Unscented;
use crate::angle::nearest;
use crate::dynamics::State;
use crate::estimate::weighted_moments;
use crate::flow::Flow;
use crate::problem::{InitialGaussian, Problem};

/// Spacing of the pilot lattice \[standard deviations\].
const PILOT_SPACING: f64 = 0.5;
/// Nodes of the pilot lattice along a half axis: it ends at three standard deviations, where the weight is 1 %.
const PILOT_NODES: i32 = 6;
/// Fewest points to plan with: those of the pilot and of a coarse lattice.
const LEAST_POINTS: usize = 600;
/// Orientations tried in a quarter turn.
const ORIENTATIONS: u32 = 6;
/// Spacings tried, each a sixth of an octave below the last.
const SPACINGS: i32 = 40;
/// The widest spacing tried \[standard deviations\].
const WIDEST: f64 = 0.6;

/// What a plan may cost and what it has to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// Largest disagreement `D`, twist included, that the plan allows at any snapshot.
    pub tolerance: f64,
    /// Most sigma points, those of the pilot included.
    pub sigma_points: usize,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self { tolerance: 0.15, sigma_points: 5000 }
    }
}

/// A lattice, and what it is expected to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The lattice.
    pub lattice: Lattice,
    /// The largest disagreement `D`, twist included, expected at any snapshot.
    pub disagreement: f64,
    /// Points that were propagated to find out.
    pub pilot_points: usize,
}

/// Plans the lattice of a problem.
///
/// # Errors
/// [`MixtureError::Plan`] if there is no room, [`MixtureError::NothingInside`], [`MixtureError::Escaped`].
pub fn plan(problem: &Problem, flow: &Flow, unscented: &Unscented, adaptive: &Adaptive) -> Result<Plan, MixtureError> {
    let Adaptive { tolerance, sigma_points } = *adaptive;
    if sigma_points < LEAST_POINTS || tolerance.is_nan() || tolerance <= 0.0 {
        return Err(MixtureError::Plan { tolerance, points: sigma_points, least: LEAST_POINTS });
    }
    let pilot = Pilot::fly(problem, flow)?;
    let room = (sigma_points - pilot.points) as f64;
    let widest = WIDEST.min(0.9 * Lattice::spacing_limit(unscented));
    let spacing = |k: i32| widest * (-f64::from(k) / 6.0).exp2();
    let mut best: Option<(Plan, f64)> = None;
    for orientation in 0..ORIENTATIONS {
        let angle = FRAC_PI_2 * f64::from(orientation) / f64::from(ORIENTATIONS);
        for (i, j) in (0..SPACINGS).flat_map(|i| (0..SPACINGS).map(move |j| (i, j))) {
            let lattice = Lattice { angle, spacing: [spacing(i), spacing(j)], ..Lattice::default() };
            let points = 1.02 * lattice.points(unscented);
            if points > room {
                continue;
            }
            let disagreement = pilot.disagreement(&lattice, unscented);
            let better = best.as_ref().is_none_or(|(plan, least)| {
                if disagreement <= tolerance && plan.disagreement <= tolerance {
                    points < *least
                } else {
                    disagreement < plan.disagreement
                }
            });
            if better {
                best = Some((Plan { lattice, disagreement, pilot_points: pilot.points }, points));
            }
        }
    }
    let refused = MixtureError::Plan { tolerance, points: sigma_points, least: LEAST_POINTS };
    best.map(|(plan, _)| plan).ok_or(refused)
}

/// The direction along which the flow bends the initial Gaussian most: its angle from the `phi` axis in standardised
/// coordinates, in `[0, π)`, and the points propagated to find it.
///
/// Vittaldev & Russell (2016, Eq. 5) measure the second difference of the flow along a direction. Here it is the second
/// difference over one standard deviation either side of the mean, in standard deviations of the linearly propagated cloud,
/// and the largest over the snapshots. Plain second differences would compare radians with eccentricities, and would call a
/// bend along the cloud as bad as one across it.
///
/// # Errors
/// [`MixtureError::NothingInside`], [`MixtureError::Escaped`].
pub fn strongest_nonlinearity(problem: &Problem, flow: &Flow) -> Result<(f64, usize), MixtureError> {
    const DIRECTIONS: u32 = 36;
    let axes = |k: u32| Axes::new(PI * f64::from(k) / f64::from(DIRECTIONS));
    let initial = &problem.initial;
    let offsets = (0..DIRECTIONS).flat_map(|k| [axes(k).point([1.0, 0.0]), axes(k).point([-1.0, 0.0])]);
    let placed: Option<Vec<State>> = [[0.0; 2]].into_iter().chain(offsets).map(|at| state(initial, at)).collect();
    let states = placed.ok_or(MixtureError::NothingInside)?;
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.iter().map(|state| (state.x1, state.x2)).unzip();
    let mut worst = [0.0f64; DIRECTIONS as usize];
    let mut now = 0.0;
    for &time in &problem.times {
        flow.advance(&mut x1, &mut x2, time - now)?;
        now = time;
        let at = |k: usize| State { x1: x1[k], x2: x2[k] };
        let one_sigma = Unscented { alpha: 1.0, beta: -1.0, eta: 0.0 };
        for k in 0..DIRECTIONS as usize {
            let perpendicular = (k + DIRECTIONS as usize / 2) % DIRECTIONS as usize;
            let pair = |k: usize| [at(1 + 2 * k), at(2 + 2 * k)];
            let ([a, b], [c, d]) = (pair(k), pair(perpendicular));
            let mut bends = Bends::new(&one_sigma, &[at(0), a, b, c, d]);
            bends.shifts[1] = [0.0; 2];
            worst[k] = worst[k].max(bends.disagreement([0.0; 2]));
        }
    }
    let strongest =
        (0..DIRECTIONS).max_by(|&a, &b| worst[a as usize].total_cmp(&worst[b as usize])).unwrap_or_default();
    Ok((PI * f64::from(strongest) / f64::from(DIRECTIONS), states.len()))
}

/// Derivatives of the flow map at the nodes of the pilot lattice.
struct Pilot {
    /// One list of nodes a snapshot.
    snapshots: Vec<Snapshot>,
    points: usize,
}

struct Snapshot {
    nodes: Vec<Node>,
    /// Square roots of the diagonal of `R`.
    resolution: [f64; 2],
}

/// Derivatives of `(phi, e)` by the standardised coordinates at a node.
struct Node {
    weight: f64,
    first: [[f64; 2]; 2],
    /// By `uu`, `uv`, `vv`.
    second: [[f64; 2]; 3],
}

impl Pilot {
    fn fly(problem: &Problem, flow: &Flow) -> Result<Self, MixtureError> {
        let (indices, states) = pilot_states(&problem.initial);
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.iter().map(|state| (state.x1, state.x2)).unzip();
        let mut now = 0.0;
        let mut snapshots = Vec::with_capacity(problem.times.len());
        for &time in &problem.times {
            flow.advance(&mut x1, &mut x2, time - now)?;
            now = time;
            let states: Vec<State> = x1.iter().zip(&x2).map(|(&x1, &x2)| State { x1, x2 }).collect();
            snapshots.push(Snapshot::new(&indices, &states));
        }
        if snapshots.iter().all(|snapshot| snapshot.nodes.is_empty()) {
            return Err(MixtureError::NothingInside);
        }
        Ok(Self { snapshots, points: states.len() })
    }

    /// The largest `D` of a lattice at any snapshot.
    fn disagreement(&self, lattice: &Lattice, unscented: &Unscented) -> f64 {
        self.snapshots.iter().map(|snapshot| snapshot.disagreement(lattice, unscented)).fold(0.0, f64::max)
    }
}

/// Where each node of the pilot lattice is in the list of points; nodes outside the domain are not.
type Indices = Vec<Vec<Option<usize>>>;

fn pilot_states(initial: &InitialGaussian) -> (Indices, Vec<State>) {
    let mut states = Vec::new();
    let edge = PILOT_NODES + 1;
    let radius = |i: i32, j: i32| i * i + j * j;
    let coordinate = |i: i32| PILOT_SPACING * f64::from(i);
    let mut place = |i: i32, j: i32| {
        let at = [coordinate(i), coordinate(j)];
        let wanted = radius(i, j) <= edge * edge + 1 && is_inside(initial, at);
        let state = state(initial, at).filter(|_| wanted)?;
        states.push(state);
        Some(states.len() - 1)
    };
    let indices = (-edge..=edge).map(|i| (-edge..=edge).map(|j| place(i, j)).collect()).collect();
    (indices, states)
}

impl Snapshot {
    fn new(indices: &Indices, states: &[State]) -> Self {
        let edge = PILOT_NODES as usize + 1;
        let weight = |i: usize, j: usize| {
            let square = |k: usize| (PILOT_SPACING * (k as f64 - edge as f64)).powi(2);
            (-0.5 * (square(i) + square(j))).exp()
        };
        let mut nodes = Vec::new();
        let (mut phi, mut e, mut weights) = (vec![], vec![], vec![]);
        for (i, j) in (0..=2 * edge).flat_map(|i| (0..=2 * edge).map(move |j| (i, j))) {
            let Some(centre) = indices[i][j].map(|k| states[k]) else { continue };
            phi.push(centre.solar_angle());
            e.push(centre.eccentricity());
            weights.push(weight(i, j));
            let around = |di: i32, dj: i32| {
                let (i, j) = (i.checked_add_signed(di as isize)?, j.checked_add_signed(dj as isize)?);
                indices.get(i)?.get(j).copied().flatten().map(|k| states[k])
            };
            nodes.extend(Node::new(weight(i, j), centre, around));
        }
        let (moments, _) = weighted_moments(&phi, &e, Some(&weights), 1.0);
        Self { nodes, resolution: [moments.std_phi, moments.std_e].map(|sigma| RESOLUTION * sigma) }
    }

    fn disagreement(&self, lattice: &Lattice, unscented: &Unscented) -> f64 {
        let axes = Axes::new(lattice.angle);
        let (p, r) = (axes.point([lattice.spacing[0], 0.0]), axes.point([0.0, lattice.spacing[1]]));
        let (sum, weight) = self.nodes.iter().fold((0.0, 0.0), |(sum, weight), node| {
            let bends = node.bends([p, r], unscented);
            let disagreement =
                bends.disagreement(self.resolution) + bends.length(node.twist([p, r], unscented), self.resolution);
            (sum + node.weight * disagreement, weight + node.weight)
        });
        sum / weight
    }
}

impl Node {
    /// `None` at the edge of the pilot lattice.
    fn new(weight: f64, centre: State, around: impl Fn(i32, i32) -> Option<State>) -> Option<Self> {
        let (phi, e) = (centre.solar_angle(), centre.eccentricity());
        let offset = |di: i32, dj: i32| {
            let state = around(di, dj)?;
            Some([nearest(state.solar_angle(), phi) - phi, state.eccentricity() - e])
        };
        let (right, left, up, down) = (offset(1, 0)?, offset(-1, 0)?, offset(0, 1)?, offset(0, -1)?);
        let corners = [offset(1, 1)?, offset(-1, -1)?, offset(1, -1)?, offset(-1, 1)?];
        let by = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
        let square = PILOT_SPACING * PILOT_SPACING;
        Some(Self {
            weight,
            first: [
                by(&|x| (right[x] - left[x]) / (2.0 * PILOT_SPACING)),
                by(&|x| (up[x] - down[x]) / (2.0 * PILOT_SPACING)),
            ],
            second: [
                by(&|x| (right[x] + left[x]) / square),
                by(&|x| (corners[0][x] + corners[1][x] - corners[2][x] - corners[3][x]) / (4.0 * square)),
                by(&|x| (up[x] + down[x]) / square),
            ],
        })
    }

    /// The twist `d_p d_r ∂²x/∂p∂r/(n + zeta)`, which sigma points on the axes do not see.
    fn twist(&self, [[pu, pv], [ru, rv]]: [[f64; 2]; 2], unscented: &Unscented) -> [f64; 2] {
        let share = 1.0 / unscented.distance_squared();
        [0, 1].map(|x| {
            share
                * (pu * ru * self.second[0][x] + (pu * rv + pv * ru) * self.second[1][x] + pv * rv * self.second[2][x])
        })
    }

    /// What sigma points at `steps` from the centre would show.
    fn bends(&self, steps: [[f64; 2]; 2], unscented: &Unscented) -> Bends {
        let share = 1.0 / unscented.distance_squared();
        let slope = |[u, v]: [f64; 2], x: usize| u * self.first[0][x] + v * self.first[1][x];
        let bend = |[u, v]: [f64; 2], x: usize| {
            0.5 * (u * u * self.second[0][x] + 2.0 * u * v * self.second[1][x] + v * v * self.second[2][x])
        };
        let covariance = |x: usize, y: usize| share * steps.iter().map(|&s| slope(s, x) * slope(s, y)).sum::<f64>();
        Bends {
            linear: [covariance(0, 0), covariance(0, 1), covariance(1, 1)],
            shifts: steps.map(|step| [share * bend(step, 0), share * bend(step, 1)]),
        }
    }
}
