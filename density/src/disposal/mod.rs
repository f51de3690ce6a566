//! The questions of a disposal designer, for a planar model: can the satellite re-enter at all, how probable is it by
//! when, how strong must the radiation pressure be, and on what does the answer depend.
//!
//! All probabilities come from the exact first-passage curve ([`crate::first_passage::exact`]), with its error
//! estimates.

pub mod over_radiation;

use crate::exact::{Error, Estimated};
use crate::first_passage::exact::{MOST_ORBITS, curve};
use crate::flow::Flow;
use crate::model::PlanarHamiltonian;
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::parameter::Parameter;
use crate::model::plane::State;
use crate::model::registry::Planar;
use crate::problem::{InitialGaussian, Problem};

/// Whether an orbit that is circular at first ever reaches an eccentricity.
///
/// It moves along the contour of the Hamiltonian through `e = 0`. The contour meets the circle of every eccentricity on
/// its way, so it reaches `e` if on all circles up to there the Hamiltonian takes the value that it has at `e = 0`. On
/// a circle it is a polynomial of second degree in `cos(phi)`, whose range is known from three of its values.
pub fn is_reached_from_circular<M: PlanarHamiltonian>(model: &M, e: f64) -> bool {
    const CIRCLES: u32 = 20_000;
    let level = model.hamiltonian(State { x1: 0.0, x2: 0.0 });
    let meets = |e: f64| {
        let at = |x1: f64, x2: f64| model.hamiltonian(State { x1, x2 });
        let (ahead, aside, behind) = (at(0.0, e), at(e, 0.0), at(0.0, -e));
        let (h1, h2) = (0.5 * (ahead - behind), 0.5 * (ahead + behind) - aside);
        let turn = -h1 / (2.0 * h2);
        let inside = if turn.abs() < 1.0 { aside + h1 * turn + h2 * turn * turn } else { ahead };
        ahead.min(behind).min(inside) <= level && level <= ahead.max(behind).max(inside)
    };
    (1..=CIRCLES).all(|k| meets(e * f64::from(k) / f64::from(CIRCLES)))
}

/// The least radiation parameter with which an orbit that is circular at first reaches an eccentricity, all other
/// parameters being those of `model`; `None` if none up to 100 does. With radiation pressure and oblateness alone it is
/// `max |1 + W/3 - s - (W/3)/s³| / e` over `0 < e <= critical_e`, `s = sqrt(1 - e²)`.
pub fn required_radiation(model: &Planar, critical_e: f64) -> Option<f64> {
    const SMALLEST: f64 = 1e-12;
    let reaches = |radiation: f64| {
        model.with("radiation", radiation).is_ok_and(|model| is_reached_from_circular(&model, critical_e))
    };
    let (mut low, mut high) = (0.0, 100.0);
    if !reaches(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if reaches(middle) { high = middle } else { low = middle }
    }
    // Other forces may suffice; bisection comes near zero then.
    Some(if high < SMALLEST { 0.0 } else { high })
}

/// The probability that the satellite has re-entered by each of `times` \[yr\].
///
/// # Errors
/// [`Error`] if the model's orbits do not fit the exact method.
pub fn probabilities(problem: &Problem<Planar>, times: &[f64]) -> Result<Vec<Estimated>, Error> {
    curve(problem, &Flow::new(problem.model), times, MOST_ORBITS)
}

/// Times \[yr\] from the start to the last snapshot, close enough together for [`time_of`].
pub fn dense_times(end: f64) -> Vec<f64> {
    const STEPS: u32 = 400;
    (0..=STEPS).map(|k| end * f64::from(k) / f64::from(STEPS)).collect()
}

/// The first time \[yr\] by which a probability is reached, on a curve that is linear between its points; `None` if it
/// is not reached.
pub fn time_of(curve: &[(f64, f64)], probability: f64) -> Option<f64> {
    let first = curve.iter().position(|(_, p)| *p >= probability)?;
    let (time, p) = curve[first];
    match first.checked_sub(1).map(|before| curve[before]) {
        Some((before, below)) => Some(before + (time - before) * (probability - below) / (p - below)),
        None => Some(time),
    }
}

/// The least radiation parameter with which the probability of re-entry by the last snapshot is `probability`, all else
/// being that of `problem`: looked for between a tenth and ten times the present one; `None` if it is not there. A
/// tenth of it means that even less may do.
///
/// # Errors
/// As [`probabilities`].
pub fn radiation_for(problem: &Problem<Planar>, probability: f64) -> Result<Option<f64>, Error> {
    const STEPS: i32 = 16;
    let Some(now) = problem.model.value("radiation").filter(|radiation| *radiation > 0.0) else { return Ok(None) };
    let end = [problem.times.last().copied().unwrap_or(0.0)];
    let suffices = |radiation: f64| -> Result<bool, Error> {
        let Ok(model) = problem.model.with("radiation", radiation) else { return Ok(false) };
        match probabilities(&Problem { model, ..problem.clone() }, &end) {
            // So weak a pull that the exact method has no answer is not looked for.
            Err(Error::EccentricityTurnsBack { .. }) => Ok(false),
            found => Ok(found?[0].value >= probability),
        }
    };
    let factor = |k: i32| 10f64.powf(f64::from(k - STEPS / 2) / f64::from(STEPS / 2));
    let mut low = None;
    for k in 0..=STEPS {
        if suffices(now * factor(k))? {
            let Some(mut low) = low else { return Ok(Some(now * factor(k))) };
            let mut high = now * factor(k);
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if suffices(middle)? { high = middle } else { low = middle }
            }
            return Ok(Some(high));
        }
        low = Some(now * factor(k));
    }
    Ok(None)
}

/// The time \[yr\] after which an orbit is where it was; `None` if it does not come back within 1000 yr, or stands
/// still.
///
/// A closed orbit is symmetric about the axis `x1 = 0` and crosses it twice, once in each direction.
pub fn period<M: PlanarHamiltonian>(model: &M, start: State) -> Option<f64> {
    const MOST_YEARS: f64 = 1000.0;
    let flow = Flow::new(*model);
    let (mut state, mut now, mut first) = (start, 0.0, None);
    while now < MOST_YEARS {
        let step = 0.1 / (SUN_MEAN_MOTION * model.pace(state));
        let next = flow.advance_one(state, step).ok()?;
        // From below to above, so that both crossings are of the same kind.
        if state.x1 < 0.0 && next.x1 >= 0.0 {
            let (mut low, mut high) = (0.0, step);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if flow.advance_one(state, middle).ok()?.x1 < 0.0 { low = middle } else { high = middle }
            }
            match first {
                None => first = Some(now + high),
                Some(first) => return Some(now + high - first),
            }
        }
        (state, now) = (next, now + step);
    }
    None
}

/// What a small change of the problem does to the probability of re-entry by the last snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// What is changed, and by how much: `radiation + 1 %`.
    pub change: String,
    /// By how much the probability then differs.
    pub effect: f64,
}

/// The effect of each small change: one percent of a parameter, a tenth of a standard deviation of a mean, ten percent
/// of a standard deviation; the largest effect first.
///
/// # Errors
/// As [`probabilities`].
pub fn sensitivities(problem: &Problem<Planar>) -> Result<Vec<Sensitivity>, Error> {
    let end = [problem.times.last().copied().unwrap_or(0.0)];
    let probability = |problem: &Problem<Planar>| Ok::<f64, Error>(probabilities(problem, &end)?[0].value);
    let now = probability(problem)?;
    let mut found = Vec::new();
    for (change, changed) in changes(problem) {
        found.push(Sensitivity { change, effect: probability(&changed)? - now });
    }
    found.sort_by(|a, b| b.effect.abs().total_cmp(&a.effect.abs()));
    Ok(found)
}

/// Small changes of a problem, in words and done.
fn changes(problem: &Problem<Planar>) -> Vec<(String, Problem<Planar>)> {
    let acting = problem.model.parameters().into_iter().filter(|(_, value)| *value > 0.0);
    let of_parameter = |(parameter, value): (Parameter, f64)| {
        let model = problem.model.with(parameter.name, 1.01 * value).ok()?;
        Some((format!("{} {} + 1 %", parameter.name, parameter.symbol), Problem { model, ..problem.clone() }))
    };
    let initial = problem.initial;
    let of_initial = [
        ("mean phi + 0.1 sigma", InitialGaussian { mean_phi: initial.mean_phi + 0.1 * initial.sigma_phi, ..initial }),
        ("mean e + 0.1 sigma", InitialGaussian { mean_e: initial.mean_e + 0.1 * initial.sigma_e, ..initial }),
        ("sigma phi + 10 %", InitialGaussian { sigma_phi: 1.1 * initial.sigma_phi, ..initial }),
        ("sigma e + 10 %", InitialGaussian { sigma_e: 1.1 * initial.sigma_e, ..initial }),
    ];
    let of_initial = of_initial.map(|(change, initial)| (change.to_owned(), Problem { initial, ..problem.clone() }));
    acting.filter_map(of_parameter).chain(of_initial).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::planar::SrpJ2;
    use crate::model::sun_moon::SunMoon;
    use crate::problem::paper::scenario;

    /// Values of the closed form by an independent computation, for semi-major axes of 2, 2.5 and 3 Earth radii.
    #[test]
    fn the_required_radiation_parameter_is_that_of_the_closed_form() {
        for (oblateness, critical_e, required) in
            [(0.89355, 0.5, 0.05349), (0.40921, 0.6, 0.122166), (0.21617, 0.6667, 0.22903)]
        {
            let model = Planar::from(SrpJ2 { radiation: 0.1, oblateness });
            let found = required_radiation(&model, critical_e).unwrap();
            assert!((found / required - 1.0).abs() < 2e-5, "{found} instead of {required}");
        }
    }

    /// An orbit that is circular at first, followed far beyond its period, reaches what the contours say.
    #[test]
    fn an_orbit_reaches_what_its_contour_does() {
        let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
        let models = [
            Planar::from(SrpJ2 { radiation: 0.1221, ..force }),
            Planar::from(SrpJ2 { radiation: 0.1223, ..force }),
            Planar::from(SunMoon { force: SrpJ2 { radiation: 0.01, ..force }, sun: 0.01, moon: 0.02 }),
        ];
        for model in models {
            let flow = Flow::new(model);
            let mut state = State { x1: 1e-9, x2: 0.0 };
            let mut highest = 0.0f64;
            for _ in 0..6000 {
                state = flow.advance_one(state, 0.005).unwrap();
                highest = highest.max(state.eccentricity());
            }
            assert!(is_reached_from_circular(&model, highest - 1e-3), "{model:?} {highest}");
            assert!(!is_reached_from_circular(&model, highest + 1e-3), "{model:?} {highest}");
        }
    }

    /// Without oblateness the flow is a rigid rotation of a sphere, once in `1/sqrt(1 + C²)` yr (`Krivov & Getino
    /// 1997`).
    #[test]
    fn the_period_without_oblateness_is_that_of_the_rotation() {
        for radiation in [0.05, 0.15, 0.3] {
            let found = period(&SrpJ2 { radiation, oblateness: 0.0 }, State::from_polar(2.0, 0.2)).unwrap();
            assert!((found * (1.0 + radiation * radiation).sqrt() - 1.0).abs() < 1e-9, "{radiation}: {found}");
        }
        let model = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
        let start = State::from_polar(2.2069, 0.145);
        let found = period(&model, start).unwrap();
        let end = Flow::new(model).advance_one(start, found).unwrap();
        assert!((end.x1 - start.x1).hypot(end.x2 - start.x2) < 1e-9, "{end:?} after {found} yr");
    }

    #[test]
    fn times_and_parameters_for_a_probability_give_that_probability() {
        let paper = scenario(1);
        let problem = Problem {
            model: Planar::from(SrpJ2 { radiation: 0.12, ..paper.model }),
            initial: paper.initial,
            times: vec![0.0, 2.0],
            critical_e: paper.critical_e,
        };
        let times = dense_times(2.0);
        let found = probabilities(&problem, &times).unwrap();
        let curve: Vec<(f64, f64)> = times.into_iter().zip(found.iter().map(|p| p.value)).collect();
        let time = time_of(&curve, 0.3).unwrap();
        let there = probabilities(&problem, &[0.0, time]).unwrap()[1].value;
        assert!((there - 0.3).abs() < 1e-3, "{there} at {time}");
        let radiation = radiation_for(&problem, 0.9).unwrap().unwrap();
        let model = problem.model.with("radiation", radiation).unwrap();
        let there = probabilities(&Problem { model, ..problem.clone() }, &[2.0]).unwrap()[0].value;
        assert!((there - 0.9).abs() < 1e-2, "{there} at {radiation}");
        let sensitivities = sensitivities(&problem).unwrap();
        assert!(sensitivities[0].effect.abs() >= sensitivities[1].effect.abs() && sensitivities.len() == 6);
        assert!(sensitivities.iter().any(|s| s.change == "radiation C + 1 %" && s.effect > 0.0), "{sensitivities:?}");
    }
}
