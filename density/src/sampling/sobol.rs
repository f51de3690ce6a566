//! The Sobol sequence in up to eight dimensions, scrambled.
//!
//! The first coordinate is van der Corput's (the index with its bits reversed behind the point). The second has the
//! direction numbers of the primitive polynomial `x + 1`: Pascal's triangle modulo 2 (Sobol', USSR Comput. Math. Math.
//! Phys. 7, 1967). The two are a (0,2)-sequence: each dyadic box of area `2^-m` holds exactly one of the first `2^m`
//! points. The further coordinates have the direction numbers of Joe & Kuo (SIAM J. Sci. Comput. 30, 2008; their table
//! `new-joe-kuo-6`), which make pairs of coordinates as even as can be.
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

/// Largest number of coordinates.
pub(super) const MOST_COORDINATES: usize = 8;

/// A row of Joe & Kuo's table: the degree and the inner coefficients of a primitive polynomial, and the initial numbers
/// `m`.
struct Polynomial {
    degree: usize,
    inner: u64,
    initial: &'static [u64],
}

/// The rows of the coordinates from the third on.
const POLYNOMIALS: [Polynomial; MOST_COORDINATES - 2] = [
    Polynomial { degree: 2, inner: 1, initial: &[1, 3] },
    Polynomial { degree: 3, inner: 1, initial: &[1, 3, 1] },
    Polynomial { degree: 3, inner: 2, initial: &[1, 1, 1] },
    Polynomial { degree: 4, inner: 1, initial: &[1, 1, 3, 3] },
    Polynomial { degree: 4, inner: 4, initial: &[1, 3, 5, 13] },
    Polynomial { degree: 5, inner: 2, initial: &[1, 1, 5, 5, 17] },
];

/// The direction numbers of one coordinate, one for each bit of an index, the first digit topmost.
type Directions = [u64; 64];

const DIRECTIONS: [Directions; MOST_COORDINATES] = {
    let mut all = [[0; 64]; MOST_COORDINATES];
    let mut bit = 0;
    while bit < 64 {
        all[0][bit] = 1 << (63 - bit);
        all[1][bit] = if bit == 0 { 1 << 63 } else { all[1][bit - 1] ^ (all[1][bit - 1] >> 1) };
        bit += 1;
    }
    let mut row = 0;
    while row < POLYNOMIALS.len() {
        all[row + 2] = directions(&POLYNOMIALS[row]);
        row += 1;
    }
    all
};

/// `v_k = a_1 v_{k-1} ^ ... ^ a_{s-1} v_{k-s+1} ^ v_{k-s} ^ (v_{k-s} >> s)`, from `v_k = m_k 2^(64 - k)` for `k <= s`.
const fn directions(polynomial: &Polynomial) -> Directions {
    let Polynomial { degree, inner, initial } = *polynomial;
    let mut v = [0; 64];
    let mut bit = 0;
    while bit < 64 {
        if bit < degree {
            v[bit] = initial[bit] << (63 - bit);
        } else {
            v[bit] = v[bit - degree] ^ (v[bit - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if inner >> (degree - 1 - k) & 1 == 1 {
                    v[bit] ^= v[bit - k];
                }
                k += 1;
            }
        }
        bit += 1;
    }
    v
}

/// One scramble of the sequence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scramble<const N: usize> {
    /// Keys of the coin tosses of the coordinates.
    pub(super) keys: [u64; N],
}

impl<const N: usize> Scramble<N> {
    /// Point `index`, inside the open unit cube.
    pub(super) fn point(&self, index: u64) -> [f64; N] {
        const { assert!(N <= MOST_COORDINATES) };
        std::array::from_fn(|k| middle(scramble(digits(index, &DIRECTIONS[k]), self.keys[k])))
    }
}

/// Binary digits of a coordinate, the first digit topmost.
fn digits(index: u64, directions: &Directions) -> u64 {
    let (mut rest, mut sum) = (index, 0);
    while rest != 0 {
        sum ^= directions[rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    sum
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
pub(super) fn middle(digits: u64) -> f64 {
    ((digits >> (64 - DIGITS)) as f64 + 0.5) / (1u64 << DIGITS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points 1, 2, 3, 7, 20, 45 and 63, times 64, of scipy 1.16's `qmc.Sobol(d=8, scramble=False)`, which is in
    /// Gray-code order.
    const SCIPY: [(usize, [u64; 8]); 7] = [
        (1, [32, 32, 32, 32, 32, 32, 32, 32]),
        (2, [48, 16, 16, 16, 48, 48, 16, 48]),
        (3, [16, 48, 48, 48, 16, 16, 48, 16]),
        (7, [8, 40, 24, 8, 8, 24, 40, 40]),
        (20, [30, 6, 54, 18, 10, 54, 58, 14]),
        (45, [55, 61, 25, 39, 21, 7, 23, 15]),
        (63, [1, 51, 23, 29, 55, 9, 37, 9]),
    ];

    #[test]
    fn points_without_a_scramble_are_scipys() {
        for (number, expected) in SCIPY {
            let index = (number ^ (number >> 1)) as u64;
            assert_eq!(DIRECTIONS.map(|directions| digits(index, &directions) >> 58), expected, "{number}");
        }
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
    fn every_coordinate_has_one_of_the_first_points_in_each_of_as_many_intervals() {
        let scramble = Scramble { keys: [3, 1, 4, 15, 92, 65, 35, 89] };
        let points: Vec<[f64; 8]> = (0..1024).map(|i| scramble.point(i)).collect();
        for k in 0..8 {
            let mut places: Vec<usize> = points.iter().map(|point| (point[k] * 1024.0) as usize).collect();
            places.sort_unstable();
            assert!(places.into_iter().eq(0..1024), "{k}");
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
