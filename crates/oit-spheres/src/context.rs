//! What the parts of a plan are made from.

use oit_gpu::{Dispatch, Pass};

use crate::ids::Ids;
use crate::text::{ROW, flag, invocations, shader, word};
use crate::view::is_perspective;
use crate::{Billboard, Culling, Detail, Order, Raster, SphereRequest, Variation, occlusion};

/// Time that does not draw.
pub(crate) const PREPROCESS: &str = "preprocess";

/// Which objects a list is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Phase {
    /// All.
    Only,
    /// Those that were last seen.
    First,
    /// Those that the pyramid does not hide and that were not in the first.
    Second,
}

/// A variation, what it is to draw, and how many passes there are so far.
pub(crate) struct Context<'a> {
    pub(crate) variation: Variation,
    pub(crate) request: &'a SphereRequest<'a>,
    pub(crate) ids: Ids,
    /// Vertices of a draw for each sphere.
    pub(crate) corners: u32,
    parts: u32,
}

impl<'a> Context<'a> {
    pub(crate) fn new(variation: Variation, request: &'a SphereRequest<'a>, ids: Ids) -> Self {
        let pulled =
            matches!(variation.raster, Raster::Billboards { billboard: Billboard::Pulled, .. });
        Self { variation, request, ids, corners: if pulled { 3 } else { 1 }, parts: 0 }
    }

    pub(crate) fn objects(&self) -> u32 {
        self.request.spheres.spheres.objects.len() as u32
    }

    pub(crate) fn levels(&self) -> u32 {
        self.request.spheres.spheres.levels.len() as u32
    }

    pub(crate) fn perspective_wgsl(&self) -> String {
        flag("PERSPECTIVE", is_perspective(self.request.camera))
    }

    /// WGSL: `id_of` and `of_id`.
    pub(crate) fn ids_wgsl(&self) -> String {
        self.ids.wgsl()
    }

    /// WGSL: `object_at`.
    pub(crate) fn order_wgsl(&self) -> &'static str {
        match self.variation.order {
            Order::AsIs => include_str!("wgsl/order_as_is.wgsl"),
            Order::Sorted => include_str!("wgsl/order_sorted.wgsl"),
            _ => include_str!("wgsl/order.wgsl"),
        }
    }

    /// A pass of the preprocessing, a part of its own.
    pub(crate) fn listing(
        &mut self,
        label: &str,
        constants: &[String],
        texts: &[&str],
        dispatch: Dispatch,
    ) -> Pass {
        let constants = [&[word("ROW", ROW)], constants].concat();
        let shader = shader(label, &constants, texts);
        self.parts += 1;
        Pass::compute(PREPROCESS, shader, dispatch).part(self.parts - 1)
    }

    /// Passes of the preprocessing that fill buffers with zeros, a part of their own.
    pub(crate) fn clears(&mut self, buffers: &[&str]) -> Vec<Pass> {
        self.parts += 1;
        let clear = |&buffer| Pass::clear(PREPROCESS, buffer).part(self.parts - 1);
        buffers.iter().map(clear).collect()
    }

    /// A pass over all objects that chooses their levels and then does what `main` says.
    pub(crate) fn choosing(
        &mut self,
        label: &str,
        phase: Phase,
        constants: &[String],
        main: &str,
    ) -> Pass {
        let own = [
            word("CORNERS", self.corners),
            word("PHASE", u32::from(phase == Phase::Second) * 2),
            word("PYRAMID_LEVELS", occlusion::levels(self)),
            flag("BY_DISTANCE", self.variation.detail == Detail::ByDistance),
            flag("CULLING", self.variation.culling != Culling::None),
            self.perspective_wgsl(),
        ];
        let in_phase: &[&str] = match phase {
            Phase::Only => &[include_str!("wgsl/one_phase.wgsl")],
            Phase::First => &[include_str!("wgsl/phase_first.wgsl")],
            Phase::Second => {
                &[include_str!("wgsl/extent.wgsl"), include_str!("wgsl/phase_second.wgsl")]
            }
        };
        let texts = [
            &[include_str!("wgsl/view.wgsl"), include_str!("wgsl/slot.wgsl"), self.order_wgsl()],
            in_phase,
            &[include_str!("wgsl/choose.wgsl"), main],
        ]
        .concat();
        let constants = [&own, constants].concat();
        self.listing(label, &constants, &texts, invocations(u64::from(self.objects())))
    }
}
