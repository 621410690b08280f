//! `array3d_nearest`: the nearest fragments of every pixel, as many as it has slots.

use std::borrow::Cow;

use oit_fragments::Lfb;
use oit_gpu::{Buffer, Pass};

use super::array3d::{from_layers, in_layers, layer_slots, layered_usage, stride_wgsl};
use super::nearest::{CITATION, NEAREST, read_back, sort, stored};
use crate::draw::{capture_pass, coverage, pixel_buffer, pool_slots};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// The same number of slots for every pixel as in [`Array3d`](super::Array3d), each kept by a
/// 64-bit atomic maximum of inverted keys: a fragment is compared with slot after slot, and goes on
/// with the farther of the two. So each pixel keeps its nearest fragments, sorted front to back,
/// the same from run to run.
///
/// Buffers: `counts` (a `u32` a pixel: the fragments it met, stored or not) and `fragments` (a
/// `vec2<u32>` each, inverted; zeros are empty).
#[derive(Clone, Copy, Debug)]
pub struct Array3dNearest;

impl Capture for Array3dNearest {
    fn name(&self) -> &'static str {
        "array3d_nearest"
    }

    fn summary(&self) -> &'static str {
        "As many slots for every pixel, which keep its nearest fragments sorted by 64-bit atomics."
    }

    fn citation(&self) -> &'static str {
        CITATION
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        [include_str!("nearest_slot.wgsl"), include_str!("array3d_layout.wgsl")].concat().into()
    }

    fn random_access(&self) -> bool {
        true
    }

    /// The fragments it keeps.
    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("array3d_nearest_count.wgsl").into()
    }

    fn keeps_nearest(&self) -> bool {
        true
    }

    fn delivers_sorted(&self) -> bool {
        true
    }

    fn slots(&self, demand: &Demand) -> u64 {
        layer_slots(demand.counts.len() as u64) * u64::from(demand.histogram.peak())
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            pixel_buffer("counts", request),
            Buffer::new("fragments", 8 * pool_slots(request.pool_slots)),
        ]);
        let fs = [NEAREST, &stride_wgsl(request), include_str!("array3d_nearest.wgsl")];
        let passes = vec![
            Pass::clear("clear", "counts"),
            Pass::clear("clear", "fragments"),
            capture_pass(request, self.name(), &fs),
        ];
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        Ok(layered_usage(&read.words("counts", read.pixels())?))
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        from_layers(read, |pixel, held, fragments| read_back(pixel, held, fragments))
    }

    /// Sorted front to back.
    fn order(&self, submitted: &mut Lfb) {
        sort(submitted);
    }

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let counts: Vec<u32> = submitted.counts().collect();
        vec![words_buffer("counts", &counts), fragments_buffer(&in_layers(&stored(submitted)))]
    }
}
