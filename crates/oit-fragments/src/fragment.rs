//! One fragment, and the two orders techniques may put fragments in.

use std::cmp::Ordering;

/// One fragment: 8 bytes, the layout every kernel reads as `vec2<u32>` (`x` colour, `y` depth key).
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Fragment {
    /// Colour and alpha, not premultiplied, RGBA with 8 bits a channel, red in the lowest byte
    /// (WGSL's `pack4x8unorm`).
    pub rgba: u32,
    /// Depth as its sortable bits: see [`depth_key`].
    pub depth_key: u32,
}

/// The bits of a depth as an unsigned integer that orders as the depths do, negative ones too.
///
/// `-0.0` is made `+0.0` first, so that equal depths have equal keys. NaN has no place in the
/// order and must not be passed.
#[must_use]
pub fn depth_key(depth: f32) -> u32 {
    debug_assert!(!depth.is_nan(), "a fragment's depth is never NaN");
    let bits = (depth + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 0x8000_0000 }
}

/// The depth a key was made from.
#[must_use]
pub fn depth_from_key(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & 0x7fff_ffff } else { !key })
}

impl Fragment {
    /// A fragment of this depth (not NaN) and colour.
    #[must_use]
    pub fn new(depth: f32, rgba: [u8; 4]) -> Self {
        Self { rgba: u32::from_le_bytes(rgba), depth_key: depth_key(depth) }
    }

    /// The total order's key: depth first, colour second. Fragments with equal keys are equal.
    #[must_use]
    pub fn key(self) -> u64 {
        (u64::from(self.depth_key) << 32) | u64::from(self.rgba)
    }

    /// The depth as a float.
    #[must_use]
    pub fn depth(self) -> f32 {
        depth_from_key(self.depth_key)
    }

    /// Red, green, blue, alpha.
    #[must_use]
    pub fn rgba8(self) -> [u8; 4] {
        self.rgba.to_le_bytes()
    }
}

/// What a technique compares when it sorts.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Ties {
    /// Depth and colour as one 64-bit key: every exact technique has one right answer.
    #[default]
    Total,
    /// Depth alone, as the papers compare: fragments of equal depth stay in whatever order the
    /// sort and the capture leave them, so a picture may change from frame to frame.
    Depth,
}

impl Ties {
    /// Both rules, in the order they are listed.
    pub const ALL: [Self; 2] = [Self::Total, Self::Depth];

    /// The word for it in names and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Depth => "depth",
        }
    }

    /// Compares two fragments by this rule, nearest first.
    #[must_use]
    #[inline]
    pub fn compare(self, a: Fragment, b: Fragment) -> Ordering {
        match self {
            Self::Total => a.key().cmp(&b.key()),
            Self::Depth => a.depth_key.cmp(&b.depth_key),
        }
    }

    /// Whether `a` must come strictly behind `b`.
    #[must_use]
    #[inline]
    pub fn behind(self, a: Fragment, b: Fragment) -> bool {
        match self {
            Self::Total => a.key() > b.key(),
            Self::Depth => a.depth_key > b.depth_key,
        }
    }

    /// Where a CPU twin says how often it compared fragments by other means than these, for the crate
    /// that counts comparisons (`oit-fragments-counted`). Does nothing here.
    #[inline]
    pub fn compared_otherwise(self, comparisons: usize) {
        let _ = comparisons;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_order_as_depths_do() {
        let depths = [
            f32::NEG_INFINITY,
            -3.0,
            -f32::MIN_POSITIVE,
            -1e-45,
            0.0,
            1e-45,
            f32::MIN_POSITIVE,
            0.5,
            1.0 - f32::EPSILON / 2.0,
            1.0,
            7.0e7,
            f32::INFINITY,
        ];
        for pair in depths.windows(2) {
            assert!(depth_key(pair[0]) < depth_key(pair[1]), "{} before {}", pair[0], pair[1]);
        }
        for depth in depths {
            assert_eq!(depth_from_key(depth_key(depth)).to_bits(), depth.to_bits());
        }
    }

    #[test]
    fn the_two_zeros_are_one_depth() {
        assert_eq!(depth_key(-0.0), depth_key(0.0));
    }

    #[test]
    fn colour_breaks_ties_only_in_the_total_order() {
        let a = Fragment::new(0.5, [1, 0, 0, 9]);
        let b = Fragment::new(0.5, [2, 0, 0, 9]);
        assert_eq!(Ties::Total.compare(a, b), Ordering::Less);
        assert_eq!(Ties::Depth.compare(a, b), Ordering::Equal);
        assert!(!Ties::Depth.behind(b, a) && Ties::Total.behind(b, a));
    }
}
