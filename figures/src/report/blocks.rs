//! A report as a list of blocks. Blocks of several runs with the same key are placed side by side.

use maud::{Markup, html};

use super::{Drawn, DrawnScene, run, tables};
use crate::atlas::{Group, Layout};
use crate::explorer;
use crate::scene::Scene;
use crate::words::reentry;

/// A part of the report under a heading.
pub struct Block {
    /// The key, the same in every run that has such a part; also its address in the page.
    pub key: String,
    /// Its heading.
    pub heading: String,
    /// Whether it begins a chapter.
    pub is_chapter: bool,
    /// Its content.
    pub content: Markup,
}

/// The blocks of a run. `place` keeps the addresses of one run apart from those of another.
pub fn of(drawn: &Drawn<'_>, place: &str) -> Vec<Block> {
    let results = drawn.results;
    let mut blocks = vec![
        chapter("summary", "Summary", run::summary(drawn)),
        section("warnings", "Warnings and remarks", run::remarks(drawn)),
        chapter("run", "What was run", run::what_was_run(results)),
        section("scenarios", "Scenarios", run::scenarios(drawn)),
    ];
    for DrawnScene { scene, further, groups } in &drawn.scenes {
        let key = |part: &str| format!("{}-{part}", scene.name);
        let critical = format!("Critical {}", reentry(scene.description).0);
        let has_passages = scene.methods.iter().any(|method| !method.passage.is_empty());
        let pairs: Vec<&Scene<'_>> = [scene].into_iter().chain(further).collect();
        let explorer = explorer::of_scenario(&pairs, &format!("{place}{}", key("explorer")));
        blocks.extend([
            chapter(&key("results"), &format!("Results of {}", scene.name), html! {}),
            section(&key("explore"), "Explore", explorer),
            section(&key("moments"), "Moments", tables::moments(scene)),
            section(&key("probabilities"), &critical, tables::probabilities(scene, has_passages)),
        ]);
        if scene.has_given() {
            blocks.push(section(
                &key("given"),
                "The radiation parameter given re-entry",
                tables::given_re_entry(scene),
            ));
        }
        blocks.extend([
            section(&key("distances"), "Distances of the densities", tables::distances(scene)),
            section(&key("effort"), "Effort", tables::effort(scene)),
            section(&key("diagnostics"), "What the methods say of themselves", tables::diagnostics(scene)),
        ]);
        let shown = groups.iter().filter(|group| !group.figures.is_empty() || !group.missing.is_empty());
        blocks.extend(shown.map(|group| {
            section(&key(&format!("figures-{}", group.key)), &group.heading, figures(group, place, scene.methods.len()))
        }));
    }
    blocks.push(chapter("across", "All scenarios", html! {}));
    blocks.push(section("across-effort", &drawn.across.heading, figures(&drawn.across, place, 1)));
    blocks
}

fn chapter(key: &str, heading: &str, content: Markup) -> Block {
    Block { key: key.into(), heading: heading.into(), is_chapter: true, content }
}

fn section(key: &str, heading: &str, content: Markup) -> Block {
    Block { key: key.into(), heading: heading.into(), is_chapter: false, content }
}

fn figures(group: &Group, place: &str, cases: usize) -> Markup {
    // Small figures stand in one row per snapshot, if all cases fit beside one another.
    let columns = match group.layout {
        Layout::Large | Layout::Pairs => None,
        Layout::CaseByCase => Some(cases),
        Layout::OtherByOther => Some(cases.saturating_sub(1)),
    };
    let small = columns.is_some();
    let style = columns.map(|columns| format!("--cases:{}", columns.clamp(1, 6)));
    html! {
        @if !group.text.is_empty() { p { (group.text) } }
        @for missing in &group.missing { p.warning { "Not drawn: " (missing) "." } }
        div.small[small] .pairs[group.layout == Layout::Pairs] style=[style] {
            @for figure in &group.figures { (figure.to_page(place, small)) }
        }
    }
}
