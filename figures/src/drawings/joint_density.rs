//! Joint densities (Figs. 3 and 4, 10 and 11, 14 and 15): all snapshots of a case in one frame, and each by itself.

use super::{CRITICAL, at_time, critical, e_axis, phi_axis};
use crate::axis::{Axis, Labels, power_label};
use crate::backend::Area;
use crate::branch::shift_into;
use crate::colour_map::{LEAST, Scale, picture, ramp};
use crate::densities::Density;
use crate::drawings::cloud_evolution::cloud_labels;
use crate::elements::Element;
use crate::figure::{DrawError, Figure};
use crate::labels;
use crate::legend::Sample;
use crate::panel::{Panel, Surroundings, units};
use crate::scene::{Method, Scene};

/// Width of a colour bar with its labels \[px\].
const BAR: f64 = 92.0;
/// The same of a small map.
const SMALL_BAR: f64 = 78.0;

/// All snapshots of a case in one frame.
pub fn draw_all(scene: &Scene<'_>, method: &Method<'_>) -> Result<Figure, DrawError> {
    let phi = scene.phi_range();
    // The scale of the yardstick, so that the figures of all cases can be compared.
    let peaks = scene.yardstick_densities().map(Density::peak);
    let scale = Scale::Logarithmic(peaks.fold(0.0, f64::max));
    let (line, line_name) = critical(scene, &phi);
    let highest =
        scene.yardstick_densities().map(|d| d.grid.e.high).chain([1.05 * scene.problem.critical_e]).fold(0.0, f64::max);
    let pictures: Vec<Element> = method
        .densities
        .iter()
        .zip(scene.clouds())
        .filter(|(density, _)| !density.is_withheld())
        .map(|(density, (cloud, _))| placed(density, shift_into(&phi, &cloud), &density.joint, scale))
        .collect::<Result<_, _>>()?;
    if pictures.is_empty() {
        return Err(DrawError(format!("{} withholds its joint density at all snapshots", method.label)));
    }
    let name = scene.figure_name(&format!("joint-density-{}-all", method.label));
    let title = format!("Joint density of {} at all snapshots", method.label);
    let caption = format!(
        "Logarithmic colour scale over three decades, the same for all cases; below {LEAST} of the highest peak of {} nothing is \
         drawn. Corresponds to Figs. 3, 10 and 14 of Sun et al. (2022).",
        scene.yardstick().map_or("the reference", |yardstick| yardstick.label)
    );
    let key = [(Sample::Line(CRITICAL), line_name)];
    Figure::draw(&name, &title, &caption, (620, 360), &key, |area| {
        let (left, right) = beside_bar(area, BAR);
        let around = Surroundings { title: method.label, ..Surroundings::default() };
        let panel = Panel::new(&left, &phi_axis(phi.clone(), 6), &e_axis(0.0..highest.min(1.0), 7), around)?;
        panel.draw(&pictures)?;
        panel.draw(&[line])?;
        labels::write(&panel, &cloud_labels(scene, &phi))?;
        colour_bar(&right, "joint density", scale)
    })
}

/// One snapshot of a case.
pub fn draw_one(scene: &Scene<'_>, method: &Method<'_>, index: usize) -> Result<Figure, DrawError> {
    let (density, t) = snapshot(scene, method, index)?;
    let yardstick = scene.yardstick_at(index).and_then(|yardstick| yardstick.densities.get(index)).unwrap_or(density);
    let name = scene.figure_name(&format!("joint-density-{}-{index}", method.label));
    let title = format!("Joint density of {} at {}", method.label, at_time(t));
    let caption = "Axes and colour scale are the same for all cases at this time; values above the scale's end have its last \
         colour. Corresponds to Figs. 4, 11 and 15 of Sun et al. (2022).";
    let heading = format!("{}, {}", method.label, at_time(t));
    map(&name, [&title, &heading, caption], density, &density.joint, Scale::Linear(yardstick.peak()), "density")
}

/// The density of a case at a snapshot, and its time.
pub(super) fn snapshot<'s>(
    scene: &Scene<'_>,
    method: &'s Method<'_>,
    index: usize,
) -> Result<(&'s Density, f64), DrawError> {
    match (method.densities.get(index), scene.times.get(index)) {
        (Some(density), Some(&t)) if density.is_withheld() => {
            Err(DrawError(format!("{} withholds its joint density at {}", method.label, at_time(t))))
        }
        (Some(density), Some(&t)) => Ok((density, t)),
        _ => Err(DrawError(format!("{} has no snapshot {index}", method.label))),
    }
}

/// A small map of `values` over the grid of `density`; `words` are its title, its heading and its caption.
pub(super) fn map(
    name: &str,
    [title, heading, caption]: [&str; 3],
    density: &Density,
    values: &[f64],
    scale: Scale,
    unit: &str,
) -> Result<Figure, DrawError> {
    let picture = placed(density, 0.0, values, scale)?;
    let (phi, e) = (density.grid.phi, density.grid.e);
    Figure::draw(name, title, caption, (264, 206), &[], |area| {
        let (left, right) = beside_bar(area, SMALL_BAR);
        let around = Surroundings { title: heading, ..Surroundings::default() };
        let (x, y) = (Axis::linear("φ [rad]", phi.low..phi.high, 4), Axis::linear("e", e.low..e.high, 5));
        Panel::new(&left, &x, &y, around)?.draw(&[picture])?;
        colour_bar(&right, unit, scale)
    })
}

/// Values over the grid of `density` as a picture, moved by `shift` in `phi`.
fn placed(density: &Density, shift: f64, values: &[f64], scale: Scale) -> Result<Element, DrawError> {
    let (phi, e) = (density.grid.phi, density.grid.e);
    let address = picture(values, phi.bins, e.bins, scale)?;
    Ok(Element::picture((phi.low + shift, e.low), (phi.high + shift, e.high), address))
}

/// Room for a map and for its colour bar.
fn beside_bar<'b>(area: &Area<'b>, bar: f64) -> (Area<'b>, Area<'b>) {
    let (width, _) = area.dim_in_pixel();
    area.split_horizontally(width.saturating_sub(units(bar)) as i32)
}

/// A scale with its numbers. `label` ends in the unit 1/rad; numbers that would be long are given in powers of ten of it.
fn colour_bar(area: &Area<'_>, label: &str, scale: Scale) -> Result<(), DrawError> {
    let (end, unit) = match scale {
        Scale::Linear(end) | Scale::Difference(end) => unit(end),
        Scale::Logarithmic(end) => (end, "1".to_owned()),
    };
    let label = format!("{label} [{unit}/rad]");
    let y = match scale {
        Scale::Linear(_) => Axis::linear(&label, 0.0..end, 5),
        Scale::Difference(_) => Axis::linear(&label, -end..end, 5),
        Scale::Logarithmic(_) if end > 0.0 => Axis::logarithmic(&label, LEAST * end, end, 5),
        Scale::Logarithmic(_) => Axis::linear(&label, 0.0..1.0, 1),
    };
    let x = Axis { label: String::new(), range: 0.0..1.0, ticks: Vec::new(), labels: Labels::None };
    // As high as the map beside it, which has labels below.
    let area = area.margin(units(13.0), units(35.0), 0, 0);
    let around = Surroundings { is_bar: true, without_grid: true, ..Surroundings::default() };
    let panel = Panel::new(&area, &x, &y, around)?;
    panel.draw(&[Element::picture((0.0, y.range.start), (1.0, y.range.end), ramp(scale)?)])
}

/// The end of a scale in units of a power of ten, and how that power is written.
fn unit(end: f64) -> (f64, String) {
    if end <= 0.0 || !end.is_finite() || (0.02..5000.0).contains(&end) {
        return (end, "1".to_owned());
    }
    let power = end.log10().floor();
    (end / 10f64.powf(power), power_label(power, false))
}
