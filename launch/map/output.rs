//! The files of a finished map: table, arrays, figure and page.

use std::path::Path;

use density::exact::Estimated;
use density::reliability::Quantity;
use density::reliability::refinement::Cell;
use figures::figure::Figure;
use figures::reliability_map::{Along, Map};
use maud::{DOCTYPE, PreEscaped, html};
use nodes::files::map_file::MapFile;
use results::arrays::ArrayWriter;
use results::table::Table;

use super::computed::{COPIES, Computed};

/// One row per point.
pub const TABLE: &str = "map.csv";
/// The same as arrays for numpy.
pub const ARRAYS: &str = "map.npz";
/// The figure.
pub const FIGURE: &str = "map.svg";
/// The page with the figure.
pub const PAGE: &str = "report.html";

/// Writes the files, and so finishes the map.
///
/// # Errors
/// Which file cannot be written.
pub fn write(map: &MapFile, cells: &[Cell], folder: &Path) -> Result<(), String> {
    table(map, cells, &folder.join(TABLE))?;
    arrays(map, cells, &folder.join(ARRAYS))?;
    let figure = figure(map, cells)?;
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
    };
    write(FIGURE, figure.to_file())?;
    write(PAGE, page(map, cells, &figure))?;
    Computed::remove(folder)
}

/// The places of a map in the order of its cells.
fn places(map: &MapFile) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, height) = map.size();
    (0..width).flat_map(move |x| (0..height).map(move |y| (x, y)))
}

fn table(map: &MapFile, cells: &[Cell], path: &Path) -> Result<(), String> {
    let head = map.axes.iter().map(String::as_str).chain(["value", "error", "is_interpolated"]);
    let mut table = Table::with_head(path, head).map_err(|e| e.to_string())?;
    let rows = places(map).zip(cells).map(|(place, cell)| {
        let Cell { quantity: Estimated { value, error }, is_interpolated } = cell;
        let numbers = map.place(place).into_iter().chain([*value, *error]).map(short);
        numbers.chain([u8::from(*is_interpolated).to_string()]).collect::<Vec<_>>()
    });
    table.write(rows).and_then(|()| table.finish()).map_err(|e| e.to_string())
}

/// A number to its last digit, without hundreds of zeros where it is tiny.
fn short(number: f64) -> String {
    let is_tiny = number != 0.0 && number.abs() < 1e-5;
    if is_tiny { format!("{number:e}") } else { number.to_string() }
}

fn along(map: &MapFile, axis: usize) -> Vec<f64> {
    let (width, height) = map.size();
    match axis {
        0 => (0..width).filter_map(|x| map.place((x, 0)).first().copied()).collect(),
        _ => (0..height).filter_map(|y| map.place((0, y)).get(1).copied()).collect(),
    }
}

fn arrays(map: &MapFile, cells: &[Cell], path: &Path) -> Result<(), String> {
    let write = || {
        let mut archive = ArrayWriter::create(path)?;
        let mut shape = Vec::new();
        for (axis, key) in map.axes.iter().enumerate() {
            let values = along(map, axis);
            archive.add(key, &[values.len()], &values)?;
            shape.push(values.len());
        }
        let of = |number: fn(&Cell) -> f64| cells.iter().map(number).collect::<Vec<f64>>();
        archive.add("value", &shape, &of(|cell| cell.quantity.value))?;
        archive.add("error", &shape, &of(|cell| cell.quantity.error))?;
        archive.add("is_interpolated", &shape, &of(|cell| f64::from(u8::from(cell.is_interpolated))))?;
        archive.finish()
    };
    write().map_err(|e: results::FolderError| e.to_string())
}

fn figure(map: &MapFile, cells: &[Cell]) -> Result<Figure, String> {
    let axis = |axis: usize| Along { label: words(map, &map.axes[axis]), values: along(map, axis) };
    let drawn = Map {
        name: "map".into(),
        label: map.label(),
        is_probability: map.other.is_none() && matches!(map.quantity, Quantity::Reentry { .. }),
        x: axis(0),
        y: (map.axes.len() > 1).then(|| axis(1)),
        values: cells.iter().map(|cell| (cell.quantity.value, cell.quantity.error)).collect(),
    };
    drawn.draw().map_err(|e| format!("{FIGURE}: {e}"))
}

/// A key of a scenario file as the label of an axis, with the unit in which it is varied.
fn words(map: &MapFile, key: &str) -> String {
    let (words, own) = match key {
        "orbit.semi_major_axis" => ("semi-major axis a", "Earth radii"),
        "orbit.altitude" => ("altitude of a circular orbit", "km"),
        "orbit.area_to_mass" => ("area-to-mass ratio", "m²/kg"),
        "orbit.reflectivity" => ("reflectivity coefficient", ""),
        "orbit.radiation" => ("radiation parameter C", ""),
        "orbit.oblateness" => ("oblateness parameter W", ""),
        "epoch.sun_longitude" => ("longitude of the Sun at the start", "rad"),
        "initial.phi" => ("initial solar angle φ", "rad"),
        "initial.e" => ("initial eccentricity e", ""),
        "initial.inclination" => ("initial inclination i", "rad"),
        "initial.node" => ("initial longitude of the ascending node", "rad"),
        "initial.argument_of_pericentre" => ("initial argument of the pericentre", "rad"),
        "initial.sigma_radiation" => ("relative deviation of the radiation parameter", ""),
        "disposal.critical_e" => ("critical eccentricity", ""),
        other => (other, ""),
    };
    match map.sweep.unit(key).unwrap_or(own) {
        "" => words.to_owned(),
        unit => format!("{words} [{unit}]"),
    }
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:60rem;padding:0 1rem}\
    figure{margin:0}svg{width:100%;height:auto}";

/// Whether nothing is known of a cell, not even that its value is not reached.
fn is_undecided(cell: &Cell) -> bool {
    !cell.quantity.error.is_finite()
}

/// So many points with their verb.
fn points(count: usize) -> String {
    if count == 1 { "1 point has".into() } else { format!("{count} points have") }
}

fn page(map: &MapFile, cells: &[Cell], figure: &Figure) -> String {
    let interpolated = cells.iter().filter(|cell| cell.is_interpolated).count();
    let aimed = map.tolerance;
    let (undecided, known): (Vec<&Cell>, Vec<&Cell>) = cells.iter().partition(|cell| is_undecided(cell));
    let worse = known.iter().filter(|cell| cell.quantity.value.is_finite() && cell.quantity.error > aimed).count();
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "phasecloud: " (map.label()) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (map.label()) }
                (figure.to_page("", false))
                p {
                    (cells.len()) " points, of which " (interpolated) " are interpolated between the others. "
                    "An error of " (aimed) " was aimed at; "
                    @if worse == 0 { "no point has a larger estimate." } @else { b { (points(worse)) " a larger estimate." } }
                    @if !undecided.is_empty() {
                        " " b { (points(undecided.len())) " no estimate" }
                        ": whether the value is reached there is within the error of its probability, or it cannot be computed."
                    }
                }
                p { a href=(TABLE) { (TABLE) } " and " (ARRAYS) " have the numbers with their errors; " (COPIES[0]) " and " (COPIES[1]) " are what was asked." }
            }
        }
    };
    markup.into_string()
}
