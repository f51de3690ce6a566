//! The probability that the re-entry variable has ever reached its critical value, against time, with its error
//! interval.

use super::probability_axis::{ProbabilityAxis, in_words};
use super::write_absent;
use crate::axis::Axis;
use crate::draw_error::DrawError;
use crate::elements::Point;
use crate::figure::Figure;
use crate::legend::{Entry, Sample};
use crate::panel::{Panel, Surroundings};
use crate::scene::{Method, Scene};
use crate::text::subscript;
use crate::words::reentry;
use results::rows::PassageRow;

/// An interval narrower than this is the error estimate of an exact method and is not drawn.
const NARROW: f64 = 1e-6;

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let is_given = |m: &&Method<'_>| m.passage.iter().any(|row| row.prob_reached_critical_e.is_finite());
    let sent: Vec<&Method<'_>> = scene.methods.iter().filter(|method| !method.passage.is_empty()).collect();
    if sent.is_empty() {
        return Err(DrawError("no case has a first-passage curve".into()));
    }
    let curves: Vec<&Method<'_>> = sent.iter().copied().filter(is_given).collect();
    let has_interval = |row: &&PassageRow| row.high - row.low > NARROW;
    let sampled: Vec<&&Method<'_>> = curves.iter().filter(|m| m.passage.iter().any(has_interval)).collect();
    let ink = |method: &Method<'_>| method.pen.stroke.ink;
    let mut key: Vec<Entry> = curves.iter().map(|m| (Sample::Line(m.pen.stroke), m.label.to_owned())).collect();
    key.extend(sampled.iter().map(|m| (Sample::Band(ink(m)), interval_in_words(m))));
    let (name, symbol) = reentry(scene.description);
    let label = format!("P({symbol} has reached {})", subscript(symbol, "cri"));
    let rows = || curves.iter().flat_map(|m| m.passage.iter().map(|row| (*m, *row)));
    let limits = rows().filter(|(_, row)| row.high - row.low > NARROW).map(|(_, row)| row.high);
    let values: Vec<f64> = rows().map(|(_, row)| row.prob_reached_critical_e).chain(limits).collect();
    let last: Vec<f64> =
        curves.iter().filter_map(|m| m.passage.last()).map(|row| row.prob_reached_critical_e).collect();
    let axes = ProbabilityAxis::all(&label, &values, &last);
    let caption = format!(
        "Peaks of the {name} between snapshots count too.{} Not in Sun et al. (2022).{}",
        in_words(&axes),
        absences(scene)
    );
    let end = scene.times.last().copied().unwrap_or(1.0);
    let title = format!("Probability of having reached {symbol} = {}", scene.description.critical);
    let size = (760, 40 + 300 * axes.len() as u32);
    Figure::draw(&scene.figure_name("first-passage"), &title, &caption, size, &key, |area| {
        let x = Axis::linear("time t [yr]", 0.0..end, 8);
        for (area, y) in area.split_evenly((axes.len(), 1)).iter().zip(&axes) {
            let panel = Panel::new(area, &x, &y.axis, Surroundings::default())?;
            let bands = sampled.iter().flat_map(|m| {
                let limits: Vec<(f64, f64, f64)> = m.passage.iter().map(|row| (row.t_yr, row.low, row.high)).collect();
                y.band(&limits, ink(m))
            });
            let lines = curves.iter().flat_map(|m| {
                let points: Vec<Point> = m.passage.iter().map(|row| (row.t_yr, row.prob_reached_critical_e)).collect();
                y.curve(&points, m.pen.stroke)
            });
            panel.draw(&bands.chain(y.divider(&x)).chain(lines).collect::<Vec<_>>())?;
            if curves.is_empty() {
                write_absent(&panel, "withheld")?;
            }
        }
        Ok(())
    })
}

/// What the band of a curve stands for.
fn interval_in_words(method: &Method<'_>) -> String {
    let kind = method.passage.iter().map(|row| row.interval.as_str()).find(|kind| *kind != "bounds");
    match kind.unwrap_or("bounds") {
        "95 %" => format!("95 % interval of {}", method.label),
        "bounds" => format!("strict bounds of {}", method.label),
        _ => format!("error estimate of {}", method.label),
    }
}

/// Sentences that name the cases without a curve and those that withhold it, wholly or in part.
fn absences(scene: &Scene<'_>) -> String {
    let named = |label: &str, is_it: &dyn Fn(&Method<'_>) -> bool| {
        let names: Vec<&str> = scene.methods.iter().filter(|m| is_it(m)).map(|m| m.label).collect();
        if names.is_empty() { String::new() } else { format!(" {label}: {}.", names.join(", ")) }
    };
    let missing = |m: &Method<'_>| m.passage.iter().filter(|row| row.prob_reached_critical_e.is_nan()).count();
    [
        named("No curve", &|m| m.passage.is_empty()),
        named("Withheld", &|m| !m.passage.is_empty() && missing(m) == m.passage.len()),
        named("Withheld in part, and not drawn there", &|m| (1..m.passage.len()).contains(&missing(m))),
    ]
    .concat()
}
