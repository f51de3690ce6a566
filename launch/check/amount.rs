//! How the report writes the size of an error: in plain decimals where they are short, else with a power of ten.

/// An amount with at least two significant digits.
pub fn amount(x: f64) -> String {
    match x.abs() {
        _ if x.is_nan() => "not a number".into(),
        size if size.is_infinite() => "more than any number".into(),
        0.0 => "0".into(),
        size if (1e-3..1e6).contains(&size) => {
            let digits = (1.0 - size.log10().floor()).max(0.0) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.1e}"),
    }
}

/// For example "right to 3.0e-12"; "right to the last digit" if nothing is off.
pub fn to_within(word: &str, off: f64) -> String {
    if off == 0.0 { format!("{word} to the last digit") } else { format!("{word} to {}", amount(off)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_read_as_a_person_would_write_them() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.0"),
            (0.05, "0.050"),
            (-2.345, "-2.3"),
            (123.4, "123"),
            (3.21e-12, "3.2e-12"),
            (f64::INFINITY, "more than any number"),
            (f64::NAN, "not a number"),
        ] {
            assert_eq!(amount(x), text);
        }
        assert_eq!(
            (to_within("kept", 0.0).as_str(), to_within("kept", 2e-9).as_str()),
            ("kept to the last digit", "kept to 2.0e-9")
        );
    }
}
