//! The difference of a case from the exact one: its joint density minus the exact joint density.

use super::density_map::{Map, yardstick};
use super::joint_density::snapshot;
use super::{at_time, withheld_words};
use crate::colour_map::Scale;
use crate::draw_error::DrawError;
use crate::figure::Figure;
use crate::scene::{Method, Scene};

/// Whether a case is the one that is subtracted from the others wherever it gives its density.
pub fn is_exact(scene: &Scene<'_>, method: &Method<'_>) -> bool {
    scene.exact.unwrap_or(scene.reference) == method.label
}

/// The case whose density is subtracted from the others at a snapshot: the exact one, else the reference, else the case
/// that stands in.
pub fn subtrahend<'s, 'a>(scene: &'s Scene<'a>, index: usize) -> Option<&'s Method<'a>> {
    let states = |other: &&Method<'_>| other.densities.get(index).is_some_and(|density| !density.is_withheld());
    scene.method(scene.exact.unwrap_or(scene.reference)).filter(states).or_else(|| scene.yardstick_at(index))
}

/// Draws one snapshot of a case.
pub fn draw(scene: &Scene<'_>, method: &Method<'_>, index: usize) -> Result<Figure, DrawError> {
    let (density, t) = snapshot(scene, method, index)?;
    let subtrahend = subtrahend(scene, index);
    let subtrahend = subtrahend.ok_or_else(|| DrawError(format!("no case states its density at {}", at_time(t))))?;
    let (other, _) = snapshot(scene, subtrahend, index)?;
    if density.grid != other.grid && !density.is_withheld() && !other.is_withheld() {
        return Err(DrawError(format!(
            "{} and {} have different bins at {}",
            method.label,
            subtrahend.label,
            at_time(t)
        )));
    }
    let name = scene.density_figure_name(&format!("difference-{}-{index}", method.label));
    let heading = format!("{} − {}, {}", method.label, subtrahend.label, at_time(t));
    let title = format!("Joint density of {} minus {} at {}", method.label, subtrahend.label, at_time(t));
    let difference: Vec<f64> = density.joint.iter().zip(&other.joint).map(|(p, q)| p - q).collect();
    let limit = difference.iter().map(|d| d.abs()).fold(0.0, f64::max);
    let share = if other.peak() > 0.0 { 100.0 * limit / other.peak() } else { f64::NAN };
    let withheld = [(method.label, density), (subtrahend.label, other)].into_iter().filter(|(_, d)| d.is_withheld());
    let withheld: String = withheld.map(|(label, _)| withheld_words(label, &[t])).collect();
    let caption = if withheld.is_empty() {
        format!(
            "Orange: too high, purple: too low. Each map has a scale of its own; the largest difference here is {share:.2} % of the \
             peak of {}.",
            subtrahend.label
        )
    } else {
        withheld.trim_start().to_owned()
    };
    let yardstick = yardstick(scene, density, index);
    let variables = scene.variables()?;
    let map = Map { density, values: &difference, yardstick, variables, scale: Scale::Difference(limit) };
    map.draw(&name, [&title, &heading, &caption], "difference")
}
