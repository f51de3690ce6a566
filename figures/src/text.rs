//! Words in figures: the room that they take, and subscripts.

use maud::{Markup, html};

/// Between these two characters text is set as a subscript.
pub const SUBSCRIPT: [char; 2] = ['\u{E000}', '\u{E001}'];

/// Width of `text` at font size `size`. It is rather too large than too small, because no font is available to measure
/// it.
pub fn text_width(text: &str, size: f64) -> f64 {
    let em = |letter: char| match letter {
        'i' | 'j' | 'l' | 't' | 'f' | 'I' | '.' | ',' | ':' | ' ' | '\'' | '|' => 0.33,
        'm' | 'w' | 'M' | 'W' | '%' => 0.92,
        'A'..='Z' => 0.72,
        letter if SUBSCRIPT.contains(&letter) => 0.0,
        _ => 0.6,
    };
    size * text.chars().map(em).sum::<f64>()
}

/// Approximate width of `text` as drawn at font size `size`, with its subscripts.
pub fn drawn_width(text: &str, size: f64) -> f64 {
    let parts = text.split(SUBSCRIPT).enumerate();
    0.95 * parts.map(|(i, part)| text_width(part, if i % 2 == 1 { SUBSCRIPT_SIZE * size } else { size })).sum::<f64>()
}

/// Marks `text` as a subscript of `base`.
pub fn subscript(base: &str, text: &str) -> String {
    format!("{base}{}{text}{}", SUBSCRIPT[0], SUBSCRIPT[1])
}

/// Size of a subscript and, below, its depth under the base line, as shares of the font size.
const SUBSCRIPT_SIZE: f64 = 0.76;
const SUBSCRIPT_DEPTH: f64 = 0.19;

/// The text of font size `size` with its subscripts as elements. Sizes and shifts are numbers of pixels: programs that
/// convert SVG disagree on what a share of a font size means.
pub fn with_subscripts(text: &str, size: f64) -> Markup {
    let tenth = |value: f64| (10.0 * value).round() / 10.0;
    let depth = tenth(SUBSCRIPT_DEPTH * size);
    // Base and subscript alternate. Blanks at the ends of an element would be dropped, so they are made non-breaking.
    let kept = |part: &str| match (part.strip_prefix(' '), part.strip_suffix(' ')) {
        (Some(rest), _) => format!("\u{a0}{rest}"),
        (None, Some(rest)) => format!("{rest}\u{a0}"),
        _ => part.to_owned(),
    };
    html! {
        @for (i, part) in text.split(SUBSCRIPT).enumerate().filter(|(_, part)| !part.is_empty()) {
            @if i == 0 { (part) }
            @else if i % 2 == 1 { tspan dy=(depth) font-size=(tenth(SUBSCRIPT_SIZE * size)) { (part) } }
            @else { tspan dy=(-depth) font-size=(size) { (kept(part)) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_subscripts_are_lowered_and_raised_again_by_pixels() {
        let markup = with_subscripts(&format!("{} < {}", subscript("e", "cri"), 1), 12.0).0;
        assert_eq!(
            markup,
            "e<tspan dy=\"2.3\" font-size=\"9.1\">cri</tspan><tspan dy=\"-2.3\" font-size=\"12\">\u{a0}&lt; 1</tspan>"
        );
    }
}
