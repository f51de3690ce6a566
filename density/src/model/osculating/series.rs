//! The Taylor series of many orbits of the unaveraged model, expanded by its recurrence ([`super::recurrence`]).
//!
//! Half of the lanes are expanded at a time, so that their coefficients stay in the first cache.

use super::recurrence::{Block, Constants, clearance};
use super::{Osculating, State, halves};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::part::WIDTH;
use crate::model::{LANES, Lanes, Model, Series};

/// Taylor coefficients of [`LANES`] orbits.
#[derive(Debug)]
pub struct OsculatingSeries<const P: usize> {
    model: Osculating,
    constants: Constants,
    blocks: [Block<P>; LANES / WIDTH],
    /// Time of each lane \[yr\].
    time: Lanes,
    state: [Aligned<P>; 6],
    clearance: Aligned<P>,
    /// See [`Self::watch_height`].
    reentry_radius: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Aligned<const P: usize>([Lanes; P]);

impl<const P: usize> OsculatingSeries<P> {
    /// Puts the Sun and the Moon where they are at a lane's time.
    #[inline(always)]
    fn place_bodies(&mut self, lane: usize) {
        let block = &mut self.blocks[lane / WIDTH];
        for (own, body) in block.bodies.iter_mut().zip(&self.constants.bodies) {
            let longitude = body.longitude(self.time[lane]);
            own.cos[0][lane % WIDTH] = libm::cos(longitude);
            own.sin[0][lane % WIDTH] = libm::sin(longitude);
        }
    }

    /// Gives a lane a radiation parameter of its own.
    #[inline(always)]
    pub(crate) fn irradiate(&mut self, lane: usize, radiation: f64) {
        self.blocks[lane / WIDTH].pressure[lane % WIDTH] = self.model.pressure_of(radiation);
    }

    /// Lets the clearance be that of the pericentre's height ([`super::above_pericentre`]).
    pub(in crate::model) fn watch_height(&mut self, reentry_radius: Option<f64>) {
        self.reentry_radius = reentry_radius;
    }

    #[inline(always)]
    fn state_of(&self, lane: usize) -> State {
        std::array::from_fn(|k| self.state[k].0[0][lane])
    }
}

impl<const P: usize> Series<P> for OsculatingSeries<P> {
    type Model = Osculating;

    #[inline(always)]
    fn new(model: &Osculating) -> Self {
        let (sin_obliquity, cos_obliquity) = model.obliquity.sin_cos();
        let constants = Constants {
            pace: model.pace(),
            oblateness: model.oblateness(),
            bodies: model.bodies(),
            sin_obliquity,
            cos_obliquity,
        };
        let zero = Aligned([[0.0; LANES]; P]);
        let blocks = [Block::under_pressure(model.pressure()); LANES / WIDTH];
        let (time, state, clearance) = ([0.0; LANES], [zero; 6], zero);
        Self { model: *model, constants, blocks, time, state, clearance, reentry_radius: None }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, time: f64) {
        let (position, velocity) = halves(state);
        let block = &mut self.blocks[lane / WIDTH];
        for k in 0..3 {
            block.position[k][0][lane % WIDTH] = position[k];
            block.velocity[k][0][lane % WIDTH] = velocity[k];
        }
        for (coordinate, value) in self.state.iter_mut().zip(state) {
            coordinate.0[0][lane] = value;
        }
        self.time[lane] = time;
        self.place_bodies(lane);
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        for (b, block) in self.blocks.iter_mut().enumerate() {
            block.expand(&self.constants);
            let first = b * WIDTH;
            for (own, coordinate) in block.position.iter().chain(&block.velocity).zip(&mut self.state) {
                (0..P).for_each(|n| coordinate.0[n][first..first + WIDTH].copy_from_slice(&own[n]));
            }
            if with_clearance {
                let clearance = clearance(block, self.reentry_radius);
                (0..P).for_each(|n| self.clearance.0[n][first..first + WIDTH].copy_from_slice(&clearance[n]));
            }
        }
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        for (b, (block, steps)) in self.blocks.iter_mut().zip(steps.chunks_exact(WIDTH)).enumerate() {
            let both = block.position.iter_mut().chain(&mut block.velocity);
            for (x, coordinate) in both.zip(&mut self.state) {
                let mut sum = x[P - 1];
                for n in (0..P - 1).rev() {
                    for l in 0..WIDTH {
                        sum[l] = sum[l].mul_add(steps[l], x[n][l]);
                    }
                }
                x[0] = sum;
                coordinate.0[0][b * WIDTH..(b + 1) * WIDTH].copy_from_slice(&sum);
            }
        }
        for lane in 0..LANES {
            if steps[lane] != 0.0 {
                self.time[lane] += steps[lane] / SUN_MEAN_MOTION;
                self.place_bodies(lane);
            }
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.model.is_inside(self.state_of(lane))
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        &self.state[k].0
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.clearance.0
    }
}
