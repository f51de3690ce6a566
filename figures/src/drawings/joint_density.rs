//! Joint densities (Figs. 3 and 4, 10 and 11, 14 and 15): all snapshots of a case in one frame, and each by itself.
//!
//! In the common frame clouds lie over one another, so there the colour shows the time and its strength the density. In
//! the figure of a single snapshot the colour shows the density.

use std::ops::Range;

use super::density_map::{Map, TITLE, colour_bar, placed, yardstick};
use super::time_bar::{TIME_BAR, time_bar};
use super::{CRITICAL, at_time, axis_of, beside_bar, critical, on_axis, withheld_words, zoom};
use crate::colour_map::{LEAST, Scale};
use crate::densities::Density;
use crate::draw_error::DrawError;
use crate::drawings::cloud_evolution::cloud_labels;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::labels;
use crate::legend::Sample;
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings, units};
use crate::scene::{Cloud, Method, Scene};

/// Width of the frame of all snapshots, and below its height \[px\].
const WIDTH: u32 = 760;
const HEIGHT: u32 = 360;
/// Width of a colour bar with its labels \[px\].
const BAR: f64 = 92.0;

/// Draws all snapshots of a case in one frame.
pub fn draw_all(scene: &Scene<'_>, method: &Method<'_>) -> Result<Figure, DrawError> {
    let (x, y) = (scene.x_range(), scene.y_range());
    let variables = scene.variables()?;
    // The yardstick's densities set the scale, so that the figures of all cases can be compared.
    let densities = scene.yardstick().map_or(&[][..], |yardstick| yardstick.densities);
    let given = || densities.iter().filter(|density| !density.is_withheld());
    let peaks = if given().next().is_some() { densities } else { method.densities };
    let peak = peaks.iter().map(Density::peak).fold(0.0, f64::max);
    let scale = Scale::Strength(peak);
    let line = critical(scene, &x, &y);
    let clouds = scene.clouds();
    let mut pictures: Vec<Element> = Vec::new();
    for (index, (density, cloud)) in method.densities.iter().zip(&clouds).enumerate() {
        if density.is_withheld() {
            continue;
        }
        let shift = cloud.as_ref().map_or(0.0, |cloud| cloud.shift_onto(&x, density.grid.is_circle));
        let ink = Ink::of_many(index, scene.times.len());
        let placed = placed(density, shift, &x, &density.joint, scale)?;
        pictures.extend(placed.into_iter().map(|picture| picture.inked(ink)));
    }
    let insets = zoom::insets(scene, method, scale, [&x, &y])?;
    let name = scene.density_figure_name(&format!("joint-density-{}-all", method.label));
    let title = format!("Joint density of {} at all snapshots", method.label);
    let caption = format!(
        "The colour of a cloud is its time, from early to late; its strength is the density, logarithmic over three decades, the \
         same for all cases; below {LEAST} of the highest peak of {} nothing is drawn. A label stands at its own cloud or is led \
         to a point of it; where there is no room for all labels the bar tells the times.{} Corresponds to Figs. 3, 10 and 14 of Sun et al. (2022).{}",
        scene.yardstick().map_or("the reference", |yardstick| yardstick.label),
        if insets.is_empty() {
            ""
        } else {
            " Below, on axes of their own: clouds that are small here, and the part of thin ones about their peak."
        },
        withheld_words(method.label, &method.withheld(&scene.times))
    );
    let key: Vec<_> = line.iter().map(|(_, name)| (Sample::Line(CRITICAL), name.clone())).collect();
    let size = (WIDTH, HEIGHT + zoom::height(&insets));
    Figure::draw(&name, &title, &caption, size, &key, |area| {
        let (area, below) = area.split_vertically(units(f64::from(HEIGHT)) as i32);
        let (left, bars) = beside_bar(&area, TIME_BAR + BAR);
        let (times, strengths) = beside_bar(&bars, BAR);
        let around = Surroundings { title: method.label, ..Surroundings::default() };
        let panel =
            Panel::new(&left, &axis_of(variables[0], x.clone(), 6), &axis_of(variables[1], y.clone(), 7), around)?;
        panel.draw(&pictures)?;
        panel.draw(&line.iter().map(|(line, _)| line.clone()).collect::<Vec<_>>())?;
        let points = method
            .densities
            .iter()
            .zip(&clouds)
            .map(|(density, cloud)| cloud_points(density, cloud.as_ref(), &x, LEAST * peak));
        labels::write(&panel, &cloud_labels(scene, &x, points.collect()))?;
        time_bar(&times.margin(units(TITLE), 0, 0, 0), &scene.times)?;
        colour_bar(&strengths, "joint density", &variables, scale)?;
        zoom::draw(&below, &insets, variables)
    })
}

/// Middles of the bins in which a density is at least `least`, the smallest density drawn, on the branch that keeps the
/// cloud whole; no points if the density is withheld.
fn cloud_points(density: &Density, cloud: Option<&Cloud>, axis: &Range<f64>, least: f64) -> Vec<Point> {
    let Some(cloud) = cloud.filter(|_| !density.is_withheld() && least > 0.0) else { return Vec::new() };
    let centre = 0.5 * (cloud.x.start + cloud.x.end) + cloud.shift_onto(axis, density.grid.is_circle);
    let grid = &density.grid;
    let middle = |axis: &density::grid::Axis, i: usize| axis.edge(i) + 0.5 * axis.width();
    let bins = density.joint.iter().enumerate().filter(|(_, p)| **p >= least);
    bins.map(|(k, _)| {
        let (x, y) = (middle(&grid.x, k / grid.y.bins), middle(&grid.y, k % grid.y.bins));
        (if grid.is_circle { on_axis(x, centre, axis) } else { x }, y)
    })
    .collect()
}

/// Draws one snapshot of a case.
pub fn draw_one(scene: &Scene<'_>, method: &Method<'_>, index: usize) -> Result<Figure, DrawError> {
    let (density, t) = snapshot(scene, method, index)?;
    let yardstick = yardstick(scene, density, index);
    let name = scene.density_figure_name(&format!("joint-density-{}-{index}", method.label));
    let title = format!("Joint density of {} at {}", method.label, at_time(t));
    let caption = format!(
        "Axes and colour scale are the same for all cases at this time; values above the scale's end have its last colour. An \
         inset magnifies the framed bins of a thin cloud. Corresponds to Figs. 4, 11 and 15 of Sun et al. (2022).{}",
        if density.is_withheld() { withheld_words(method.label, &[t]) } else { String::new() }
    );
    let heading = format!("{}, {}", method.label, at_time(t));
    let variables = scene.variables()?;
    let map = Map { density, values: &density.joint, yardstick, variables, scale: Scale::Linear(yardstick.peak()) };
    map.draw(&name, [&title, &heading, &caption], "density")
}

/// The density of a case at a snapshot, and its time.
pub(super) fn snapshot<'s>(
    scene: &Scene<'_>,
    method: &'s Method<'_>,
    index: usize,
) -> Result<(&'s Density, f64), DrawError> {
    match (method.densities.get(index), scene.times.get(index)) {
        (Some(density), Some(&t)) => Ok((density, t)),
        _ => Err(DrawError(format!("{} has no snapshot {index}", method.label))),
    }
}
