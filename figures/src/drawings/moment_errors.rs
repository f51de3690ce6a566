//! Relative errors of means and standard deviations against time (Figs. 6, 13, 17), with the sampling error of Monte
//! Carlo.

use super::at_times;
use crate::axis::Axis;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::legend::{Entry, Sample};
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings};
use crate::scene::{Method, Scene};
use crate::text::subscript;
use crate::words::{means_and_deviations, moment_symbol};
use results::MomentsRow;
use results::description::Quantity;

const SIGMAS: f64 = 1.96;
/// Height of a row of panels, which has the mean and the deviation of a variable \[px\].
const ROW: u32 = 260;
const BAND: Ink = Ink::Series(0);
/// Errors below this are rounding.
pub(super) const ROUNDING: f64 = 1e-12;

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let sampled = scene.monte_carlo();
    let mut key: Vec<Entry> = scene.others().map(|m| (Sample::Case(m.pen), m.label.to_owned())).collect();
    key.extend(sampled.map(|(mc, _)| (Sample::Band(BAND), format!("below the 95 % sampling error of {}", mc.label))));
    let caption = format!(
        "Errors of means and standard deviations, relative to {}; on a logarithmic axis, without errors below {ROUNDING:e}.{} \
         Corresponds to Figs. 6, 13 and 17 of Sun et al. (2022), which are relative to Monte Carlo.{}",
        scene.reference,
        match sampled {
            Some((mc, _)) => format!(" The band ends at {SIGMAS} standard errors of {}.", mc.label),
            None => String::new(),
        },
        withheld(scene)
    );
    let quantities = means_and_deviations(scene.description);
    let curves: Vec<Vec<Vec<Point>>> =
        quantities.iter().map(|q| scene.others().map(|m| errors(scene, m, &q.name)).collect()).collect();
    let limit = |q: &&Quantity| sampled.map_or(Vec::new(), |(mc, _)| sampling_limit(mc, &q.column));
    let limits: Vec<Vec<Point>> = quantities.iter().map(limit).collect();
    let all = || curves.iter().flatten().chain(&limits).flatten().map(|(_, error)| *error);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let end = scene.times.last().copied().unwrap_or(1.0);
    let x = Axis::linear("time t [yr]", -0.04 * end..1.04 * end, 6);
    let title = "Relative errors of the moments";
    let rows = quantities.len().div_ceil(2);
    let size = (760, ROW * rows as u32);
    Figure::draw(&scene.figure_name("moment-errors"), title, &caption, size, &key, |area| {
        for (k, (area, quantity)) in area.split_evenly((rows, 2)).iter().zip(&quantities).enumerate() {
            let (letter, index) = moment_symbol(scene.description, quantity);
            let label = format!("relative error of {}", subscript(letter, index));
            let y = if low.is_finite() {
                Axis::logarithmic(&label, 0.5 * low, 2.0 * high, 7)
            } else {
                Axis::logarithmic(&label, 1e-6, 1.0, 7)
            };
            let panel = Panel::new(area, &x, &y, Surroundings::default())?;
            let to_log = |points: &[Point]| points.iter().map(|&(t, error)| (t, error.log10())).collect::<Vec<_>>();
            let floor = |points: &[Point]| {
                points.iter().map(|&(t, error)| (t, y.range.start, error.log10())).collect::<Vec<_>>()
            };
            let mut elements = vec![Element::band(&floor(&limits[k]), BAND)];
            elements.extend(
                curves[k].iter().zip(scene.others()).map(|(points, m)| Element::curve(to_log(points), m.pen.stroke)),
            );
            panel.draw(&elements)?;
            let markers =
                curves[k].iter().zip(scene.others()).map(|(points, m)| Element::markers_of(to_log(points), &m.pen));
            panel.draw_over(&markers.collect::<Vec<_>>())?;
        }
        Ok(())
    })
}

/// Sentences that name the cases that withhold moments, and the times.
fn withheld(scene: &Scene<'_>) -> String {
    let quantities = means_and_deviations(scene.description);
    let is_missing = |row: &&&MomentsRow| quantities.iter().any(|q| row.number(&q.column).is_nan());
    let of =
        |method: &Method<'_>| -> Vec<f64> { method.moments.iter().filter(is_missing).map(|row| row.t_yr).collect() };
    let cases = scene.methods.iter().map(|method| (method.label, of(method))).filter(|(_, times)| !times.is_empty());
    cases
        .map(|(label, times)| format!(" {label} withholds moments at {}: no errors there.", at_times(&times)))
        .collect()
}

/// Times and relative errors, where an error is given and is above rounding.
pub(super) fn errors(scene: &Scene<'_>, method: &Method<'_>, quantity: &str) -> Vec<Point> {
    let rows = scene.results.errors.iter().filter(|row| row.scenario == scene.name && row.method == method.label);
    let rows = rows.filter(|row| row.quantity == quantity && row.rel_error.is_finite() && row.rel_error > ROUNDING);
    rows.map(|row| (row.t_yr, row.rel_error)).collect()
}

/// Times, and the relative errors up to which sampling explains a difference.
fn sampling_limit(mc: &Method<'_>, column: &str) -> Vec<Point> {
    let limit = |row: &&MomentsRow| (row.t_yr, SIGMAS * row.standard_error(column) / row.number(column).abs());
    mc.moments.iter().map(limit).filter(|(_, error)| error.is_finite() && *error > ROUNDING).collect()
}
