//! The probability that the eccentricity has ever reached its critical value, against time, with its interval.

use crate::axis::Axis;
use crate::elements::{Element, Point};
use crate::figure::{DrawError, Figure};
use crate::legend::{Entry, Sample};
use crate::panel::{Panel, Surroundings};
use crate::results::PassageRow;
use crate::scene::{Method, Scene};
use crate::text::subscript;

/// An interval narrower than this is an exact method's own error estimate.
const NARROW: f64 = 1e-6;

/// Draws it.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let curves: Vec<&Method<'_>> = scene.methods.iter().filter(|method| !method.passage.is_empty()).collect();
    if curves.is_empty() {
        return Err(DrawError("no case has a first-passage curve".into()));
    }
    let without: Vec<&str> = scene.methods.iter().filter(|m| m.passage.is_empty()).map(|m| m.label).collect();
    let has_interval = |row: &&PassageRow| row.high - row.low > NARROW;
    let sampled: Vec<&&Method<'_>> = curves.iter().filter(|m| m.passage.iter().any(has_interval)).collect();
    let ink = |method: &Method<'_>| method.pen.stroke.ink;
    let mut key: Vec<Entry> = curves.iter().map(|m| (Sample::Line(m.pen.stroke), m.label.to_owned())).collect();
    key.extend(sampled.iter().map(|m| (Sample::Band(ink(m)), format!("95 % interval of {}", m.label))));
    let mut caption = "Peaks of the eccentricity between snapshots count too. Not in Sun et al. (2022).".to_owned();
    if !without.is_empty() {
        caption += &format!(" No curve: {}.", without.join(", "));
    }
    let end = scene.times.last().copied().unwrap_or(1.0);
    let title = format!("Probability of having reached e = {}", scene.problem.critical_e);
    Figure::draw(&scene.figure_name("first-passage"), &title, &caption, (760, 340), &key, |area| {
        let x = Axis::linear("time t [yr]", 0.0..end, 8);
        let label = format!("P(e has reached {})", subscript("e", "cri"));
        let highest = curves
            .iter()
            .flat_map(|m| &m.passage)
            .map(|row| row.high.max(row.prob_reached_critical_e))
            .fold(1e-12, f64::max);
        let y = Axis::linear(&label, -0.03 * highest..1.05 * highest, 5);
        let panel = Panel::new(area, &x, &y, Surroundings::default())?;
        let band = |m: &&&Method<'_>| {
            let bounded = m.passage.iter().filter(|row| row.low.is_finite() && row.high.is_finite());
            let limits: Vec<(f64, f64, f64)> = bounded.map(|row| (row.t_yr, row.low, row.high)).collect();
            Element::band(&limits, ink(m))
        };
        let curve = |m: &&Method<'_>| {
            // What is withheld shows as its bounds alone.
            let points = m.passage.iter().map(|row| (row.t_yr, row.prob_reached_critical_e));
            let points: Vec<Point> = points.filter(|(_, p)| p.is_finite()).collect();
            Element::curve(points, m.pen.stroke)
        };
        panel.draw(&sampled.iter().map(band).chain(curves.iter().map(curve)).collect::<Vec<_>>())
    })
}
