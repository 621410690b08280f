//! The capture methods, one file each.

mod array3d;
mod array3d_nearest;
mod interleaved;
mod interleaved_lists;
mod linearized;
mod linearized_nearest;
mod linearized_unclipped;
mod linked_list;
mod linked_list_sorted;
mod linked_list_wide;
mod linked_pages;
mod nearest;
mod rewrite;

use oit_scene::Problem;

use crate::Capture;
pub use array3d::Array3d;
pub use array3d_nearest::Array3dNearest;
pub use interleaved::Interleaved;
pub use interleaved_lists::InterleavedLists;
pub use linearized::Linearized;
pub use linearized_nearest::LinearizedNearest;
pub use linearized_unclipped::LinearizedUnclipped;
pub use linked_list::LinkedList;
pub use linked_list_sorted::LinkedListSorted;
pub use linked_list_wide::LinkedListWide;
pub use linked_pages::LinkedPages;

/// Every capture method.
pub const CAPTURES: &[&dyn Capture] = &[
    &LinkedList::EACH,
    &LinkedList::SUBGROUPS,
    &LinkedList::BLEND,
    &LinkedListSorted::PATIENT,
    &LinkedPages::new(4),
    &LinkedPages::new(6),
    &Linearized::BLOCKS,
    &Linearized::SWEEP,
    &Linearized::LOOK_BACK,
    &Linearized::BLEND,
    &LinearizedNearest,
    &Interleaved,
    &InterleavedLists,
    &Array3d,
    &Array3dNearest,
];

/// Captures of fragments of 128 bits, which few sorts take, or by depth alone: they are found by name,
/// and are in no `all`.
pub const WIDE: &[&dyn Capture] = &[&LinkedListWide::DIRECT, &LinkedListWide::INDIRECT];

/// Captures that are kept to show what is wrong with them: they do not agree with the others, and
/// are found by name alone.
pub const FAULTY: &[&dyn Capture] =
    &[&LinearizedUnclipped { late: false }, &LinearizedUnclipped { late: true }];

/// A name that no capture method has, with the nearest ones.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{0}")]
pub struct UnknownCapture(pub Problem);

/// The capture method of this name, one of wide fragments and a faulty one too.
///
/// # Errors
/// Where there is none.
pub fn capture(name: &str) -> Result<&'static dyn Capture, UnknownCapture> {
    let all = || CAPTURES.iter().chain(WIDE).chain(FAULTY);
    let names = || all().map(|capture| capture.name());
    let found = all().find(|capture| capture.name() == name);
    found.copied().ok_or_else(|| UnknownCapture(Problem::unknown("capture", name, names())))
}
