//! The axes on which clouds in space are compared: they enclose a pilot cloud.
//!
//! The pilot orbits start on shells about the mean out to four standard deviations, evenly in all directions, and move
//! in the averaged model, also where the scenario's is unaveraged, from which it differs by less than the margin.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use crate::angle::{Circular, nearest};
use crate::flow::{Accuracy, Flow};
use crate::grid::Axis;
use crate::model::irradiated::WithRadiation;
use crate::model::shadow::ShadowedVectorial;
use crate::model::uncertain_radiation::{Linear, Logarithmic};
use crate::model::{Coordinates, Kind, Model, Variable};
use crate::orbits::{LostOrbit, Orbits};
use crate::sampling::{Draws, SamplingPlan, normal_quantile_of_tail};

use super::SpaceProblem;

/// Number of shells, the outermost of which has a radius of `REACH` standard deviations, and of directions on each.
const SHELLS: usize = 8;
const DIRECTIONS: usize = 256;
const REACH: f64 = 4.0;
/// What an axis has beyond the pilot cloud, at either end, as a share of its length; and its least length.
const MARGIN: f64 = 0.04;
const LEAST: f64 = 1e-6;

/// The axes of all variables at each snapshot, with these numbers of bins.
///
/// # Errors
/// [`LostOrbit`] if no pilot orbit can be followed to a snapshot.
pub fn axes(problem: &SpaceProblem, bins: &[usize]) -> Result<Vec<Vec<Axis>>, LostOrbit> {
    if let Some(model) = problem.model.averaged_with_shadow(None).filter(|_| problem.shadow) {
        return shadowed_axes(model, problem, bins);
    }
    let (points, weights) = shells(problem, DIRECTIONS);
    let model = problem.model.averaged();
    match (problem.spread.is_some(), problem.is_logarithmic()) {
        (false, _) => follow(model, problem, &points, &weights, (bins, Accuracy::Fine)),
        (_, false) => {
            follow(WithRadiation::<_, Linear>::new(model), problem, &points, &weights, (bins, Accuracy::Fine))
        }
        (_, true) => {
            follow(WithRadiation::<_, Logarithmic>::new(model), problem, &points, &weights, (bins, Accuracy::Fine))
        }
    }
}

/// The axes of a cloud that passes the Earth's shadow. An orbit takes a thousand times as long, so that there are fewer
/// of them.
fn shadowed_axes(
    model: ShadowedVectorial,
    problem: &SpaceProblem,
    bins: &[usize],
) -> Result<Vec<Vec<Axis>>, LostOrbit> {
    /// Place of the semi-major axis among the variables; it is none of the cloud's.
    const AXIS: usize = 4;
    let (mut points, weights) = shells(problem, DIRECTIONS / 8);
    points.insert(AXIS, vec![model.semi_major_axis; weights.len()]);
    let mut bins = bins.to_vec();
    bins.insert(AXIS.min(bins.len()), 0);
    let all = match (problem.spread.is_some(), problem.is_logarithmic()) {
        (false, _) => follow(model, problem, &points, &weights, (&bins, Accuracy::Medium)),
        (_, false) => {
            follow(WithRadiation::<_, Linear>::new(model), problem, &points, &weights, (&bins, Accuracy::Medium))
        }
        (_, true) => {
            follow(WithRadiation::<_, Logarithmic>::new(model), problem, &points, &weights, (&bins, Accuracy::Medium))
        }
    };
    all.map(|mut all| {
        for axes in &mut all {
            axes.remove(AXIS);
        }
        all
    })
}

/// The pilot orbits' variables at `t = 0`, one column each, and their shares of the probability.
fn shells(problem: &SpaceProblem, directions: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
    const DIMENSIONS: usize = 5;
    let plan = SamplingPlan { draws: Draws::Sobol, seed: 1, replicates: NonZeroUsize::MIN };
    let shares = plan.shares::<DIMENSIONS>();
    let radiation = problem.radiation();
    let used = if radiation.is_some() { DIMENSIONS } else { DIMENSIONS - 1 };
    let gaussian = problem.initial.gaussian().ok();
    let (mut columns, mut weights) = (vec![Vec::new(); used], Vec::new());
    for (shell, direction) in (1..=SHELLS).flat_map(|shell| (0..directions).map(move |k| (shell, k))) {
        let normal = shares(direction + directions * (shell - 1)).map(normal_quantile_of_tail);
        let length = normal[..used].iter().map(|z| z * z).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let radius = REACH * shell as f64 / SHELLS as f64;
        let [a, b, c, d, last] = normal.map(|z| z / length * radius);
        let mut point = gaussian.map_or(problem.initial.mean, |gaussian| gaussian.point([a, b, c, d])).to_vec();
        point[1] = point[1].clamp(1e-9, 0.999);
        if let Some((mean, sigma)) = radiation {
            let value = mean + sigma * last;
            point.push(if problem.is_logarithmic() { value } else { value.max(0.0) });
        }
        columns.iter_mut().zip(point).for_each(|(column, value)| column.push(value));
        weights.push(radius.powi(used as i32 - 1) * (-0.5 * radius * radius).exp());
    }
    (columns, weights)
}

fn follow<M: Model>(
    model: M,
    problem: &SpaceProblem,
    points: &[Vec<f64>],
    weights: &[f64],
    (bins, accuracy): (&[usize], Accuracy),
) -> Result<Vec<Vec<Axis>>, LostOrbit> {
    let flow = Flow { model, accuracy };
    let start = || Orbits::from_variables(flow, &points.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let mut columns = start().columns().to_vec();
    let (mut now, mut all) = (0.0, Vec::new());
    for &time in &problem.times {
        let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        flow.carry_where_possible(&mut slices, now, time);
        now = time;
        let there: Vec<(M::Variables, f64)> = (0..weights.len())
            .filter(|&i| !columns[0][i].is_nan())
            .map(|i| (model.read_out(time, Coordinates::from_fn(|k| columns[k][i])), weights[i]))
            .collect();
        if there.is_empty() {
            start().advance_to(time)?;
        }
        let axis = |(k, variable): (usize, &Variable)| {
            let values: Vec<(f64, f64)> = there.iter().map(|(place, weight)| (place.component(k), *weight)).collect();
            enclosing(&values, variable, bins.get(k).copied().unwrap_or(0))
        };
        all.push(M::VARIABLES.iter().enumerate().map(axis).collect());
    }
    Ok(all)
}

/// The axis around weighted values; of an angle on the branch that keeps them together.
fn enclosing(values: &[(f64, f64)], variable: &Variable, bins: usize) -> Axis {
    let vector = |f: fn(f64) -> f64| values.iter().map(|(value, weight)| weight * f(*value)).sum::<f64>();
    let centre = Circular::from_mean_vector(vector(f64::sin), vector(f64::cos)).mean;
    let on_branch = |value: f64| if variable.is_circle() { nearest(value, centre) } else { value };
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().map(|(value, _)| on_branch(*value)).fold(ends, |(a, b), v| (a.min(v), b.max(v)));
    let margin = MARGIN * (high - low) + 0.5 * LEAST;
    let (least, most) = match variable.kind {
        Kind::Circle => (centre - PI, centre + PI),
        Kind::Interval { low, high } => (low, high),
    };
    Axis { low: (low - margin).max(least), high: (high + margin).min(most), bins }
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::super::sampled::Sampled;
    use super::*;
    use crate::flow::Passages;

    /// The share of a sample that lies on every axis, at the last snapshot.
    fn share_inside(problem: &SpaceProblem) -> f64 {
        const ORBITS: usize = 4000;
        let variables = problem.variables();
        let axes = axes(problem, &vec![10; variables.len()]).unwrap();
        assert_eq!(axes.len(), problem.times.len());
        let plan = SamplingPlan { draws: Draws::Independent, seed: 8, replicates: NonZeroUsize::MIN };
        let sampled = Sampled { problem, simplification: None, plan, accuracy: Accuracy::Medium };
        let mut cloud = sampled.cloud(0..ORBITS).unwrap();
        let mut passed = vec![0; ORBITS];
        let time = *problem.times.last().unwrap();
        let passages = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
        cloud.advance_watching(time, problem.critical_e, passages).unwrap();
        let mut columns = vec![0.0; variables.len() * ORBITS];
        cloud.read_out(&mut columns);
        let last = axes.last().unwrap();
        let is_on = |k: usize, i: usize| {
            let (axis, value) = (last[k], columns[k * ORBITS + i]);
            let branch = axis.low.midpoint(axis.high);
            axis.bin(if variables[k].is_circle() { nearest(value, branch) } else { value }).is_some()
        };
        (0..ORBITS).filter(|&i| (0..variables.len()).all(|k| is_on(k, i))).count() as f64 / ORBITS as f64
    }

    #[test]
    fn the_axes_enclose_the_cloud_but_for_a_few_orbits() {
        assert!(share_inside(&example::problem()) > 0.995);
        let mut flat = example::problem();
        flat.initial.mean[2] = 0.0;
        flat.initial.correlation = [0.0; 6];
        flat.spread = None;
        assert!(share_inside(&flat) > 0.995, "{}", share_inside(&flat));
    }

    #[test]
    fn a_certain_variable_has_an_axis_with_an_extent() {
        let mut problem = example::problem();
        (problem.initial.sigma[2], problem.initial.sigma[3]) = (0.0, 0.0);
        problem.initial.correlation = [0.0; 6];
        let axes = axes(&problem, &[10; 5]).unwrap();
        assert!(axes[0].iter().all(|axis| axis.low < axis.high), "{axes:?}");
    }
}
