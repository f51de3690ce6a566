//! The first numbers of many streams of a generator, side by side.
//!
//! Every draw has a stream of its own and takes a few numbers from it. The library's generator computes four blocks of
//! a stream at a time, most of which a draw never looks at. Here the first block of [`STREAMS`] neighbouring streams is
//! computed at once, one stream in each lane of a vector, and a draw that wants more goes on with the library's
//! generator. The numbers are the same, bit by bit.
//!
//! A block of ChaCha (Bernstein, *ChaCha, a variant of Salsa20*, 2008) is sixteen words of 32 bits: four constants, the
//! key, the number of the block, which is 0 here, and the number of the stream, mixed in eight rounds and added to what
//! they were.

use std::convert::Infallible;

use multiversion::multiversion;
use rand::{Rng, SeedableRng, TryRng};
use rand_chacha::ChaCha8Rng;

/// Number of streams side by side.
pub(super) const STREAMS: usize = 32;
/// Number of words of a block.
const WORDS: usize = 16;
/// The constants at the beginning of a block: "expand 32-byte k".
const CONSTANTS: [u32; 4] = [0x6170_7865, 0x3320_646e, 0x7962_2d32, 0x6b20_6574];

/// The same word of many streams.
type Word = [u32; STREAMS];

/// The streams of a seed.
#[derive(Debug, Clone)]
pub(super) struct Streams {
    generator: ChaCha8Rng,
    key: [u32; 8],
}

/// The first blocks of [`STREAMS`] neighbouring streams.
pub(super) struct Blocks<'a> {
    streams: &'a Streams,
    first: u64,
    words: [Word; WORDS],
}

/// One of them: a generator of the numbers of a stream.
pub(super) struct Stream<'a> {
    blocks: &'a Blocks<'a>,
    lane: usize,
    /// Number of words that have been taken from the block.
    taken: usize,
    /// What goes on where the block ends.
    rest: Option<ChaCha8Rng>,
}

impl Streams {
    pub fn new(seed: u64) -> Self {
        let generator = ChaCha8Rng::seed_from_u64(seed);
        let seed = generator.get_seed();
        let (words, _) = seed.as_chunks::<4>();
        let key = std::array::from_fn(|k| u32::from_le_bytes(words[k]));
        Self { generator, key }
    }

    /// The first blocks of the streams from number `first` on.
    pub fn blocks(&self, first: u64) -> Blocks<'_> {
        let mut words = [[0; STREAMS]; WORDS];
        first_blocks(&self.key, first, &mut words);
        Blocks { streams: self, first, words }
    }
}

impl Blocks<'_> {
    /// The stream of number `first + lane`, from its beginning.
    pub fn stream(&self, lane: usize) -> Stream<'_> {
        Stream { blocks: self, lane: lane % STREAMS, taken: 0, rest: None }
    }
}

impl Stream<'_> {
    /// The next `N` words of the block, if it has so many left.
    #[inline(always)]
    fn take<const N: usize>(&mut self) -> Option<[u32; N]> {
        let words = self.blocks.words.get(self.taken..self.taken + N)?;
        self.taken += N;
        Some(std::array::from_fn(|k| words[k][self.lane]))
    }

    /// The library's generator, at the word that comes next.
    #[cold]
    fn rest(&mut self) -> &mut ChaCha8Rng {
        let Blocks { streams, first, .. } = self.blocks;
        let at = std::mem::replace(&mut self.taken, WORDS);
        self.rest.get_or_insert_with(|| {
            let mut generator = streams.generator.clone();
            generator.set_stream(first.wrapping_add(self.lane as u64));
            generator.set_word_pos(at as u128);
            generator
        })
    }
}

impl TryRng for Stream<'_> {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.take::<1>().map_or_else(|| self.rest().next_u32(), |[word]| word))
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let whole = |[low, high]: [u32; 2]| u64::from(high) << 32 | u64::from(low);
        Ok(self.take::<2>().map_or_else(|| self.rest().next_u64(), whole))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.rest().fill_bytes(bytes);
        Ok(())
    }
}

#[inline(always)]
fn quarter_round([mut a, mut b, mut c, mut d]: [u32; 4]) -> [u32; 4] {
    a = a.wrapping_add(b);
    d = (d ^ a).rotate_left(16);
    c = c.wrapping_add(d);
    b = (b ^ c).rotate_left(12);
    a = a.wrapping_add(b);
    d = (d ^ a).rotate_left(8);
    c = c.wrapping_add(d);
    b = (b ^ c).rotate_left(7);
    [a, b, c, d]
}

/// A round over the columns of the block, then one over its diagonals.
#[inline(always)]
fn two_rounds(block: [u32; WORDS]) -> [u32; WORDS] {
    let [x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13, x14, x15] = block;
    let [x0, x4, x8, x12] = quarter_round([x0, x4, x8, x12]);
    let [x1, x5, x9, x13] = quarter_round([x1, x5, x9, x13]);
    let [x2, x6, x10, x14] = quarter_round([x2, x6, x10, x14]);
    let [x3, x7, x11, x15] = quarter_round([x3, x7, x11, x15]);
    let [x0, x5, x10, x15] = quarter_round([x0, x5, x10, x15]);
    let [x1, x6, x11, x12] = quarter_round([x1, x6, x11, x12]);
    let [x2, x7, x8, x13] = quarter_round([x2, x7, x8, x13]);
    let [x3, x4, x9, x14] = quarter_round([x3, x4, x9, x14]);
    [x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13, x14, x15]
}

/// The first blocks of the streams from number `first` on. The rounds are within the loop over the streams, since only
/// then does the compiler keep the blocks in vectors.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn first_blocks(key: &[u32; 8], first: u64, words: &mut [Word; WORDS]) {
    let ([c0, c1, c2, c3], [k0, k1, k2, k3, k4, k5, k6, k7]) = (CONSTANTS, *key);
    let (mut low, mut high) = ([0; STREAMS], [0; STREAMS]);
    for l in 0..STREAMS {
        let number = first.wrapping_add(l as u64);
        (low[l], high[l]) = (number as u32, (number >> 32) as u32);
    }
    for l in 0..STREAMS {
        let start = [c0, c1, c2, c3, k0, k1, k2, k3, k4, k5, k6, k7, 0, 0, low[l], high[l]];
        let mixed = two_rounds(two_rounds(two_rounds(two_rounds(start))));
        for k in 0..WORDS {
            words[k][l] = mixed[k].wrapping_add(start[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_a_stream_are_those_of_the_librarys_generator() {
        let streams = Streams::new(17);
        for first in [0, 5, (1 << 32) - 7, u64::MAX - 3] {
            let blocks = streams.blocks(first);
            for lane in 0..STREAMS {
                let (mut stream, mut library) = (blocks.stream(lane), ChaCha8Rng::seed_from_u64(17));
                library.set_stream(first.wrapping_add(lane as u64));
                assert!((0..20).all(|_| stream.next_u64() == library.next_u64()), "stream {first} + {lane}");
            }
        }
    }

    #[test]
    fn numbers_of_any_length_may_be_taken_across_the_end_of_the_block() {
        let streams = Streams::new(3);
        for before in 0..WORDS {
            let blocks = streams.blocks(40);
            let (mut stream, mut library) = (blocks.stream(2), ChaCha8Rng::seed_from_u64(3));
            library.set_stream(42);
            assert!((0..before).all(|_| stream.next_u32() == library.next_u32()));
            assert!((0..9).all(|_| stream.next_u64() == library.next_u64()), "{before} words before");
            assert!((0..3).all(|_| stream.next_u32() == library.next_u32()));
        }
    }
}
