//! Tests of the figures of a made-up run, read back from their SVG.
#![allow(missing_docs)]

use std::collections::BTreeMap;

use density::grid::{Axis, Grid};
use density::model::planar::Force;
use density::problem::{InitialGaussian, Problem};
use figures::atlas;
use figures::densities::{Densities, Density};
use figures::palette::Ink;
use figures::scene::{Scenario, Scene};
use figures::text::text_width;
use results::rows::PassageRow;
use results::{Manifest, MomentsRow, Results};

const BINS: usize = 40;
const NAN: f64 = f64::NAN;
const ABOVE: &str = "prob_above_critical_e";

/// A run of `exact` (the reference) and `mc` whose clouds and probabilities are made up.
struct Run {
    scenario: Scenario,
    results: Results,
    densities: Densities,
}

fn manifest() -> Manifest {
    let text = r#"{"run_id": "1", "started": "2026-01-01T00:00:00Z", "versions": {}, "scenarios": {}, "reference": "exact",
        "cases": {"exact": {"runs": ["exact"], "settings": []}, "mc": {"runs": ["mc"], "settings": []}}, "failures": {}}"#;
    serde_json::from_str(text).unwrap()
}

/// A density that is 1 where `cloud(phi, e)` is true and 0 elsewhere.
fn density(grid: Grid, cloud: impl Fn(f64, f64) -> bool) -> Density {
    let middle = |axis: &Axis, i: usize| axis.edge(i) + 0.5 * axis.width();
    let bin = |k: usize| f64::from(u8::from(cloud(middle(&grid.phi, k / BINS), middle(&grid.e, k % BINS))));
    let joint: Vec<f64> = (0..BINS * BINS).map(bin).collect();
    let marginal_phi = joint.chunks(BINS).map(|row| row.iter().sum()).collect();
    let marginal_e = (0..BINS).map(|j| joint.iter().skip(j).step_by(BINS).sum()).collect();
    Density { grid, joint, marginal_phi, marginal_e }
}

fn withheld(grid: Grid) -> Density {
    Density { grid, joint: vec![NAN; BINS * BINS], marginal_phi: vec![NAN; BINS], marginal_e: vec![NAN; BINS] }
}

fn grid() -> Grid {
    Grid { phi: Axis { low: 1.0, high: 5.0, bins: BINS }, e: Axis { low: 0.1, high: 0.7, bins: BINS } }
}

/// A ring: nothing is in its middle.
fn ring() -> Density {
    density(grid(), |phi, e| (0.75..1.0).contains(&((phi - 3.0) / 2.0).hypot((e - 0.4) / 0.3)))
}

fn row(method: &str, t_yr: f64, above: f64) -> MomentsRow {
    let se = if method == "mc" { 0.01 } else { NAN };
    let numbers = [
        ("mean_phi_rad", 3.0),
        ("std_phi_rad", 0.5),
        ("mean_e", 0.4),
        ("std_e", 0.1),
        (ABOVE, above),
        ("se_mean_phi_rad", se),
        ("se_std_phi_rad", se),
        ("se_mean_e", se),
        ("se_std_e", se),
    ];
    MomentsRow {
        scenario: "made-up".into(),
        method: method.into(),
        t_yr,
        columns: numbers.iter().map(|(column, _)| (*column).to_owned()).collect(),
        numbers: numbers.iter().map(|(_, number)| *number).collect(),
    }
}

impl Run {
    /// `count` snapshots of a ring.
    fn new(count: usize) -> Self {
        let times: Vec<f64> = (0..count).map(|k| 0.25 * k as f64).collect();
        let mut densities = Densities::new();
        let of = densities.entry("made-up".into()).or_default();
        for method in ["exact", "mc"] {
            of.insert(method.into(), vec![ring(); count]);
        }
        let rows = |method: &'static str| times.iter().map(move |&t| row(method, t, 0.5)).collect::<Vec<_>>();
        let moments = [rows("exact"), rows("mc")].concat();
        let problem = Problem {
            model: Force { radiation: 0.15, oblateness: 0.40921 }.into(),
            initial: InitialGaussian { mean_phi: 2.2, mean_e: 0.2, sigma_phi: 0.2, sigma_e: 0.02 },
            times,
            critical_e: 0.6,
        };
        let results = Results { manifest: manifest(), moments, ..Results::default() };
        Self { scenario: Scenario { name: "made-up".into(), problem }, results, densities }
    }

    /// Changes a number in the moments.
    fn set(&mut self, row: usize, column: &str, number: f64) {
        let row = &mut self.results.moments[row];
        let place = row.columns.iter().position(|name| name == column).unwrap();
        row.numbers[place] = number;
    }

    fn of(mut self, radiation: f64, oblateness: f64) -> Self {
        self.scenario.problem.model = Force { radiation, oblateness }.into();
        self
    }

    fn density(&mut self, method: &str, index: usize) -> &mut Density {
        &mut self.densities.get_mut("made-up").unwrap().get_mut(method).unwrap()[index]
    }

    /// Adds a first-passage curve, with one value per snapshot.
    fn passages(&mut self, method: &str, values: &[f64]) {
        for (&p, &t_yr) in values.iter().zip(&self.scenario.problem.times) {
            let [scenario, method] = ["made-up", method].map(str::to_owned);
            self.results.passages.push(PassageRow {
                scenario,
                method,
                t_yr,
                prob_reached_critical_e: p,
                low: p,
                high: p,
                interval: "error estimate".into(),
            });
        }
    }

    /// All figures as files, by name.
    fn figures(&self) -> BTreeMap<String, String> {
        let groups = atlas::of_scene(&Scene::new(&self.scenario, &self.results, &self.densities, false));
        let missing: Vec<&String> = groups.iter().flat_map(|group| &group.missing).collect();
        assert!(missing.is_empty(), "{missing:?}");
        let figures = groups.iter().flat_map(|group| &group.figures);
        figures.map(|figure| (figure.name.clone(), figure.to_file())).collect()
    }

    /// The figure with this name as a file.
    fn figure(&self, name: &str) -> String {
        self.figures().remove(name).unwrap_or_else(|| panic!("no {name}"))
    }
}

/// All words of a figure with their places, its description and its number of pictures.
struct Drawn {
    words: Vec<(String, f64, f64)>,
    description: String,
    images: usize,
}

impl Drawn {
    fn of(svg: &str) -> Self {
        let document = roxmltree::Document::parse(svg).unwrap();
        let named = |name: &'static str| document.descendants().filter(move |node| node.tag_name().name() == name);
        let all = |node: roxmltree::Node<'_, '_>| node.descendants().filter_map(|n| n.text()).collect::<String>();
        // For an element, `text` gives the text of its first child, so only text nodes are taken.
        let own = |node: roxmltree::Node<'_, '_>| {
            node.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect::<String>()
        };
        let number = |node: roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
        Self {
            words: named("text").map(|node| (own(node), number(node, "x"), number(node, "y"))).collect(),
            description: named("desc").map(all).next().unwrap(),
            images: named("image").count(),
        }
    }

    fn has(&self, words: &str) -> bool {
        self.words.iter().any(|(text, ..)| text == words)
    }

    fn count(&self, words: &str) -> usize {
        self.words.iter().filter(|(text, ..)| text == words).count()
    }
}

/// The middle of a small cloud that goes round with time, at the `index`-th of `count` snapshots.
fn spot_middle(index: usize, count: usize) -> (f64, f64) {
    let turn = 5.6 * index as f64 / count as f64;
    (3.0 + 1.6 * turn.cos(), 0.4 + 0.23 * turn.sin())
}

/// Half widths of the small cloud.
const SPOT: (f64, f64) = (0.15, 0.025);

/// A run of small clouds, each at its own place.
fn spots(count: usize) -> Run {
    let mut run = Run::new(count);
    for index in 0..count {
        let middle = spot_middle(index, count);
        let spot = || density(grid(), |phi, e| ((phi - middle.0) / SPOT.0).hypot((e - middle.1) / SPOT.1) < 1.0);
        *run.density("exact", index) = spot();
        *run.density("mc", index) = spot();
    }
    run
}

fn number(node: roxmltree::Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// The label of a snapshot as it is drawn.
struct Written {
    index: usize,
    /// Left, top, right and bottom of the words.
    place: [f64; 4],
    /// The place where the line that leads to the cloud begins.
    led_to: Option<(f64, f64)>,
}

/// The labels at the clouds of a figure of `count` snapshots, which are a quarter of a year apart.
fn written(document: &roxmltree::Document<'_>, count: usize) -> Vec<Written> {
    let with_class = |class: String| document.descendants().filter(move |n| n.attribute("class") == Some(&*class));
    let of_index = |index: usize| {
        let (ink, words) = (Ink::of_many(index, count), format!("t = {} yr", 0.25 * index as f64));
        let text = with_class(ink.fill_class().into_owned()).find(|node| node.text() == Some(&*words))?;
        let (width, base) = (0.85 * text_width(&words, 11.0), number(text, "y"));
        let share = match text.attribute("text-anchor") {
            Some("middle") => 0.5,
            Some("end") => 1.0,
            _ => 0.0,
        };
        let left = number(text, "x") - share * width;
        let lines = with_class(ink.stroke_class().into_owned()).filter(|node| node.attribute("fill") == Some("none"));
        let mut starts = lines.filter_map(|line| line.attribute("d")?.strip_prefix('M')?.split('L').next());
        let start = starts.next_back().and_then(|start| start.split_once(' '));
        Some(Written {
            index,
            place: [left, base - 9.0, left + width, base + 3.0],
            led_to: start.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())),
        })
    };
    (0..count).filter_map(of_index).collect()
}

/// Whether no word and no place of a figure is "NaN". Pictures are left out, because their encoding may contain these
/// letters.
fn has_numbers_only(svg: &str) -> bool {
    let document = roxmltree::Document::parse(svg).unwrap();
    let is_good = |node: roxmltree::Node<'_, '_>| {
        let mut attributes = node.attributes().filter(|attribute| attribute.name() != "href");
        !node.text().unwrap_or("").contains("NaN") && attributes.all(|attribute| !attribute.value().contains("NaN"))
    };
    document.descendants().all(is_good)
}

#[test]
fn the_label_of_a_ring_is_at_the_ring_and_not_in_its_empty_middle() {
    let svg = Run::new(2).figure("joint-density-exact-all");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let drawn = Drawn::of(&svg);
    // The scale of the figure, from the numbers on its axes.
    let ticks = |horizontal: bool| {
        let number = |(text, x, y): &(String, f64, f64)| Some((text.parse::<f64>().ok()?, *x, *y));
        let all: Vec<(f64, f64, f64)> = drawn.words.iter().filter_map(number).filter(|(_, x, _)| *x < 580.0).collect();
        let lowest = all.iter().map(|(.., y)| *y).fold(0.0, f64::max);
        let on_axis = |(_, _, y): &&(f64, f64, f64)| (*y > lowest - 1.0) == horizontal;
        let chosen: Vec<_> = all.iter().filter(on_axis).copied().collect();
        let (a, b) = (chosen[0], *chosen.last().unwrap());
        let pixel = move |tick: (f64, f64, f64)| if horizontal { tick.1 } else { tick.2 };
        move |at: f64| a.0 + (at - pixel(a)) / (pixel(b) - pixel(a)) * (b.0 - a.0)
    };
    let labels = written(&document, 2);
    assert_eq!(labels.len(), 2);
    for Written { index, place: [left, top, right, bottom], .. } in labels {
        let (phi, e) = (ticks(true)(0.5 * (left + right)), ticks(false)(0.5 * (top + bottom)));
        let radius = ((phi - 3.0) / 2.0).hypot((e - 0.4) / 0.3);
        assert!((0.5..1.4).contains(&radius), "{index} at phi = {phi}, e = {e}, {radius} of the ring");
    }
}

#[test]
fn thirteen_snapshots_have_thirteen_colours_and_a_bar_that_says_which_is_when() {
    let svg = Run::new(13).figure("cloud-evolution");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let clouds = document.descendants().filter(|node| node.attribute("stroke-width") == Some("0.8"));
    let shades = clouds
        .filter_map(|node| node.attribute("class"))
        .filter(|class| class.starts_with("s-t") && *class != "s-text");
    assert_eq!(shades.collect::<std::collections::BTreeSet<_>>().len(), 13);
    let drawn = Drawn::of(&svg);
    assert!(drawn.has("time t [yr]") && drawn.has("2.75"));
    assert!(
        drawn.words.iter().filter(|(text, ..)| text.starts_with("t = ")).count() >= 6,
        "labels stand at their clouds"
    );
}

#[test]
fn each_label_is_at_its_own_cloud_or_led_to_it_in_its_colour_and_clear_of_other_labels() {
    for (count, least) in [(2, 2), (5, 5), (13, 13), (40, 12), (64, 12)] {
        let svg = spots(count).figure("joint-density-exact-all");
        let document = roxmltree::Document::parse(&svg).unwrap();
        let labels = written(&document, count);
        assert!(labels.len() >= least, "{count}: {}", labels.len());
        assert_eq!([labels[0].index, labels.last().unwrap().index], [0, count - 1], "the ends have labels");
        for (k, label) in labels.iter().enumerate() {
            let class = Ink::of_many(label.index, count).fill_class();
            let is_cloud = |node: &roxmltree::Node<'_, '_>| {
                node.attribute("mask").is_some() && node.attribute("class") == Some(&*class)
            };
            let cloud = document.descendants().find(is_cloud).unwrap();
            let [left, top, width, height] = ["x", "y", "width", "height"].map(|name| number(cloud, name));
            let ((phi, e), grid) = (spot_middle(label.index, count), grid());
            let x = left + width * (phi - grid.phi.low) / (grid.phi.high - grid.phi.low);
            let y = top + height * (grid.e.high - e) / (grid.e.high - grid.e.low);
            let radius =
                (width * SPOT.0 / (grid.phi.high - grid.phi.low)).max(height * SPOT.1 / (grid.e.high - grid.e.low));
            let [l, t, r, b] = label.place;
            let (end, slack) = label.led_to.map_or(((x.clamp(l, r), y.clamp(t, b)), 9.0), |start| (start, 3.0));
            let away = (end.0 - x).hypot(end.1 - y);
            assert!(away < radius + slack, "{count}: label {} is {away} from its cloud of {radius}", label.index);
            for other in &labels[..k] {
                let [l2, t2, r2, b2] = other.place;
                assert!(r <= l2 || r2 <= l || b <= t2 || b2 <= t, "{count}: {} and {}", label.index, other.index);
            }
        }
    }
}

#[test]
fn every_snapshot_has_a_colour_of_its_own_that_the_bar_of_times_repeats() {
    for count in [2, 5, 13, 64] {
        let svg = spots(count).figure("joint-density-mc-all");
        let document = roxmltree::Document::parse(&svg).unwrap();
        let classes = |is_cloud: bool| {
            let nodes = document.descendants().filter(move |node| node.attribute("mask").is_some() == is_cloud);
            let filled = nodes.filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "rect")) == is_cloud);
            let shades = filled.filter_map(|node| node.attribute("class")).filter(|class| class.starts_with("f-t"));
            shades.filter(|class| *class != "f-text").collect::<std::collections::BTreeSet<_>>()
        };
        assert_eq!(classes(true).len(), count);
        assert!(classes(true).is_subset(&classes(false)), "the bar has a block of each");
        let drawn = Drawn::of(&svg);
        assert!(drawn.has("time t [yr]") && drawn.has("0") && drawn.has(&(0.25 * (count - 1) as f64).to_string()));
        let masks = document.descendants().filter_map(|node| node.attribute("mask"));
        for mask in masks.filter_map(|mask| mask.strip_prefix("url(#")?.strip_suffix(')')) {
            assert_eq!(document.descendants().filter(|node| node.attribute("id") == Some(mask)).count(), 1, "{mask}");
        }
    }
}

#[test]
fn a_key_is_near_every_row_of_the_marginals() {
    for count in [1, 2, 13, 40] {
        let svg = Run::new(count).figure("marginals-mc");
        let drawn = Drawn::of(&svg);
        let heights =
            |words: &str| drawn.words.iter().filter(|(text, ..)| text == words).map(|(.., y)| *y).collect::<Vec<f64>>();
        let keys = heights("exact");
        assert_eq!(keys.len(), count.div_ceil(2));
        for index in 0..count {
            let row = heights(&format!("t = {} yr", 0.25 * index as f64))[0];
            assert!(keys.iter().any(|key| (0.0..300.0).contains(&(row - key))), "{count}: row {index} at {row}");
        }
        let document = roxmltree::Document::parse(&svg).unwrap();
        let bottom = number(document.root_element(), "height");
        assert!(drawn.words.iter().all(|(.., y)| *y < bottom), "{count}: nothing is cut off below");
    }
}

#[test]
fn sub_domains_are_named_where_the_portrait_has_them() {
    for (radiation, oblateness, present, absent) in [
        (0.15, 0.40921, vec![1, 2, 3], vec![]),
        (0.15, 0.2, vec![1, 2, 3], vec![]),
        (0.15, 0.0, vec![2, 3], vec![1]),
        (1.0, 0.40921, vec![1, 2], vec![3]),
        (0.0, 0.40921, vec![2], vec![1, 3]),
    ] {
        let drawn = Drawn::of(&Run::new(2).of(radiation, oblateness).figure("phase-portrait"));
        for number in present {
            assert!(drawn.has(&format!("SubD{number}")), "C = {radiation}, W = {oblateness}: no {number}");
            assert!(drawn.description.contains(&format!("in sub-domain {number}")), "{}", drawn.description);
        }
        for number in absent {
            assert!(!drawn.has(&format!("SubD{number}")), "C = {radiation}, W = {oblateness}: {number}");
            assert!(drawn.description.contains(&format!("no sub-domain {number}")), "{}", drawn.description);
        }
        assert_eq!(drawn.has("saddle"), radiation == 0.15 && oblateness > 0.0, "C = {radiation}, W = {oblateness}");
    }
}

#[test]
fn rare_probabilities_are_told_apart_on_a_logarithmic_axis_that_has_a_line_for_0() {
    let mut run = Run::new(4);
    run.passages("exact", &[0.0, 2e-6, 3e-5, 4e-4]);
    let drawn = Drawn::of(&run.figure("first-passage"));
    for tick in ["0", "10⁻⁶", "10⁻⁵", "10⁻⁴"] {
        assert!(drawn.has(tick), "{tick} of {:?}", drawn.words);
    }
    assert!(drawn.description.contains("logarithmic") && drawn.description.contains("No curve: mc"));
    let likely = Drawn::of(&{
        let mut run = Run::new(4);
        run.passages("exact", &[0.0, 0.2, 0.5, 1.0]);
        run.figure("first-passage")
    });
    assert!(!likely.description.contains("logarithmic") && likely.has("1.0"));
}

#[test]
fn the_probability_above_has_a_logarithmic_panel_beside_the_linear_one_if_it_spans_decades() {
    let mut run = Run::new(3);
    for (row, p) in [0.9, 1e-5, 0.0].into_iter().enumerate() {
        run.set(row, ABOVE, p);
    }
    let drawn = Drawn::of(&run.figure("probability-above"));
    assert_eq!(drawn.count("time t [yr]"), 2);
    assert!(drawn.has("10⁻⁴") && drawn.has("0"), "{:?}", drawn.words);
}

#[test]
fn a_thin_cloud_is_magnified_and_a_thick_one_is_not() {
    let thin = || density(grid(), |phi, e| (e - 0.1 - 0.15 * (phi - 1.0)).abs() < 0.0076);
    let mut run = Run::new(2);
    *run.density("exact", 1) = thin();
    *run.density("mc", 1) = thin();
    let figures = run.figures();
    let images = |name: &str| Drawn::of(&figures[name]).images;
    // A map and its colour bar; the second figure also has the inset.
    assert_eq!([images("joint-density-mc-0"), images("joint-density-mc-1")], [2, 3]);
    // Two clouds, the colour bar, and the inset.
    assert_eq!(images("joint-density-mc-all"), 4);
    assert!(Drawn::of(&figures["joint-density-mc-1"]).words.iter().any(|(text, ..)| text.starts_with('×')));
}

#[test]
fn marginals_have_a_residual_below_that_is_method_minus_reference() {
    let drawn = Drawn::of(&Run::new(2).figure("marginals-mc"));
    assert_eq!(drawn.count("residual"), 4, "two a snapshot");
    assert!(drawn.description.contains("mc minus exact"));
}

#[test]
fn what_is_withheld_is_absent_and_called_so_and_never_0() {
    let mut run = Run::new(3);
    *run.density("exact", 1) = withheld(grid());
    run.set(1, ABOVE, NAN);
    run.set(1, "mean_e", NAN);
    run.passages("exact", &[0.1, NAN, NAN]);
    run.passages("mc", &[NAN, NAN, NAN]);
    let figures = run.figures();
    let said = |name: &str, words: &str| {
        let drawn = Drawn::of(&figures[name]);
        assert!(drawn.description.contains(words), "{name}: {}", drawn.description);
        drawn
    };
    assert_eq!(said("joint-density-exact-all", "exact withholds its density at t = 0.25 yr").images, 3);
    let map = said("joint-density-exact-1", "exact withholds its density at t = 0.25 yr");
    assert!(map.images == 0 && map.has("withheld"));
    assert_eq!(said("joint-density-mc-1", "").images, 2, "another case is drawn as ever");
    assert!(figures.contains_key("difference-mc-0") && !figures.contains_key("difference-mc-1"));
    assert_eq!(said("marginals-mc", "exact withholds its density at t = 0.25 yr").count("reference withheld"), 2);
    assert!(figures.values().all(|svg| has_numbers_only(svg)));
    said("probability-above", "exact withholds its value at t = 0.25 yr");
    let passage = said("first-passage", "Withheld: mc.");
    assert!(passage.description.contains("Withheld in part, and not drawn there: exact."));
    said("moment-errors", "exact withholds moments at t = 0.25 yr");
    said("cloud-evolution", "");
    said("phase-portrait", "");
}

#[test]
fn a_run_whose_every_density_is_withheld_still_has_its_figures() {
    for count in [1, 2, 13] {
        let mut run = Run::new(count);
        for index in 0..count {
            *run.density("exact", index) = withheld(grid());
            *run.density("mc", index) = withheld(grid());
        }
        assert!(run.figures().values().all(|svg| has_numbers_only(svg)));
    }
}

#[test]
fn a_single_snapshot_and_sixty_four_are_drawn() {
    for count in [1, 64] {
        let figures = Run::new(count).figures();
        let drawn = Drawn::of(&figures["cloud-evolution"]);
        assert!(drawn.words.iter().any(|(text, ..)| text.starts_with("t = ")));
        assert!(figures.values().all(|svg| has_numbers_only(svg)));
    }
}

#[test]
fn a_cloud_round_the_whole_circle_is_drawn_once_on_one_turn() {
    let mut run = Run::new(2);
    let turn = Grid { phi: Axis { low: -1.0, high: -1.0 + std::f64::consts::TAU, bins: BINS }, ..grid() };
    for method in ["exact", "mc"] {
        *run.density(method, 1) = density(turn, |_, e| (0.3..0.4).contains(&e));
    }
    let scene = Scene::new(&run.scenario, &run.results, &run.densities, false);
    let phi = scene.phi_range();
    assert!((phi.end - phi.start - std::f64::consts::TAU).abs() < 1e-9, "{phi:?}");
    // The first cloud, the two parts of the cloud round the circle, and the colour bar.
    assert_eq!(Drawn::of(&run.figure("joint-density-exact-all")).images, 4);
}

#[test]
fn subscripts_are_shifted_by_numbers_that_every_program_understands() {
    let svg = Run::new(2).figure("phase-portrait");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let spans: Vec<_> = document.descendants().filter(|node| node.tag_name().name() == "tspan").collect();
    assert!(!spans.is_empty());
    for span in spans {
        for name in ["dy", "font-size"] {
            assert!(span.attribute(name).unwrap().parse::<f64>().is_ok(), "{span:?}");
        }
        assert_eq!(span.parent().unwrap().attribute("text-anchor"), Some("start"), "parts are not centred one by one");
    }
}
