//! Densities in two bytes per bin, as the script of the page reads them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// How many powers of ten below the peak are told apart; a density below that is 0 here.
pub const DECADES: f64 = 12.0;
/// The number that stands for the peak; 0 stands for 0.
const TOP: f64 = u16::MAX as f64;

/// The density of each bin as a little-endian number `q` of two bytes, in base64. The density is
/// `peak * 10^(-DECADES (1 - (q - 1) / (TOP - 1)))`, or 0 where `q` is 0: it is right to 2.2e-4 of itself.
pub fn encode(values: &[f64], peak: f64) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|&value| step(value, peak).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

fn step(value: f64, peak: f64) -> u16 {
    let position = 1.0 + (value / peak).log10() / DECADES;
    if position >= 0.0 { (1.0 + position.min(1.0) * (TOP - 1.0)).round() as u16 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_density_is_right_to_two_parts_in_ten_thousand_or_zero() {
        let read = |q: u16| match q {
            0 => 0.0,
            q => 7.0 * 10f64.powf(-DECADES * (1.0 - (f64::from(q) - 1.0) / (TOP - 1.0))),
        };
        for value in [7.0, 6.9, 1.0, 1e-3, 3.3e-9, 7.1e-12] {
            assert!((read(step(value, 7.0)) / value - 1.0).abs() < 2.2e-4, "{value}");
        }
        assert_eq!([0.0, 6e-12, f64::NAN].map(|value| step(value, 7.0)), [0; 3]);
        assert_eq!(step(7.0, 7.0), u16::MAX);
        assert_eq!(encode(&[0.0, 7.0], 7.0), "AAD//w==");
        assert_eq!(encode(&[0.0, 0.0], 0.0), "AAAAAA==", "a density without mass is 0 everywhere");
    }
}
