//! `report.html` of a sweep: what was varied, and one row per scenario and method, in one file that loads nothing else.

use std::path::Path;

use figures::report::PAGE;
use maud::{DOCTYPE, Markup, html};

use super::table::{Row, TABLE, columns};

/// Most rows that the page shows; the table has all.
const MOST_ROWS: usize = 2000;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:75rem;padding:0 1rem}\
    table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
    th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #8886}\
    th[scope=row],td.words,th.words{text-align:left}.table{overflow-x:auto}.problem{color:#b00020}\
    @media (prefers-color-scheme:dark){.problem{color:#ff8a80}}";

/// Writes the page of a sweep of `combinations` combinations into `folder`.
pub(super) fn write(keys: &[&str], rows: &[Row], combinations: usize, folder: &Path) -> Result<(), String> {
    let path = folder.join(PAGE);
    let page = page(keys, rows, combinations).into_string();
    std::fs::write(&path, page).map_err(|e| {
        let _ = std::fs::remove_file(&path); // rather none than half of one
        format!("{}: {e}", path.display())
    })
}

fn page(keys: &[&str], rows: &[Row], combinations: usize) -> Markup {
    let mut scenarios: Vec<usize> = rows.iter().filter(|row| !row.folder.is_empty()).map(|row| row.index).collect();
    scenarios.dedup();
    let troubles = rows.iter().filter(|row| !row.problem.is_empty()).count();
    let title = format!("phasecloud: a sweep of {}", keys.join(", "));
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (STYLE) }
            }
            body {
                h1 { (title) }
                p {
                    (scenarios.len()) " of " (combinations) " combinations are recorded. "
                    @if rows.iter().any(|row| row.problem == super::NOT_DONE) {
                        b.problem { "The sweep was stopped; this is not the whole of it. " }
                    }
                    @if troubles > 0 { b.problem { (troubles) " rows have no result, or one that cannot be right, each with the reason." } }
                    @else if scenarios.len() == combinations { "Every case ran to its end." }
                }
                p {
                    "Moments and the probability of being above the critical value are those at the last time of each scenario; \
                     the probability of ever having reached it is that by then. "
                    a href=(TABLE) { (TABLE) } " has the same numbers in full."
                }
                (table(keys, rows))
                @if rows.len() > MOST_ROWS {
                    p { "The first " (MOST_ROWS) " of " (rows.len()) " rows are shown." }
                }
            }
        }
    }
}

fn table(keys: &[&str], rows: &[Row]) -> Markup {
    let columns = columns(rows);
    html! {
        div.table tabindex="0" role="region" aria-label="All scenarios" {
            table {
                thead { tr {
                    th.words scope="col" { "scenario" }
                    @for key in keys { th scope="col" { (key) } }
                    th.words scope="col" { "method" }
                    @for name in &columns { th scope="col" { (name) } }
                } }
                tbody { @for row in rows.iter().take(MOST_ROWS) { tr {
                    th scope="row" {
                        @if row.folder.is_empty() { (row.scenario) }
                        @else { a href={ (row.folder) "/" } { (row.scenario) } }
                    }
                    @for value in &row.values { td { (value) } }
                    td.words { (row.method) }
                    @if row.has_numbers() { @for column in &columns { td { (short(row.number(column))) } } }
                    @else { td.words.problem colspan=(columns.len().max(1)) { (row.problem) } }
                }
                @if row.has_numbers() && !row.problem.is_empty() { tr {
                    td {}
                    td.words.problem colspan=(keys.len() + 1 + columns.len()) { (row.method) ": " (row.problem) }
                } } } }
            }
        }
    }
}

/// A number with the digits that a table needs.
fn short(number: f64) -> String {
    match number.abs() {
        _ if number.is_nan() => "-".into(),
        size if size == 0.0 || (1e-4..1e6).contains(&size) => format!("{number:.5}"),
        _ => format!("{number:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_row_and_every_problem_and_nothing_of_a_name_becomes_markup() {
        let row = |index, problem: &str| Row {
            index,
            scenario: format!("s-{index}"),
            method: "mc".into(),
            values: vec![0.125],
            numbers: if index == 1 { Vec::new() } else { vec![("mean_e".into(), 0.25)] },
            folder: format!("00000{index}-s-{index}"),
            problem: problem.into(),
        };
        let rows = [row(0, ""), row(1, "<b>lost</b>"), row(2, "it falls")];
        let page = page(&["initial.e"], &rows, 4).into_string();
        for words in [
            "3 of 4 combinations",
            "href=\"000000-s-0/\"",
            "0.125",
            "0.25000",
            "&lt;b&gt;lost",
            "initial.e",
            "mc: it falls",
        ] {
            assert!(page.contains(words), "{words}: {page}");
        }
    }
}
