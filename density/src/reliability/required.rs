//! The factor on the radiation parameter with which a probability is reached.

use crate::exact::Estimated;

use super::quantity::{LARGEST_FACTOR, Quantity, SMALLEST_FACTOR};

/// The least factor with which a probability is reached, with half the distance between those at which the probability
/// plus and less its error reaches it.
pub fn factor_for(probability: f64, of: impl Fn(f64) -> Estimated) -> Estimated {
    const STEPS: i32 = 120;
    let factor = |k: i32| SMALLEST_FACTOR * (LARGEST_FACTOR / SMALLEST_FACTOR).powf(f64::from(k) / f64::from(STEPS));
    let with = |sign: f64| {
        let suffices = |factor: f64| {
            let found = of(factor);
            found.value + sign * found.error >= probability
        };
        let Some(first) = (0..=STEPS).find(|&k| suffices(factor(k))) else { return f64::INFINITY };
        if first == 0 {
            return 0.0;
        }
        let (mut low, mut high) = (factor(first - 1), factor(first));
        for _ in 0..30 {
            let middle = low.midpoint(high);
            if suffices(middle) { high = middle } else { low = middle }
        }
        high
    };
    let (value, early, late) = (with(0.0), with(1.0), with(-1.0));
    if value.is_infinite() || late.is_infinite() {
        return Estimated { value, error: if early == late { 0.0 } else { f64::INFINITY } };
    }
    Estimated { value, error: 0.5 * (late - early) }
}

/// The error of the probability on which a quantity rests: that of the point itself, or that at the factor that is
/// required.
pub fn error_at(quantity: Quantity, of: impl Fn(f64) -> Estimated) -> f64 {
    let factor = match quantity {
        Quantity::RequiredFactor { probability, .. } => factor_for(probability, &of).value,
        _ => 1.0,
    };
    of(factor.clamp(SMALLEST_FACTOR, LARGEST_FACTOR)).error
}
