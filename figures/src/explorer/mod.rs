//! The interactive part of the report: the densities of two cases at a time that a slider sets, divided by a
//! swipe or as a difference, with the values under the pointer; and the first-passage curves with a cursor.
//!
//! Without scripts, and on paper, the page shows the figures alone: they show the same.

mod data;
mod quantised;

use maud::{Markup, PreEscaped, html};

use crate::scene::Scene;

/// The script of all explorers of a page.
pub const SCRIPT: &str = include_str!("explorer.js");
/// The style of the explorers.
pub const STYLE: &str = include_str!("explorer.css");

/// The explorer of a scenario, which `scenes` show in its pairs of variables. `id` is its address in the page.
pub fn of_scenario(scenes: &[&Scene<'_>], id: &str) -> Markup {
    match data::of(scenes) {
        Err(why) => html! { p { "Not offered here: " (why) "." } },
        Ok(data) => html! {
            p.still { "The figures below show the densities at all times. On a screen, and with scripts, this place shows two of them at a time, of your choice." }
            div.explorer id=(id) hidden { (controls(scenes, id)) (view(id)) (passage(scenes, id)) }
            // Nothing in it may end the element early.
            script type="application/json" id={ (id) "-data" } { (PreEscaped(data.to_string().replace('<', "\\u003c"))) }
        },
    }
}

fn controls(scenes: &[&Scene<'_>], id: &str) -> Markup {
    let scene = scenes[0];
    let last = scene.times.len().saturating_sub(1);
    let first = scene.others().next().map_or(scene.reference, |method| method.label);
    let cases = |name: &str, words: &str, chosen: &str| {
        html! { label { (words) " " select name=(name) {
            @for method in &scene.methods { option selected[method.label == chosen] { (method.label) } }
        } } }
    };
    let pairs: Vec<String> = scenes.iter().filter_map(|scene| scene.pair_name()).collect();
    html! {
        div.controls role="group" aria-label="What is shown" {
            label.wide { "Time " input type="range" name="time" min="0" max=(last) step="1" value=(last); " " output name="t" {} }
            (cases("a", "Case", first))
            (cases("b", "against", scene.reference))
            @if pairs.len() > 1 { label { "in " select name="pair" { @for pair in &pairs { option { (pair) } } } } }
            fieldset { legend { "Show" }
                label { input type="radio" name={ (id) "-view" } value="swipe" checked; " side by side" }
                label { input type="radio" name={ (id) "-view" } value="difference"; " difference" }
            }
            label { input type="checkbox" name="log"; " logarithmic colours" }
            label { input type="checkbox" name="whole"; " one frame for all times" }
            label.wide.divider { "Divide at " input type="range" name="divide" min="0" max="1000" value="500"; }
        }
    }
}

fn view(id: &str) -> Markup {
    html! {
        canvas.map tabindex="0" role="img" aria-describedby={ (id) "-values" } {}
        div.scale { span data-name="low" {} canvas.ramp aria-hidden="true" {} span data-name="high" {} " " span data-name="unit" {} }
        p.values id={ (id) "-values" } role="status" { "Point at the map, or move the cross with the arrow keys, to read values." }
    }
}

fn passage(scenes: &[&Scene<'_>], id: &str) -> Markup {
    if scenes[0].methods.iter().all(|method| method.passage.is_empty()) {
        return html! {};
    }
    html! {
        canvas.curves tabindex="0" role="img" aria-describedby={ (id) "-probabilities" } {}
        p.hint { "Point at the curves, or move the cursor with the arrow keys." }
        table id={ (id) "-probabilities" } aria-live="polite" { caption {} tbody {} }
    }
}
