//! Accuracy against effort: errors over the number of trajectories propagated, and over CPU time.

use super::moment_errors::{ROUNDING, errors};
use crate::axis::Axis;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::legend::{Entry, Sample};
use crate::palette::{Ink, Stroke};
use crate::panel::{Panel, Surroundings};
use crate::scene::{Method, Scene};
use crate::words::means_and_deviations;

const SLOPE: Stroke = Stroke { ink: Ink::Faint, width: 1.2, dashes: &[] };

/// The effort of a case.
type Cost = fn(&Method<'_>) -> f64;
/// The error of a case.
type Inaccuracy = fn(&Scene<'_>, &Method<'_>) -> f64;

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let mut key: Vec<Entry> = scene
        .others()
        .map(|m| (Sample::Marker(m.pen.marker, m.pen.stroke, m.pen.filled), m.label.to_owned()))
        .collect();
    let sampled = scene.monte_carlo().map(|(mc, _)| mc);
    key.extend(sampled.map(|mc| (Sample::Line(SLOPE), format!("N^(−1/2) through {}", mc.label))));
    let costs: [(&str, Cost); 2] = [
        ("trajectories propagated", |m| m.effort.map_or(f64::NAN, |effort| effort.trajectories)),
        ("CPU time [s]", |m| m.effort.map_or(f64::NAN, |effort| effort.t_cal_s)),
    ];
    let quantities: [(&str, Inaccuracy); 2] =
        [("worst relative error", worst_moment), ("worst total variation", worst_distance)];
    let caption = format!(
        "Each marker is a case; lower left is better. Above the largest relative error of the means and standard deviations \
         after t = 0, below the largest total variation distance of the joint density, both against {}. A mixture counts five \
         sigma points per component, also those that neighbours share. Not in Sun et al. (2022).",
        scene.reference
    );
    let title = "Accuracy against effort";
    Figure::draw(&scene.figure_name("accuracy-against-effort"), title, &caption, (760, 560), &key, |area| {
        for (k, area) in area.split_evenly((2, 2)).iter().enumerate() {
            let ((x_label, cost), (y_label, error)) = (costs[k % 2], quantities[k / 2]);
            let place = |m: &Method<'_>| (cost(m), error(scene, m));
            let is_shown = |(x, y): &Point| *x > 0.0 && *y > ROUNDING && x.is_finite() && y.is_finite();
            let points: Vec<Point> = scene.others().map(place).filter(is_shown).collect();
            let axis = |label: &str, of: fn(&Point) -> f64, count| {
                let (low, high) =
                    points.iter().map(of).fold((f64::INFINITY, 0.0), |(low, high), v| (v.min(low), v.max(high)));
                if low < f64::INFINITY {
                    Axis::logarithmic(label, 0.5 * low, 2.0 * high, count)
                } else {
                    Axis::logarithmic(label, 0.1, 10.0, count)
                }
            };
            let (x, y) = (axis(x_label, |p| p.0, 5), axis(y_label, |p| p.1, 6));
            let panel = Panel::new(area, &x, &y, Surroundings::default())?;
            let through = sampled.filter(|mc| mc.label != scene.reference).map(place).filter(is_shown);
            let slope = through.map(|(at, error)| {
                let height = |x: f64| error.log10() - 0.5 * (x - at.log10());
                Element::curve([x.range.start, x.range.end].map(|x| (x, height(x))).to_vec(), SLOPE)
            });
            panel.draw(&slope.into_iter().collect::<Vec<_>>())?;
            for method in scene.others() {
                let point = Some(place(method)).filter(is_shown).map(|(x, y)| (x.log10(), y.log10()));
                panel.draw_over(&[Element::markers_of(point.into_iter().collect(), &method.pen)])?;
            }
        }
        Ok(())
    })
}

/// Largest relative error of the means and standard deviations after t = 0; NaN if there is none.
pub fn worst_moment(scene: &Scene<'_>, method: &Method<'_>) -> f64 {
    let quantities = means_and_deviations(scene.description);
    let all = quantities.iter().flat_map(|quantity| errors(scene, method, &quantity.name));
    all.filter(|(t, _)| *t > 0.0).map(|(_, error)| error).fold(f64::NAN, f64::max)
}

/// Largest total variation distance of the density by which methods are judged, in the plane the joint density; NaN if
/// there is none.
pub fn worst_distance(scene: &Scene<'_>, method: &Method<'_>) -> f64 {
    let density = scene.description.projections.first().map_or("", |projection| projection.density.as_str());
    let rows = scene.results.distances.iter().filter(|row| row.scenario == scene.name && row.method == method.label);
    let rows = rows.filter(|row| row.density == density && row.measure == "total_variation");
    rows.map(|row| row.value).filter(|value| value.is_finite()).fold(f64::NAN, f64::max)
}
