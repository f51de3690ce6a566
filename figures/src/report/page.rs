//! The page around the blocks.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::Drawn;
use super::blocks::{self, Block};
use crate::explorer;
use crate::palette::dark_rules;
use crate::words::named;
use results::notes::listed;

const STYLE: &str = include_str!("style.css");

/// The page of one run.
pub fn of_one(drawn: &Drawn<'_>) -> Markup {
    let blocks = blocks::of(drawn, "");
    let names: Vec<&str> = drawn.scenes.iter().map(|drawn| drawn.scene.name).collect();
    let body = html! {
        @for block in &blocks { section id=(block.key) { (heading(block)) (block.content) } }
    };
    let variables = variables_of(std::slice::from_ref(drawn));
    page(&format!("phasecloud: {}", names.join(", ")), "", &variables, &blocks.iter().collect::<Vec<_>>(), &body)
}

/// The page of several runs, one column per run.
pub fn of_several(runs: &[Drawn<'_>]) -> Markup {
    let columns: Vec<Vec<Block>> =
        runs.iter().enumerate().map(|(k, run)| blocks::of(run, &format!("run{k}-"))).collect();
    let union = united(&columns);
    let body = html! {
        @for block in &union {
            section id=(block.key) {
                (heading(block))
                div.runs style={ "--runs:" (runs.len()) } {
                    @for (run, column) in runs.iter().zip(&columns) {
                        div.run {
                            p.name { (run.name) }
                            @match column.iter().find(|other| other.key == block.key) {
                                Some(own) => (own.content),
                                None => p { "Not in this run." },
                            }
                        }
                    }
                }
            }
        }
    };
    let names: Vec<&str> = runs.iter().map(|run| run.name).collect();
    page(&format!("phasecloud: {}", names.join(" beside ")), "wide", &variables_of(runs), &union, &body)
}

/// The variables of all scenarios: `solar angle φ and eccentricity e`.
fn variables_of(runs: &[Drawn<'_>]) -> String {
    let scenes = runs.iter().flat_map(|run| &run.scenes).flat_map(|drawn| &drawn.scene.description.variables);
    let mut names: Vec<String> = Vec::new();
    for name in scenes.map(named) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    listed(&names)
}

/// The blocks of all runs, one per key. A block that only a later run has follows the block that it follows in that
/// run.
fn united(columns: &[Vec<Block>]) -> Vec<&Block> {
    let mut union: Vec<&Block> = Vec::new();
    for column in columns {
        let mut place = 0;
        for block in column {
            match union.iter().position(|known| known.key == block.key) {
                Some(known) => place = known + 1,
                None => {
                    union.insert(place, block);
                    place += 1;
                }
            }
        }
    }
    union
}

fn heading(block: &Block) -> Markup {
    html! { @if block.is_chapter { h2 { (block.heading) } } @else { h3 { (block.heading) } } }
}

fn page(title: &str, class: &str, variables: &str, blocks: &[&Block], body: &Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(explorer::STYLE)) "@media screen and (prefers-color-scheme:dark){" (dark_rules()) "}" }
            }
            body class=(class) {
                header {
                    h1 { (title) }
                    p { "How the uncertainty of a satellite's orbit evolves: densities of " (variables) ", propagated by competing methods." }
                }
                nav aria-label="Contents" {
                    h2 { "Contents" }
                    ol { @for chapter in chapters(blocks) {
                        @if let [first, rest @ ..] = chapter {
                            li {
                                a href={ "#" (first.key) } { (first.heading) }
                                @if !rest.is_empty() { ol { @for block in rest { li { a href={ "#" (block.key) } { (block.heading) } } } } }
                            }
                        }
                    } }
                }
                main { (body) }
                footer { p { "References: Sun, Colombo, Trisolini & Li (2022), "
                    cite { "Comparison of continuity equation and Gaussian mixture model for long-term density propagation using semi-analytical methods" }
                    ". The figures are in the folder figures, the numbers in the tables beside this page." } }
                script { (PreEscaped(explorer::SCRIPT)) }
            }
        }
    }
}

/// The blocks divided into chapters.
fn chapters<'b, 'c>(blocks: &'c [&'b Block]) -> Vec<&'c [&'b Block]> {
    blocks.chunk_by(|_, next| !next.is_chapter).collect()
}
