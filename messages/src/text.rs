//! Text in fixed-size fields: UTF-8, padded with NUL bytes.

/// A label, such as a propagator's.
pub type Label = [u8; 32];

/// Packs `text`, cutting it at the last character that fits.
pub fn pack<const N: usize>(text: &str) -> [u8; N] {
    let fits = (0..=text.len().min(N)).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
    let mut field = [0; N];
    field[..fits].copy_from_slice(&text.as_bytes()[..fits]);
    field
}

/// Unpacks a field up to its first NUL; bytes that are not UTF-8 become `U+FFFD`.
pub fn unpack(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).into_owned()
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
    fn long_text_is_cut_between_characters() {
        assert_eq!(unpack(&pack::<4>("aaaé")), "aaa");
    }

    #[test]
    fn arbitrary_bytes_never_panic() {
        assert_eq!(unpack(&[0xff, b'a', 0, b'b']), "\u{fffd}a");
    }
}
