//! The part of the report that answers to the hand, tried with real clicks and keys in a real browser.
//!
//! Needs Chromium; without it the test prints this and is skipped, unless `PHASECLOUD_REQUIRE_CHROMIUM=1`.
#![allow(missing_docs)]

mod common;

use common::Bench;
use common::browser::{Browser, chromium};
use results::arrays::{ArrayReader, Place, edges};

const CASES: &str = r#"
[[propagator]]
label = "exact"
node = "exact"

[[propagator]]
label = "mc"
node = "mc"
samples = 4_000
"#;

/// Results of two cases on scenario 1.
fn bench() -> Bench {
    let bench = Bench::new();
    let head = "name = \"two\"\nscenarios = [\"scenario-1.toml\"]\nreference = \"exact\"\nbins = [60, 60]\n";
    let launch = bench.write("two.toml", &format!("{head}{CASES}"));
    bench.run_well(&launch, "out");
    bench
}

fn opened(bench: &Bench, chromium: &str) -> Browser {
    let address = format!("file://{}", bench.path("out/report.html").display());
    Browser::open(chromium, &bench.path("browser"), &address, [1200, 900])
}

/// All numbers in a text, in their order.
fn numbers(text: &str) -> Vec<f64> {
    let text = text.replace('−', "-");
    text.split(|c: char| c.is_whitespace() || ",:;(%)".contains(c)).filter_map(|word| word.parse().ok()).collect()
}

/// The density of a case at a place, as the results folder has it.
fn density(bench: &Bench, case: &str, index: usize, [phi, e]: [f64; 2]) -> f64 {
    let mut archive = ArrayReader::open(&bench.path("out/densities.npz")).unwrap();
    let place = Place::new("scenario-1", case, index);
    let bin = |archive: &mut ArrayReader, symbol: &str, value: f64| {
        let edges = archive.array(&place.name(&edges(symbol)), 1).unwrap();
        let turns = if symbol == "phi" { ((value - edges[0]) / std::f64::consts::TAU).floor() } else { 0.0 };
        let value = value - turns * std::f64::consts::TAU;
        let (low, width) = (edges[0], edges[1] - edges[0]);
        let at = (value - low) / width;
        assert!((at.fract() - 0.5).abs() < 0.48, "the place is between two bins; the test needs another one");
        at as usize
    };
    let (i, j) = (bin(&mut archive, "phi", phi), bin(&mut archive, "e", e));
    archive.array(&place.name("joint"), 2).unwrap()[60 * i + j]
}

#[test]
fn the_pointer_reads_the_densities_of_the_time_that_the_slider_sets() {
    let Some(chromium) = chromium() else { return };
    let bench = bench();
    let mut browser = opened(&bench, chromium);
    assert_eq!(browser.text(".explorer output[name=t]"), "t = 2 yr", "it begins at the end");

    // The slider has five steps; the middle one is the third snapshot.
    browser.click(".explorer input[name=time]", [0.5, 0.5]);
    assert_eq!(browser.text(".explorer output[name=t]"), "t = 1 yr");
    browser.press("ArrowLeft");
    assert_eq!(browser.text(".explorer output[name=t]"), "t = 0.5 yr", "arrow keys move the slider too");

    for shares in [[0.52, 0.47], [0.47, 0.58]] {
        browser.point(".explorer canvas.map", shares);
        let told = browser.text(".explorer .values");
        let [phi, e, mc, exact, difference] = numbers(&told)[..5] else { panic!("{told}") };
        assert!(told.contains("rad") && told.contains("mc") && told.contains("exact"), "{told}");
        for (case, shown) in [("mc", mc), ("exact", exact)] {
            let stored = density(&bench, case, 1, [phi, e]);
            assert!((shown - stored).abs() <= 1e-3 * stored, "{case}: {shown} shown, {stored} stored, {told}");
        }
        assert!(exact > 1.0 && (difference - (mc - exact)).abs() <= 2e-3 * mc.max(exact), "{told}");
    }
}

#[test]
fn the_map_divides_two_cases_or_shows_their_difference_as_one_clicks() {
    let Some(chromium) = chromium() else { return };
    let bench = bench();
    let mut browser = opened(&bench, chromium);
    // The sum of all colour components of a part of the map.
    let ink = |browser: &mut Browser, from: f64, to: f64| {
        browser
            .value(&format!(
                "(() => {{ const c = document.querySelector('.explorer canvas.map'); \
                 const part = c.getContext('2d').getImageData({from} * c.width, 0, {to} * c.width, c.height).data; \
                 return part.reduce((sum, value) => sum + value, 0); }})()"
            ))
            .as_f64()
            .unwrap()
    };
    let aria = "document.querySelector('.explorer canvas.map').getAttribute('aria-label')";
    assert!(browser.value(aria).as_str().unwrap().contains("mc left of the divider, exact right"));
    let before = ink(&mut browser, 0.0, 1.0);
    browser.click(".explorer input[name=divide]", [0.95, 0.5]);
    assert_ne!(ink(&mut browser, 0.0, 1.0), before, "the divider moves");
    browser.click(".explorer input[value=difference]", [0.5, 0.5]);
    assert!(browser.value(aria).as_str().unwrap().contains("mc minus that of exact"));
    let [low, high] = ["low", "high"].map(|end| numbers(&browser.text(&format!(".explorer [data-name={end}]")))[0]);
    assert!(high > 0.0 && low == -high, "the colours of a difference are symmetric: {low} to {high}");
    let plain = ink(&mut browser, 0.0, 1.0);
    browser.click(".explorer input[value=swipe]", [0.5, 0.5]);
    browser.click(".explorer input[name=log]", [0.5, 0.5]);
    assert_ne!(ink(&mut browser, 0.0, 1.0), plain);
    assert!(browser.text(".explorer [data-name=unit]").contains("logarithmic"));
    assert!(numbers(&browser.text(".explorer [data-name=low]"))[0] > 0.0);
}

#[test]
fn the_cross_moves_by_bins_with_the_arrow_keys() {
    let Some(chromium) = chromium() else { return };
    let bench = bench();
    let mut browser = opened(&bench, chromium);
    browser.click(".explorer canvas.map", [0.5, 0.5]);
    let place = |browser: &mut Browser| numbers(&browser.text(".explorer .values"))[..2].to_vec();
    let mut archive = ArrayReader::open(&bench.path("out/densities.npz")).unwrap();
    let name = Place::new("scenario-1", "exact", 4);
    let mut width = |symbol: &str| {
        let edges = archive.array(&name.name(&edges(symbol)), 1).unwrap();
        edges[1] - edges[0]
    };
    let widths = [width("phi"), width("e")];
    let start = place(&mut browser);
    for (key, [right, up]) in [("ArrowRight", [1.0, 0.0]), ("ArrowUp", [0.0, 1.0])] {
        let before = place(&mut browser);
        browser.press(key);
        let after = place(&mut browser);
        assert!((after[0] - before[0] - right * widths[0]).abs() < 2e-3, "{before:?} {after:?}");
        assert!((after[1] - before[1] - up * widths[1]).abs() < 2e-4, "{before:?} {after:?}");
    }
    assert_ne!(place(&mut browser), start);
}

#[test]
fn the_cursor_reads_the_first_passage_curves() {
    let Some(chromium) = chromium() else { return };
    let bench = bench();
    let mut browser = opened(&bench, chromium);
    browser.click(".explorer canvas.curves", [0.6, 0.5]);
    let caption = browser.text(".explorer table caption");
    let t = *numbers(&caption).last().unwrap();
    assert!((0.9..1.5).contains(&t), "{caption}");
    for case in ["exact", "mc"] {
        let rows: Vec<(f64, f64)> = bench
            .table("out/first_passage.csv")
            .iter()
            .filter(|row| row["method"] == case)
            .map(|row| (row["t_yr"].parse().unwrap(), row["prob_reached_critical_e"].parse().unwrap()))
            .collect();
        let after = rows.iter().position(|row| row.0 >= t).unwrap();
        let ((t0, p0), (t1, p1)) = (rows[after - 1], rows[after]);
        let expected = p0 + (t - t0) / (t1 - t0) * (p1 - p0);
        let row = browser.value(&format!(
            "[...document.querySelectorAll('.explorer tbody tr')].find(r => r.cells[0].textContent === '{case}').cells[1].textContent"
        ));
        let shown = numbers(row.as_str().unwrap())[0];
        assert!((shown - expected).abs() <= 2e-3 * expected.max(1e-4), "{case} at {t}: {shown}, {expected}");
    }
    let before = browser.text(".explorer table caption");
    browser.press("ArrowRight");
    assert_ne!(browser.text(".explorer table caption"), before, "arrow keys move the cursor");
    browser.press("End");
    assert!(browser.text(".explorer table caption").ends_with("t = 2 yr"));
}

#[test]
fn the_page_needs_no_network_and_without_scripts_or_on_paper_it_shows_its_figures() {
    let Some(chromium) = chromium() else { return };
    let bench = bench();
    let mut browser = opened(&bench, chromium);
    let shown = |browser: &mut Browser, selector: &str| {
        browser.value(&format!("getComputedStyle(document.querySelector(`{selector}`)).display")) != "none"
    };
    assert!(shown(&mut browser, ".explorer") && !shown(&mut browser, ".still"));
    assert!(browser.asked.iter().all(|address| address.starts_with("file:") || address.starts_with("data:")));
    assert_eq!(browser.asked.iter().filter(|address| address.starts_with("file:")).count(), 1, "{:?}", browser.asked);
    browser.call("Emulation.setEmulatedMedia", serde_json::json!({"media": "print"}));
    assert!(!shown(&mut browser, ".explorer") && shown(&mut browser, ".still"));
    browser.call("Emulation.setEmulatedMedia", serde_json::json!({"media": ""}));
    browser.call("Emulation.setScriptExecutionDisabled", serde_json::json!({"value": true}));
    browser.call("Page.reload", serde_json::json!({}));
    browser.wait_for("document.readyState === 'complete' && document.querySelector('.explorer').hidden");
    assert!(!shown(&mut browser, ".explorer") && shown(&mut browser, ".still"));
    assert!(browser.value("document.querySelectorAll('figure svg').length").as_u64().unwrap() > 10);
}
