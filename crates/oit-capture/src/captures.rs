//! The capture methods, one file each.

mod interleaved;
mod interleaved_lists;
mod linearized;
mod linked_list;

use oit_scene::Problem;

use crate::Capture;
pub use interleaved::Interleaved;
pub use interleaved_lists::InterleavedLists;
pub use linearized::Linearized;
pub use linked_list::LinkedList;

/// Every capture method.
#[rustfmt::skip]
pub const CAPTURES: &[&dyn Capture] = &[
    &LinkedList,
    &Linearized::BLOCKS,
    &Linearized::SWEEP,
    &Linearized::LOOK_BACK,
    &Linearized::BLEND,
    &Interleaved,
    &InterleavedLists,
];

/// A name that no capture method has, with the nearest ones.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{0}")]
pub struct UnknownCapture(pub Problem);

/// The capture method of this name.
///
/// # Errors
/// Where there is none.
pub fn capture(name: &str) -> Result<&'static dyn Capture, UnknownCapture> {
    let names = || CAPTURES.iter().map(|capture| capture.name());
    let found = CAPTURES.iter().find(|capture| capture.name() == name);
    found.copied().ok_or_else(|| UnknownCapture(Problem::unknown("capture", name, names())))
}
