//! Text in fixed-size fields: UTF-8, padded with NUL bytes.

/// A label, such as a propagator's.
pub type Label = [u8; 32];

/// Longest field that holds a name \[bytes\]; longer fields hold sentences.
const LONGEST_NAME: usize = 64;

/// Packs `text`. A text that is too long is cut after the last character that fits. In a field for sentences it is
/// cut after the last word that fits, and an ellipsis follows.
pub fn pack<const N: usize>(text: &str) -> [u8; N] {
    if N > LONGEST_NAME && text.len() > N {
        let fits = cut(text, N - "…".len());
        let words = fits.rsplit_once(' ').map_or(fits, |(words, _)| words);
        return pack(&format!("{words}…"));
    }
    let mut field = [0; N];
    let fits = cut(text, N);
    field[..fits.len()].copy_from_slice(fits.as_bytes());
    field
}

/// The beginning of a text, at most `most` bytes long.
fn cut(text: &str, most: usize) -> &str {
    let end = (0..=text.len().min(most)).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
    &text[..end]
}

/// Unpacks a field up to its first NUL, [printable]; bytes that are not UTF-8 become `U+FFFD`.
pub fn unpack(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    printable(&String::from_utf8_lossy(&field[..end]))
}

/// Text that is safe to print: characters that a terminal would obey instead of printing them (control characters of
/// ASCII and of Latin 1, so also the one-byte CSI and OSC; marks that turn the direction of writing or end a line)
/// are escaped.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            c if c.is_control() => shown.extend(c.escape_default()),
            c @ ('\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}') => {
                shown.extend(c.escape_unicode());
            }
            c => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_fits_comes_back_whole() {
        assert_eq!(unpack(&pack::<32>("gmm-ut")), "gmm-ut");
        assert_eq!(unpack(&pack::<4>("abcd")), "abcd");
    }

    #[test]
    fn a_long_sentence_is_cut_between_words_and_says_so() {
        let shown = unpack(&pack::<72>(&"turns too fast to be followed ".repeat(5)));
        assert!(shown.ends_with("followed turns…") && shown.len() <= 72, "{shown}");
        assert_eq!(unpack(&pack::<72>(&"x".repeat(100))).len(), 72);
    }

    #[test]
    fn long_text_is_cut_between_characters() {
        assert_eq!(unpack(&pack::<4>("aaaé")), "aaa");
    }

    #[test]
    fn no_text_can_command_a_terminal() {
        for (code, shown) in [
            ("\u{1b}[2J", "\\u{1b}[2J"),
            ("\u{1b}]0;title\u{7}", "\\u{1b}]0;title\\u{7}"),
            ("\u{9b}2J", "\\u{9b}2J"),
            ("a\rb\u{8}c\nd", "a\\rb\\u{8}c\\nd"),
            ("\u{202e}abc", "\\u{202e}abc"),
            ("e = 0.5 ± 1e-3 µ, φ", "e = 0.5 ± 1e-3 µ, φ"),
        ] {
            assert_eq!(printable(code), shown);
            assert_eq!(unpack(&pack::<64>(code)), shown);
        }
    }

    #[test]
    fn arbitrary_bytes_never_panic() {
        assert_eq!(unpack(&[0xff, b'a', 0, b'b']), "\u{fffd}a");
    }
}
