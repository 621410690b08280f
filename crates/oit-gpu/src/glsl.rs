//! Stages in GLSL, for what WGSL cannot say: geometry, tessellation and mesh shaders.

use crate::plan::{Glsl, Mesh, PreRaster};
use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderMessage, ShaderSource, SourceLanguage,
    SpirvVersion, Target, VulkanVersion,
};
use std::sync::Arc;

/// A stage that comes before rasterisation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Stage {
    Vertex,
    TessellationControl,
    TessellationEvaluation,
    Geometry,
    Task,
    Mesh,
}

impl Stage {
    /// Its name in messages and listings.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::TessellationControl => "tessellation control",
            Self::TessellationEvaluation => "tessellation evaluation",
            Self::Geometry => "geometry",
            Self::Task => "task",
            Self::Mesh => "mesh",
        }
    }

    fn glslang(self) -> glslang::ShaderStage {
        match self {
            Self::Vertex => glslang::ShaderStage::Vertex,
            Self::TessellationControl => glslang::ShaderStage::TesselationControl,
            Self::TessellationEvaluation => glslang::ShaderStage::TesselationEvaluation,
            Self::Geometry => glslang::ShaderStage::Geometry,
            Self::Task => glslang::ShaderStage::Task,
            Self::Mesh => glslang::ShaderStage::Mesh,
        }
    }
}

/// The stages in GLSL, in the order in which they run; none where the vertex stage is in WGSL.
pub(crate) fn stages(pre_raster: &PreRaster) -> Vec<(Stage, &Arc<str>)> {
    let mut stages = Vec::new();
    match pre_raster {
        PreRaster::Wgsl => {}
        PreRaster::Glsl(glsl) => {
            let Glsl { vertex, tessellation, geometry, .. } = &**glsl;
            stages.push((Stage::Vertex, vertex));
            if let Some(both) = tessellation {
                stages.push((Stage::TessellationControl, &both.control));
                stages.push((Stage::TessellationEvaluation, &both.evaluation));
            }
            stages.extend(geometry.iter().map(|source| (Stage::Geometry, source)));
        }
        PreRaster::Mesh(both) => {
            let Mesh { task, mesh } = &**both;
            stages.extend(task.iter().map(|source| (Stage::Task, source)));
            stages.push((Stage::Mesh, mesh));
        }
    }
    stages
}

/// The SPIR-V of a stage, with the entry point `main`.
///
/// # Errors
/// The compiler's message, with the lines concerned.
pub(crate) fn spirv(stage: Stage, source: &str) -> Result<Vec<u32>, String> {
    if source.contains('\0') {
        return Err("a source holds the character 0".to_owned());
    }
    let compiler = Compiler::acquire().ok_or("the compiler of GLSL does not start")?;
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan {
            version: VulkanVersion::Vulkan1_3,
            spirv_version: SpirvVersion::SPIRV1_6,
        },
        version_profile: None,
        messages: ShaderMessage::DEFAULT,
    };
    let none = None::<&[(&str, Option<&str>)]>;
    let text = ShaderSource::from(source);
    ShaderInput::new(&text, stage.glslang(), &options, none, None)
        .and_then(|input| compiler.create_shader(input))
        .and_then(|shader| shader.compile())
        .map_err(|error| with_lines(&error.to_string(), source))
}

/// A message of glslang's, each line that names a line of the source (`ERROR: 0:12: ...`) followed
/// by it.
fn with_lines(message: &str, source: &str) -> String {
    let mut text = String::new();
    let message = message.split("DebugLog:").next().unwrap_or_default();
    for line in message.lines().filter(|line| !line.trim().is_empty()) {
        text.push_str(line);
        text.push('\n');
        let number = line.strip_prefix("ERROR: 0:").and_then(|rest| rest.split(':').next());
        let number = number.and_then(|number| number.parse::<usize>().ok());
        let shown = number.and_then(|number| source.lines().nth(number.checked_sub(1)?));
        if let Some(shown) = shown {
            text.push_str(&format!("    {}\n", shown.trim_end()));
        }
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_show_the_line() {
        let source = "#version 450\nvoid main() {\n    gl_Position = nothing;\n}\n";
        let message = spirv(Stage::Vertex, source).expect_err("undeclared");
        assert!(message.contains("0:3:") && message.contains("nothing;"), "{message}");
        let message = spirv(Stage::Vertex, "#version 450\n").expect_err("no main");
        assert!(message.contains("Missing entry point"), "{message}");
        assert!(spirv(Stage::Vertex, "\0").is_err());
    }
}
