//! Words in figures: how much room they take, and subscripts.

use maud::{Markup, html};

/// Between these two characters text is set as a subscript.
pub const SUBSCRIPT: [char; 2] = ['\u{E000}', '\u{E001}'];

/// Width of `text` at font size `size`, rather too much than too little: no font is at hand to measure it.
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

/// Marks `text` as a subscript of `base`.
pub fn subscript(base: &str, text: &str) -> String {
    format!("{base}{}{text}{}", SUBSCRIPT[0], SUBSCRIPT[1])
}

/// The text with its subscripts as elements.
pub fn with_subscripts(text: &str) -> Markup {
    // Base and subscript in turn.
    html! {
        @for (i, part) in text.split(SUBSCRIPT).enumerate().filter(|(_, part)| !part.is_empty()) {
            @if i == 0 { (part) }
            @else if i % 2 == 1 { tspan dy="0.25em" font-size="76%" { (part) } }
            @else { tspan dy="-0.19em" { (part) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_subscripts_are_lowered_and_raised_again() {
        let markup = with_subscripts(&format!("{} < {}", subscript("e", "cri"), 1)).0;
        assert_eq!(markup, "e<tspan dy=\"0.25em\" font-size=\"76%\">cri</tspan><tspan dy=\"-0.19em\"> &lt; 1</tspan>");
    }
}
