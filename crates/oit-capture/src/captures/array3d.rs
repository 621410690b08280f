//! `array3d`: as many slots for every pixel as the deepest needs.

use std::borrow::Cow;

use oit_fragments::{Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Pass};

use super::rewrite::rewritable_slots;
use crate::draw::{capture_pass, coverage, pixel_buffer, pool_slots};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// The same number of slots for every pixel, and a counter for each that says how many are filled:
/// the brute force of the LFB chapter (section 20.1). One pass, and no pointers; but every pixel
/// has room for as many fragments as the deepest has.
///
/// Fragment `i` of pixel `p` is at `i * pixels + p`, a layer of the picture behind the other, so
/// that neighbouring pixels' fragments are neighbours. A pool has as many layers as fit whole; one
/// with less than one slot a pixel has none.
///
/// Buffers: `counts` (a `u32` a pixel: the fragments it met, stored or not) and `fragments` (a
/// `vec2<u32>` each).
#[derive(Clone, Copy, Debug)]
pub struct Array3d;

/// Slots of a layer. At least four: the layout's reader takes their number from the binding of
/// `counts`, and no buffer has less than 16 bytes.
pub(super) fn layer_slots(pixels: u64) -> u64 {
    pixels.max(4)
}

/// The fragments of a pool of layers; `take` takes those of a pixel from the first layer on.
///
/// # Errors
/// Where a buffer cannot be read, or `take` finds it damaged.
pub(super) fn from_layers(
    read: &mut LfbReader,
    mut take: impl FnMut(
        usize,
        &mut dyn Iterator<Item = Fragment>,
        &mut Vec<Fragment>,
    ) -> Result<(), LfbError>,
) -> Result<Lfb, CaptureError> {
    let pixels = read.pixels();
    let layers = pool_slots(read.pool_slots) / layer_slots(pixels);
    let counts = read.words("counts", pixels)?;
    let slots = read.fragments(layers * layer_slots(pixels))?;
    let stride = layer_slots(pixels) as usize;

    let mut offsets = Vec::with_capacity(counts.len() + 1);
    let mut fragments = Vec::new();
    offsets.push(0);
    for (pixel, &count) in counts.iter().enumerate() {
        let held = u64::from(count).min(layers) as usize;
        take(pixel, &mut (0..held).map(|layer| slots[layer * stride + pixel]), &mut fragments)?;
        offsets.push(fragments.len());
    }
    Ok(Lfb::new(read.width_px, read.height_px, offsets, fragments)?)
}

/// The constant by which the capture's shaders know the size of a layer.
pub(super) fn stride_wgsl(request: &CaptureRequest) -> String {
    let pixels = u64::from(request.width_px) * u64::from(request.height_px);
    // No device has buffers for a picture that does not fit.
    let stride = u32::try_from(layer_slots(pixels)).unwrap_or(u32::MAX);
    format!("\nconst STRIDE = {stride}u;\n\n")
}

/// What each pixel met, stored or not, from its counts: the fragments, and the slots that a layer
/// for each of the deepest pixel's would take.
pub(super) fn layered_usage(counts: &[u32]) -> Usage {
    let peak = counts.iter().copied().max().unwrap_or(0);
    Usage {
        fragments: counts.iter().map(|&count| u64::from(count)).sum(),
        slots: layer_slots(counts.len() as u64) * u64::from(peak),
    }
}

/// The fragments of a pool layer by layer, as many layers as the deepest pixel has.
pub(super) fn in_layers(submitted: &Lfb) -> Vec<Fragment> {
    let stride = layer_slots(submitted.pixels() as u64) as usize;
    let peak = submitted.counts().max().unwrap_or(0) as usize;
    let mut fragments = vec![Fragment::default(); stride * peak];
    for pixel in 0..submitted.pixels() {
        for (layer, &fragment) in submitted.pixel(pixel).iter().enumerate() {
            fragments[layer * stride + pixel] = fragment;
        }
    }
    fragments
}

impl Capture for Array3d {
    fn name(&self) -> &'static str {
        "array3d"
    }

    fn summary(&self) -> &'static str {
        "As many slots for every pixel as the deepest needs, filled in one pass."
    }

    fn citation(&self) -> &'static str {
        "Liu et al., Single Pass Depth Peeling via CUDA Rasterizer, SIGGRAPH 2009 Talks; Knowles et \
         al., Efficient Layered Fragment Buffer Techniques, OpenGL Insights, 2012, section 20.1"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        [include_str!("array3d_slot.wgsl"), include_str!("array3d_layout.wgsl")].concat().into()
    }

    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        rewritable_slots(self, "lfb_stride")
    }

    fn random_access(&self) -> bool {
        true
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linked_list_count.wgsl").into()
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
        let fs = [&stride_wgsl(request), include_str!("array3d.wgsl")];
        let passes = vec![Pass::clear("clear", "counts"), capture_pass(request, "array3d", &fs)];
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        Ok(layered_usage(&read.words("counts", read.pixels())?))
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        from_layers(read, |_, held, fragments| {
            fragments.extend(held);
            Ok(())
        })
    }

    /// A pixel's slots are filled from the first: the order is that of submission.
    fn order(&self, _submitted: &mut Lfb) {}

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let counts: Vec<u32> = submitted.counts().collect();
        vec![words_buffer("counts", &counts), fragments_buffer(&in_layers(submitted))]
    }
}
