//! Where a sphere's triangle is made: stages in GLSL, where WGSL has none.

use oit_gpu::{Glsl, Mesh, PreRaster, Tessellation, Topology};

use crate::context::Context;
use crate::drawing::MESH_BATCH;
use crate::ids::Ids;
use crate::view::is_perspective;
use crate::{Billboard, Drawing, Projection};

const VERSION: &str = "#version 460\n";
const SPHERES: &str = include_str!("glsl/spheres.glsl");

/// What makes the triangles.
pub(crate) fn stages(
    context: &Context,
    drawing: Drawing,
    billboard: Billboard,
    projection: Projection,
) -> PreRaster {
    let ids = match context.ids {
        Ids::Split { atom_bits } => format!("const uint ATOM_BITS = {atom_bits}u;\n"),
        Ids::Numbered => "#define NUMBERED_IDS\n".to_owned(),
    };
    let constants = format!(
        "const bool PERSPECTIVE = {};\nconst bool PROJECT_CENTER = {};\nconst bool PACKED_IDS = {};\n\
         {ids}",
        is_perspective(context.request.camera),
        projection == Projection::PerCenter,
        context.variation.output.packs_ids(),
    );
    let stage = |texts: &[&str]| [&[VERSION, &constants], texts].concat().concat().into();
    match billboard {
        Billboard::Pulled => PreRaster::Wgsl,
        Billboard::MeshShader => PreRaster::Mesh(Box::new(Mesh {
            task: None,
            mesh: [
                VERSION,
                "#extension GL_EXT_mesh_shader : require\n",
                &constants,
                &format!("const uint BATCH = {MESH_BATCH}u;\n"),
                SPHERES,
                include_str!("glsl/batch.mesh"),
            ]
            .concat()
            .into(),
        })),
        Billboard::Geometry => {
            let geometry: std::sync::Arc<str> =
                stage(&[SPHERES, include_str!("glsl/triangle.geom")]);
            let points = |vertex: &str| Glsl {
                topology: Topology::Points,
                vertex: stage(&[vertex]),
                tessellation: None,
                geometry: Some(geometry.clone()),
            };
            PreRaster::Glsl(Box::new(match drawing {
                Drawing::PerObject => points(include_str!("glsl/per_object.vert")),
                Drawing::PerMesh => points(include_str!("glsl/per_mesh.vert")),
                Drawing::IndexList => points(include_str!("glsl/index_list.vert")),
                Drawing::Batches => Glsl {
                    topology: Topology::Patches(1),
                    vertex: stage(&[include_str!("glsl/batch.vert")]),
                    tessellation: Some(Tessellation {
                        control: stage(&[include_str!("glsl/batch.tesc")]),
                        evaluation: stage(&[include_str!("glsl/batch.tese")]),
                    }),
                    geometry: Some(geometry.clone()),
                },
            }))
        }
    }
}
