//! What the device counts of raster passes: pipeline statistics queries, in a run of their own.

use super::failure;
use super::prepared::Prepared;
use crate::glsl::{self, Stage};
use crate::{GpuError, PassStatistics, Work};
use ash::vk;

type Counted = vk::QueryPipelineStatisticFlags;

impl Prepared {
    /// Runs the plan once and counts. The device has the feature.
    pub(super) fn statistics(&self) -> Result<Vec<PassStatistics>, GpuError> {
        let passes = self.plan.passes.len() as u32;
        if passes == 0 {
            return Ok(Vec::new());
        }
        let device = &self.gpu.device;
        let features = &self.gpu.physical.features;
        let mut counted = Counted::INPUT_ASSEMBLY_VERTICES
            | Counted::INPUT_ASSEMBLY_PRIMITIVES
            | Counted::VERTEX_SHADER_INVOCATIONS
            | Counted::CLIPPING_INVOCATIONS
            | Counted::CLIPPING_PRIMITIVES
            | Counted::FRAGMENT_SHADER_INVOCATIONS;
        if features.geometry_shader != 0 {
            counted |= Counted::GEOMETRY_SHADER_INVOCATIONS | Counted::GEOMETRY_SHADER_PRIMITIVES;
        }
        if features.tessellation_shader != 0 {
            counted |= Counted::TESSELLATION_CONTROL_SHADER_PATCHES
                | Counted::TESSELLATION_EVALUATION_SHADER_INVOCATIONS;
        }
        let create = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::PIPELINE_STATISTICS)
            .query_count(passes)
            .pipeline_statistics(counted);
        // SAFETY: the device is alive and has the feature, and the stages of all that is counted.
        let pool = unsafe { device.create_query_pool(&create, None) }
            .map_err(|error| failure("creating statistics", error))?;
        let told = self
            .gpu
            .once(|commands| {
                // SAFETY: the pool has so many queries; no rendering has begun.
                unsafe { device.cmd_reset_query_pool(commands, pool, 0, passes) };
                self.record(commands, Some(pool));
            })
            .and_then(|()| self.told(pool, counted));
        // SAFETY: the commands have run, or the device is lost.
        unsafe { device.destroy_query_pool(pool, None) };
        told
    }

    /// What a pool holds, after a run.
    fn told(&self, pool: vk::QueryPool, counted: Counted) -> Result<Vec<PassStatistics>, GpuError> {
        let mut statistics = Vec::new();
        let bits: Vec<Counted> = (0..u32::BITS)
            .map(|bit| Counted::from_raw(1 << bit))
            .filter(|&bit| counted.contains(bit))
            .collect();
        for (pass, work) in (0..).zip(self.plan.passes.iter().map(|pass| &pass.work)) {
            let Work::Raster(raster) = work else { continue };
            let stages = glsl::stages(&raster.pre_raster);
            let has = |wanted| stages.iter().any(|&(stage, _)| stage == wanted);
            // One query is as many numbers as are counted, in the order of their bits.
            let mut bytes = [[0_u64; 16]];
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: the commands have written the query of every raster pass, and no more than 16
            // numbers are counted.
            unsafe { self.gpu.device.get_query_pool_results(pool, pass, &mut bytes, flags) }
                .map_err(|error| failure("reading statistics", error))?;
            let of = |bit: Counted| {
                let place = bits.iter().position(|&counted| counted == bit)?;
                bytes[0].get(place).copied()
            };
            let of_stage = |stage, bit| of(bit).filter(|_| has(stage));
            let always = |bit| of(bit).unwrap_or_default();
            statistics.push(PassStatistics {
                pass: pass as usize,
                input_vertices: of(Counted::INPUT_ASSEMBLY_VERTICES),
                input_primitives: of(Counted::INPUT_ASSEMBLY_PRIMITIVES),
                vertex_invocations: always(Counted::VERTEX_SHADER_INVOCATIONS),
                tessellation_patches: of_stage(
                    Stage::TessellationControl,
                    Counted::TESSELLATION_CONTROL_SHADER_PATCHES,
                ),
                tessellation_invocations: of_stage(
                    Stage::TessellationEvaluation,
                    Counted::TESSELLATION_EVALUATION_SHADER_INVOCATIONS,
                ),
                geometry_invocations: of_stage(
                    Stage::Geometry,
                    Counted::GEOMETRY_SHADER_INVOCATIONS,
                ),
                geometry_primitives: of_stage(Stage::Geometry, Counted::GEOMETRY_SHADER_PRIMITIVES),
                clipping_invocations: always(Counted::CLIPPING_INVOCATIONS),
                clipping_primitives: always(Counted::CLIPPING_PRIMITIVES),
                fragment_invocations: always(Counted::FRAGMENT_SHADER_INVOCATIONS),
            });
        }
        Ok(statistics)
    }
}
