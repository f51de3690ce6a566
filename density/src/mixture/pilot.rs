//! Derivatives of the flow map over the initial Gaussian, from a coarse lattice of orbits.
//!
//! The derivatives are central differences over the nine points around a node, half a standard deviation apart. They
//! are not the derivatives at the node but their mean over a component or more, which is what matters here. See
//! [`super::plan`] for their use.

use super::error::MixtureError;
use super::lattice::Lattice;
use super::linearity::{Bends, RESOLUTION};
use super::split::{Axes, is_inside, state};
use super::unscented::Unscented;
use crate::angle::nearest;
use crate::estimate::weighted_moments;
use crate::flow::Flow;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::problem::{InitialGaussian, Problem};

/// Spacing of the pilot lattice \[standard deviations\].
const PILOT_SPACING: f64 = 0.5;
/// Number of nodes of the pilot lattice along a half axis. It ends at three standard deviations, where the weight is 1
/// %.
const PILOT_NODES: i32 = 6;

/// Derivatives of the flow map at the nodes of the pilot lattice.
pub(super) struct Pilot {
    /// One list of nodes per snapshot.
    snapshots: Vec<Snapshot>,
    /// Number of points propagated.
    pub(super) points: usize,
}

struct Snapshot {
    nodes: Vec<Node>,
    /// Square roots of the diagonal of `R`.
    resolution: [f64; 2],
}

/// Derivatives of `(phi, e)` with respect to the standardised coordinates at a node.
struct Node {
    weight: f64,
    first: [[f64; 2]; 2],
    /// With respect to `uu`, `uv`, `vv`.
    second: [[f64; 2]; 3],
}

impl Pilot {
    /// Carries the pilot lattice through the snapshots of a problem.
    pub(super) fn fly<M: PlanarHamiltonian>(problem: &Problem<M>, flow: &Flow<M>) -> Result<Self, MixtureError> {
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
    pub(super) fn disagreement(&self, lattice: &Lattice, unscented: &Unscented) -> f64 {
        self.snapshots.iter().map(|snapshot| snapshot.disagreement(lattice, unscented)).fold(0.0, f64::max)
    }
}

/// Index of each node of the pilot lattice in the list of points; `None` for nodes outside `0 < e < 1`.
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

    /// The bends that sigma points at `steps` from the centre would show.
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
