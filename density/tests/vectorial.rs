//! Tests of the averaged model in space: against orbits of another program, against the planar model, and of what it
//! keeps.

use std::f64::consts::TAU;

use density::flow::{Accuracy, Flow};
use density::model::Model;
use density::model::planar::SrpJ2;
use density::model::plane;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::{State, VARIABLES, Vectorial};

/// One row of the reference: an orbit's start and its state at a time.
struct Row {
    model: Vectorial,
    start: State,
    years: f64,
    end: State,
}

fn reference() -> Vec<Row> {
    let (head, rows) = include_str!("reference/vectorial-states.csv").split_once('\n').unwrap();
    let keys: Vec<&str> = head.trim_end().split(',').collect();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let text = |key: &str| fields[keys.iter().position(|known| *known == key).unwrap()];
        let of = |key: &str| text(key).trim().parse::<f64>().unwrap();
        let angle = |key: &str| of(key).to_radians();
        let force = SrpJ2 { radiation: of("C"), oblateness: of("W") };
        let (sun, moon) = if text("terms").contains("sun") { (of("A_sun"), of("B_moon")) } else { (0.0, 0.0) };
        let model = Vectorial {
            forces: SunMoon { force, sun, moon },
            obliquity: angle("obliquity_deg"),
            sun_longitude: angle("lambda_sun0_deg"),
        };
        let phi = angle("node0_deg") + angle("argument_of_pericentre0_deg") - model.sun_longitude;
        let start = model.state(0.0, [phi, of("e0"), angle("inclination0_deg"), angle("node0_deg")]);
        Row { model, start, years: of("t_yr"), end: ["e1", "e2", "e3", "h1", "h2", "h3"].map(of) }
    };
    rows.lines().map(row).collect()
}

fn apart(a: State, b: State) -> f64 {
    a.iter().zip(b).fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

#[test]
fn every_orbit_of_the_reference_is_reached_to_1e_10() {
    let rows = reference();
    assert_eq!(rows.len(), 48);
    for (k, Row { model, start, years, end }) in rows.into_iter().enumerate() {
        let found = Flow::new(model).carry_one(start, 0.0, years).unwrap();
        assert!(apart(found, end) < 1e-10, "row {k} at {years} yr: {:e}", apart(found, end));
        let back = Flow::new(model).carry_one(found, years, 0.0).unwrap();
        assert!(apart(back, start) < 1e-10, "row {k} back from {years} yr: {:e}", apart(back, start));
    }
}

const FORCES: SunMoon =
    SunMoon { force: SrpJ2 { radiation: 0.15, oblateness: 0.40921 }, sun: 4.762_24e-4, moon: 1.036_98e-3 };
const INCLINED: Vectorial = Vectorial { forces: FORCES, obliquity: 0.409_092, sun_longitude: 1.3 };

#[test]
fn without_obliquity_an_orbit_in_the_equator_moves_as_in_the_planar_model() {
    let model = Vectorial { obliquity: 0.0, ..INCLINED };
    for (phi, e) in [(2.2069, 0.145), (0.5419, 0.095), (0.3004, 0.23), (4.0, 0.5), (1.0, 0.0)] {
        for years in [0.5, 2.0, 10.0] {
            let planar = Flow::new(FORCES).advance_one(plane::State::from_polar(phi, e), years).unwrap();
            let in_space = Flow::new(model).carry_one(model.state(0.0, [phi, e, 0.0, 2.5]), 0.0, years).unwrap();
            let [found_phi, found_e, inclination, _] = model.read_out(years, in_space);
            let found = plane::State::from_polar(found_phi, found_e);
            let apart = (found.x1 - planar.x1).hypot(found.x2 - planar.x2);
            assert!(apart < 1e-10 && inclination < 1e-10, "{phi} {e} after {years} yr: {apart:e} {inclination:e}");
        }
    }
}

#[test]
fn the_rate_is_that_of_the_hamiltonian() {
    let time = 0.37;
    for variables in [[0.4, 0.3, 0.9, 2.0], [5.0, 0.7, 2.2, 0.1], [1.0, 1e-3, 1e-3, 4.0]] {
        let state = INCLINED.state(time, variables);
        let step = 1e-5;
        // The Hamiltonian is differentiated with respect to e and to h, each held free of the constraints.
        let slope = |k: usize| {
            let at =
                |by: f64| INCLINED.hamiltonian(time, std::array::from_fn(|j| state[j] + if j == k { by } else { 0.0 }));
            (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)
        };
        let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
        };
        let (e, h) = density::model::vectorial::vectors(state);
        let (by_e, by_h) = ([0, 1, 2].map(slope), [3, 4, 5].map(slope));
        let expected: State = std::array::from_fn(|k| {
            let (of_e, of_h) = if k < 3 { (by_h, by_e) } else { (by_e, by_h) };
            TAU * (cross(e, of_e)[k % 3] + cross(h, of_h)[k % 3])
        });
        let rate: State = INCLINED.rate(time, state);
        assert!(apart(rate, expected) < 1e-8, "{variables:?}: {rate:?} {expected:?}");
    }
}

#[test]
fn the_vectors_stay_perpendicular_and_of_unit_length_together_for_a_century() {
    for variables in [[0.4, 0.3, 0.9, 2.0], [5.0, 0.6, 2.2, 0.1], [2.2, 0.145, 0.0, 0.0]] {
        let start = INCLINED.state(0.0, variables);
        let end = Flow::new(INCLINED).carry_one(start, 0.0, 100.0).unwrap();
        for ((name, before), (_, after)) in INCLINED.conserved(0.0, start).iter().zip(INCLINED.conserved(100.0, end)) {
            assert!((after - before).abs() < 1e-12, "{name} from {variables:?}: {:e}", after - before);
        }
    }
}

#[test]
fn volume_in_the_variables_changes_by_the_measure_and_volume_in_the_vectors_is_kept() {
    let (from, to) = (0.25, 2.25);
    let flow = Flow::new(INCLINED);
    for variables in [[0.4, 0.3, 0.9, 2.0], [2.2, 0.145, 0.4, 3.0]] {
        let start = INCLINED.state(from, variables);
        let end = flow.carry_one(start, from, to).unwrap();
        let growth = INCLINED.density_growth(start, end).unwrap();
        let step = 1e-4;
        let column = |k: usize| {
            let at = |by: f64| {
                let moved = std::array::from_fn(|j| variables[j] + if j == k { by } else { 0.0 });
                INCLINED.read_out(to, flow.carry_one(INCLINED.state(from, moved), from, to).unwrap())
            };
            let [far, near, back, far_back] = [2.0, 1.0, -1.0, -2.0].map(|steps| at(steps * step));
            let turn = |a: f64, j: usize| {
                if VARIABLES[j].is_circle() { (a + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0 } else { a }
            };
            std::array::from_fn(|j| (8.0 * turn(near[j] - back[j], j) - turn(far[j] - far_back[j], j)) / (12.0 * step))
        };
        let columns: [[f64; 4]; 4] = [0, 1, 2, 3].map(column);
        let volume = nalgebra::Matrix4::from_fn(|j, k| columns[k][j]).determinant().abs();
        assert!((volume * growth - 1.0).abs() < 1e-7, "{variables:?}: {volume} {growth}");
        assert!(INCLINED.divergence(from, start).abs() < 1e-13);
    }
}

#[test]
fn the_levels_of_accuracy_hold_in_space() {
    for accuracy in Accuracy::ALL {
        for (k, Row { model, start, years, end }) in
            reference().into_iter().enumerate().filter(|(_, row)| row.years == 2.0)
        {
            let found = Flow { model, accuracy }.carry_one(start, 0.0, years).unwrap();
            let error = apart(found, end);
            assert!(error < accuracy.largest_error(), "row {k}, {accuracy:?}: {error:e}");
        }
    }
}
