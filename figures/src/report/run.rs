//! What was run, and a short summary of the results.

use maud::{Markup, html};

use super::numbers::{count, seconds, small};
use super::{Drawn, DrawnScene, answer};
use crate::drawings::accuracy::{worst_distance, worst_moment};
use crate::scene::Scene;
use crate::words::glyph;
use results::Results;
use results::notes::{NoteGroup, Severity, groups, listed};
use results::rows::of_scenario;

/// An overview of the cases, and the most accurate of them.
pub fn summary(drawn: &Drawn<'_>) -> Markup {
    let manifest = &drawn.results.manifest;
    let scenarios: Vec<&str> = drawn.scenes.iter().map(|drawn| drawn.scene.name).collect();
    let first = drawn.scenes.first().map(|drawn| drawn.scene.description);
    let variables = first.map_or(Vec::new(), |first| first.variables.iter().map(|v| glyph(&v.symbol)).collect());
    let variables = variables.join(", ");
    html! {
        @for DrawnScene { scene, .. } in &drawn.scenes { (answer::of(scene)) }
        @for group in of_severity(drawn, Severity::Fallback) {
            p.warning { "In " (group.first.scenario) ": " (group.when()) (group.first.text()) "." }
        }
        @for group in of_severity(drawn, Severity::Error) {
            p.warning { "In " (group.first.scenario) ", " (group.first.method) ": " (group.when()) (group.first.text()) "." }
        }
        p {
            "This run propagated the density of (" (variables) ") in " (listed(&scenarios)) " with " (manifest.cases.len())
            @if manifest.cases.len() == 1 { " case" } @else { " cases" }
            " and compared each with " b { (manifest.reference) } ". "
            @if manifest.failures.is_empty() && manifest.incomplete_because.is_none() { "Every case ran to its end." }
        }
        @if let Some(why) = &manifest.incomplete_because {
            p.warning { "These results are not whole: " (why) "." }
        }
        @for (label, why) in &manifest.failures {
            p.warning { "The case " b { (label) } " failed and was left out: " (why) "." }
        }
        @for DrawnScene { scene, .. } in &drawn.scenes {
            div.table tabindex="0" role="region" aria-label={ "Cases at a glance, " (scene.name) } {
                table {
                    caption { "Cases at a glance, " (scene.name) ": largest relative error of the means and standard deviations after t = 0, \
                        largest total variation distance of the joint density, both against " (scene.reference) ", and what it cost." }
                    thead { tr {
                        th scope="col" { "case" } th scope="col" { "trajectories" } th scope="col" { "CPU time, s" }
                        th scope="col" { "worst relative error" } th scope="col" { "worst total variation" }
                    } }
                    tbody { @for method in &scene.methods { tr {
                        th scope="row" { (method.label) }
                        td { (count(method.effort.map_or(f64::NAN, |effort| effort.trajectories))) }
                        td { (seconds(method.effort.map_or(f64::NAN, |effort| effort.t_cal_s))) }
                        @if method.label == scene.reference { td { "reference" } td { "reference" } }
                        @else { td { (small(worst_moment(scene, method))) } td { (small(worst_distance(scene, method))) } }
                    } } }
                }
            }
            p { (verdict(scene)) }
            (verdicts(scene))
        }
    }
}

/// What each case is good for.
fn verdicts(scene: &Scene<'_>) -> Markup {
    let rows = of_scenario(&scene.results.verdicts, scene.name);
    let tolerance = rows.first().map_or(0.0, |row| row.tolerance);
    html! { @if !rows.is_empty() {
        div.table tabindex="0" role="region" aria-label={ "Verdicts, " (scene.name) } {
            table.words {
                caption { "What each case of " (scene.name) " is good for, to " (100.0 * tolerance) " %: errors of means and deviations in standard \
                    deviations, of probabilities, and the total variation of the joint density; ± is the noise of samples." }
                thead { tr { th scope="col" { "case" } th scope="col" { "verdict" } th scope="col" { "worst moment" } th scope="col" { "worst density" } } }
                tbody { @for row in rows { tr {
                    th scope="row" { (row.method) }
                    td { (row.verdict) }
                    td { (worst((row.moments_error, row.moments_noise), &row.moments_quantity, row.moments_t_yr, &row.moments_judged_by)) }
                    td { (worst((row.density_error, row.density_noise), "", row.density_t_yr, &row.density_judged_by)) }
                } } }
            }
        }
    } }
}

fn worst((error, noise): (f64, f64), quantity: &str, t_yr: f64, by: &str) -> Markup {
    let quantity = quantity.replace('_', " ");
    html! {
        @if by == "withheld" { "withheld" } @else if error.is_nan() { "not measured, by " (by) } @else {
            (small(error)) @if noise > 0.0 { " ± " (small(noise)) } ", by " (by)
        }
        @if !quantity.is_empty() { ", " (quantity) }
        " at " (t_yr) " yr"
    }
}

/// The notes of a severity, those that differ only in their numbers together.
fn of_severity<'a>(drawn: &'a Drawn<'_>, severity: Severity) -> Vec<NoteGroup<'a>> {
    groups(drawn.results.notes.iter().filter(|note| note.severity() == severity))
}

/// Names the case whose moments are closest to the reference.
fn verdict(scene: &Scene<'_>) -> String {
    let errors = scene.others().map(|method| (method.label, worst_moment(scene, method)));
    let best = errors.filter(|(_, error)| error.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(String::new(), |(label, error)| {
        format!("In {} the moments of {label} are closest: off by at most {:.2} %.", scene.name, 100.0 * error)
    })
    .replace("at most 0.00 %", "less than 0.01 %")
}

/// Warnings and remarks as sentences.
pub fn remarks(drawn: &Drawn<'_>) -> Markup {
    let groups = groups(&drawn.results.notes);
    let is_grave = |group: &NoteGroup<'_>| group.first.severity() != Severity::Remark;
    html! {
        @if groups.is_empty() { p { "No method doubts its own result." } }
        @else {
            ul { @for group in &groups {
                li.warning[is_grave(group)] {
                    b { (group.first.method) } " in " (group.first.scenario)
                    @let times = group.times_in_words();
                    @if !times.is_empty() { " at t = " (times) " yr" }
                    ": " (group.first.note) "."
                    @if group.times.len() > 1 { " (The numbers are those of the first time; the others are in notes.csv.)" }
                }
            } }
        }
    }
}

/// The run and its cases.
pub fn what_was_run(results: &Results) -> Markup {
    let manifest = &results.manifest;
    let mut labels: Vec<&str> = Vec::new();
    for row in &results.moments {
        if !labels.contains(&row.method.as_str()) {
            labels.push(&row.method);
        }
    }
    labels.extend(manifest.cases.keys().map(String::as_str).filter(|label| manifest.failures.contains_key(*label)));
    labels.dedup();
    html! {
        p {
            "Run " code { (manifest.run_id) } ", started " time datetime=(manifest.started) { (manifest.started.replace('T', " ").replace('Z', " UTC")) }
            ", with " @for (i, (name, version)) in manifest.versions.iter().enumerate() { @if i > 0 { ", " } (name) " " (version) } "."
        }
        div.table tabindex="0" role="region" aria-label="Cases" {
            table.words {
                caption { "The cases. The same settings and seeds give the same numbers, however many threads there are." }
                thead { tr { th scope="col" { "case" } th scope="col" { "runs" } th scope="col" { "settings" } } }
                tbody { @for label in labels { @if let Some(case) = manifest.cases.get(label) { tr {
                    th scope="row" { (label) @if label == manifest.reference { " (reference)" } }
                    td { code { (case.runs.join(" ")) } }
                    td { @for (i, setting) in case.settings.iter().enumerate() { @if i > 0 { ", " } code { (setting) } } }
                } } } }
            }
        }
    }
}

/// The scenarios with their parameters.
pub fn scenarios(drawn: &Drawn<'_>) -> Markup {
    let columns: Vec<Vec<Stated>> = drawn.scenes.iter().map(|drawn| stated(&drawn.scene)).collect();
    let mut rows: Vec<(&str, &str)> = Vec::new();
    for (name, unit, _) in columns.iter().flatten() {
        if !rows.contains(&(name, unit)) {
            rows.push((name, unit));
        }
    }
    let value = |column: &[Stated], row: &(&str, &str)| {
        column
            .iter()
            .find(|(name, unit, _)| (name.as_str(), unit.as_str()) == *row)
            .map_or("–".into(), |stated| stated.2.clone())
    };
    html! {
        div.table tabindex="0" role="region" aria-label="Scenarios" {
            table.words {
                caption { "The scenarios: force, initial Gaussian, snapshots, disposal." }
                thead { tr { th scope="col" { "parameter" } th scope="col" { "unit" } @for DrawnScene { scene, .. } in &drawn.scenes { th scope="col" { (scene.name) } } } }
                tbody { @for row in &rows { tr {
                    th scope="row" { (row.0) } td { (if row.1.is_empty() { "–" } else { row.1 }) }
                    @for column in &columns { td { (value(column, row)) } }
                } } }
            }
        }
    }
}

/// A parameter of a scenario: its name, its unit and its value.
type Stated = (String, String, String);

/// All parameters of a scenario, in the order of the table.
fn stated(scene: &Scene<'_>) -> Vec<Stated> {
    let description = scene.description;
    let mut rows: Vec<Stated> = Vec::new();
    let mut row = |name: String, unit: &str, value: String| rows.push((name, unit.into(), value));
    for parameter in &description.parameters {
        row(format!("{} parameter {}", parameter.name, parameter.symbol), "", parameter.value.to_string());
    }
    let count = description.variables.len();
    for (variable, mean) in description.variables.iter().zip(&description.mean) {
        row(format!("initial mean {}", variable.name), &variable.unit, mean.to_string());
    }
    // The upper triangle has the variance of variable k where its row begins.
    let start = |k: usize| (0..k).map(|before| count - before).sum::<usize>();
    let deviation = |k: usize| description.covariance.get(start(k)).map_or(f64::NAN, |variance| variance.sqrt());
    for (k, variable) in description.variables.iter().enumerate() {
        let name = format!("initial standard deviation of the {}", variable.name);
        row(name, &variable.unit, deviation(k).to_string());
    }
    let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
    for (a, b) in pairs {
        let covariance = description.covariance.get(start(a) + b - a).copied().unwrap_or(f64::NAN);
        let correlation = covariance / (deviation(a) * deviation(b));
        let [first, second] = [a, b].map(|k| description.variables[k].name.as_str());
        row(format!("initial correlation of {first} and {second}"), "", rounded(correlation).to_string());
    }
    let times: Vec<String> = scene.times.iter().map(f64::to_string).collect();
    row("snapshots".into(), "yr", times.join(", "));
    if let Some(variable) = description.reentry_variable() {
        row(format!("critical {}", variable.name), &variable.unit, description.critical.to_string());
    }
    let grid = scene.yardstick().and_then(|yardstick| yardstick.densities.first()).map(|density| density.grid);
    if let (Some(grid), Ok([x, y])) = (grid, scene.variables()) {
        let name = format!("bins of the comparison grid, {} × {}", glyph(&x.symbol), glyph(&y.symbol));
        row(name, "", format!("{} × {}", grid.x.bins, grid.y.bins));
    }
    rows
}

/// A number without the rounding errors of a few operations: the 12 decimals that a correlation has.
fn rounded(value: f64) -> f64 {
    (1e12 * value).round() / 1e12
}
