//! How draws are submitted: what a device lists of a scene, and the draw over the list.

mod batches;
mod index_list;
mod per_mesh;
mod per_object;

use oit_gpu::{Buffer, Draw, Pass};

use crate::context::{Context, Phase};
use crate::text::rows;
use crate::{Billboard, Drawing};

pub(crate) use batches::MESH_BATCH;

/// The buffers of a list.
pub(crate) fn buffers(context: &Context, drawing: Drawing) -> Result<Vec<Buffer>, String> {
    match drawing {
        Drawing::Batches => batches::buffers(context),
        Drawing::PerObject => Ok(per_object::buffers(context)),
        Drawing::PerMesh => Ok(per_mesh::buffers(context)),
        Drawing::IndexList => index_list::buffers(context),
    }
}

/// The passes that make it.
pub(crate) fn passes(context: &mut Context, drawing: Drawing, phase: Phase) -> Vec<Pass> {
    match drawing {
        Drawing::Batches => batches::passes(context, phase),
        Drawing::PerObject => per_object::passes(context, phase),
        Drawing::PerMesh => per_mesh::passes(context, phase),
        Drawing::IndexList => index_list::passes(context, phase),
    }
}

/// The draw over it.
pub(crate) fn draw(context: &Context, drawing: Drawing, billboard: Billboard) -> Draw {
    let indirect = |arguments: &str, draws: u32| Draw::VerticesIndirect {
        arguments: arguments.to_owned(),
        offset_bytes: 0,
        draws,
    };
    match (drawing, billboard) {
        (Drawing::Batches, Billboard::MeshShader) => Draw::MeshIndirect {
            arguments: "batch_groups".to_owned(),
            offset_bytes: 0,
            at_most: rows(context.request.spheres.places_of(MESH_BATCH)),
        },
        (Drawing::Batches, _) => indirect("batch_count", 1),
        (Drawing::PerObject, _) => indirect("commands", context.objects()),
        (Drawing::PerMesh, _) => indirect("commands", context.levels()),
        (Drawing::IndexList, _) => indirect("list_draw", 1),
    }
}

/// WGSL: the vertex stage over the list.
pub(crate) fn vs_wgsl(drawing: Drawing) -> &'static str {
    match drawing {
        // Batches are tessellated, or drawn by a mesh shader.
        Drawing::Batches => "",
        Drawing::PerObject => include_str!("../wgsl/vs_per_object.wgsl"),
        Drawing::PerMesh => include_str!("../wgsl/vs_per_mesh.wgsl"),
        Drawing::IndexList => include_str!("../wgsl/vs_index_list.wgsl"),
    }
}
