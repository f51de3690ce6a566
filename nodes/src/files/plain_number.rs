//! Numbers as a person writes them: no row of zeros where a power of ten is shorter.

/// A number in words for people: 0.25, but 1e-300.
pub fn plain(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 || !size.is_finite() || (1e-6..1e15).contains(&size) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_a_row_of_zeros() {
        for (number, text) in [
            (0.25, "0.25"),
            (-2.0, "-2"),
            (0.0, "0"),
            (1e-6, "0.000001"),
            (1e-300, "1e-300"),
            (-1.5e300, "-1.5e300"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(plain(number), text);
        }
    }
}
