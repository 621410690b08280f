//! A variation as a plan. Its stages: `preprocess` lists what is drawn (each pass a part), `draw` is
//! the thesis's protein program, and `shade` makes the picture of what it wrote.

use std::sync::Arc;

use oit_gpu::{
    Buffer, ColorAttachment, Compare, Depth as DepthTest, DepthStencil, Dispatch, Draw, Format,
    Load, Pass, Plan, Raster as Drawn, Target,
};
use oit_scene::{Camera, Shading};

use crate::context::{Context, Phase};
use crate::ids::Ids;
use crate::text::shader;
use crate::view::View;
use crate::{
    Billboard, Cover, Culling, Depth, Drawing, Order, Output, Projection, Raster, SphereBytes,
    Variation, billboard, drawing, occlusion, order,
};

/// What a plan leaves its picture in, a target or a buffer: four floats a pixel, premultiplied; alpha
/// is 1 where there is a sphere, and 0 elsewhere.
pub const PICTURE: &str = "image";

const DRAW: &str = "draw";
const SHADE: &str = "shade";

/// What is to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct SphereRequest<'a> {
    /// The spheres. Their colours' alpha is not used: all are opaque.
    pub spheres: &'a SphereBytes,
    /// How they are lit.
    pub shading: &'a Shading,
    /// From where.
    pub camera: &'a Camera,
    /// Pixels of a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

impl Variation {
    /// The plan that draws spheres in this way and leaves the picture in [`PICTURE`].
    ///
    /// # Errors
    /// Why this cannot be drawn so, in words. What a device lacks is found by the device.
    pub fn plan(&self, request: &SphereRequest) -> Result<Plan, String> {
        self.refuse()?;
        let spheres = &request.spheres.spheres;
        if spheres.objects.is_empty() {
            return Err("there is no object to draw".to_owned());
        }
        if u32::try_from(3 * spheres.atoms.len()).is_err() {
            return Err(format!(
                "{} atoms have more corners than 32 bits count",
                spheres.atoms.len()
            ));
        }
        let needs_ids = self.output.packs_ids() || self.raster == Raster::Compute;
        let ids = match Ids::of(spheres) {
            Err(why) if needs_ids => return Err(why),
            ids => ids.unwrap_or(Ids::Split { atom_bits: 16 }),
        };
        let mut context = Context::new(*self, request, ids);
        let mut plan = Plan { name: self.to_string(), ..Plan::default() };
        plan.buffers = buffers(&context)?;
        plan.targets = self.output.targets(request.width_px, request.height_px);
        let target = |name: &str, format| Target {
            name: name.to_owned(),
            format,
            width: request.width_px,
            height: request.height_px,
        };
        if self.output == Output::Direct {
            let pixels = u64::from(request.width_px) * u64::from(request.height_px);
            plan.buffers.push(Buffer::new(PICTURE, 16 * pixels));
        } else {
            plan.targets.push(target(PICTURE, Format::Rgba32Float));
        }
        if self.raster != Raster::Compute {
            plan.targets.push(target("depth", Format::Depth32Float));
        }
        if self.order == Order::Sorted {
            plan.passes.extend(order::sort_passes(&mut context));
        }
        let phases: &[Phase] = match self.culling {
            Culling::Occlusion => &[Phase::First, Phase::Second],
            _ => &[Phase::Only],
        };
        for &phase in phases {
            if phase == Phase::Second {
                plan.passes.extend(occlusion::passes(&mut context));
            }
            match self.raster {
                Raster::Compute => {
                    plan.passes.extend(drawing::groups(&mut context, phase));
                    if phase != Phase::Second {
                        plan.passes.push(Pass::clear(DRAW, "nearest"));
                    }
                    plan.passes.push(rasterise(&context));
                }
                Raster::Billboards { drawing, .. } => {
                    plan.passes.extend(drawing::passes(&mut context, drawing, phase));
                    plan.passes.push(draw(&context, phase));
                }
            }
        }
        if self.raster == Raster::Compute && self.output != Output::Direct {
            plan.passes.push(write_out(&context));
        }
        plan.passes.push(shade(&context));
        Ok(plan)
    }

    /// Why it cannot be drawn, whatever the spheres.
    pub(crate) fn refuse(&self) -> Result<(), &'static str> {
        match self.raster {
            Raster::Compute if self.order != Order::AsIs => {
                Err("a compute rasteriser keeps the nearest in whatever order spheres come")
            }
            Raster::Billboards { drawing: Drawing::PerMesh, .. } if self.order != Order::AsIs => {
                Err("one draw for each mesh has its objects by mesh, in no order of their own")
            }
            Raster::Billboards { depth, cover, .. }
                if self.culling == Culling::Occlusion
                    && (depth == Depth::Flat || cover == Cover::Triangle) =>
            {
                Err("the pyramid is of the spheres' own depths")
            }
            _ => Ok(()),
        }
    }
}

fn buffers(context: &Context) -> Result<Vec<Buffer>, String> {
    let request = context.request;
    let spheres = request.spheres;
    let (width, height) = (request.width_px, request.height_px);
    let view = View::new(request.shading, request.camera, width, height, context.objects());
    let mut buffers = vec![
        Buffer::data("view", bytemuck::bytes_of(&view).into()),
        Buffer::data("atoms", spheres.atoms.clone()),
        Buffer::data("atom_rgba", spheres.atom_rgba.clone()),
        Buffer::data("levels", spheres.levels.clone()),
        Buffer::data("kinds", spheres.kinds.clone()),
        Buffer::data("places", spheres.places.clone()),
        Buffer::data("object_rgba", spheres.object_rgba.clone()),
        Buffer::new("placed", 32 * u64::from(context.objects())),
    ];
    buffers.extend(context.ids.buffer(&spheres.spheres));
    match context.variation.raster {
        Raster::Compute => {
            buffers.extend(drawing::workgroup_batches(context)?);
            buffers.push(Buffer::new("nearest", 8 * u64::from(width) * u64::from(height)));
        }
        Raster::Billboards { drawing, .. } => {
            buffers.extend(drawing::buffers(context, drawing)?);
        }
    }
    if context.variation.order == Order::Sorted {
        buffers.push(order::sort_buffer(context));
    }
    if let Some(order) = context.variation.order.known(&spheres.spheres, request.camera) {
        let bytes: Arc<[u8]> = bytemuck::cast_slice(&order).into();
        buffers.push(Buffer::data("order", bytes));
    }
    if context.variation.culling == Culling::Occlusion {
        buffers.extend(occlusion::buffers(context));
    }
    Ok(buffers)
}

/// The draw of billboards.
fn draw(context: &Context, phase: Phase) -> Pass {
    let Raster::Billboards { drawing, billboard, projection, depth, cover } =
        context.variation.raster
    else {
        unreachable!("only billboards are drawn so");
    };
    let keep = phase == Phase::Second;
    let output = context.variation.output;
    let writes_depth = depth != Depth::Flat;
    let constants = [
        context.perspective_wgsl(),
        context.ids_wgsl(),
        crate::text::flag("PROJECT_FRAGMENT", projection == Projection::PerFragment),
        crate::text::flag("PROJECT_CENTER", projection == Projection::PerCenter),
    ];
    let vertex = match billboard {
        Billboard::Pulled => [
            include_str!("wgsl/billboard.wgsl"),
            include_str!("wgsl/pulled.wgsl"),
            drawing::vs_wgsl(drawing),
        ]
        .concat(),
        Billboard::Geometry | Billboard::MeshShader => String::new(),
    };
    let fragment = output.fragment_wgsl(writes_depth);
    let fs = fs_wgsl(depth, cover);
    let texts = [
        include_str!("wgsl/view.wgsl"),
        include_str!("wgsl/spheres.wgsl"),
        include_str!("wgsl/meet.wgsl"),
        include_str!("wgsl/corner.wgsl"),
        &fragment,
        include_str!("wgsl/fs_sphere.wgsl"),
        &vertex,
        &fs,
    ];
    let shader = shader("draw: spheres", &constants, &texts);
    let mut raster = Drawn::new(shader, drawing::draw(context, drawing, billboard));
    raster.pre_raster = billboard::stages(context, drawing, billboard, projection);
    raster.color = output.attachments(keep);
    raster.depth_stencil = Some(DepthStencil {
        target: "depth".to_owned(),
        depth: Some(DepthTest {
            load: if keep { Load::Keep } else { Load::Clear(0.0) },
            compare: Compare::Greater,
            write: true,
        }),
        stencil: None,
    });
    Pass::raster(DRAW, raster)
}

/// WGSL: the fragment stage.
fn fs_wgsl(depth: Depth, cover: Cover) -> String {
    let early = match depth {
        // Depth is reversed: no greater is no nearer.
        Depth::Conservative => "@early_depth_test(less_equal)\n",
        Depth::Flat | Depth::Sphere => "",
    };
    let discard = match cover {
        Cover::Discard => "    if !hit.covered {\n        discard;\n    }\n",
        Cover::Triangle | Cover::Infinite => "",
    };
    let own = match depth {
        Depth::Flat => "",
        Depth::Sphere => "    out.depth = clamp(depth_of(hit, in), 0.0, 1.0);\n",
        Depth::Conservative => "    out.depth = clamp(depth_of(hit, in), 0.0, in.position.z);\n",
    };
    let infinite = match cover {
        Cover::Infinite => "    if !hit.covered {\n        out.depth = 0.0;\n    }\n",
        Cover::Discard | Cover::Triangle => "",
    };
    format!(
        "@fragment\n{early}fn fs(in: Corner) -> Fragment {{\n    let hit = meet(in.sphere, in.position.xy);\n\
         {discard}    var out = fragment_of(in.ids, hit);\n{own}{infinite}    return out;\n}}\n"
    )
}

/// The compute rasteriser over its batches.
fn rasterise(context: &Context) -> Pass {
    let constants = [
        crate::text::word("ROW", crate::text::ROW),
        context.perspective_wgsl(),
        context.ids_wgsl(),
    ];
    let texts = [
        include_str!("wgsl/view.wgsl"),
        include_str!("wgsl/spheres.wgsl"),
        include_str!("wgsl/meet.wgsl"),
        include_str!("wgsl/extent.wgsl"),
        include_str!("wgsl/rasterise.wgsl"),
    ];
    let dispatch = Dispatch::Indirect { buffer: "batch_groups".to_owned(), offset_bytes: 0 };
    Pass::compute(DRAW, shader("draw: rasterise", &constants, &texts), dispatch)
}

/// A draw of the whole image.
const WHOLE: Draw = Draw::Vertices { count: 3, instances: 1 };

/// What the compute rasteriser kept, as fragments.
fn write_out(context: &Context) -> Pass {
    let output = context.variation.output;
    let constants = [context.perspective_wgsl(), context.ids_wgsl()];
    let fragment = output.fragment_wgsl(false);
    let texts = [
        include_str!("wgsl/view.wgsl"),
        include_str!("wgsl/spheres.wgsl"),
        include_str!("wgsl/meet.wgsl"),
        &fragment,
        include_str!("wgsl/ids_at_nearest.wgsl"),
        include_str!("wgsl/write_out.wgsl"),
    ];
    let mut raster = Drawn::new(shader("draw: write out", &constants, &texts), WHOLE);
    raster.color = output.attachments(false);
    Pass::raster(DRAW, raster)
}

fn shade(context: &Context) -> Pass {
    let constants = [context.perspective_wgsl(), context.ids_wgsl()];
    let output = context.variation.output;
    let seen = output.seen_wgsl();
    let shader = |entry| {
        let texts = [
            include_str!("wgsl/view.wgsl"),
            include_str!("wgsl/spheres.wgsl"),
            include_str!("wgsl/meet.wgsl"),
            &seen,
            include_str!("wgsl/shade.wgsl"),
            entry,
        ];
        shader("shade: picture", &constants, &texts)
    };
    if output == Output::Direct {
        let (width, height) = (context.request.width_px, context.request.height_px);
        let groups = Dispatch::Workgroups([width.div_ceil(8), height.div_ceil(8), 1]);
        return Pass::compute(SHADE, shader(include_str!("wgsl/shade_compute.wgsl")), groups);
    }
    let mut raster = Drawn::new(shader(include_str!("wgsl/shade_raster.wgsl")), WHOLE);
    raster.color = vec![ColorAttachment {
        target: PICTURE.to_owned(),
        load: Load::Clear([0.0; 4]),
        blend: None,
        write: true,
    }];
    Pass::raster(SHADE, raster)
}
