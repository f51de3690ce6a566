//! The tables of a scenario.

use maud::{Markup, html};

use super::numbers::{count, given, plain, probability, seconds, small};
use crate::densities::Density;
use crate::scene::{Method, Scene};
use crate::words::{glyph, means_and_deviations, moment_symbol, reentry};
use results::description::{Description, Projection};
use results::notes::listed;
use results::rows::{ErrorRow, PassageRow, RE_ENTRY};

/// A table in a frame that scrolls where the page is narrow.
fn framed(name: &str, table: &Markup) -> Markup {
    html! { div.table tabindex="0" role="region" aria-label=(name) { (table) } }
}

fn time_heads(scene: &Scene<'_>) -> Markup {
    html! { @for t in &scene.times { th scope="col" { "t = " (t) " yr" } } }
}

/// Means and standard deviations, with standard errors and relative errors.
pub fn moments(scene: &Scene<'_>) -> Markup {
    let quantities = means_and_deviations(scene.description);
    let circles = scene.description.variables.iter().filter(|variable| variable.is_circle());
    let circles: Vec<&str> = circles.map(|variable| glyph(&variable.symbol)).collect();
    let units = scene.description.variables.iter().filter(|variable| !variable.unit.is_empty());
    let units: Vec<String> = units.map(|v| format!("of {} in {}", glyph(&v.symbol), v.unit)).collect();
    let table = html! {
        table {
            caption {
                "Means μ and standard deviations σ" @for unit in &units { ", " (unit) }
                @if !circles.is_empty() { ", of " (listed(&circles)) " on the branch that keeps the cloud whole" } ". ± is the standard error of a method that \
                 samples; δ is the relative error against " (scene.reference) "."
            }
            thead { tr { th scope="col" { "case" } th scope="col" { "" } (time_heads(scene)) } }
            @for method in &scene.methods { tbody {
                @for (k, quantity) in quantities.iter().enumerate() { @let (letter, index) = moment_symbol(scene.description, quantity); tr {
                    @if k == 0 { th scope="rowgroup" rowspan=(quantities.len()) { (method.label) } }
                    th scope="row" { i { (letter) } sub { (index) } }
                    @for row in &method.moments { @let (value, error) = (row.number(&quantity.column), row.standard_error(&quantity.column)); td {
                        (given(value, plain))
                        @if error.is_finite() { " " span.uncertainty { "± " (small(error)) } }
                        @if method.label != scene.reference { span.error { "δ " (small(relative_error(scene, method, row.t_yr, &quantity.name))) } }
                    } }
                } }
            } }
        }
    };
    framed(&format!("Moments, {}", scene.name), &table)
}

fn relative_error(scene: &Scene<'_>, method: &Method<'_>, t_yr: f64, quantity: &str) -> f64 {
    let is_it = |row: &&ErrorRow| {
        row.scenario == scene.name && row.method == method.label && row.t_yr == t_yr && row.quantity == quantity
    };
    scene.results.errors.iter().find(is_it).map_or(f64::NAN, |row| row.rel_error)
}

/// Probabilities of being above the critical value at each snapshot, and of ever having reached it.
pub fn probabilities(scene: &Scene<'_>, has_passages: bool) -> Markup {
    let end = scene.times.last().copied().unwrap_or(0.0);
    let (above, symbol) = (scene.description.above_critical(), reentry(scene.description).1);
    let has_interval = |row: &&PassageRow| row.high - row.low > 1e-6;
    let table = html! {
        table {
            caption { "Probability that " (symbol) " exceeds " (scene.description.critical) " at each time, and that it has ever reached it. ± is a standard error." }
            thead { tr {
                th scope="col" { "case" } (time_heads(scene))
                @if has_passages { th scope="col" { "ever by " (end) " yr" } th scope="col" { "interval" } }
            } }
            tbody { @for method in &scene.methods { @let last = method.passage.last().copied(); tr {
                th scope="row" { (method.label) }
                @for row in &method.moments { td {
                    @let error = row.standard_error(above);
                    (given(row.number(above), probability))
                    @if error.is_finite() { " " span.uncertainty { "± " (small(error)) } }
                } }
                @if has_passages {
                    td { @if let Some(row) = last { (given(row.prob_reached_critical_e, probability)) } @else { "–" } }
                    td { @if let Some(row) = last.filter(|row| has_interval(row)) { (plain(row.low)) " to " (plain(row.high)) @if !row.interval.is_empty() { " (" (row.interval) ")" } } @else { "–" } }
                }
            } } }
        }
    };
    framed(&format!("Probabilities, {}", scene.name), &table)
}

/// Mean and deviation of an uncertain radiation parameter given re-entry by the end, and given none.
pub fn given_re_entry(scene: &Scene<'_>) -> Markup {
    let end = scene.times.last().copied().unwrap_or(0.0);
    let cell = |value: f64, error: f64| {
        html! {
            @if value.is_nan() { "too rare" } @else { (plain(value)) }
            @if error.is_finite() { " " span.uncertainty { "± " (small(error)) } }
        }
    };
    let table = html! {
        table {
            caption { "The radiation parameter C given re-entry by " (end) " yr, and given none: what re-entry hangs on. ± is a standard error, or an estimate of the error." }
            thead { tr { th scope="col" { "case" } th.left scope="col" { "given" } th scope="col" { "mean" } th scope="col" { "deviation" } } }
            @for method in &scene.methods { @let rows: Vec<_> = scene.given(method).into_iter().filter(|row| row.t_yr == end).collect(); tbody {
                @for (k, row) in rows.iter().enumerate() { tr {
                    @if k == 0 { th scope="rowgroup" rowspan=(rows.len()) { (method.label) } }
                    th scope="row" { @if row.given == RE_ENTRY { "re-entry" } @else { "no re-entry" } }
                    td { (cell(row.mean_C, row.error_mean_C)) }
                    td { (cell(row.std_C, row.error_std_C)) }
                } }
            } }
        }
    };
    framed(&format!("Radiation parameter, {}", scene.name), &table)
}

/// Distances of the densities at each snapshot.
pub fn distances(scene: &Scene<'_>) -> Markup {
    let value = |method: &Method<'_>, t: f64, density: &str, measure: &str| {
        let rows =
            scene.results.distances.iter().filter(|row| row.scenario == scene.name && row.method == method.label);
        let mut rows = rows.filter(|row| row.t_yr == t && row.density == density && row.measure == measure);
        rows.next().map_or(f64::NAN, |row| row.value)
    };
    let is_withheld = |method: &Method<'_>, index: usize| {
        let cases = [Some(method), scene.method(scene.reference)];
        cases.into_iter().flatten().any(|case| case.densities.get(index).is_some_and(Density::is_withheld))
    };
    let measures = distances_shown(scene.description);
    let table = html! {
        table {
            caption { "Distances from the density of " (scene.reference) ", 0 for the same density, 1 for densities that have nothing in common; distances.csv has more." }
            thead { tr { th scope="col" { "case" } th.left scope="col" { "distance" } (time_heads(scene)) } }
            @for method in scene.others() { tbody {
                @for (k, (density, measure, name)) in measures.iter().enumerate() { tr {
                    @if k == 0 { th scope="rowgroup" rowspan=(measures.len()) { (method.label) } }
                    th scope="row" { (name) }
                    @for (index, &t) in scene.times.iter().enumerate() { @let value = value(method, t, density, measure); td {
                        @if value.is_nan() && is_withheld(method, index) { "withheld" } @else { (small(value)) }
                    } }
                } }
            } }
        }
    };
    framed(&format!("Distances, {}", scene.name), &table)
}

/// The distances that are shown: the density, the measure, and the words for both. Densities of two variables have a
/// total variation and a Hellinger distance, those of one variable the largest difference of their distribution
/// functions.
fn distances_shown(description: &Description) -> Vec<(String, &'static str, String)> {
    let symbols = |projection: &Projection| -> Vec<&str> {
        projection.variables.iter().map(|&position| glyph(&description.variables[position].symbol)).collect()
    };
    let name = |projection: &Projection| match projection.density.as_str() {
        "joint" => "joint".to_owned(),
        _ => symbols(projection).join(", "),
    };
    let of = |projection: &Projection| {
        let measures: &[(&str, &str)] = match projection.variables.len() {
            1 => &[("kolmogorov", "Kolmogorov")],
            _ => &[("total_variation", "total variation"), ("hellinger", "Hellinger")],
        };
        let row = |(measure, words): &(&'static str, &str)| {
            (projection.density.clone(), *measure, format!("{words}, {}", name(projection)))
        };
        measures.iter().map(row).collect::<Vec<_>>()
    };
    let first = description.projections.first().map_or(String::new(), |projection| projection.density.clone());
    let outside = (first, "mass_outside_grid", "mass outside the grid".to_owned());
    description.projections.iter().flat_map(of).chain([outside]).collect()
}

/// The effort of each case.
pub fn effort(scene: &Scene<'_>) -> Markup {
    let rows = scene.methods.iter().filter_map(|method| Some((method.label, method.effort?)));
    let baseline = scene.results.manifest.baseline.as_deref();
    let of_baseline = baseline.map_or("baseline".to_owned(), str::to_uppercase);
    let table = html! {
        table {
            caption { "CPU time of all threads: propagation, estimation of the densities, their sum; and the sum relative to that of " (baseline.map_or("a baseline, which this run has not".to_owned(), |label| format!("the case {label}"))) "." }
            thead { tr {
                th scope="col" { "case" } th scope="col" { "trajectories" } th scope="col" { "t" sub { "prop" } ", s" } th scope="col" { "t" sub { "int" } ", s" }
                th scope="col" { "t" sub { "cal" } ", s" } th scope="col" { "t" sub { "cal" } " / t" sub { "cal-" (of_baseline) } }
            } }
            tbody { @for (label, row) in rows { tr {
                th scope="row" { (label) } td { (count(row.trajectories)) }
                td { (seconds(row.t_prop_s)) } td { (seconds(row.t_int_s)) } td { (seconds(row.t_cal_s)) } td { (seconds(row.ratio_to_baseline)) }
            } } }
        }
    };
    framed(&format!("Effort, {}", scene.name), &table)
}

/// What each diagnostic means.
fn meaning(diagnostic: &str) -> &str {
    match diagnostic {
        "trajectory_error" => {
            "the propagator's own estimate of the largest error of a coordinate of an interpolated trajectory"
        }
        "measure_defect" => "share of the flow's invariant measure that the mesh loses: how coarse it is for the flow",
        "flipped_mass" => "probability in triangles that the flow has turned over",
        "truncated_mass" => "probability outside the mesh",
        "misplaced_mass" => "probability that the joint density may have in wrong bins",
        "disagreement" => "how far the flow over a component is from linear",
        "moment_error_sigmas" => "estimated error of the moments, in standard deviations",
        "resultant_vector_error" => "estimated error of the circular mean vector",
        "prob_above_critical_e_error" => "estimated error of the probability above the critical value",
        "joint_l1_error" => "estimated L1 error of the joint density",
        other => other,
    }
}

/// The worst value of each diagnostic.
pub fn diagnostics(scene: &Scene<'_>) -> Markup {
    let mut worst: Vec<(&str, &str, f64, f64)> = Vec::new();
    for row in scene.results.diagnostics.iter().filter(|row| row.scenario == scene.name && row.value.is_finite()) {
        match worst
            .iter_mut()
            .find(|(method, name, ..)| (*method, *name) == (row.method.as_str(), row.diagnostic.as_str()))
        {
            Some(known) if known.2 < row.value => (known.2, known.3) = (row.value, row.t_yr),
            Some(_) => {}
            None => worst.push((&row.method, &row.diagnostic, row.value, row.t_yr)),
        }
    }
    let table = html! {
        table.words {
            caption { "The worst value of each diagnostic over all snapshots. All are 0 for a perfect result." }
            thead { tr { th scope="col" { "case" } th scope="col" { "diagnostic" } th scope="col" { "worst" } th scope="col" { "at t, yr" } } }
            tbody { @for (method, name, value, t) in &worst { tr {
                th scope="row" { (method) } td { (meaning(name)) } td.number { (small(*value)) } td.number { (t) }
            } } }
        }
    };
    html! { @if worst.is_empty() { p { "No method reports a diagnostic here." } } @else { (framed(&format!("Diagnostics, {}", scene.name), &table)) } }
}
