//! Formats of the numbers in the report.

use maud::{Markup, html};

/// A value with five decimals, as in the tables of the paper.
pub fn plain(value: f64) -> Markup {
    if value.is_nan() {
        html! { "–" }
    } else {
        html! { (format!("{value:.5}").replace('-', "−")) }
    }
}

/// A value that a case should give, as `number` prints it; the word "withheld" if the case withholds it.
pub fn given(value: f64, number: impl Fn(f64) -> Markup) -> Markup {
    if value.is_nan() {
        html! { "withheld" }
    } else {
        number(value)
    }
}

/// A small number: two digits and a power of ten.
pub fn small(value: f64) -> Markup {
    if value.is_nan() {
        return html! { "–" };
    }
    if value == 0.0 {
        return html! { "0" };
    }
    let text = format!("{value:.1e}");
    match text.split_once('e') {
        Some((mantissa, power)) if !matches!(power, "0" | "-1" | "1") => {
            html! { (mantissa.replace('-', "−")) " × 10" sup { (power.replace('-', "−")) } }
        }
        _ => html! { (format!("{value:.2}").replace('-', "−")) },
    }
}

/// A probability: five decimals, or a power of ten if they would all be 0; a method may withhold it.
pub fn probability(p: f64) -> Markup {
    if p == 0.0 || p >= 1e-5 || p.is_nan() { given(p, plain) } else { small(p) }
}

/// Seconds of CPU time.
pub fn seconds(value: f64) -> Markup {
    if value.is_nan() {
        html! { "–" }
    } else {
        html! { (format!("{value:.4}")) }
    }
}

/// A count with its digits in groups of three.
pub fn count(value: f64) -> Markup {
    if !(0.0..1e15).contains(&value) {
        return html! { "–" };
    }
    let digits = format!("{value:.0}");
    let grouped: String = digits
        .char_indices()
        .flat_map(|(i, digit)| {
            let is_start = i > 0 && (digits.len() - i) % 3 == 0;
            is_start.then_some('\u{2009}').into_iter().chain([digit])
        })
        .collect();
    html! { (grouped) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_two_digits_and_unknown_ones_are_a_dash() {
        assert_eq!(small(2.71e-4).0, "2.7 × 10<sup>−4</sup>");
        assert_eq!(small(0.271).0, "0.27");
        assert_eq!(small(f64::NAN).0, "–");
        assert_eq!(given(f64::NAN, plain).0, "withheld");
        assert_eq!(given(0.0, plain).0, "0.00000");
        assert_eq!(count(99_856.0).0, "99\u{2009}856");
        assert_eq!(count(f64::NAN).0, "–");
    }
}
