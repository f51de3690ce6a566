//! How the cloud moves (Fig. 2): samples at every snapshot between the contours of their lowest and highest Hamiltonian.

use density::dynamics::State;
use density::flow::{Accuracy, Flow};
use density::orbits::Orbits;
use density::sampling::draw as draw_samples;

use super::{CRITICAL, at_time, critical, e_axis, mirrored, phi_axis, snapshot_marker};
use crate::backend::Stroke;
use crate::branch::shift_into;
use crate::elements::{Element, Point};
use crate::figure::{DrawError, Figure};
use crate::hamiltonian;
use crate::labels::{self, Label};
use crate::legend::{Entry, Sample};
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings};
use crate::scene::Scene;

/// Samples drawn, as in the paper.
const SAMPLES: usize = 961;
const SEED: u64 = 1;
const BOUND: Stroke = Stroke { ink: Ink::Faint, width: 1.6, dashes: &[] };

/// Draws it.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let phi = scene.phi_range();
    let clouds = scene.clouds();
    let (samples, levels) = snapshots(scene)?;
    let highest = samples.iter().flatten().map(|(_, e)| *e).chain([scene.problem.critical_e]).fold(0.0, f64::max);
    let (line, line_name) = critical(scene, &phi);
    let times = scene.times.iter().enumerate();
    let mut key: Vec<Entry> = times
        .map(|(index, &t)| {
            let (marker, stroke) = snapshot_marker(index);
            (Sample::Marker(marker, stroke, false), at_time(t))
        })
        .collect();
    key.push((Sample::Line(BOUND), "lowest and highest H of the samples".into()));
    key.push((Sample::Line(CRITICAL), line_name));
    let caption = format!(
        "{SAMPLES} samples of the initial Gaussian (seed {SEED}), carried by the flow for this figure, at every snapshot. Grey: \
         the contours of the lowest and the highest Hamiltonian among them, which the cloud never leaves. φ runs over a branch \
         on which every cloud is whole. Corresponds to Fig. 2 of Sun et al. (2022)."
    );
    Figure::draw(&scene.figure_name("cloud-evolution"), "Evolution of the cloud", &caption, (760, 430), &key, |area| {
        let e = e_axis(0.0..(1.08 * highest).min(1.0), 8);
        let panel = Panel::new(area, &phi_axis(phi.clone(), 7), &e, Surroundings::default())?;
        let bounds =
            levels.iter().flat_map(|level| mirrored(&hamiltonian::contour(scene.problem.force, *level), &phi, BOUND));
        panel.draw(&bounds.chain([line]).collect::<Vec<_>>())?;
        let markers = samples.iter().zip(&clouds).enumerate().map(|(index, (points, (cloud, _)))| {
            let centre = 0.5 * (cloud.start + cloud.end) + shift_into(&phi, cloud);
            let near = |&(x, e): &Point| (density::angle::nearest(x, centre), e);
            let (marker, stroke) = snapshot_marker(index);
            Element::markers(points.iter().map(near).collect(), marker, 1.6, Stroke { width: 0.8, ..stroke }, false)
        });
        panel.draw(&markers.collect::<Vec<_>>())?;
        labels::write(&panel, &cloud_labels(scene, &phi))
    })
}

/// The times beside the clouds.
pub fn cloud_labels(scene: &Scene<'_>, phi: &std::ops::Range<f64>) -> Vec<Label> {
    let label = |(t, (cloud, e)): (&f64, (std::ops::Range<f64>, std::ops::Range<f64>))| {
        let shift = shift_into(phi, &cloud);
        Label { words: at_time(*t), low: (cloud.start + shift, e.start), high: (cloud.end + shift, e.end) }
    };
    scene.times.iter().zip(scene.clouds()).map(label).collect()
}

type Snapshots = (Vec<Vec<Point>>, [f64; 2]);

/// The samples at each snapshot, and their lowest and highest Hamiltonian.
fn snapshots(scene: &Scene<'_>) -> Result<Snapshots, DrawError> {
    let problem = scene.problem;
    let (x1, x2) = draw_samples(&problem.initial, SEED, SAMPLES);
    let levels = x1.iter().zip(&x2).map(|(&x1, &x2)| problem.force.hamiltonian(State { x1, x2 }));
    let levels = levels.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    let mut orbits = Orbits::new(Flow { force: problem.force, accuracy: Accuracy::Coarse }, x1, x2);
    let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
    let mut snapshots = Vec::with_capacity(problem.times.len());
    for &time in &problem.times {
        orbits.advance_to(time).map_err(|lost| DrawError(lost.to_string()))?;
        orbits.read_out(&mut phi, &mut e);
        snapshots.push(phi.iter().copied().zip(e.iter().copied()).collect());
    }
    Ok((snapshots, levels))
}
