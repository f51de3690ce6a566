//! What the script of the page needs to know of a scenario, as JSON.

use std::ops::Range;

use density::grid::Axis;
use serde_json::{Value, json};

use super::quantised::{DECADES, encode};
use crate::colour_map::{Scale, colours};
use crate::densities::{Density, Grid};
use crate::draw_error::DrawError;
use crate::scene::{Cloud, Method, Scene};
use crate::words::{density_label, glyph, label, reentry};

/// Room around a cloud, as a share of its extent.
const MARGIN: f64 = 0.08;
/// The most bytes of densities that a page carries per scenario, in all pairs of variables.
const MOST_BYTES: usize = 24 << 20;

/// A scenario, seen in each of its pairs of variables.
///
/// # Errors
/// Why there is nothing to explore: no density of two variables, or more of them than a page should carry.
pub fn of(scenes: &[&Scene<'_>]) -> Result<Value, DrawError> {
    let Some(first) = scenes.first().filter(|scene| scene.pair.is_some()) else {
        return Err(DrawError("no density of two variables is compared".into()));
    };
    let bins = |scene: &&Scene<'_>| {
        scene.methods.iter().flat_map(|m| m.densities).map(|density| density.joint.len()).sum::<usize>()
    };
    let bytes = scenes.iter().map(bins).sum::<usize>() * 8 / 3;
    if bytes > MOST_BYTES {
        let [megabytes, most] = [bytes, MOST_BYTES].map(|bytes| bytes >> 20);
        return Err(DrawError(format!(
            "the densities would add {megabytes} MB to this page, which carries up to {most} MB; with fewer bins, snapshots or cases they fit"
        )));
    }
    let pairs: Vec<Value> = scenes.iter().map(|scene| pair(scene)).collect::<Result<_, _>>()?;
    let (name, symbol) = reentry(first.description);
    Ok(json!({
        "times": first.times,
        "reference": first.reference,
        "cases": first.methods.iter().map(case).collect::<Vec<_>>(),
        "critical": {"name": name, "symbol": symbol, "value": first.description.critical},
        "decades": DECADES,
        "ramp": colours(Scale::Linear(1.0)),
        "divergence": colours(Scale::Difference(1.0)),
        "pairs": pairs,
    }))
}

/// A case: how its curve is drawn, and its first-passage curve if it has one.
fn case(method: &Method<'_>) -> Value {
    let stroke = method.pen.stroke;
    let curve = |number: fn(&results::rows::PassageRow) -> f64| -> Vec<Option<f64>> {
        method.passage.iter().map(|row| number(row)).map(|value| value.is_finite().then_some(value)).collect()
    };
    json!({
        "label": method.label,
        "colours": stroke.ink.on_light_and_dark(),
        "dashes": stroke.dashes,
        "passage": {
            "t": curve(|row| row.t_yr),
            "p": curve(|row| row.prob_reached_critical_e),
            "low": curve(|row| row.low),
            "high": curve(|row| row.high),
            "interval": method.passage.last().map_or("", |row| row.interval.as_str()),
        },
    })
}

/// A pair of variables with the densities of all cases at all snapshots.
fn pair(scene: &Scene<'_>) -> Result<Value, DrawError> {
    let variables = scene.variables()?;
    let (x, y) = (scene.x_range(), scene.y_range());
    let clouds = scene.clouds();
    let snapshot = |index: usize| {
        let densities: Vec<Option<&Density>> = scene.methods.iter().map(|m| m.densities.get(index)).collect();
        let stated = || densities.iter().copied().flatten().filter(|density| !density.is_withheld());
        let peak = stated().map(Density::peak).fold(0.0, f64::max);
        let frame = clouds.get(index).cloned().flatten().map_or((x.clone(), y.clone()), |cloud| around(&cloud));
        let one = |density: &Option<&Density>| match density {
            Some(density) if !density.is_withheld() => {
                json!({"grid": grid(&density.grid), "q": encode(&density.joint, peak)})
            }
            _ => Value::Null,
        };
        json!({
            "peak": peak,
            "frame": [frame.0.start, frame.0.end, frame.1.start, frame.1.end],
            "cases": densities.iter().map(one).collect::<Vec<_>>(),
        })
    };
    let symbol = |place: usize| glyph(&variables[place].symbol);
    Ok(json!({
        "name": format!("{}, {}", symbol(0), symbol(1)),
        "labels": variables.map(label),
        "symbols": [symbol(0), symbol(1)],
        "units": variables.map(|variable| variable.unit.as_str()),
        "is_circle": variables[0].is_circle(),
        "critical_axis": (0..2).find(|&place| scene.is_reentry(place)),
        "density": density_label("density", "1", &variables),
        "frame": [x.start, x.end, y.start, y.end],
        "snapshots": (0..scene.times.len()).map(snapshot).collect::<Vec<_>>(),
    }))
}

/// The range of a cloud with some room around it.
fn around(cloud: &Cloud) -> (Range<f64>, Range<f64>) {
    let wider = |range: &Range<f64>| {
        let room = MARGIN * (range.end - range.start);
        range.start - room..range.end + room
    };
    (wider(&cloud.x), wider(&cloud.y))
}

fn grid(grid: &Grid) -> Value {
    let ends = |axis: &Axis| json!([axis.low, axis.high, axis.bins]);
    json!([ends(&grid.x), ends(&grid.y)])
}
