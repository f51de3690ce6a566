//! Marginal densities of a case and the reference (Figs. 5, 12, 16), with the counting error of Monte Carlo.

use density::grid::Axis as Bins;

use super::{at_time, axis_of, steps, withheld_words, write_absent};
use crate::axis::Axis;
use crate::backend::Area;
use crate::densities::Density;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::legend::{self, Entry, Sample};
use crate::palette::{Ink, Pen, Stroke};
use crate::panel::{Panel, Surroundings, room_beside, units};
use crate::scene::{Method, Scene};
use crate::words::density_label;
use results::description::Variable;

/// Half width of a 95 % interval in standard deviations.
const SIGMAS: f64 = 1.96;
/// Height of a row of panels \[px\]. The densities take `UPPER` of it, and the residuals take the rest.
const ROW: f64 = 236.0;
/// Number of rows below a key: so few that one key is always on the screen.
const ROWS_A_KEY: usize = 2;
const WIDTH: u32 = 760;
const UPPER: f64 = 134.0;
const BAND: Ink = Ink::Series(0);
const ZERO: Stroke = Stroke { ink: Ink::Faint, width: 0.8, dashes: &[] };

/// The contents of the panels of a snapshot.
struct Snapshot<'s> {
    title: String,
    own: &'s Density,
    pen: Pen,
    reference: Option<(&'s Density, Pen)>,
    sampled: Option<(&'s Density, f64)>,
}

/// Draws both marginals of a case at every snapshot, and below each marginal its difference from the reference.
pub fn draw(scene: &Scene<'_>, method: &Method<'_>) -> Result<Figure, DrawError> {
    let [x, y] = scene.variables()?;
    let reference = scene.yardstick().filter(|yardstick| yardstick.label != method.label);
    let band = scene.monte_carlo();
    let mut key: Vec<Entry> = vec![(Sample::Line(method.pen.stroke), method.label.to_owned())];
    key.extend(reference.map(|reference| (Sample::Line(reference.pen.stroke), reference.label.to_owned())));
    key.extend(band.map(|(mc, n)| (Sample::Band(BAND), format!("95 % counting error of {} ({n} samples)", mc.label))));
    let residuals = reference.map_or(String::new(), |r| format!(" Below each, {} minus {}.", method.label, r.label));
    let counted = band.map_or(String::new(), |(mc, _)| {
        format!(" The band is {SIGMAS} binomial standard deviations of a bin's count about {}.", mc.label)
    });
    let withheld: String = [Some(method), reference]
        .into_iter()
        .flatten()
        .map(|case| withheld_words(case.label, &case.withheld(&scene.times)))
        .collect();
    let caption = format!(
        "Left the {}{}, right the {}; one row per snapshot.{residuals}{counted} Corresponds to Figs. 5, 12 and 16 of Sun et al. (2022).{withheld}",
        x.name,
        if x.is_circle() { ", on the branch that keeps the cloud whole" } else { "" },
        y.name
    );
    let name = scene.density_figure_name(&format!("marginals-{}", method.label));
    let beside = reference.map_or(String::new(), |reference| format!(" and {}", reference.label));
    let title = format!("Marginal densities of {}{beside}", method.label);
    let sides = [(x, true), (y, false)].map(|(variable, is_first)| Side { variable, is_first });
    let rows = method.densities.len();
    let key_height = legend::height(&key, f64::from(WIDTH));
    let height = ROW * rows as f64 + key_height * rows.div_ceil(ROWS_A_KEY) as f64;
    Figure::draw(&name, &title, &caption, (WIDTH, height.ceil() as u32), &[], |area| {
        let mut rest = area.clone();
        for (index, own) in method.densities.iter().enumerate() {
            if index.is_multiple_of(ROWS_A_KEY) {
                let (head, below) = rest.split_vertically(units(key_height) as i32);
                legend::draw(&head, &key, f64::from(WIDTH))?;
                rest = below;
            }
            let (row, below) = rest.split_vertically(units(ROW) as i32);
            rest = below;
            let snapshot = Snapshot {
                title: scene.times.get(index).map_or(String::new(), |&t| at_time(t)),
                own,
                pen: method.pen,
                reference: reference.and_then(|r| Some((r.densities.get(index)?, r.pen))),
                sampled: band.and_then(|(mc, n)| Some((mc.densities.get(index)?, n))).filter(|(d, _)| !d.is_withheld()),
            };
            for (area, of) in row.split_evenly((1, 2)).iter().zip(sides) {
                let (upper, lower) = area.split_vertically(units(UPPER) as i32);
                let (y, residual) = (density_axis(&snapshot, of), residual(&snapshot, of));
                let beside = residual.as_ref().map_or(0.0, |residual| room_beside(&residual.axis)).max(room_beside(&y));
                draw_densities(&upper, &snapshot, of, &y, beside)?;
                if let Some(residual) = residual {
                    draw_residual(&lower, &snapshot, of, &residual, beside)?;
                }
            }
        }
        Ok(())
    })
}

/// The axis of the densities of a snapshot.
fn density_axis(snapshot: &Snapshot<'_>, of: Side<'_>) -> Axis {
    let shown =
        [Some(snapshot.own), snapshot.reference.map(|(density, _)| density), snapshot.sampled.map(|(mc, _)| mc)];
    let highest = shown.into_iter().flatten().flat_map(|d| of.values(d)).copied().fold(0.0, f64::max);
    Axis::linear(&of.label(), 0.0..1.06 * if highest > 0.0 { highest } else { 1.0 }, 3)
}

fn draw_densities(
    area: &Area<'_>,
    snapshot: &Snapshot<'_>,
    of: Side<'_>,
    y: &Axis,
    beside: f64,
) -> Result<(), DrawError> {
    let Snapshot { own, sampled, .. } = snapshot;
    let reference = snapshot.reference.filter(|(density, _)| !density.is_withheld());
    let mut elements = Vec::new();
    elements.extend(sampled.map(|(mc, n)| of.band(mc, n)));
    elements.extend(reference.map(|(density, pen)| Element::curve(of.curve(density), pen.stroke)));
    if !own.is_withheld() {
        elements.push(Element::curve(of.curve(own), snapshot.pen.stroke));
    }
    let around = Surroundings { title: &snapshot.title, beside, ..Surroundings::default() };
    let panel = Panel::new(area, &snapshot.axis(of).bare(), y, around)?;
    panel.draw(&elements)?;
    if own.is_withheld() { write_absent(&panel, "withheld") } else { Ok(()) }
}

/// The difference of a case from the reference.
struct Residual {
    axis: Axis,
    /// One value per bin, or the reason why there is none.
    values: Result<Vec<f64>, &'static str>,
    /// Half widths of the counting error about 0; empty if no Monte Carlo case has the same bins.
    errors: Vec<f64>,
}

/// The residual of a snapshot, if there is a reference.
fn residual(snapshot: &Snapshot<'_>, of: Side<'_>) -> Option<Residual> {
    let ((reference, _), own) = (snapshot.reference?, snapshot.own);
    let values = match (own.is_withheld(), reference.is_withheld()) {
        (true, _) => Err("withheld"),
        (_, true) => Err("reference withheld"),
        _ if of.bins(own) != of.bins(reference) => Err("different bins"),
        _ => Ok(of.values(own).iter().zip(of.values(reference)).map(|(p, q)| p - q).collect::<Vec<f64>>()),
    };
    let sampled = snapshot.sampled.filter(|(mc, _)| values.is_ok() && of.bins(mc) == of.bins(own));
    let errors = sampled.map_or(Vec::new(), |(mc, n)| of.counting_errors(mc, n));
    // The residual sets the scale, but a residual far below the counting error or the peak is not magnified to noise.
    let largest = |values: &mut dyn Iterator<Item = &f64>| values.map(|value| value.abs()).fold(0.0, f64::max);
    let least = (0.15 * largest(&mut errors.iter())).max(1e-4 * largest(&mut of.values(own).iter()));
    let limit = (1.1 * largest(&mut values.iter().flatten())).max(least);
    let limit = if limit > 0.0 { limit } else { 1.0 };
    let mut axis = Axis::linear("residual", -limit..limit, 5);
    // The panel is low, so it has ticks at 0 and at both ends only.
    let last = axis.ticks.len().saturating_sub(1);
    axis.ticks = [0, last / 2, last].into_iter().filter_map(|k| axis.ticks.get(k).copied()).collect();
    if values.is_err() {
        axis.ticks.clear();
    }
    Some(Residual { axis, values, errors })
}

fn draw_residual(
    area: &Area<'_>,
    snapshot: &Snapshot<'_>,
    of: Side<'_>,
    residual: &Residual,
    beside: f64,
) -> Result<(), DrawError> {
    let x = snapshot.axis(of);
    let panel = Panel::new(area, &x, &residual.axis, Surroundings { beside, ..Surroundings::default() })?;
    let values = match &residual.values {
        Ok(values) => values,
        Err(words) => return write_absent(&panel, words),
    };
    let bins = of.bins(snapshot.own);
    let limits = |(i, &half): (usize, &f64)| [bins.edge(i), bins.edge(i + 1)].map(|x| (x, -half, half));
    let limits: Vec<(f64, f64, f64)> = residual.errors.iter().enumerate().flat_map(limits).collect();
    let band = (!limits.is_empty()).then(|| Element::band(&limits, BAND));
    let zero = Element::curve(vec![(x.range.start, 0.0), (x.range.end, 0.0)], ZERO);
    let curve = Element::curve(steps(bins, values), Stroke { dashes: &[], ..snapshot.pen.stroke });
    panel.draw(&band.into_iter().chain([zero, curve]).collect::<Vec<_>>())
}

impl Snapshot<'_> {
    /// The axis of the case's bins, or of the reference's bins if the case withholds its density.
    fn axis(&self, of: Side<'_>) -> Axis {
        match self.reference {
            Some((reference, _)) if self.own.is_withheld() => of.axis(reference),
            _ => of.axis(self.own),
        }
    }
}

/// One of the two variables of a density.
#[derive(Clone, Copy)]
struct Side<'s> {
    variable: &'s Variable,
    is_first: bool,
}

impl Side<'_> {
    fn label(self) -> String {
        density_label("density", "1", &[self.variable])
    }

    fn bins(self, density: &Density) -> &Bins {
        if self.is_first { &density.grid.x } else { &density.grid.y }
    }

    fn values(self, density: &Density) -> &[f64] {
        if self.is_first { &density.marginal_x } else { &density.marginal_y }
    }

    fn axis(self, density: &Density) -> Axis {
        let bins = self.bins(density);
        axis_of(self.variable, bins.low..bins.high, 6)
    }

    fn curve(self, density: &Density) -> Vec<Point> {
        steps(self.bins(density), self.values(density))
    }

    /// Half widths of the 95 % intervals of the density in each bin, from the counts of `n` samples.
    fn counting_errors(self, density: &Density, n: f64) -> Vec<f64> {
        let width = self.bins(density).width();
        self.values(density).iter().map(|&value| SIGMAS * counting_error(value, n, width)).collect()
    }

    /// The band of the counting error of `n` samples.
    fn band(self, density: &Density, n: f64) -> Element {
        let bins = self.bins(density);
        let halves = self.counting_errors(density, n);
        let limits = self.values(density).iter().zip(halves).enumerate().flat_map(|(i, (&value, half))| {
            [bins.edge(i), bins.edge(i + 1)].map(|x| (x, (value - half).max(0.0), value + half))
        });
        Element::band(&limits.collect::<Vec<_>>(), BAND)
    }
}

/// Standard deviation of a density that was counted from `n` samples in bins of the given width.
fn counting_error(density: f64, n: f64, width: f64) -> f64 {
    let p = (density * width).clamp(0.0, 1.0);
    (p * (1.0 - p) / n).sqrt() / width
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counting_error_is_that_of_a_binomial_count() {
        // 100 samples, half of them in a bin 0.1 wide: the count is 50 ± 5, the density 5 ± 0.5.
        assert!((counting_error(5.0, 100.0, 0.1) - 0.5).abs() < 1e-12);
        assert_eq!(counting_error(0.0, 100.0, 0.1), 0.0);
    }
}
