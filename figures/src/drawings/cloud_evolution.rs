//! The evolution of the cloud (Fig. 2): samples at every snapshot, between the contours of their extreme Hamiltonians.

use std::ops::Range;

use density::flow::{Accuracy, Flow};
use density::model::PlanarHamiltonian;
use density::model::plane::State;
use density::orbits::Orbits;
use density::sampling::draw as draw_samples;

use super::time_bar::{TIME_BAR, time_bar};
use super::{CRITICAL, at_time, axis_of, beside_bar, critical, mirrored, on_axis, snapshot_marker, snapshots_of_many};
use crate::branch::shift_into;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::hamiltonian;
use crate::labels::{self, Label};
use crate::legend::{Entry, Sample};
use crate::palette::{Ink, Stroke};
use crate::panel::{Panel, Surroundings};
use crate::scene::{Cloud, Scene};

/// Number of samples drawn, as in the paper.
const SAMPLES: usize = 961;
const SEED: u64 = 1;
/// Number of points that stand for a line across the figure, close enough that no words fit between them.
const LINE_POINTS: usize = 300;
const BOUND: Stroke = Stroke { ink: Ink::Faint, width: 1.6, dashes: &[] };

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let problem = scene.problem()?;
    hamiltonian::check_form(problem.model)?;
    let [x, y] = scene.variables()?;
    let phi = scene.x_range();
    let (samples, levels) = snapshots(scene)?;
    let highest = samples.iter().flatten().map(|(_, e)| *e).chain([problem.critical_e]).fold(0.0, f64::max);
    let e = 0.0..(1.08 * highest).min(1.0);
    let line = critical(scene, &phi, &e);
    let count = scene.times.len();
    let has_bar = snapshots_of_many(count);
    let times = scene.times.iter().enumerate().filter(|_| !has_bar);
    let mut key: Vec<Entry> = times
        .map(|(index, &t)| {
            let (marker, stroke) = snapshot_marker(index, count);
            (Sample::Marker(marker, stroke, false), at_time(t))
        })
        .collect();
    key.push((Sample::Line(BOUND), "lowest and highest H of the samples".into()));
    key.extend(line.iter().map(|(_, name)| (Sample::Line(CRITICAL), name.clone())));
    let caption = format!(
        "{SAMPLES} samples of the initial Gaussian (seed {SEED}), carried by the flow for this figure, at every snapshot. Grey: \
         the contours of the lowest and the highest Hamiltonian among them, which the cloud never leaves. φ runs over a branch \
         on which every cloud is whole. Corresponds to Fig. 2 of Sun et al. (2022)."
    );
    let clouds = placed(&samples, &scene.clouds(), &phi);
    Figure::draw(&scene.figure_name("cloud-evolution"), "Evolution of the cloud", &caption, (760, 430), &key, |area| {
        let (left, right) = if has_bar { beside_bar(area, TIME_BAR) } else { (area.clone(), area.clone()) };
        let panel = Panel::new(&left, &axis_of(x, phi.clone(), 7), &axis_of(y, e.clone(), 8), Surroundings::default())?;
        let bounds =
            levels.iter().flat_map(|level| mirrored(&hamiltonian::contour(problem.model, *level), &phi, BOUND));
        panel.draw(&bounds.chain(line.iter().map(|(line, _)| line.clone())).collect::<Vec<_>>())?;
        let markers = clouds.iter().enumerate().map(|(index, points)| {
            let (marker, stroke) = snapshot_marker(index, count);
            Element::markers(points.clone(), marker, 1.6, Stroke { width: 0.8, ..stroke }, false)
        });
        panel.draw(&markers.collect::<Vec<_>>())?;
        if has_bar {
            time_bar(&right, &scene.times)?;
        }
        labels::write(&panel, &cloud_labels(scene, &phi, clouds))
    })
}

/// The samples at each snapshot, on the branch where their cloud is whole.
fn placed(samples: &[Vec<Point>], clouds: &[Option<Cloud>], phi: &Range<f64>) -> Vec<Vec<Point>> {
    let place = |(points, cloud): (&Vec<Point>, &Option<Cloud>)| {
        let axis_middle = 0.5 * (phi.start + phi.end);
        let centre = cloud.as_ref().map_or(axis_middle, |c| 0.5 * (c.x.start + c.x.end) + shift_into(phi, &c.x));
        points.iter().map(|&(x, e)| (on_axis(x, centre, phi), e)).collect()
    };
    samples.iter().zip(clouds).map(place).collect()
}

/// The times beside the clouds, each in the colour of its cloud; they keep clear of the line of the critical
/// value.
pub fn cloud_labels(scene: &Scene<'_>, x: &Range<f64>, clouds: Vec<Vec<Point>>) -> Vec<Label> {
    let times = &scene.times;
    let label = |(index, points): (usize, Vec<Point>)| Label {
        words: times.get(index).map_or(String::new(), |&t| at_time(t)),
        points,
        ink: Ink::of_many(index, times.len()),
    };
    let along = (0..=LINE_POINTS).map(|k| x.start + (x.end - x.start) * k as f64 / LINE_POINTS as f64);
    let line = scene.is_reentry(1).then(|| along.map(|x| (x, scene.description.critical)).collect());
    let line = line.map(|points| Label { words: String::new(), points, ink: CRITICAL.ink });
    clouds.into_iter().enumerate().map(label).chain(line).collect()
}

type Snapshots = (Vec<Vec<Point>>, [f64; 2]);

/// The samples at each snapshot, and their lowest and highest Hamiltonian.
fn snapshots(scene: &Scene<'_>) -> Result<Snapshots, DrawError> {
    let problem = scene.problem()?;
    let (x1, x2) = draw_samples(&problem.initial, SEED, SAMPLES);
    let levels = x1.iter().zip(&x2).map(|(&x1, &x2)| problem.model.hamiltonian(State { x1, x2 }));
    let levels = levels.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    let mut orbits = Orbits::new(Flow { model: problem.model, accuracy: Accuracy::Coarse }, x1, x2);
    let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
    let mut snapshots = Vec::with_capacity(problem.times.len());
    for &time in &problem.times {
        orbits.advance_to(time).map_err(|lost| DrawError(lost.to_string()))?;
        orbits.read_out(&mut phi, &mut e);
        snapshots.push(phi.iter().copied().zip(e.iter().copied()).collect());
    }
    Ok((snapshots, levels))
}
