//! Colours that colour-blind readers can distinguish, each with a counterpart for dark screens.
//!
//! The hues of the curves are those of Okabe & Ito (*Color Universal Design*, 2008), darkened where they would be too
//! pale on white. A case is identified by its colour, its dashes and its marker together, so colour is never the only
//! cue.

use std::borrow::Cow;

use maud::{Markup, PreEscaped, html};

/// A colour of the palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Axes, labels, and the reference.
    Text,
    /// Lines and words in the background: contours, secondary labels.
    Faint,
    /// Lines of the grid.
    Grid,
    /// The background.
    Paper,
    /// The colour of a series.
    Series(usize),
    /// A place between 0 and [`LAST_SHADE`] on a scale from early to late.
    Shade(u8),
}

/// The last place on the scale from early to late; a run has at most as many snapshots as the scale has places.
pub const LAST_SHADE: u8 = 63;

impl Ink {
    /// The `index`-th of `count` colours from early to late.
    pub fn of_many(index: usize, count: usize) -> Self {
        let share = index as f64 / (count.max(2) - 1) as f64;
        Self::Shade((share.min(1.0) * f64::from(LAST_SHADE)).round() as u8)
    }
}

/// The scale from early to late on white and on dark, each without the end that would be invisible there.
fn shade(place: u8) -> [(u8, u8, u8); 2] {
    let share = f64::from(place.min(LAST_SHADE)) / f64::from(LAST_SHADE);
    [0.76 * share, 0.3 + 0.7 * share].map(|at| colorous::PLASMA.eval_continuous(at).as_tuple())
}

/// The colours on white and on dark, of text, faint, grid and paper, then of the series.
const COLOURS: [[(u8, u8, u8); 2]; 10] = [
    [(0x1c, 0x21, 0x27), (0xe8, 0xea, 0xed)],
    [(0x6b, 0x74, 0x7e), (0x9b, 0xa6, 0xb1)],
    [(0xdf, 0xe3, 0xe7), (0x35, 0x3c, 0x45)],
    [(0xff, 0xff, 0xff), PAPER_DARK],
    [(0x00, 0x72, 0xb2), (0x5c, 0xb8, 0xec)],
    [(0xd5, 0x5e, 0x00), (0xf4, 0x91, 0x45)],
    [(0x00, 0x8f, 0x68), (0x2f, 0xcb, 0x9c)],
    [(0xa8, 0x42, 0x83), (0xe4, 0x94, 0xc6)],
    [(0x86, 0x6a, 0x00), (0xe4, 0xc2, 0x35)],
    [(0x56, 0x4f, 0xc8), (0xa3, 0x9d, 0xf8)],
];
const SERIES: usize = COLOURS.len() - FIRST_SERIES;
/// Position of the first series.
const FIRST_SERIES: usize = 4;
/// The background of a dark page.
pub const PAPER_DARK: (u8, u8, u8) = (0x15, 0x19, 0x1e);

const CLASSES: [[&str; 2]; COLOURS.len()] = [
    ["s-text", "f-text"],
    ["s-faint", "f-faint"],
    ["s-grid", "f-grid"],
    ["s-paper", "f-paper"],
    ["s-0", "f-0"],
    ["s-1", "f-1"],
    ["s-2", "f-2"],
    ["s-3", "f-3"],
    ["s-4", "f-4"],
    ["s-5", "f-5"],
];

impl Ink {
    /// Its place in the table of colours; `None` for a shade.
    fn position(self) -> Option<usize> {
        match self {
            Self::Text => Some(0),
            Self::Faint => Some(1),
            Self::Grid => Some(2),
            Self::Paper => Some(3),
            Self::Series(series) => Some(FIRST_SERIES + series % SERIES),
            Self::Shade(_) => None,
        }
    }

    /// Red, green and blue on white and on dark.
    fn colours(self) -> [(u8, u8, u8); 2] {
        match (self, self.position()) {
            (Self::Shade(place), _) => shade(place),
            (_, position) => COLOURS[position.unwrap_or(0)],
        }
    }

    /// Red, green and blue on white.
    pub fn rgb(self) -> (u8, u8, u8) {
        self.colours()[0]
    }

    /// The colour as SVG writes it.
    pub fn hex(self) -> String {
        hex(self.rgb())
    }

    /// The colours on white and on a dark page as a style sheet writes them.
    pub fn on_light_and_dark(self) -> [String; 2] {
        self.colours().map(hex)
    }

    /// The colour of the palette with these components on white; `Ink::Text` if there is none.
    pub fn from_rgb(rgb: (u8, u8, u8)) -> Self {
        match COLOURS.iter().position(|[light, _]| *light == rgb) {
            Some(1) => Self::Faint,
            Some(2) => Self::Grid,
            Some(3) => Self::Paper,
            Some(series @ FIRST_SERIES..) => Self::Series(series - FIRST_SERIES),
            Some(_) => Self::Text,
            None => (0..=LAST_SHADE).find(|place| shade(*place)[0] == rgb).map_or(Self::Text, Self::Shade),
        }
    }

    /// Class of elements that are stroked with the colour.
    pub fn stroke_class(self) -> Cow<'static, str> {
        self.class(0)
    }

    /// Class of elements that are filled with the colour.
    pub fn fill_class(self) -> Cow<'static, str> {
        self.class(1)
    }

    fn class(self, part: usize) -> Cow<'static, str> {
        match (self, self.position()) {
            (Self::Shade(place), _) => format!("{}{place}", ["s-t", "f-t"][part]).into(),
            (_, position) => CLASSES[position.unwrap_or(0)][part].into(),
        }
    }
}

fn hex((r, g, b): (u8, u8, u8)) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Style rules that recolour inline figures for a dark screen.
pub fn dark_rules() -> Markup {
    let named = [Ink::Text, Ink::Faint, Ink::Grid, Ink::Paper].into_iter();
    let inks = named.chain((0..SERIES).map(Ink::Series)).chain((0..=LAST_SHADE).map(Ink::Shade));
    let rules = inks.map(|ink| {
        let (stroke, fill, [_, dark]) = (ink.stroke_class(), ink.fill_class(), ink.colours());
        format!(".{stroke}{{stroke:{dark}}}.{fill}{{fill:{dark}}}", dark = hex(dark))
    });
    html! { (PreEscaped(rules.collect::<String>())) }
}

/// Dashes and gaps \[px\] of the series, in turn.
const DASHES: [&[f64]; 7] =
    [&[6.0, 3.0], &[2.0, 2.0], &[9.0, 3.0, 2.0, 3.0], &[12.0, 4.0], &[5.0, 2.0, 1.5, 2.0, 1.5, 2.0], &[3.0, 5.0], &[]];

/// A small outline that marks a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// ○
    Circle,
    /// □
    Square,
    /// △
    Triangle,
    /// ◇
    Diamond,
    /// ×
    Cross,
    /// +
    Plus,
    /// ▽
    Wedge,
}

impl Marker {
    const ALL: [Self; 7] =
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond, Self::Cross, Self::Plus, Self::Wedge];

    /// The marker of a series.
    pub fn of(series: usize) -> Self {
        Self::ALL[series % Self::ALL.len()]
    }

    /// Its outline as relative path data, `r` px in half width.
    pub fn outline(self, r: f64) -> String {
        let d = 2.0 * r;
        match self {
            Self::Circle => format!("m{r} 0a{r} {r} 0 1 1 -{d} 0a{r} {r} 0 1 1 {d} 0z"),
            Self::Square => format!("m-{r} -{r}h{d}v{d}h-{d}z"),
            Self::Triangle => format!("m0 -{r}l{r} {d}h-{d}z"),
            Self::Diamond => format!("m0 -{r}l{r} {r}l-{r} {r}l-{r} -{r}z"),
            Self::Cross => format!("m-{r} -{r}l{d} {d}m0 -{d}l-{d} {d}"),
            Self::Plus => format!("m-{r} 0h{d}m-{r} -{r}v{d}"),
            Self::Wedge => format!("m0 {r}l{r} -{d}h-{d}z"),
        }
    }
}

/// How a curve or an outline is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width \[px\].
    pub width: f64,
    /// Dashes and gaps \[px\]; empty for a solid line.
    pub dashes: &'static [f64],
}

/// How a case is drawn in every figure.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    /// Its line.
    pub stroke: Stroke,
    /// Its marker.
    pub marker: Marker,
    /// Whether the marker is filled.
    pub filled: bool,
}

impl Pen {
    /// The pen of the reference: solid, in the colour of the text.
    pub const REFERENCE: Self =
        Self { stroke: Stroke { ink: Ink::Text, width: 1.3, dashes: &[] }, marker: Marker::Circle, filled: true };

    /// The pen of the `series`-th other case.
    pub fn of(series: usize) -> Self {
        // Colours and dashes repeat together after a while; from then on the markers differ.
        let stroke = Stroke { ink: Ink::Series(series), width: 1.6, dashes: DASHES[series % DASHES.len()] };
        Self { stroke, marker: Marker::of(series + series / (SERIES * DASHES.len())), filled: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_is_recognised_and_recoloured_in_the_dark() {
        let rules = dark_rules().0;
        let series = (0..SERIES).map(Ink::Series);
        let shades = (0..=LAST_SHADE).map(Ink::Shade);
        for ink in [Ink::Text, Ink::Faint, Ink::Grid, Ink::Paper].into_iter().chain(series).chain(shades) {
            assert_eq!(Ink::from_rgb(ink.rgb()), ink);
            assert!(rules.contains(&format!(".{}{{fill:", ink.fill_class())), "{ink:?}");
        }
    }

    #[test]
    fn no_two_of_as_many_snapshots_as_a_run_may_have_share_a_colour() {
        let colours: std::collections::BTreeSet<_> = (0..64).map(|index| Ink::of_many(index, 64).rgb()).collect();
        assert_eq!(colours.len(), 64);
    }

    #[test]
    fn as_many_cases_as_a_run_may_have_are_drawn_in_ways_of_their_own() {
        let look = |series: usize| {
            let pen = Pen::of(series);
            (pen.stroke.ink.hex(), format!("{:?} {:?}", pen.stroke.dashes, pen.marker))
        };
        let looks: std::collections::BTreeSet<_> = (0..64).map(look).collect();
        assert_eq!(looks.len(), 64);
    }
}
