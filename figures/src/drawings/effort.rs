//! The effort of each case: shares of propagation and estimation (Fig. 7), and effort relative to Monte Carlo (Fig. 8).

use plotters::style::text_anchor::{HPos, VPos};

use crate::axis::Axis;
use crate::draw_error::DrawError;
use crate::elements::Element;
use crate::figure::Figure;
use crate::legend::{Entry, Sample};
use crate::palette::{Ink, Marker, Stroke};
use crate::panel::{Panel, SMALL, Surroundings, text_style};
use crate::scene::{Method, Scene};
use crate::text::subscript;

const ROW: u32 = 28;
const PROPAGATION: Ink = Ink::Series(0);
const ESTIMATION: Ink = Ink::Series(1);

/// Shares of propagation and estimation in the effort of each case.
pub fn draw_shares(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let methods: Vec<(&Method<'_>, f64, f64)> = scene
        .methods
        .iter()
        .filter_map(|method| method.effort.map(|effort| (method, effort.t_prop_s, effort.t_cal_s)))
        .collect();
    let outline = |ink| Stroke { ink, width: 1.2, dashes: &[] };
    let key: Vec<Entry> = vec![
        (Sample::Marker(Marker::Square, outline(PROPAGATION), true), "propagation".into()),
        (Sample::Marker(Marker::Square, outline(ESTIMATION), false), "estimation of the densities".into()),
    ];
    let caption = "CPU time of all threads: the part that propagates (full), the part that turns snapshots into densities \
                   (outlined), and their sum in seconds. Corresponds to Fig. 7 of Sun et al. (2022).";
    let height = ROW * methods.len() as u32 + 56;
    Figure::draw(&scene.figure_name("effort-shares"), "Shares of the effort", caption, (760, height), &key, |area| {
        let mut y = Axis::names(methods.iter().map(|(method, ..)| method.label.to_owned()).collect());
        downwards(&mut y);
        let x = Axis::linear("share of the CPU time [%]", 0.0..112.0, 5);
        let x = Axis { ticks: vec![0.0, 25.0, 50.0, 75.0, 100.0], ..x };
        let panel = Panel::new(area, &x, &y, Surroundings::default())?;
        for (row, (_, propagation, total)) in methods.iter().enumerate() {
            let middle = y.ticks[row];
            let share = if *total > 0.0 { 100.0 * propagation / total } else { 0.0 };
            let (low, high) = (middle - 0.3, middle + 0.3);
            let frame = vec![(share, low), (100.0, low), (100.0, high), (share, high), (share, low)];
            panel.draw(&[
                Element::block((0.0, low), (share, high), PROPAGATION, 0.9),
                Element::block((share, low), (100.0, high), ESTIMATION, 0.15),
                Element::curve(frame, outline(ESTIMATION)),
            ])?;
            let style = text_style(SMALL, Ink::Text, HPos::Right, VPos::Center);
            panel.write(&format!("{total:.3} s"), (111.5, middle), style)?;
        }
        Ok(())
    })
}

/// Effort of each case in all scenarios of the run, relative to that of the baseline if there is one.
pub fn draw_normalised(scenes: &[Scene<'_>]) -> Result<Figure, DrawError> {
    let mut labels: Vec<&str> = Vec::new();
    for method in scenes.iter().flat_map(|scene| &scene.methods).filter(|method| method.effort.is_some()) {
        if !labels.contains(&method.label) {
            labels.push(method.label);
        }
    }
    let is_normalised = scenes
        .iter()
        .flat_map(|scene| &scene.methods)
        .any(|m| m.effort.is_some_and(|e| e.ratio_to_baseline.is_finite()));
    let value = |method: &Method<'_>| {
        method.effort.map(|e| if is_normalised { e.ratio_to_baseline } else { e.t_cal_s }).filter(|v| *v > 0.0)
    };
    let values = || scenes.iter().flat_map(|scene| scene.methods.iter().filter_map(value));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    if !low.is_finite() {
        return Err(DrawError("no case has an effort".into()));
    }
    let stroke = |scene: usize| Stroke { ink: Ink::Series(scene), width: 1.8, dashes: &[] };
    let key: Vec<Entry> = scenes
        .iter()
        .enumerate()
        .map(|(k, scene)| (Sample::Marker(Marker::of(k), stroke(k), false), scene.name.to_owned()))
        .collect();
    let baseline =
        scenes.first().and_then(|scene| scene.results.manifest.baseline.as_deref()).unwrap_or("the baseline");
    let (label, title) = if is_normalised {
        (relative_effort(baseline), "Normalised effort")
    } else {
        ("CPU time [s]".to_owned(), "Effort")
    };
    let caption = "CPU time of propagation and estimation together, on a logarithmic axis. Corresponds to Fig. 8 of Sun et al. (2022).";
    let height = ROW * labels.len() as u32 + 56;
    Figure::draw("effort-normalised", title, caption, (760, height), &key, |area| {
        let mut y = Axis::names(labels.iter().map(|&label| label.to_owned()).collect());
        downwards(&mut y);
        let x = Axis::logarithmic(&label, 0.7 * low, 1.4 * high, 8);
        let panel = Panel::new(area, &x, &y, Surroundings::default())?;
        for (k, scene) in scenes.iter().enumerate() {
            let place = |method: &Method<'_>| {
                let row = labels.iter().position(|label| *label == method.label)?;
                Some((value(method)?.log10(), y.ticks.get(row).copied()?))
            };
            let points = scene.methods.iter().filter_map(place).collect();
            panel.draw_over(&[Element::markers(points, Marker::of(k), 4.5, stroke(k), false)])?;
        }
        Ok(())
    })
}

/// The words for the effort as a multiple of that of the case `baseline`.
fn relative_effort(baseline: &str) -> String {
    let of_baseline = subscript("t", &format!("cal-{}", baseline.to_uppercase()));
    format!("effort relative to {baseline}, {} / {of_baseline}", subscript("t", "cal"))
}

/// Reverses an axis of names so that the first is on top.
fn downwards(axis: &mut Axis) {
    axis.ticks.reverse();
    if let crate::axis::Labels::Names(names) = &mut axis.labels {
        names.reverse();
    }
}
