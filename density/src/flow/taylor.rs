//! A batched Taylor-series integrator.
//!
//! A model supplies the Taylor coefficients of its orbits ([`Series`]); this module follows them. The step of each
//! orbit follows from its own last two coefficients (Jorba & Zou, Exp. Math. 14, 2005, Sect. 3.2) and is cut at the end
//! of the interval. Time is in the unit `1/n_sun`; an orbit runs backwards by negative steps.
//!
//! [`LANES`] orbits are processed at a time, one per SIMD lane. A lane whose orbit has arrived takes the next one, so
//! that no lane waits for the orbit with the most steps. A lane never looks at its neighbours, and every operation is a
//! correctly rounded IEEE one. So the result of an orbit is the same bytes whatever the other orbits, the thread or the
//! instruction set.

use multiversion::multiversion;

use super::accuracy::Accuracy;
use super::carry::{Batch, Carry, Crew, Loss, Step, Watch};
use super::step_size::radii;
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, LANES, Lanes, Model, Series, Task};

/// Largest number of coefficients of a series.
pub(crate) const MOST_COEFFICIENTS: usize = 19;
/// Number of steps that an orbit may take in any interval; for each year of the interval, `MOST_STEPS_A_YEAR` more. At
/// the default accuracy a year takes about fifteen steps. Next to `e = 1`, where oblateness turns orbits by `W/s⁴` per
/// unit of time, it takes proportionally more: 6e5 at `e = 0.99` and `W = 10`.
const MOST_STEPS: f64 = 10_000.0;
const MOST_STEPS_A_YEAR: f64 = 2e6;
/// An orbit is given up if the steps that it may still take would have to be longer than the last one by this factor.
const HASTE: f64 = 4.0;

impl Batch<'_, '_> {
    /// The state and the years of an orbit, if there is such an orbit.
    #[inline(always)]
    fn get<M: Model>(&self, orbit: usize) -> Option<(M::State<f64>, f64)> {
        let years = self.years.get(orbit).or(self.years.last())?;
        let is_there = self.columns.iter().all(|column| orbit < column.len());
        is_there.then(|| (Coordinates::from_fn(|k| self.columns[k][orbit]), *years))
    }

    #[inline(always)]
    fn set<M: Model>(&mut self, orbit: usize, state: M::State<f64>) {
        for (k, column) in self.columns.iter_mut().enumerate() {
            column[orbit] = state.component(k);
        }
    }
}

impl Task for Carry<'_, '_, '_> {
    type Output = Vec<(usize, Loss)>;

    fn with<M: Model>(self, model: &M) -> Self::Output {
        let Self { accuracy, batch, watch } = self;
        match accuracy {
            Accuracy::Coarse => advance::<12, M>(model, batch, 4e-8, watch),
            Accuracy::Medium => advance::<15, M>(model, batch, 3.5e-11, watch),
            Accuracy::Fine => advance::<MOST_COEFFICIENTS, M>(model, batch, 3.5e-14, watch),
        }
    }
}

/// Moves orbits with Taylor series of `P` coefficients; `tolerance` is the size at which the last terms are cut.
/// Returns the orbits that were lost and why, in no particular order; their states stay as they were. `watch` sees
/// every step.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn advance<const P: usize, M: Model>(
    model: &M,
    mut batch: Batch<'_, '_>,
    tolerance: f64,
    mut watch: Option<&mut dyn Watch>,
) -> Vec<(usize, Loss)> {
    let with_clearance = watch.as_ref().is_some_and(|watch| watch.sees_clearance());
    let reach = libm::pow(tolerance, 1.0 / (P - 1) as f64);
    let mut series = M::Series::<P>::new(model);
    let mut crew = Crew::new();
    let mut next = 0;
    for lane in 0..LANES {
        next += crew.board(lane, next, &mut series, &batch);
    }
    let mut lost = Vec::new();
    while crew.at_work > 0 {
        series.expand(with_clearance);
        let lengths = crew.take_steps(series.shorten(crew.planned(&radii(&series), reach)));
        if let Some(watch) = &mut watch {
            let coordinate = |k: usize| series.coordinate(k).as_slice();
            watch.see(&Step { coordinate: &coordinate, clearance: series.clearance(), lengths: &lengths, crew: &crew });
        }
        series.move_on(&crew.directed(&lengths));
        for (lane, &length) in lengths.iter().enumerate() {
            let is_inside = series.is_inside(lane);
            if crew.left[lane] > 0.0 && is_inside && !crew.is_stuck(lane, length, series.may_creep(lane)) {
                continue;
            }
            let Some(orbit) = crew.orbit[lane] else { continue };
            if !is_inside {
                lost.push((orbit, Loss::LeftTheDomain));
            } else if crew.left[lane] > 0.0 {
                lost.push((orbit, Loss::Stuck));
            } else {
                batch.set::<M>(orbit, state(&series, lane));
            }
            next += crew.board(lane, next, &mut series, &batch);
        }
    }
    lost
}

/// The state of a lane.
#[inline(always)]
fn state<const P: usize, S: Series<P>>(series: &S, lane: usize) -> <S::Model as Model>::State<f64> {
    Coordinates::from_fn(|k| series.coordinate(k)[0][lane])
}

impl Crew {
    fn new() -> Self {
        Self { orbit: [None; LANES], sign: [1.0; LANES], left: [0.0; LANES], steps: [0.0; LANES], at_work: LANES }
    }

    /// Puts the orbit `next` into a lane if there is such an orbit; otherwise the lane rests. Returns the number of
    /// orbits put in.
    #[inline(always)]
    fn board<const P: usize, S: Series<P>>(
        &mut self,
        lane: usize,
        next: usize,
        series: &mut S,
        batch: &Batch<'_, '_>,
    ) -> usize {
        let Some((state, years)) = batch.get::<S::Model>(next) else {
            (self.orbit[lane], self.left[lane]) = (None, 0.0);
            self.at_work -= 1;
            series.start(lane, Coordinates::from_fn(|_| 0.0), batch.from);
            series.head_for(lane, 0.0);
            return 0;
        };
        (self.orbit[lane], self.steps[lane]) = (Some(next), MOST_STEPS + MOST_STEPS_A_YEAR * years.abs());
        (self.sign[lane], self.left[lane]) = (years.signum(), SUN_MEAN_MOTION * years.abs());
        series.start(lane, state, batch.from);
        series.head_for(lane, years);
        1
    }

    /// The length of each lane's step, from the radius of its series and the time left.
    #[inline(always)]
    fn planned(&self, radii: &Lanes, reach: f64) -> Lanes {
        let mut step = [0.0; LANES];
        for l in 0..LANES {
            step[l] = (reach * radii[l]).min(self.left[l]);
        }
        step
    }

    /// Takes steps of these lengths, and returns them.
    #[inline(always)]
    fn take_steps(&mut self, steps: Lanes) -> Lanes {
        for ((left, rest), step) in self.left.iter_mut().zip(&mut self.steps).zip(&steps) {
            *left -= step;
            *rest -= 1.0;
        }
        steps
    }

    /// The steps of these lengths, negative in lanes that run backwards.
    #[inline(always)]
    fn directed(&self, lengths: &Lanes) -> Lanes {
        let mut steps = *lengths;
        for (step, sign) in steps.iter_mut().zip(&self.sign) {
            *step *= sign;
        }
        steps
    }

    /// Whether a lane's orbit makes no progress: it has no steps left, or the step taken is so short that the steps
    /// left would not take it to the end. So an orbit that turns a thousand times too fast is noticed at its first
    /// step, not after minutes.
    #[inline(always)]
    fn is_stuck(&self, lane: usize, step: f64, may_creep: bool) -> bool {
        self.left[lane] > HASTE * step * self.steps[lane] && !(may_creep && self.steps[lane] > 0.0)
    }
}
