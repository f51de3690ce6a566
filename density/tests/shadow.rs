//! The Earth's shadow: averages against a quadrature, limits, the unaveraged dynamics, and the density's equation.

use std::f64::consts::TAU;

use density::flow::{Accuracy, Flow, Passages};
use density::model::elements::{Elements, Vectors};
use density::model::osculating::Osculating;
use density::model::osculating::kepler::Motion;
use density::model::osculating::mean::{MeanOrbit, mean_orbit};
use density::model::planar::SrpJ2;
use density::model::shadow::{ShadowedOsculating, ShadowedVectorial};
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::model::{Model, ecliptic};
use nalgebra::SMatrix;

const AXIS: f64 = 2.5;

fn forces(radiation: f64) -> SunMoon {
    SunMoon::at(AXIS, SrpJ2 { radiation, oblateness: 0.409_204 })
}

fn averaged(radiation: f64) -> ShadowedVectorial {
    let model = Vectorial { forces: forces(radiation), obliquity: 0.409_092, sun_longitude: 0.7 };
    ShadowedVectorial { model, semi_major_axis: AXIS, reentry_radius: None }
}

fn unaveraged(radiation: f64) -> ShadowedOsculating {
    let Vectorial { forces, obliquity, sun_longitude } = averaged(radiation).model;
    let model = Osculating { semi_major_axis: AXIS, forces, obliquity, sun_longitude, moon_longitude: 0.3 };
    ShadowedOsculating { model, has_shadow: true, reentry_radius: None }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Rates of `e`, `h` and `ln a` by sunlight alone, in units of `n_sun C`: Gauss's equations integrated over the mean
/// anomaly with a satellite that is put on its ellipse by Kepler's equation, between edges that are found by halving.
/// Nothing of this is shared with the model but the definition of the shadow.
fn by_quadrature(motion: impl Fn(f64) -> ([f64; 3], [f64; 3]), h: [f64; 3], s: [f64; 3], radius: f64) -> [f64; 7] {
    const PIECES: usize = 40_000;
    let is_lit = |anomaly: f64| {
        let (r, _) = motion(anomaly);
        let toward = dot(r, s);
        toward >= 0.0 || dot(r, r) - toward * toward >= radius * radius
    };
    // a = mu = n = 1; the force is -s, and C n_sun = 1.5 of it.
    let rate = |anomaly: f64| -> [f64; 7] {
        let (r, v) = motion(anomaly);
        let force = s.map(|x| -x);
        let torque = cross(r, force);
        let (first, second) = (cross(force, h), cross(v, torque));
        let axis = 2.0 * dot(v, force);
        std::array::from_fn(|k| match k {
            0..3 => first[k] + second[k],
            3..6 => torque[k - 3] - 0.5 * axis * h[k - 3],
            _ => axis,
        })
    };
    let mut edges = vec![0.0];
    for piece in 0..PIECES {
        let [mut low, mut high] = [piece, piece + 1].map(|k| TAU * k as f64 / PIECES as f64);
        if is_lit(low) != is_lit(high) {
            let side = is_lit(low);
            while low.midpoint(high) > low && low.midpoint(high) < high {
                let middle = low.midpoint(high);
                if is_lit(middle) == side { low = middle } else { high = middle }
            }
            edges.push(low);
        }
    }
    edges.push(TAU);
    let mut sum = [0.0; 7];
    for ends in edges.windows(2).filter(|ends| is_lit(0.5 * (ends[0] + ends[1]))) {
        // Gauss's rule with three nodes in many pieces.
        let pieces = 4000;
        let width = (ends[1] - ends[0]) / f64::from(pieces);
        for piece in 0..pieces {
            let middle = ends[0] + width * (f64::from(piece) + 0.5);
            for (offset, weight) in [(-0.6f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6f64.sqrt(), 5.0 / 18.0)] {
                let rate = rate(middle + 0.5 * width * offset);
                sum.iter_mut().zip(rate).for_each(|(sum, rate)| *sum += weight * width * rate);
            }
        }
    }
    sum.map(|x| x / (TAU * 1.5))
}

#[test]
fn the_averages_over_a_revolution_are_those_of_a_quadrature_whether_the_shadow_is_deep_grazing_or_missed() {
    let model = averaged(0.15);
    let (mut dark, mut several) = (0, 0);
    // Circular, near it, moderate, next to the critical eccentricity 0.5925, and through the Earth.
    for eccentricity in [0.0, 1e-9, 0.145, 0.59, 0.8] {
        for (k, phi) in [0.1, 1.0, 2.2, std::f64::consts::PI, 4.5].into_iter().enumerate() {
            for inclination in [0.0, 0.3, 0.409, 1.3, 2.8] {
                let (time, node) = (0.13, 0.4 + f64::from(k as u8));
                let variables = [phi, eccentricity, inclination, node, 2.4];
                let state = model.state(time, variables);
                let h = [state[3], state[4], state[5]];
                let longitude = TAU * time + model.model.sun_longitude;
                let s = ecliptic::direction(longitude.sin_cos(), model.model.obliquity);
                let vectors =
                    Elements { eccentricity, inclination, node, longitude_of_pericentre: phi + longitude }.vectors();
                let motion = |mean_anomaly| Motion { axis: 1.0, vectors, mean_anomaly }.position_and_velocity();
                let expected = by_quadrature(motion, h, s, 1.0 / 2.4);
                let only_light = SunMoon { force: SrpJ2 { radiation: 0.15, oblateness: 0.0 }, sun: 0.0, moon: 0.0 };
                let lit = ShadowedVectorial { model: Vectorial { forces: only_light, ..model.model }, ..model };
                let found = lit.rate(time, state);
                let strength = 0.15 * (2.4f64 / AXIS).sqrt() * TAU;
                for n in 0..7 {
                    let expected = expected[n] * strength * if n == 6 { state[6] } else { 1.0 };
                    assert!((found[n] - expected).abs() < 2e-10, "{variables:?} {n}: {} {expected}", found[n]);
                }
                let stretches = model.dark(time, state).stretches().len();
                dark += usize::from(stretches > 0);
                several += usize::from(stretches > 1);
            }
        }
    }
    assert!(
        (40..120).contains(&dark) && several > 0,
        "{dark} of 125 orbits are in the shadow, {several} more than once"
    );
}

#[test]
fn an_orbit_that_misses_the_shadow_moves_as_without_it() {
    // Over the terminator, at a right angle to the Sun, for a tenth of a year.
    let model = averaged(0.05);
    let s = ecliptic::direction((model.model.sun_longitude).sin_cos(), model.model.obliquity);
    let inclination = s[2].acos();
    let node = s[0].atan2(-s[1]);
    let start = [1.0, 0.1, inclination, node, AXIS];
    let state = model.state(0.0, start);
    let end = Flow::new(model).carry_one(state, 0.0, 0.03).unwrap();
    let six = std::array::from_fn(|k| state[k]);
    let expected = Flow::new(model.model).carry_one(six, 0.0, 0.03).unwrap();
    assert!(model.dark(0.03, end).stretches().is_empty());
    assert_eq!(end[6], 1.0);
    for k in 0..6 {
        assert!((end[k] - expected[k]).abs() < 1e-12, "{k}: {} {}", end[k], expected[k]);
    }
    for (with, without) in model.rate(0.0, state).into_iter().zip(model.model.rate(0.0, six)) {
        assert!((with - without).abs() < 1e-14, "{with} {without}");
    }
}

/// Rate of the density by finite differences: how a small volume of the variables grows, and the measure `e sin(i)`.
#[test]
fn the_divergence_is_that_of_neighbouring_orbits() {
    let model = averaged(0.15);
    let flow = Flow::new(model);
    let start = [2.9, 0.3, 0.35, 0.4, 2.45];
    let (from, to) = (0.2, 0.21);
    assert!(!model.dark(from, model.state(from, start)).stretches().is_empty());
    let end = |variables: [f64; 5]| -> [f64; 5] {
        model.read_out(to, flow.carry_one(model.state(from, variables), from, to).unwrap())
    };
    let step = 1e-4;
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    for column in 0..5 {
        let moved = |by: f64| {
            let mut variables = start;
            variables[column] += by;
            end(variables)
        };
        let (ahead, behind) = (moved(step), moved(-step));
        (0..5).for_each(|row| matrix[(row, column)] = (ahead[row] - behind[row]) / (2.0 * step));
    }
    let measure = |[_, e, i, ..]: [f64; 5]| e * i.sin();
    let growth = matrix.determinant() * measure(end(start)) / measure(start);
    // Simpson's rule along the orbit.
    let divergence = |time: f64| {
        let state = flow.carry_one(model.state(from, start), from, time).unwrap();
        model.divergence(time, state)
    };
    let h = to - from;
    let integral = h / 6.0 * (divergence(from) + 4.0 * divergence(from + 0.5 * h) + divergence(to));
    assert!(integral.abs() > 1e-5, "the flow keeps no volume: {integral:e}");
    assert!((growth.ln() - integral).abs() < 1e-6 * integral.abs().max(1e-2), "{:e} {integral:e}", growth.ln());
    // Without the shadow it keeps the measure.
    let lit = model.model;
    let six = lit.state(from, [2.9, 0.3, 0.35, 0.4]);
    assert!(lit.divergence(from, six).abs() < 1e-9);
}

/// Vectors and semi-major axis of the averaged model and of the unaveraged one, averaged over a revolution, after a
/// while, where all forces are multiplied by a factor; and those of the averaged model without the shadow. The Moon is
/// left out: the averaged model also averages over the month.
fn ends(factor: f64) -> [[f64; 7]; 3] {
    const YEARS: f64 = 0.1;
    let SunMoon { force, sun, .. } = forces(0.15);
    let force = SrpJ2 { radiation: factor * force.radiation, oblateness: factor * force.oblateness };
    let forces = SunMoon { force, sun: factor * sun, moon: 0.0 };
    let (short, full) = (averaged(0.15), unaveraged(0.15));
    let short = ShadowedVectorial { model: Vectorial { forces, ..short.model }, ..short };
    let full = ShadowedOsculating { model: Osculating { forces, ..full.model }, ..full };
    let flow = Flow::new(full);
    let mean = |time: f64, state: [f64; 6]| -> [f64; 7] {
        let MeanOrbit { vectors: Vectors { e, h }, semi_major_axis } =
            mean_orbit(&flow, &full.model, time, state).unwrap();
        [e[0], e[1], e[2], h[0], h[1], h[2], semi_major_axis / AXIS]
    };
    let start = full.state(0.0, [2.9, 0.3, 0.4, 1.0, 0.5, AXIS]);
    let first = mean(0.0, start);
    let found = Flow::new(short).carry_one(first, 0.0, YEARS).unwrap();
    let six = std::array::from_fn(|k| first[k]);
    let lit = Flow::new(short.model).carry_one(six, 0.0, YEARS).unwrap();
    let lit = std::array::from_fn(|k| if k < 6 { lit[k] } else { first[6] });
    [found, mean(YEARS, flow.carry_one(start, 0.0, YEARS).unwrap()), lit]
}

fn apart(a: [f64; 7], b: [f64; 7]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

#[test]
fn the_averaged_model_follows_the_unaveraged_one_to_the_second_order_of_the_forces() {
    let (whole, quarter) = (ends(1.0), ends(0.25));
    let errors = [whole, quarter].map(|[found, expected, _]| apart(found, expected));
    assert!((errors[0] / errors[1]).log(4.0) > 1.7, "{errors:?}");
    // The shadow is worth much more than what averaging errs by.
    let [found, expected, lit] = whole;
    assert!(apart(lit, expected) > 10.0 * errors[0], "{found:?} {expected:?} {lit:?}");
}

#[test]
fn averaged_orbits_are_as_accurate_as_is_asked_for_through_all_seasons_of_the_shadow() {
    // In the equator, through the Earth, at high inclination, and circular at first.
    for (obliquity, inclination, radiation, e) in
        [(0.0, 0.0, 0.15, 0.145), (0.409, 0.0, 0.15, 0.145), (0.409, 1.2, 0.05, 0.1), (0.409, 0.6, 0.1, 0.0)]
    {
        let model = averaged(radiation);
        let model = ShadowedVectorial { model: Vectorial { obliquity, ..model.model }, ..model };
        let start = model.state(0.0, [2.2069, e, inclination, 0.5, AXIS]);
        let run = |accuracy, pieces: u32| {
            let flow = Flow { model, accuracy };
            let time = |k: u32| 2.0 * f64::from(k) / f64::from(pieces);
            (0..pieces).fold(start, |state, k| flow.carry_one(state, time(k), time(k + 1)).unwrap())
        };
        let fine = run(Accuracy::Fine, 1);
        assert!((fine[6] - 1.0).abs() > 1e-4, "it passes the shadow");
        let errors = [(Accuracy::Coarse, 1), (Accuracy::Medium, 1), (Accuracy::Fine, 300)];
        let errors = errors.map(|(accuracy, pieces)| apart(run(accuracy, pieces), fine));
        assert!(errors[0] < 1e-6 && errors[1] < 1e-9 && errors[2] < 1e-11, "{obliquity} {inclination}: {errors:?}");
        let back = Flow::new(model).carry_one(fine, 2.0, 0.0).unwrap();
        assert!(apart(back, start) < 1e-11);
    }
}

#[test]
fn an_unaveraged_orbit_comes_back_by_the_way_it_went_through_the_shadow() {
    let model = unaveraged(0.15);
    let start = model.state(0.1, [2.9, 0.3, 0.4, 1.0, 0.5, AXIS]);
    let there = Flow::new(model).carry_one(start, 0.1, 0.11).unwrap();
    let back = Flow::new(model).carry_one(there, 0.11, 0.1).unwrap();
    assert!(start.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-10), "{start:?} {back:?}");
    // The shadow has changed the orbit.
    let lit = Flow::new(model.model).carry_one(start, 0.1, 0.11).unwrap();
    assert!(there.iter().zip(lit).any(|(a, b)| (a - b).abs() > 1e-4));
}

#[test]
fn a_pericentre_at_the_reentry_height_is_noted_whatever_the_semi_major_axis_is_then() {
    // From two times the Earth's radius; the shadow changes the semi-major axis on the way.
    let radius = 1.05;
    let model = ShadowedVectorial { reentry_radius: Some(radius), ..averaged(0.15) };
    let start = [2.2069, 0.145, 0.2, 0.4, AXIS];
    let mut passages = [f64::NAN];
    let flow = Flow::new(model);
    let mut columns: Vec<[f64; 1]> = model.state(0.0, start).iter().map(|&x| [x]).collect();
    let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(|column| column.as_mut_slice()).collect();
    let note = |time: f64| time;
    passages[0] = -1.0;
    // Nothing happens in no time.
    flow.carry_watching(&mut slices, (0.0, 0.0), 0.5, Passages { passages: &mut passages, pending: -1.0, note: &note })
        .unwrap();
    assert_eq!(passages[0], -1.0);
    flow.carry_watching(&mut slices, (0.0, 1.0), 0.5, Passages { passages: &mut passages, pending: -1.0, note: &note })
        .unwrap();
    let [_, e, _, _, axis] =
        model.read_out(passages[0], flow.carry_one(model.state(0.0, start), 0.0, passages[0]).unwrap());
    assert!((axis * (1.0 - e) - radius).abs() < 1e-7, "{axis} {e} at {}", passages[0]);
    assert!((axis - AXIS).abs() > 1e-2);
}
