//! Quadrature rules on `[-1, 1]`: the 15-point Gauss-Kronrod rule with its embedded 7-point Gauss rule (Piessens et
//! al., *QUADPACK*, 1983, `qk15`), and the 8-point Gauss-Legendre rule.

/// Number of points of the Gauss-Kronrod rule.
pub(super) const POINTS: usize = 15;

/// Abscissa, Kronrod weight and Gauss weight (0 where the Gauss rule has no node), from the middle outwards.
const HALF: [(f64, f64, f64); 8] = [
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_225, 0.0),
];

/// Abscissae, Kronrod weights and Gauss weights.
pub(super) fn kronrod() -> [(f64, f64, f64); POINTS] {
    std::array::from_fn(|i| {
        let (x, kronrod, gauss) = HALF[i.abs_diff(7)];
        (if i < 7 { -x } else { x }, kronrod, gauss)
    })
}

/// Abscissae and weights of the 8-point Gauss-Legendre rule, positive half.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Number of points of the Gauss-Legendre rule.
pub(super) const GAUSS_POINTS: usize = 8;

/// Nodes and weights of the 8-point Gauss-Legendre rule on `[low, high]`, ascending.
pub(super) fn gauss(low: f64, high: f64) -> [(f64, f64); GAUSS_POINTS] {
    let (middle, half) = (low.midpoint(high), 0.5 * (high - low));
    std::array::from_fn(|i| {
        let (x, w) = if i < 4 { GAUSS_8[3 - i] } else { GAUSS_8[i - 4] };
        (middle + if i < 4 { -x } else { x } * half, w * half)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monomial(n: i32) -> f64 {
        if n % 2 == 0 { 2.0 / f64::from(n + 1) } else { 0.0 }
    }

    #[test]
    fn kronrod_rule_is_exact_up_to_degree_23_and_its_gauss_rule_up_to_13() {
        for n in 0..=23 {
            let sum: f64 = kronrod().iter().map(|&(x, w, _)| w * x.powi(n)).sum();
            assert!((sum - monomial(n)).abs() < 1e-15, "{n}");
        }
        let gauss = |n: i32| kronrod().iter().map(|&(x, _, w)| w * x.powi(n)).sum::<f64>() - monomial(n);
        assert!(gauss(12).abs() < 1e-15 && gauss(14).abs() > 1e-6);
    }

    #[test]
    fn gauss_rule_is_exact_up_to_degree_15() {
        let integral = |n: i32| gauss(1.0, 3.0).iter().map(|&(x, w)| w * x.powi(n)).sum::<f64>();
        for n in [0, 1, 7, 15] {
            let exact = (3f64.powi(n + 1) - 1.0) / f64::from(n + 1);
            assert!((integral(n) / exact - 1.0).abs() < 1e-14, "{n}");
        }
    }
}
