//! The plane: states, and what a planar Hamiltonian model states beyond every other model.
//!
//! The solar angle `phi` \[rad\] is the angle from the direction towards the Sun to the pericentre; `e` is the
//! eccentricity. In `x1 = e sin(phi)`, `x2 = e cos(phi)`, which are regular at `e = 0`, averaged motion in the plane
//! has a Hamiltonian `H(x1, x2)` that does not depend on time (Eq. 3 of Sun et al. 2022, after Krivov & Getino 1997):
//!
//! ```text
//! x1' = n_sun s ∂H/∂x2      x2' = -n_sun s ∂H/∂x1      s = sqrt(1 - e²)
//! ```
//!
//! So `H` is constant along every orbit, orbits are its contours, and the flow keeps the measure `dx1 dx2/s = e/s dphi
//! de`.

use std::f64::consts::TAU;
use std::fmt::Debug;

use super::coordinates::Coordinates;
use super::earth::SUN_MEAN_MOTION;
use super::parameter::Parameter;
use super::{Kind, Lanes, Model, Quantity, Series, Task, Variable, acceleration};
use crate::flow::carry::{Carry, Loss};
use crate::lanes::polar;

/// The variables of every planar model: solar angle and eccentricity.
pub const VARIABLES: [Variable; 2] = [
    Variable { name: "solar angle", symbol: "phi", unit: "rad", kind: Kind::Circle },
    Variable { name: "eccentricity", symbol: "e", unit: "", kind: Kind::Interval { low: 0.0, high: 1.0 } },
];

/// An orbit in coordinates that are regular at zero eccentricity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T = f64> {
    /// `e sin(phi)`.
    pub x1: T,
    /// `e cos(phi)`.
    pub x2: T,
}

impl State {
    /// The state at solar angle `phi` \[rad\] and eccentricity `e`.
    pub fn from_polar(phi: f64, e: f64) -> Self {
        let (sin, cos) = phi.sin_cos();
        Self { x1: e * sin, x2: e * cos }
    }

    /// Solar angle in `[0, 2π)` \[rad\].
    pub fn solar_angle(self) -> f64 {
        let phi = self.x1.atan2(self.x2);
        if phi < 0.0 { (phi + TAU).min(TAU.next_down()) } else { phi }
    }

    /// Eccentricity.
    pub fn eccentricity(self) -> f64 {
        (self.x1 * self.x1 + self.x2 * self.x2).sqrt()
    }
}

impl<T: Quantity> State<T> {
    /// `sqrt(1 - e²)`.
    pub fn s(self) -> T {
        (T::from(1.0) - self.x1 * self.x1 - self.x2 * self.x2).sqrt()
    }
}

impl<T: Copy> Coordinates<T> for State<T> {
    const COUNT: usize = 2;

    #[inline(always)]
    fn from_fn(mut component: impl FnMut(usize) -> T) -> Self {
        Self { x1: component(0), x2: component(1) }
    }

    #[inline(always)]
    fn component(&self, k: usize) -> T {
        [self.x1, self.x2][k]
    }
}

/// A planar model with a Hamiltonian: the capability that closed orbits, the exact density, meshes and phase portraits
/// need.
///
/// Every such model is a [`Model`] automatically: the variables, the range `e < 1`, the kept measure, the conserved
/// Hamiltonian and the mirror image in time are the same for all of them.
pub trait PlanarHamiltonian: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The Taylor series of the integrator, see [`Model::Series`].
    type Series<const P: usize>: Series<P, Model = Self>;

    /// Time derivatives of `(x1, x2)` \[1/yr\]. The mirror image `(-x1, x2)` moves in the same way with time reversed.
    fn motion<T: Quantity>(&self, state: State<T>) -> State<T>;

    /// The Hamiltonian, constant along every orbit.
    fn hamiltonian(&self, state: State) -> f64;

    /// Bounds of the Hamiltonian for solar angles \[rad\] and eccentricities between the given ends.
    fn hamiltonian_range(&self, phi: (f64, f64), e: (f64, f64)) -> (f64, f64);

    /// The model's parameters with their values, for checks and for printing.
    fn parameters(&self) -> Vec<(Parameter, f64)> {
        Vec::new()
    }

    /// Upper bound of `|e'|/(n_sun s)`: how strongly the eccentricity is driven.
    fn pull(&self) -> f64;

    /// Upper bound of the rate at which an orbit in a state turns by everything except the pull towards the Sun \[rad
    /// per radian of the Sun\].
    fn turning_rate(&self, state: State) -> f64;

    /// Whether the eccentricity of every orbit grows where `x1 > 0` and falls where `x1 < 0`: an orbit then passes
    /// every eccentricity once on its way up and once on its way down.
    fn eccentricity_follows_x1(&self) -> bool;

    /// Upper bound of the rate at which an orbit moves near a state, in the time unit `1/n_sun`.
    fn pace(&self, state: State) -> f64 {
        1.0 + self.pull() + self.turning_rate(state)
    }

    /// `dH/dx2` on the axis `x1 = 0`, at `x2 = q`.
    fn slope_on_axis(&self, q: f64) -> f64 {
        let state = State { x1: 0.0, x2: q };
        self.motion(state).x1 / (SUN_MEAN_MOTION * ((1.0 - q) * (1.0 + q)).sqrt())
    }

    /// Rates of solar angle and eccentricity \[per radian of the Sun\].
    fn polar_rates(&self, phi: f64, e: f64) -> (f64, f64) {
        let e = e.clamp(f64::MIN_POSITIVE, 1.0f64.next_down());
        let (sin, cos) = phi.sin_cos();
        let State { x1, x2 } = self.motion(State { x1: e * sin, x2: e * cos });
        ((x1 * cos - x2 * sin) / (SUN_MEAN_MOTION * e), (x1 * sin + x2 * cos) / SUN_MEAN_MOTION)
    }

    /// First and second time derivative of `e²` \[1/yr, 1/yr²\].
    fn eccentricity_squared_rates(&self, state: State) -> [f64; 2] {
        let (rate, bend) = (self.motion(state), acceleration(self, 0.0, state));
        let product = |a: State, b: State| a.x1 * b.x1 + a.x2 * b.x2;
        [2.0 * product(state, rate), 2.0 * (product(rate, rate) + product(state, bend))]
    }

    /// Points on the axis `phi = 0` or `π` where the flow stands still, ordered by `e cos(phi)`: the zeros of `dH/dx2`.
    /// (`e = 0` is a kink of the polar phase portrait. It is not an equilibrium of the flow unless the pull is zero.)
    fn stationary_points(&self) -> Vec<State> {
        let rate = |x2: f64| self.motion(State { x1: 0.0, x2 }).x1;
        let steps = 4000;
        let node = |i: usize| (f64::from(i as u32) / f64::from(steps as u32) * 2.0 - 1.0) * (1.0 - 1e-9);
        (0..steps)
            .filter(|&i| rate(node(i)).signum() != rate(node(i + 1)).signum())
            .map(|i| State { x1: 0.0, x2: zero_between(rate, node(i), node(i + 1)) })
            .collect()
    }

    /// Points where the flow stands still off that axis, of which each has its mirror image in the list.
    fn stationary_points_off_axis(&self) -> Vec<State> {
        Vec::new()
    }

    /// See [`Model::perform`].
    fn perform_in_plane<T: Task>(&self, task: T) -> T::Output {
        task.with(self)
    }

    /// See [`Model::carry`].
    fn carry_in_plane(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.perform_in_plane(orbits)
    }
}

impl<M: PlanarHamiltonian> Model for M {
    type State<T: Quantity> = State<T>;
    type Variables = [f64; 2];
    type Series<const P: usize> = <M as PlanarHamiltonian>::Series<P>;

    const VARIABLES: &'static [Variable] = &VARIABLES;
    const REENTRY: usize = 1;

    fn rate<T: Quantity>(&self, _: T, state: State<T>) -> State<T> {
        self.motion(state)
    }

    fn is_inside(&self, State { x1, x2 }: State) -> bool {
        x1 * x1 + x2 * x2 < 1.0
    }

    fn state(&self, _: f64, [phi, e]: [f64; 2]) -> State {
        State::from_polar(phi, e)
    }

    fn read_out(&self, _: f64, state: State) -> [f64; 2] {
        [state.solar_angle(), state.eccentricity()]
    }

    fn read_out_lanes(&self, _: f64, states: &[Lanes], variables: &mut [Lanes]) {
        let [angles, lengths] = variables else { return };
        polar(&states[0], &states[1], angles, lengths);
    }

    /// `s`, which falls as the eccentricity grows.
    fn clearance<T: Quantity>(&self, state: State<T>) -> T {
        state.s()
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        ((1.0 - critical) * (1.0 + critical)).sqrt()
    }

    fn density_growth(&self, start: State, end: State) -> Option<f64> {
        Some(density_growth(start, end))
    }

    fn conserved(&self, _: f64, state: State) -> Vec<(&'static str, f64)> {
        vec![("hamiltonian", self.hamiltonian(state))]
    }

    fn reversed(&self, State { x1, x2 }: State) -> Option<State> {
        Some(State { x1: -x1, x2 })
    }

    fn perform<T: Task>(&self, task: T) -> T::Output {
        self.perform_in_plane(task)
    }

    fn carry(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.carry_in_plane(orbits)
    }
}

/// Factor by which a density per unit `phi`-`e` area has changed after the flow carried it from `start` to `end`:
/// `n(end)/n(start) = [e_t/s_t] / [e_0/s_0]`.
///
/// The flow keeps the measure `e/s dphi de` (Eq. 3 is quasi-canonical), which is the integral of Eq. 8 with the
/// Jacobian `e` of the polar coordinates. The paper leaves that Jacobian out, see [`density_growth_without_jacobian`].
pub fn density_growth(start: State, end: State) -> f64 {
    density_growth_without_jacobian(start, end) * end.eccentricity() / start.eccentricity()
}

/// Like [`density_growth`], for a density per unit `x1`-`x2` area: `s_0/s_t`. Using it for densities per `phi`-`e` area
/// is the paper's first error (the `as-printed` mode reproduces it).
pub fn density_growth_without_jacobian(start: State, end: State) -> f64 {
    start.s() / end.s()
}

/// Bounds of the cosine of the angles between two given angles \[rad\].
pub fn cosine_range(from: f64, to: f64) -> (f64, f64) {
    let holds = |angle: f64| ((from - angle) / TAU).ceil() * TAU + angle <= to;
    let (a, b) = (from.cos(), to.cos());
    let low = if holds(std::f64::consts::PI) { -1.0 } else { a.min(b) };
    let high = if holds(0.0) { 1.0 } else { a.max(b) };
    (low, high)
}

/// The zero of `f` between two points at which its signs differ, to the last bit.
pub fn zero_between(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let sign = f(low).signum();
    while low.midpoint(high) != low && low.midpoint(high) != high {
        let middle = low.midpoint(high);
        if f(middle).signum() == sign { low = middle } else { high = middle }
    }
    low
}
