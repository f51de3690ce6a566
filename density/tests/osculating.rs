//! Tests of the unaveraged model: against orbits of another program, and of what its averages are.

use density::flow::Flow;
use density::model::Model;
use density::model::elements::Vectors;
use density::model::osculating::kepler::Motion;
use density::model::osculating::mean::{MeanOrbit, mean_orbit};
use density::model::osculating::{Osculating, State};
use density::model::planar::SrpJ2;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;

/// One row of the reference: an orbit's start, and its vectors and semi-major axis at a time.
struct Row {
    model: Osculating,
    start: State,
    years: f64,
    vectors: [f64; 6],
    axis: f64,
    position: [f64; 3],
}

fn reference() -> Vec<Row> {
    let (head, rows) = include_str!("reference/osculating-states.csv").split_once('\n').unwrap();
    let keys: Vec<&str> = head.trim_end().split(',').collect();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let text = |key: &str| fields[keys.iter().position(|known| *known == key).unwrap()];
        let of = |key: &str| text(key).trim().parse::<f64>().unwrap();
        let angle = |key: &str| of(key).to_radians();
        let axis = of("a_earth_radii");
        let oblateness = density::model::planar::force_from_orbit(axis, 0.0, 0.0).oblateness;
        let forces = SunMoon::at(axis, SrpJ2 { radiation: of("C"), oblateness });
        let with_third_bodies = text("forces").contains("sun+moon");
        let model = Osculating {
            semi_major_axis: axis,
            forces: if with_third_bodies { forces } else { SunMoon { sun: 0.0, moon: 0.0, ..forces } },
            obliquity: angle("obliquity_deg"),
            sun_longitude: angle("lambda_sun0_deg"),
            moon_longitude: angle("lambda_moon0_deg"),
        };
        let phi = angle("node0_deg") + angle("argument_of_pericentre0_deg") - model.sun_longitude;
        let elements = [phi, of("e0"), angle("inclination0_deg"), angle("node0_deg"), angle("mean_anomaly0_deg"), axis];
        Row {
            model,
            start: model.state(0.0, elements),
            years: of("t_yr"),
            vectors: ["e1", "e2", "e3", "h1", "h2", "h3"].map(of),
            axis: of("a"),
            position: ["x", "y", "z"].map(of),
        }
    };
    rows.lines().map(row).collect()
}

fn vectors(state: State) -> ([f64; 6], f64) {
    let [x, y, z, vx, vy, vz] = state;
    let Motion { axis, vectors, .. } = Motion::of([x, y, z], [vx, vy, vz]);
    let [e, h] = [vectors.e, vectors.h];
    ([e[0], e[1], e[2], h[0], h[1], h[2]], axis)
}

fn apart<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn every_orbit_of_the_reference_has_its_shape_and_orientation_to_1e_8_over_two_years() {
    let rows = reference();
    assert_eq!(rows.len(), 24);
    // The rows of an orbit follow each other in time.
    let (mut time, mut state) = (0.0, rows[0].start);
    for (k, row) in rows.into_iter().enumerate() {
        let Row { model, start, years, vectors: expected, axis, position } = row;
        if years <= time {
            (time, state) = (0.0, start);
        }
        state = Flow::new(model).carry_one(state, time, years).unwrap();
        time = years;
        let (found, found_axis) = vectors(state);
        let place: [f64; 3] = std::array::from_fn(|k| state[k] * model.semi_major_axis);
        assert!(apart(found, expected) < 1e-8, "row {k} at {years} yr: {:e}", apart(found, expected));
        assert!((found_axis * model.semi_major_axis - axis).abs() < 1e-8, "row {k} at {years} yr");
        assert!(apart(place, position) < 1e-5, "row {k} at {years} yr: {:e}", apart(place, position));
    }
}

/// Scenario 1's satellite, out of the plane.
fn satellite() -> Osculating {
    let forces = SunMoon::at(2.5, SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
    Osculating { semi_major_axis: 2.5, forces, obliquity: 0.409_092, sun_longitude: 1.3, moon_longitude: 0.7 }
}

#[test]
fn the_recurrence_moves_orbits_as_the_equations_say() {
    let model = satellite();
    let (time, step) = (0.3, 2e-7);
    for elements in [[0.4, 0.3, 0.9, 2.0, 1.0, 2.5], [5.0, 0.8, 2.2, 0.1, 3.0, 2.4]] {
        let state = model.state(time, elements);
        let at = |steps: f64| Flow::new(model).carry_one(state, time, time + steps * step).unwrap();
        let [far, near, back, far_back] = [2.0, 1.0, -1.0, -2.0].map(at);
        let quotient: State =
            std::array::from_fn(|k| (8.0 * (near[k] - back[k]) - (far[k] - far_back[k])) / (12.0 * step));
        let rate: State = model.rate(time, state);
        let size = rate.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        assert!(apart(quotient, rate) < 1e-8 * size, "{quotient:?} {rate:?}");
        assert!(model.divergence(time, state).abs() < 1e-9);
    }
}

/// How far the averaged model is from the mean orbit after a while, and the osculating orbit from the mean one, where
/// all forces are multiplied by a factor. The Moon is left out: the averaged model also averages over the month, which
/// makes a difference of the first order.
fn averaging_errors(factor: f64) -> (f64, f64) {
    const YEARS: f64 = 0.1;
    let whole = satellite();
    let SunMoon { force, sun, .. } = whole.forces;
    let force = SrpJ2 { radiation: factor * force.radiation, oblateness: factor * force.oblateness };
    let forces = SunMoon { force, sun: factor * sun, moon: 0.0 };
    let Osculating { obliquity, sun_longitude, .. } = whole;
    let averaged = Flow::new(Vectorial { forces, obliquity, sun_longitude });
    let flow = Flow::new(Osculating { forces, ..whole });
    let mean = |time: f64, state: State| -> [f64; 6] {
        let MeanOrbit { vectors: Vectors { e, h }, .. } = mean_orbit(&flow, &flow.model, time, state).unwrap();
        [e[0], e[1], e[2], h[0], h[1], h[2]]
    };
    let start = whole.state(0.0, [2.2, 0.3, 0.4, 1.0, 0.5, 2.5]);
    let end = flow.carry_one(start, 0.0, YEARS).unwrap();
    let expected = mean(YEARS, end);
    let found = averaged.carry_one(mean(0.0, start), 0.0, YEARS).unwrap();
    (apart(found, expected), apart(vectors(end).0, expected))
}

#[test]
fn the_averaged_model_errs_by_the_second_order_of_the_forces_and_oscillations_are_of_the_first() {
    let (whole, quarter) = (averaging_errors(1.0), averaging_errors(0.25));
    let orders = [whole.0 / quarter.0, whole.1 / quarter.1].map(|ratio| ratio.log(4.0));
    assert!(orders[0] > 1.7 && (orders[1] - 1.0).abs() < 0.3, "{whole:?} {quarter:?} {orders:?}");
}

#[test]
fn without_forces_the_mean_orbit_is_the_orbit_itself() {
    let forces = SunMoon { force: SrpJ2 { radiation: 0.0, oblateness: 0.0 }, sun: 0.0, moon: 0.0 };
    let model = Osculating { forces, ..satellite() };
    let start = model.state(0.0, [2.2, 0.7, 0.4, 1.0, 0.5, 2.5]);
    let later = Flow::new(model).carry_one(start, 0.0, 0.01).unwrap();
    let MeanOrbit { vectors: Vectors { e, h }, semi_major_axis } =
        mean_orbit(&Flow::new(model), &model, 0.01, later).unwrap();
    assert!(apart([e[0], e[1], e[2], h[0], h[1], h[2]], vectors(start).0) < 1e-12);
    assert!((semi_major_axis - 2.5).abs() < 1e-12);
}
