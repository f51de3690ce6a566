//! What was run, and a short summary of the results.

use density::model::PlanarHamiltonian;
use maud::{Markup, html};

use super::Drawn;
use super::numbers::{count, seconds, small};
use crate::drawings::accuracy::{worst_distance, worst_moment};
use crate::scene::Scene;
use results::Results;
use results::notes::{NoteGroup, Severity, groups, listed};
use results::rows::of_scenario;

/// An overview of the cases, and the most accurate of them.
pub fn summary(drawn: &Drawn<'_>) -> Markup {
    let manifest = &drawn.results.manifest;
    let scenarios: Vec<&str> = drawn.scenes.iter().map(|(scene, _)| scene.name).collect();
    html! {
        @for group in of_severity(drawn, Severity::Fallback) {
            p.warning { "In " (group.first.scenario) ": " (group.when()) (group.first.text()) "." }
        }
        @for group in of_severity(drawn, Severity::Error) {
            p.warning { "In " (group.first.scenario) ", " (group.first.method) ": " (group.when()) (group.first.text()) "." }
        }
        p {
            "This run propagated the density of (φ, e) in " (listed(&scenarios)) " with " (manifest.cases.len())
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
        @for (scene, _) in &drawn.scenes {
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
    type Row = (&'static str, &'static str, fn(&Scene<'_>) -> String);
    let rows: [Row; 8] = [
        ("initial mean solar angle", "rad", |s| s.problem.initial.mean_phi.to_string()),
        ("initial mean eccentricity", "", |s| s.problem.initial.mean_e.to_string()),
        ("initial standard deviation of the solar angle", "rad", |s| s.problem.initial.sigma_phi.to_string()),
        ("initial standard deviation of the eccentricity", "", |s| s.problem.initial.sigma_e.to_string()),
        ("initial correlation of solar angle and eccentricity", "", |s| s.problem.initial.correlation.to_string()),
        ("snapshots", "yr", |s| s.times.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")),
        ("critical eccentricity", "", |s| s.problem.critical_e.to_string()),
        ("bins of the comparison grid, φ × e", "", bins),
    ];
    html! {
        div.table tabindex="0" role="region" aria-label="Scenarios" {
            table.words {
                caption { "The scenarios: force, initial Gaussian, snapshots, disposal." }
                thead { tr { th scope="col" { "parameter" } th scope="col" { "unit" } @for (scene, _) in &drawn.scenes { th scope="col" { (scene.name) } } } }
                tbody { @for (name, symbol) in parameters(drawn) { tr {
                    th scope="row" { (name) " parameter " (symbol) } td { "–" }
                    @for (scene, _) in &drawn.scenes { td { (parameter(scene, name)) } }
                } }
                @for (name, unit, value) in rows { tr {
                    th scope="row" { (name) } td { (if unit.is_empty() { "–" } else { unit }) }
                    @for (scene, _) in &drawn.scenes { td { (value(scene)) } }
                } } }
            }
        }
    }
}

/// The names and symbols of the parameters that the scenarios' models have, each once.
fn parameters(drawn: &Drawn<'_>) -> Vec<(&'static str, &'static str)> {
    let mut names = Vec::new();
    for (parameter, _) in drawn.scenes.iter().flat_map(|(scene, _)| scene.problem.model.parameters()) {
        if !names.contains(&(parameter.name, parameter.symbol)) {
            names.push((parameter.name, parameter.symbol));
        }
    }
    names
}

/// The value of a parameter in a scenario; a dash if its model has no such parameter.
fn parameter(scene: &Scene<'_>, name: &str) -> String {
    let found = scene.problem.model.parameters().into_iter().find(|(parameter, _)| parameter.name == name);
    found.map_or("–".into(), |(_, value)| value.to_string())
}

fn bins(scene: &Scene<'_>) -> String {
    let grid = scene.yardstick().and_then(|yardstick| yardstick.densities.first()).map(|density| density.grid);
    grid.map_or(String::new(), |grid| format!("{} × {}", grid.phi.bins, grid.e.bins))
}
