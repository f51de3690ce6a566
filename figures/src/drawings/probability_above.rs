//! The probability that the re-entry variable is above its critical value at each snapshot.

use super::probability_axis::{ProbabilityAxis, in_words};
use super::{at_times, write_absent};
use crate::axis::Axis;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::legend::{Entry, Sample};
use crate::panel::{Panel, Surroundings};
use crate::scene::{Method, Scene};
use crate::text::subscript;
use crate::words::reentry;

/// Half width of a 95 % interval in standard errors.
const SIGMAS: f64 = 1.96;

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let above = scene.description.above_critical();
    let symbol = reentry(scene.description).1;
    let points = |m: &Method<'_>| -> Vec<Point> { m.moments.iter().map(|row| (row.t_yr, row.number(above))).collect() };
    let values: Vec<f64> = scene.methods.iter().flat_map(points).map(|(_, p)| p).collect();
    let label = format!("P({symbol} > {})", subscript(symbol, "cri"));
    let axes = ProbabilityAxis::all(&label, &values, &values);
    let key: Vec<Entry> = scene.methods.iter().map(|m| (Sample::Case(m.pen), m.label.to_owned())).collect();
    let withheld: String = scene
        .methods
        .iter()
        .map(|m| (m.label, points(m).into_iter().filter(|(_, p)| p.is_nan()).map(|(t, _)| t).collect::<Vec<_>>()))
        .filter(|(_, times)| !times.is_empty())
        .map(|(label, times)| format!(" {label} withholds its value at {}: not drawn.", at_times(&times)))
        .collect();
    let caption = format!(
        "At the snapshots; lines lead the eye from one to the next. Bars: {SIGMAS} standard errors of a method that samples.{} \
         Not in Sun et al. (2022).{withheld}",
        in_words(&axes)
    );
    let end = scene.times.last().copied().unwrap_or(1.0);
    let title = format!("Probability that {symbol} exceeds {}", scene.description.critical);
    let size = (760, 40 + 280 * axes.len() as u32);
    Figure::draw(&scene.figure_name("probability-above"), &title, &caption, size, &key, |area| {
        let x = Axis::linear("time t [yr]", -0.04 * end..1.04 * end, 8);
        for (area, y) in area.split_evenly((axes.len(), 1)).iter().zip(&axes) {
            let panel = Panel::new(area, &x, &y.axis, Surroundings::default())?;
            let lines = scene
                .methods
                .iter()
                .flat_map(|m| y.curve(&points(m), m.pen.stroke).into_iter().chain(bars(m, above, y)));
            panel.draw(&y.divider(&x).into_iter().chain(lines).collect::<Vec<_>>())?;
            for m in &scene.methods {
                let places = points(m).into_iter().filter_map(|(t, p)| Some((t, y.place(p)?))).collect();
                panel.draw_over(&[Element::markers_of(places, &m.pen)])?;
            }
            if !values.iter().any(|p| p.is_finite()) {
                write_absent(&panel, "withheld")?;
            }
        }
        Ok(())
    })
}

/// Bars of the standard errors of a method that has standard errors.
fn bars(method: &Method<'_>, above: &str, y: &ProbabilityAxis) -> Vec<Element> {
    let bar = |t: f64, p: f64, error: f64| {
        let ends = [p - error, p + error].map(|end| y.place(end.clamp(0.0, 1.0)));
        Some(Element::curve(vec![(t, ends[0]?), (t, ends[1]?)], method.pen.stroke))
    };
    let rows = method.moments.iter().filter(|row| row.standard_error(above) > 0.0);
    rows.filter_map(|row| bar(row.t_yr, row.number(above), SIGMAS * row.standard_error(above))).collect()
}
