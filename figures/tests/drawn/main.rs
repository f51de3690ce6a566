//! Tests of the figures of a made-up run, read back from their SVG.
#![allow(missing_docs)]

mod made_up;
mod svg;

use density::grid::Axis;
use figures::densities::Grid;
use figures::palette::Ink;
use figures::scene::Scene;

use made_up::{ABOVE, BINS, NAN, Run, SPOT, density, grid, spot_middle, spots, withheld};
use svg::{Drawn, Written, has_numbers_only, number, written};

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
            let x = left + width * (phi - grid.x.low) / (grid.x.high - grid.x.low);
            let y = top + height * (grid.y.high - e) / (grid.y.high - grid.y.low);
            let radius =
                (width * SPOT.0 / (grid.x.high - grid.x.low)).max(height * SPOT.1 / (grid.y.high - grid.y.low));
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
    let turn = Grid { x: Axis { low: -1.0, high: -1.0 + std::f64::consts::TAU, bins: BINS }, ..grid() };
    for method in ["exact", "mc"] {
        *run.density(method, 1) = density(turn, |_, e| (0.3..0.4).contains(&e));
    }
    let scene = Scene::new(&run.scenario, &run.results, &run.densities, 0, false);
    let phi = scene.x_range();
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
