//! The two-dimensional Sobol sequence, scrambled.
//!
//! The first coordinate is van der Corput's (the index with its bits reversed behind the point). The second has the
//! direction numbers of the primitive polynomial `x + 1`: Pascal's triangle modulo 2 (Sobol', USSR Comput. Math. Math.
//! Phys. 7, 1967). The two are a (0,2)-sequence: each dyadic box of area `2^-m` holds exactly one of the first `2^m`
//! points.
//!
//! Nested uniform scrambling (Owen, in *Monte Carlo and Quasi-Monte Carlo Methods*, 1995) flips each binary digit by a
//! coin toss that depends on all digits before it. It keeps the property of the sequence. It makes each point uniform,
//! hence every mean unbiased, and it makes the errors of independent scrambles independent; for smooth integrands the
//! variance falls almost as `n^-3` (Owen, Ann. Statist. 25, 1997). The coin toss is a hash of the digits before, so
//! that a point needs no other point.
//!
//! The code is our own, because existing crates end at 2^16 points in single precision or do not scramble.

/// Number of binary digits of a coordinate: as many as make the middle of the last box exact in double precision.
const DIGITS: u32 = 52;

/// One scramble of the sequence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scramble {
    /// Keys of the coin tosses of the two coordinates.
    pub(super) keys: [u64; 2],
}

impl Scramble {
    /// Point `index`, inside the open unit square.
    pub(super) fn point(self, index: u64) -> [f64; 2] {
        let plain = [index.reverse_bits(), second_coordinate(index)];
        std::array::from_fn(|k| middle(scramble(plain[k], self.keys[k])))
    }
}

/// Binary digits of the second coordinate, the first digit topmost.
fn second_coordinate(index: u64) -> u64 {
    let directions = std::iter::successors(Some(1u64 << 63), |v| Some(v ^ (v >> 1)));
    directions.take(64).enumerate().fold(0, |sum, (bit, v)| if index >> bit & 1 == 1 { sum ^ v } else { sum })
}

/// Flips each digit by the coin toss of the digits before it.
fn scramble(digits: u64, key: u64) -> u64 {
    (0..DIGITS).fold(digits, |flipped, place| {
        // The node of the binary tree that these digits lead to, numbered as in a heap.
        let node = 1u64 << place | digits.unbounded_shr(64 - place);
        flipped ^ (hash(key, node) >> 63) << (63 - place)
    })
}

/// Mixes a counter (the finaliser of SplitMix64: Steele, Lea & Flood, OOPSLA 2014), twice because the counters are few.
fn hash(key: u64, node: u64) -> u64 {
    mix(mix(key.wrapping_add(node.wrapping_mul(0x9e37_79b9_7f4a_7c15))) ^ key.rotate_left(32))
}

fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The middle of the box of the first [`DIGITS`] digits.
fn middle(digits: u64) -> f64 {
    ((digits >> (64 - DIGITS)) as f64 + 0.5) / (1u64 << DIGITS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_points_without_a_scramble_are_sobols() {
        // Joe & Kuo's published table begins (0,0), (1/2,1/2), (3/4,1/4), (1/4,3/4), (3/8,3/8) in Gray-code order.
        let points: Vec<[u64; 2]> = (0..8u64).map(|i| [i.reverse_bits() >> 61, second_coordinate(i) >> 61]).collect();
        let gray = |i: usize| points[i ^ (i >> 1)];
        assert_eq!([gray(0), gray(1), gray(2), gray(3), gray(4)], [[0, 0], [4, 4], [6, 2], [2, 6], [3, 3]]);
    }

    #[test]
    fn every_dyadic_box_holds_one_of_the_first_points_under_any_scramble() {
        for key in 0..20 {
            let scramble = Scramble { keys: [key, !key] };
            for m in [1, 4, 7, 10] {
                let points: Vec<[f64; 2]> = (0..1 << m).map(|i| scramble.point(i)).collect();
                for a in 0..=m {
                    let (wide, high) = (f64::from(1 << a), f64::from(1 << (m - a)));
                    let mut counts = vec![0; 1 << m];
                    points
                        .iter()
                        .for_each(|[x, y]| counts[(x * wide) as usize + ((y * high) as usize) * (1 << a)] += 1);
                    assert!(counts.iter().all(|&count| count == 1), "{key} {m} {a}");
                }
            }
        }
    }

    #[test]
    fn each_point_is_uniform_over_the_scrambles() {
        const SCRAMBLES: u64 = 20_000;
        const CELLS: usize = 8;
        for index in [0, 1, 37] {
            let mut counts = [0.0f64; CELLS * CELLS];
            for key in 0..SCRAMBLES {
                let [x, y] = Scramble { keys: [mix(key + 1), mix(key + (1 << 40))] }.point(index);
                counts[(x * CELLS as f64) as usize * CELLS + (y * CELLS as f64) as usize] += 1.0;
            }
            let expected = SCRAMBLES as f64 / counts.len() as f64;
            let chi_square: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
            let freedom = (counts.len() - 1) as f64;
            assert!((chi_square - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(), "{index} {chi_square}");
        }
    }
}
