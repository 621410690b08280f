//! The nearest few, again and again: no array, however deep a pixel is.

use super::early;
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Reads all of a pixel's fragments and keeps the nearest 32 in registers, in order; blends them; and
/// reads all again for the nearest 32 behind those, until none is left. It is multi-layer depth
/// peeling over captured fragments instead of draws of the scene. Of n fragments n / 32
/// scans read n each, and it takes no memory: there is nothing to be too small, and no array for a
/// driver to refuse.
///
/// A fragment that equals the last one blended is skipped as often as its equals have been blended,
/// so that none of several equal ones is lost.
pub(crate) struct Rescan {
    /// Whether it ends where what is left can hardly be seen: deep pixels then take a scan or two.
    pub(super) early: bool,
}

/// Registers of fragments.
const NEAREST: usize = 32;

impl SortStrategy for Rescan {
    fn name(&self) -> &'static str {
        if self.early { "rescan_early" } else { "rescan" }
    }

    fn summary(&self) -> &'static str {
        if self.early {
            "Scans for the nearest 32 of those left until less than 1/512 shows through: off by at most that."
        } else {
            "Scans all fragments for the nearest 32 of those left, in registers, until none is left."
        }
    }

    fn citation(&self) -> &'static str {
        if self.early {
            "Liu, Wei, Xu 2006 (of captured fragments); ended as ray casting is (Levoy 1990)"
        } else {
            "Liu, Wei, Xu, Multi-Layer Depth Peeling via Fragment Sort, MSR-TR-2006-81 (of captured fragments)"
        }
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Registers]
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn error_bound(&self) -> Option<f32> {
        self.early.then_some(early::BOUND)
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("rescan.wgsl.j2")
    }

    fn values(&self, _: &SortSpec) -> Value {
        context! {
            nearest => NEAREST,
            stop_below => self.early.then_some(early::BOUND_WGSL),
        }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => rescan(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => rescan(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }

    fn composite(&self, sorted: &[Fragment]) -> [f32; 4] {
        early::composite_front(sorted, self.error_bound())
    }
}

fn rescan(
    frags: &mut [Fragment],
    scratch: &mut Vec<Fragment>,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    scratch.clear();
    scratch.extend_from_slice(frags);
    let mut last: Option<Fragment> = None;
    let (mut blended, mut blended_equal) = (0, 0);
    while blended < frags.len() {
        // In order, in the places that they will have.
        let nearest = &mut frags[blended..];
        let room = nearest.len().min(NEAREST);
        let (mut held, mut equal) = (0, 0);
        for &f in scratch.iter() {
            if let Some(last) = last {
                if behind(last, f) {
                    continue;
                }
                if !behind(f, last) {
                    equal += 1;
                    if equal <= blended_equal {
                        continue;
                    }
                }
            }
            if held == room {
                if !behind(nearest[room - 1], f) {
                    continue;
                }
            } else {
                held += 1;
            }
            let mut i = held - 1;
            while i > 0 && behind(nearest[i - 1], f) {
                nearest[i] = nearest[i - 1];
                i -= 1;
            }
            nearest[i] = f;
        }
        for &f in &nearest[..held] {
            if last.is_none_or(|last| behind(f, last)) {
                last = Some(f);
                blended_equal = 0;
            }
            blended_equal += 1;
        }
        blended += held;
    }
}
