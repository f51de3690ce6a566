//! A Gaussian over solar angle, eccentricity, inclination and node, carried by the cubature rule of degree 3
//! (Arasaratnam & Haykin, IEEE Trans. Autom. Control 54(6), 2009): `2n` points at `sqrt(n)` standard deviations along
//! the columns of a square root of the covariance, all of the same weight. Orbits move in the eccentricity vector `e`
//! and the angular momentum vector `h` (docs/models.md) by Runge-Kutta steps.
use std::f64::consts::{PI, TAU};

use density::model::vectorial::Vectorial;
use kit::{Assignment, Failure, Form, Propagator};
use messages::content::Mixture;

type Vector = [f64; 3];
type Orbit = [Vector; 2]; // e and h

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
/// The sum of vectors, each times a number.
fn sum<const N: usize>(terms: [(f64, Vector); N]) -> Vector {
    std::array::from_fn(|k| terms.iter().map(|(factor, vector)| factor * vector[k]).sum())
}

/// `e' = n_sun (e × ∂H/∂h + h × ∂H/∂e)` and `h' = n_sun (h × ∂H/∂h + e × ∂H/∂e)` (Tremaine, Touma & Namouni 2009)
/// \[1/yr\].
fn rate(model: &Vectorial, time: f64, [e, h]: Orbit) -> Orbit {
    let Vectorial { forces, obliquity, sun_longitude } = *model;
    let (c, w, a, b) = (forces.force.radiation, forces.force.oblateness, forces.sun, forces.moon);
    let (sin_l, cos_l) = (TAU * time + sun_longitude).sin_cos();
    let s = [cos_l, sin_l * obliquity.cos(), sin_l * obliquity.sin()];
    let (k, p) = ([0.0, -obliquity.sin(), obliquity.cos()], [0.0, 0.0, 1.0]);
    let (h2, z) = (dot(h, h), h[2]);
    let by_e = sum([(c + 10.0 * a * dot(e, s), s), (b - 4.0 * a, e), (-5.0 * b * dot(e, k), k)]);
    let along_h = w * (0.5 - 2.5 * z * z / h2) * h2.powf(-2.5) - b;
    let by_h = sum([(w * z * h2.powf(-2.5), p), (along_h, h), (-2.0 * a * dot(h, s), s), (b * dot(h, k), k)]);
    [sum([(TAU, cross(e, by_h)), (TAU, cross(h, by_e))]), sum([(TAU, cross(h, by_h)), (TAU, cross(e, by_e))])]
}

/// One step of the classical Runge-Kutta method.
fn step(model: &Vectorial, time: f64, orbit: Orbit, length: f64) -> Orbit {
    let at = |rate: Orbit, share: f64| [0, 1].map(|i| sum([(1.0, orbit[i]), (share * length, rate[i])]));
    let first = rate(model, time, orbit);
    let second = rate(model, time + length / 2.0, at(first, 0.5));
    let third = rate(model, time + length / 2.0, at(second, 0.5));
    let fourth = rate(model, time + length, at(third, 1.0));
    [0, 1].map(|i| {
        let mean = sum([(1.0, first[i]), (2.0, second[i]), (2.0, third[i]), (1.0, fourth[i])]);
        sum([(1.0, orbit[i]), (length / 6.0, mean)])
    })
}

/// The vectors of an orbit; `l` is the longitude of the Sun.
fn vectors([phi, e, i, node]: [f64; 4], l: f64) -> Orbit {
    let normal = [node.sin() * i.sin(), -node.cos() * i.sin(), i.cos()];
    let to_node = [node.cos(), node.sin(), 0.0];
    let argument = phi + l - node;
    let to_pericentre = sum([(argument.cos(), to_node), (argument.sin(), cross(normal, to_node))]);
    [sum([(e, to_pericentre)]), sum([((1.0 - e * e).sqrt(), normal)])]
}

/// Solar angle, eccentricity, inclination and node of an orbit.
fn variables([e, h]: Orbit, l: f64) -> [f64; 4] {
    let node = h[0].atan2(-h[1]);
    let to_node = [node.cos(), node.sin(), 0.0];
    let argument = (dot(e, cross(h, to_node)) / dot(h, h).sqrt()).atan2(dot(e, to_node));
    [node + argument - l, dot(e, e).sqrt(), h[0].hypot(h[1]).atan2(h[2]), node]
}

/// An angle within half a turn of another.
fn nearest(angle: f64, other: f64) -> f64 {
    other + (angle - other + PI).rem_euclid(TAU) - PI
}

/// The model, the snapshot times, the time that has been reached, and the points.
struct Cubature(Option<(Vectorial, Vec<f64>, f64, Vec<Orbit>)>);

impl Propagator for Cubature {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let refuse = |why: &str| Failure::Refused(why.into());
        let problem = assignment.in_space.as_ref().ok_or_else(|| refuse("it takes scenarios in space alone"))?;
        let (Some(model), None) = (problem.model.if_averaged(), problem.spread) else {
            return Err(refuse("it takes the averaged model in space, with a certain radiation parameter"));
        };
        let gaussian = problem.initial.gaussian().map_err(|why| refuse(&why.to_string()))?;
        let point =
            |k: usize| gaussian.point(std::array::from_fn(|j| if j == k / 2 { [2.0, -2.0][k % 2] } else { 0.0 }));
        let points = (0..8).map(|k| vectors(point(k), model.sun_longitude)).collect();
        self.0 = Some((model, problem.times.clone(), 0.0, points));
        Ok(Form::whole(Mixture::UNJUDGED, 1))
    }
    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let (model, times, now, points) = self.0.as_mut().ok_or_else(Failure::no_scenario)?;
        let steps = (1000.0 * (times[index] - *now)).ceil().max(1.0);
        let length = (times[index] - *now) / steps;
        for orbit in points.iter_mut() {
            for k in 0..steps as u32 {
                *orbit = step(model, *now + length * f64::from(k), *orbit, length);
                // Where an orbit comes to e = 1 the model ends: it is a line, which a step may lead over.
                if dot(orbit[1], orbit[1]).is_nan() || dot(orbit[1], orbit[1]) < 1e-3 {
                    return Err(Failure::Refused("an orbit comes too near to e = 1".into()));
                }
            }
        }
        *now = times[index];
        Ok(1)
    }
    fn write(&self, columns: &mut [f64]) {
        let Some((model, _, now, points)) = &self.0 else { return };
        let all: Vec<[f64; 4]> = points.iter().map(|p| variables(*p, TAU * now + model.sun_longitude)).collect();
        let off = |point: &[f64; 4], k: usize| match k {
            0 | 3 => nearest(point[k], all[0][k]) - all[0][k],
            _ => point[k] - all[0][k],
        };
        let mean = |f: &dyn Fn(&[f64; 4]) -> f64| all.iter().map(f).sum::<f64>() / all.len() as f64;
        let shift: [f64; 4] = std::array::from_fn(|k| mean(&|point| off(point, k)));
        columns[0] = 1.0;
        (0..4).for_each(|k| columns[1 + k] = all[0][k] + shift[k]);
        let pairs = (0..4).flat_map(|a| (a..4).map(move |b| (a, b)));
        let covariance = |(a, b)| mean(&|point| (off(point, a) - shift[a]) * (off(point, b) - shift[b]));
        columns[5..].iter_mut().zip(pairs.map(covariance)).for_each(|(column, value)| *column = value);
    }
}

fn main() -> std::process::ExitCode {
    kit::main(Cubature(None))
}
