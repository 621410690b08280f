//! How many invocations share workgroup memory when each has its sorting arrays in it.

use crate::INVOCATIONS;

/// Workgroup memory that a program may take, in bytes. Desktop GPUs have 32 KiB and more (an H200 has
/// 48 KiB), and one number for all makes the programs the same on every device.
pub const WORKGROUP_BYTES: u32 = 32 * 1024;

/// The fewest invocations of a workgroup. Below a subgroup's 32 some of its lanes do nothing, and
/// they are what makes room for the deepest arrays; with fewer than 8 hardly any would be left.
pub const LEAST_INVOCATIONS: u32 = 8;

/// Bytes of a fragment.
const FRAG_BYTES: u32 = 8;

/// The most invocations, a power of two up to [`INVOCATIONS`], that find room for `frags` fragments
/// each; `None` where [`LEAST_INVOCATIONS`] do not.
pub(crate) fn invocations_with_room(frags: u32) -> Option<u32> {
    let has_room = |&invocations: &u32| {
        u64::from(invocations) * u64::from(frags) * u64::from(FRAG_BYTES)
            <= u64::from(WORKGROUP_BYTES)
    };
    let halved = |&invocations: &u32| Some(invocations / 2);
    std::iter::successors(Some(INVOCATIONS), halved)
        .take_while(|&invocations| invocations >= LEAST_INVOCATIONS)
        .find(has_room)
}

/// The most fragments of a pixel whose arrays, `array_frags` fragments in all, find room in
/// workgroup memory.
pub(crate) fn most_frags(array_frags: impl Fn(u32) -> u32) -> u32 {
    let most = WORKGROUP_BYTES / FRAG_BYTES / LEAST_INVOCATIONS;
    (1..=most).rev().find(|&n| invocations_with_room(array_frags(n)).is_some()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workgroup_shrinks_until_its_arrays_fit() {
        let fit = [(1, 64), (64, 64), (65, 32), (128, 32), (129, 16), (256, 16), (512, 8)];
        for (frags, invocations) in fit {
            assert_eq!(invocations_with_room(frags), Some(invocations), "{frags}");
        }
        assert_eq!(invocations_with_room(513), None);
        assert_eq!(invocations_with_room(u32::MAX), None);
    }

    #[test]
    fn the_deepest_array_fits_and_the_next_does_not() {
        assert_eq!(most_frags(|n| n), 512);
        assert_eq!(most_frags(|n| n + n / 2), 341);
        assert_eq!(most_frags(|_| 513), 0);
    }
}
