//! The phase portrait (Fig. 1): contours of the Hamiltonian, stationary points, sub-domains, the critical eccentricity.

use std::collections::BTreeSet;
use std::ops::Range;

use density::model::PlanarHamiltonian;
use density::model::parameter::Parameter;
use density::model::registry::Planar;
use density::problem::Problem;
use plotters::style::text_anchor::{HPos, VPos};

use super::{CONTOUR, TURN, axis_of, critical, mirrored};
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::hamiltonian::{self, Stationary};
use crate::legend::Sample;
use crate::palette::{Ink, Marker, Stroke};
use crate::panel::{Panel, Surroundings, TEXT, bold, text_style};
use crate::scene::Scene;
use crate::sub_domains::{self, Motion};
use crate::text::{subscript, text_width};

const DIVIDING: Stroke = Stroke { ink: Ink::Text, width: 1.6, dashes: &[] };
const POINT: Stroke = Stroke { ink: Ink::Series(0), width: 1.8, dashes: &[] };
const MEAN: Stroke = Stroke { ink: Ink::Series(3), width: 2.0, dashes: &[] };
const STANDING: Stroke = Stroke { ink: Ink::Series(0), width: 1.8, dashes: &[2.0, 3.0] };
/// Number of contours drawn.
const LEVELS: usize = 15;

/// Draws the figure.
pub fn draw(scene: &Scene<'_>) -> Result<Figure, DrawError> {
    let problem = scene.problem()?;
    let [x, y] = scene.variables()?;
    let model = problem.model;
    hamiltonian::check_form(model)?;
    let phi = scene.x_range();
    let points = hamiltonian::stationary_points(model);
    let cloudy = scene.clouds().into_iter().flatten().map(|cloud| cloud.y.end);
    let highest = cloudy.chain(points.iter().map(|point| point.e + 0.03)).fold(0.9, f64::max).min(0.99);
    let still = hamiltonian::still_circle(model).filter(|e| *e < highest);
    let borders = sub_domains::borders(model, &points);
    let line = critical(scene, &phi, &(0.0..highest));
    let line_name = line.as_ref().map_or(String::new(), |(_, name)| name.clone());
    let mean = &problem.initial;
    let start = mean.mean_phi + crate::branch::shift_into(&phi, &(mean.mean_phi..mean.mean_phi));
    let of_kind = |is_centre: bool| -> Vec<Point> {
        let shown = points.iter().filter(|p| p.is_centre == is_centre && p.e <= highest);
        shown.flat_map(|p| copies(p, &phi)).collect()
    };
    let entries = [
        (true, Sample::Line(CONTOUR), "constant Hamiltonian H".to_owned()),
        (!borders.is_empty(), Sample::Line(DIVIDING), "border of a sub-domain (SubD)".to_owned()),
        (line.is_some(), Sample::Line(super::CRITICAL), line_name),
        (!of_kind(true).is_empty(), Sample::Marker(Marker::Circle, POINT, true), "centre".to_owned()),
        (!of_kind(false).is_empty(), Sample::Marker(Marker::Cross, POINT, false), "saddle".to_owned()),
        (still.is_some(), Sample::Line(STANDING), "every point stands still".to_owned()),
        (true, Sample::Marker(Marker::Plus, MEAN, false), "initial mean".to_owned()),
    ];
    let key: Vec<_> =
        entries.into_iter().filter(|(exists, ..)| *exists).map(|(_, sample, words)| (sample, words)).collect();
    let levels = levels(model, highest);
    let contours = |level: &f64, stroke| mirrored(&hamiltonian::contour(model, *level), &phi, stroke);
    let caption = format!(
        "Contours of the Hamiltonian for {}; satellites move along them. {} φ and φ + 2π are the same. \
         Corresponds to Fig. 1 of Sun et al. (2022), whose points P1 and P4 are e = 0 and the saddle.",
        parameters_in_words(&model),
        sub_domains_in_words(&sub_domains::present(model, &points, highest), !borders.is_empty())
    );
    Figure::draw(&scene.figure_name("phase-portrait"), "Phase portrait", &caption, (760, 430), &key, |area| {
        let panel =
            Panel::new(area, &axis_of(x, phi.clone(), 7), &axis_of(y, 0.0..highest, 9), Surroundings::default())?;
        let thin = levels.iter().flat_map(|level| contours(level, CONTOUR));
        let thick = mirrored(&borders, &phi, DIVIDING);
        let standing = still.map(|e| Element::curve(vec![(phi.start, e), (phi.end, e)], STANDING));
        panel.draw(
            &thin.chain(thick).chain(standing).chain(line.iter().map(|(line, _)| line.clone())).collect::<Vec<_>>(),
        )?;
        let markers = [
            Element::markers(of_kind(true), Marker::Circle, 4.0, POINT, true),
            Element::markers(of_kind(false), Marker::Cross, 4.5, POINT, false),
            Element::markers(vec![(start, mean.mean_e)], Marker::Plus, 5.5, MEAN, false),
        ];
        panel.draw_over(&markers)?;
        let obstacles: Vec<Point> =
            of_kind(true).into_iter().chain(of_kind(false)).chain([(start, mean.mean_e)]).collect();
        let labels = sub_domain_labels(problem, &panel, &points, &obstacles);
        labels.into_iter().try_for_each(|(number, place)| write_number(&panel, number, place))
    })
}

/// Writes the number of a sub-domain at a place of it, on a block that hides the contours.
fn write_number(panel: &Panel<'_, '_>, number: usize, place: Point) -> Result<(), DrawError> {
    let text = subscript("SubD", &number.to_string());
    let (x, y) = panel.pixels(place);
    let half = 0.5 * text_width(&text, TEXT) + 2.0;
    let (corner, opposite) = (panel.point(x - half, y - 8.0), panel.point(x + half, y + 10.0));
    panel.draw_over(&[Element::block(corner, opposite, Ink::Paper, 0.85)])?;
    panel.write(&text, place, bold(text_style(TEXT, Ink::Text, HPos::Center, VPos::Center)))
}

/// The model's parameters: `C = 0.15 and W = 0.40921`.
fn parameters_in_words(model: &Planar) -> String {
    let said = |(parameter, value): (Parameter, f64)| format!("{} = {value}", parameter.symbol);
    let said: Vec<String> = model.parameters().into_iter().map(said).collect();
    match said.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => said.concat(),
    }
}

/// What each sub-domain is, and which are not there.
fn sub_domains_in_words(present: &BTreeSet<Motion>, has_borders: bool) -> String {
    let named = present.iter().map(|motion| match motion.number() {
        Some(number) => format!("in sub-domain {number} {}", motion.words()),
        None => format!("without a number: {}", motion.words()),
    });
    let named = named.collect::<Vec<_>>().join("; ");
    if present.contains(&Motion::Unsorted) {
        return format!("Here, {}.", Motion::Unsorted.words());
    }
    let absent: Vec<String> = [Motion::AboutPi, Motion::Round, Motion::AboutZero]
        .into_iter()
        .filter(|motion| !present.contains(motion))
        .filter_map(|motion| motion.number().map(|number| number.to_string()))
        .collect();
    let absent = match absent.as_slice() {
        [] => String::new(),
        numbers => format!(" This portrait has no sub-domain {}.", numbers.join(" and no sub-domain ")),
    };
    let borders = if has_borders { "Thick contours pass through e = 0 and through the saddles: " } else { "Here, " };
    format!("{borders}{named}.{absent}")
}

/// A stationary point on every turn that the axis shows.
fn copies(point: &Stationary, phi: &Range<f64>) -> Vec<Point> {
    let first = ((phi.start - point.phi) / TURN).ceil() as i32;
    let places = (first..).map(|turn| point.phi + f64::from(turn) * TURN).take_while(|at| *at <= phi.end + 1e-9);
    places.map(|at| (at, point.e)).collect()
}

/// Levels that divide the plane shown into parts of about the same area.
fn levels(model: Planar, highest: f64) -> Vec<f64> {
    const SIDE: usize = 40;
    let middle = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let mut values: Vec<f64> = (0..SIDE * SIDE)
        .map(|k| hamiltonian::at(model, std::f64::consts::PI * middle(k / SIDE), highest * middle(k % SIDE)))
        .collect();
    values.sort_by(f64::total_cmp);
    (0..LEVELS).filter_map(|k| values.get((2 * k + 1) * values.len() / (2 * LEVELS)).copied()).collect()
}

/// Numbers and places of the labels of sub-domains. Each part of a sub-domain that has a number is labelled at the
/// place farthest from its borders, from the marked points and from the frame.
fn sub_domain_labels(
    problem: &Problem<Planar>,
    panel: &Panel<'_, '_>,
    points: &[Stationary],
    marked: &[Point],
) -> Vec<(usize, Point)> {
    /// Room that the letters need above and below; they need twice as much on either side \[px\].
    const ROOM: f64 = 9.0;
    let [left, top, right, bottom] = panel.frame();
    let place = |k: usize| {
        let (i, j) = (k / ROWS, k % ROWS);
        let x = left + (right - left) * (i as f64 + 0.5) / COLUMNS as f64;
        (x, top + (bottom - top) * (j as f64 + 0.5) / ROWS as f64)
    };
    let domain = |k: usize| {
        let (x, y) = place(k);
        let (phi, e) = panel.point(x, y);
        sub_domains::motion(problem.model, points, phi, e)
    };
    let domains: Vec<Motion> = (0..COLUMNS * ROWS).map(domain).collect();
    let marked: Vec<(f64, f64)> = marked.iter().map(|point| panel.pixels(*point)).collect();
    let critical = panel.pixels((0.0, problem.critical_e)).1;
    // Words are wider than they are high, so distances along x count half.
    let distance = |a: (f64, f64), b: (f64, f64)| (0.5 * (a.0 - b.0)).hypot(a.1 - b.1);
    let room = |k: usize| {
        let at = place(k);
        let others = (0..domains.len()).filter(|&other| domains[other] != domains[k]);
        let others = others.map(|other| distance(at, place(other)));
        let frame = [0.5 * (at.0 - left), 0.5 * (right - at.0), at.1 - top, bottom - at.1, (at.1 - critical).abs()];
        others.chain(marked.iter().map(|&m| distance(at, m))).chain(frame).fold(f64::INFINITY, f64::min)
    };
    let best = |part: Vec<usize>| {
        let roomiest = part.into_iter().map(|k| (k, room(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        let (k, _) = roomiest.filter(|(_, room)| *room > ROOM)?;
        Some((domains[k].number()?, panel.point(place(k).0, place(k).1)))
    };
    parts(&domains).into_iter().filter_map(best).collect()
}

/// Number of columns of the lattice on which places for labels are looked for.
const COLUMNS: usize = 48;
/// Number of its rows, counted from the top.
const ROWS: usize = 36;

/// The connected parts of the lattice with the same motion.
fn parts(domains: &[Motion]) -> Vec<Vec<usize>> {
    let mut is_taken = vec![false; domains.len()];
    let mut parts = Vec::new();
    for seed in 0..domains.len() {
        let (mut part, mut open) = (Vec::new(), vec![seed]);
        while let Some(k) = open.pop() {
            if is_taken[k] || domains[k] != domains[seed] {
                continue;
            }
            is_taken[k] = true;
            part.push(k);
            open.extend((k % ROWS > 0).then(|| k - 1));
            open.extend((k % ROWS < ROWS - 1).then(|| k + 1));
            open.extend(k.checked_sub(ROWS));
            open.extend((k + ROWS < domains.len()).then_some(k + ROWS));
        }
        if !part.is_empty() {
            parts.push(part);
        }
    }
    parts
}
