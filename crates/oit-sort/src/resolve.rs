//! The CPU twin of a whole resolve program, for one pixel: take, sort, composite.

use crate::{End, SortSpec, SortStrategy};
use oit_fragments::Fragment;

/// Memory that [`sorted`] and [`resolve`] use again from pixel to pixel.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    fragments: Vec<Fragment>,
    work: Vec<Fragment>,
}

/// The first `spec.max_frags` of a pixel's fragments (in the order given, which is the layout's),
/// put nearest first by the twin of the strategy's kernel. An unsorted strategy leaves them as they
/// came.
pub fn sorted<'a>(
    strategy: &dyn SortStrategy,
    spec: &SortSpec,
    fragments: &[Fragment],
    scratch: &'a mut Scratch,
) -> &'a [Fragment] {
    let limit = strategy.limit_in(spec.store);
    debug_assert!(limit.is_none_or(|limit| spec.max_frags <= limit), "beyond its limit");
    let taken = fragments.len().min(spec.max_frags as usize);
    scratch.fragments.clear();
    scratch.fragments.extend_from_slice(&fragments[..taken]);
    strategy.sort(spec, &mut scratch.fragments, &mut scratch.work);
    &scratch.fragments
}

/// One pixel by the twin of the whole program: the first `spec.max_frags` fragments, sorted and
/// composited as the kernel does. Premultiplied red, green, blue, alpha.
pub fn resolve(
    strategy: &dyn SortStrategy,
    spec: &SortSpec,
    fragments: &[Fragment],
    scratch: &mut Scratch,
) -> [f32; 4] {
    strategy.composite(sorted(strategy, spec, fragments, scratch))
}

/// The twin of `blend_front` and `blend_back` in single precision: fragments in the order they are
/// blended (nearest first for [`End::Front`], farthest first for [`End::Back`]) to premultiplied
/// red, green, blue and `1 - transmittance`.
pub fn composite(fragments: impl Iterator<Item = Fragment>, end: End) -> [f32; 4] {
    let mut colour = [0.0f32; 3];
    let mut transmittance = 1.0f32;
    for fragment in fragments {
        let [r, g, b, a] = fragment.rgba8().map(|c| UNORM[usize::from(c)]);
        let own = [r, g, b];
        match end {
            End::Front => {
                let weight = transmittance * a;
                for (sum, own) in colour.iter_mut().zip(own) {
                    *sum += weight * own;
                }
            }
            End::Back => {
                for (behind, own) in colour.iter_mut().zip(own) {
                    *behind += (own - *behind) * a;
                }
            }
        }
        transmittance *= 1.0 - a;
    }
    [colour[0], colour[1], colour[2], 1.0 - transmittance]
}

/// Eight bits to 0..1, as `unpack4x8unorm` does: a table is faster than four divisions.
static UNORM: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = i as f32 / 255.0;
        i += 1;
    }
    table
};
