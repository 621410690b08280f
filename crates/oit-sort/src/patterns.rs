//! Lists of fragments that sorts are tested on, on the CPU and on the GPU.
//!
//! In the drawings time of arrival runs to the right and depth upwards.

use oit_fragments::Fragment;

/// A family of lists: one for each length and seed.
#[derive(Clone, Copy)]
pub struct Pattern {
    /// Its name.
    pub name: &'static str,
    depth: fn(usize, usize, &mut Rng) -> f32,
    colour: fn(&mut Rng) -> [u8; 4],
}

impl Pattern {
    /// The list of `n` fragments. Equal seeds give equal lists.
    #[must_use]
    pub fn fragments(&self, n: usize, seed: u64) -> Vec<Fragment> {
        let mut rng = Rng(seed);
        let fragment = |i| Fragment::new((self.depth)(i, n, &mut rng), (self.colour)(&mut rng));
        (0..n).map(fragment).collect()
    }
}

/// Every pattern, in the order they are listed.
pub const PATTERNS: &[Pattern] = &[
    //  .    '   .
    //    ' .  '   .
    // '  .    .  '
    Pattern { name: "random", depth: |_, _, rng| rng.unit(), colour: any },
    //          . '
    //      . '
    //  . '
    Pattern { name: "sorted", depth: |i, n, _| (i + 1) as f32 / (n + 1) as f32, colour: any },
    //  ' .
    //      ' .
    //          ' .
    Pattern { name: "reversed", depth: |i, n, _| (n - i) as f32 / (n + 1) as f32, colour: any },
    //      . ' .
    //    '       '
    //  .           .
    Pattern {
        name: "organ_pipe",
        depth: |i, n, _| i.min(n - 1 - i) as f32 / n as f32,
        colour: any,
    },
    //
    //  . . . . . . .   unlike colours
    //
    Pattern { name: "all_equal", depth: |_, _, _| 0.5, colour: any },
    //
    //  . . . . . . .   one colour
    //
    Pattern { name: "identical", depth: |_, _, _| 0.5, colour: |_| [10, 20, 30, 40] },
    //  .   . .     .
    //
    //    .     . .     unlike colours
    Pattern {
        name: "two_valued",
        depth: |_, _, rng| if rng.next() & 1 == 0 { 0.25 } else { 0.75 },
        colour: any,
    },
    //  . ' .  '  . '   all below the least normal number, of both signs
    // -+-+-+-+-+-+-+-  0
    //  ' .  '  . '
    Pattern {
        name: "denormal",
        depth: |_, _, rng| f32::from_bits(rng.next() as u32 & 0x807f_ffff),
        colour: any,
    },
    //  . ' : . ' : '   a few units in the last place apart, so many are equal
    Pattern {
        name: "near_equal",
        depth: |_, _, rng| f32::from_bits(0.5f32.to_bits() + (rng.next() % 7) as u32),
        colour: |rng| [(rng.next() % 3) as u8, 0, 0, 128],
    },
    //  .       .       infinity
    //      .       .   greatest, 1, least, 0, -0, ...
    //    .   .         minus infinity
    Pattern {
        name: "extremes",
        depth: |_, _, rng| EXTREMES[(rng.next() % EXTREMES.len() as u64) as usize],
        colour: |rng| [[0; 4], [255; 4], [0, 0, 0, 255], [255, 0, 0, 0]][(rng.next() % 4) as usize],
    },
];

const EXTREMES: [f32; 9] = [
    f32::NEG_INFINITY,
    f32::MIN,
    -1e-45,
    -0.0,
    0.0,
    f32::MIN_POSITIVE,
    1.0,
    f32::MAX,
    f32::INFINITY,
];

fn any(rng: &mut Rng) -> [u8; 4] {
    (rng.next() as u32).to_le_bytes()
}

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 (included) to 1 (not).
    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u32 << 24) as f32
    }
}
