//! Averages over a revolution, with which averaged models are compared.

use std::f64::consts::TAU;

use super::kepler::Motion;
use super::{Osculating, halves};
use crate::flow::{Escaped, Flow};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::elements::Vectors;
use crate::model::vector::{Vector, plus, times};
use crate::model::{Coordinates, Model};

/// Number of instants of a revolution. What oscillates within it is a smooth function of the place on the ellipse, so
/// that the mean of equally spaced instants converges like `(e/(1 + sqrt(1 - e²)))^INSTANTS`.
const INSTANTS: u32 = 96;

/// The mean orbit at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanOrbit {
    /// Means of the eccentricity vector and of the angular momentum vector.
    pub vectors: Vectors,
    /// Mean of the semi-major axis \[Earth radii\].
    pub semi_major_axis: f64,
}

/// The mean orbit over one revolution centred on a time \[yr\], at which the satellite is in the given state. The first
/// six coordinates of the flow's states are those of the unaveraged model `nominal`.
///
/// # Errors
/// [`Escaped`] if the satellite cannot be followed.
pub fn mean_orbit<M: Model>(
    flow: &Flow<M>,
    nominal: &Osculating,
    time: f64,
    state: M::State<f64>,
) -> Result<MeanOrbit, Escaped> {
    let motion = |state: &M::State<f64>| {
        let (position, velocity) = halves(std::array::from_fn(|k| state.component(k)));
        Motion::of(position, velocity)
    };
    let period = TAU * motion(&state).axis.powf(1.5) / (SUN_MEAN_MOTION * nominal.pace());
    let step = period / f64::from(INSTANTS);
    let (mut at, mut state) = (time - 0.5 * period + 0.5 * step, state);
    state = flow.carry_one(state, time, at)?;
    let mut sums: (Vector<f64>, Vector<f64>, f64) = ([0.0; 3], [0.0; 3], 0.0);
    for k in 0..INSTANTS {
        let Motion { axis, vectors, .. } = motion(&state);
        sums = (plus(sums.0, vectors.e), plus(sums.1, vectors.h), sums.2 + axis);
        if k + 1 < INSTANTS {
            state = flow.carry_one(state, at, at + step)?;
            at += step;
        }
    }
    let share = 1.0 / f64::from(INSTANTS);
    let vectors = Vectors { e: times(sums.0, share), h: times(sums.1, share) };
    Ok(MeanOrbit { vectors, semi_major_axis: sums.2 * share * nominal.semi_major_axis })
}

/// Means of the eccentricity and angular momentum vectors of many orbits, each over one revolution centred on a time
/// \[yr\]. The first six columns are their states in the unaveraged model `nominal`. All are averaged over its nominal
/// period, from which theirs differ by a thousandth or so while the semi-major axis keeps its mean: that much of what
/// oscillates is left in the means.
///
/// # Errors
/// [`Escaped`] names the first orbit that cannot be followed.
pub fn mean_vectors<M: Model>(
    flow: &Flow<M>,
    nominal: &Osculating,
    time: f64,
    columns: &[Vec<f64>],
) -> Result<Vec<Vectors>, Escaped> {
    let step = TAU / (SUN_MEAN_MOTION * nominal.pace()) / f64::from(INSTANTS);
    let mut columns = columns.to_vec();
    let mut sums: Vec<(Vector<f64>, Vector<f64>)> = vec![([0.0; 3], [0.0; 3]); columns[0].len()];
    let mut now = time;
    for k in 0..INSTANTS {
        let at = time + step * (f64::from(k) + 0.5 - 0.5 * f64::from(INSTANTS));
        flow.carry(&mut columns.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>(), now, at)?;
        now = at;
        for (i, (e, h)) in sums.iter_mut().enumerate() {
            let (position, velocity) = halves(std::array::from_fn(|k| columns[k][i]));
            let Motion { vectors, .. } = Motion::of(position, velocity);
            (*e, *h) = (plus(*e, vectors.e), plus(*h, vectors.h));
        }
    }
    let share = 1.0 / f64::from(INSTANTS);
    Ok(sums.into_iter().map(|(e, h)| Vectors { e: times(e, share), h: times(h, share) }).collect())
}
