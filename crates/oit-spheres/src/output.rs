//! What is written for each fragment, and how a picture is made of it (section 3.3, Table 3.4).

use oit_gpu::{ColorAttachment, Format, Load, Target};

use crate::{Output, Raster};

/// One target of an output's fragments.
struct Part {
    /// What the fragment calls it; the target's name is this and `_out`.
    name: &'static str,
    format: Format,
    /// Its type in the shader.
    wgsl: &'static str,
    /// What stands for nothing.
    clear: f32,
}

const fn part(name: &'static str, format: Format, wgsl: &'static str, clear: f32) -> Part {
    Part { name, format, wgsl, clear }
}

/// Atom and instance in one word; all ones stand for nothing.
const IDS: Part = part("ids", Format::R32Uint, "u32", f32::INFINITY);
const POSITION: Part = part("position", Format::Rgba32Float, "vec4<f32>", 0.0);
const NORMAL: Part = part("normal", Format::Rgba32Float, "vec4<f32>", 0.0);

impl Output {
    fn parts(self) -> &'static [Part] {
        match self {
            Self::Bytes64 => {
                const PARTS: &[Part] = &[
                    part("atom", Format::Rgba32Float, "vec4<f32>", -1.0),
                    part("instance", Format::Rgba32Float, "vec4<f32>", 0.0),
                    POSITION,
                    NORMAL,
                ];
                PARTS
            }
            Self::Bytes36 => {
                const PARTS: &[Part] = &[IDS, POSITION, NORMAL];
                PARTS
            }
            Self::Bytes24 => {
                const PARTS: &[Part] =
                    &[IDS, POSITION, part("normal", Format::R32Float, "f32", 0.0)];
                PARTS
            }
            Self::Bytes12 => {
                const PARTS: &[Part] = &[
                    IDS,
                    part("xy", Format::R32Uint, "u32", 0.0),
                    part("z_normal", Format::R32Uint, "u32", 0.0),
                ];
                PARTS
            }
            Self::Bytes8 => {
                const PARTS: &[Part] = &[IDS, part("behind", Format::R32Float, "f32", 0.0)];
                PARTS
            }
            Self::Bytes4 => {
                const PARTS: &[Part] = &[IDS];
                PARTS
            }
            Self::Direct => &[],
        }
    }

    /// Whether atom and instance are one word.
    pub(crate) fn packs_ids(self) -> bool {
        self != Self::Bytes64
    }

    pub(crate) fn targets(self, width: u32, height: u32) -> Vec<Target> {
        let target = |part: &Part| Target {
            name: format!("{}_out", part.name),
            format: part.format,
            width,
            height,
        };
        self.parts().iter().map(target).collect()
    }

    /// The attachments, in the order of the fragment's locations.
    pub(crate) fn attachments(self, keep: bool) -> Vec<ColorAttachment> {
        let attachment = |part: &Part| ColorAttachment {
            target: format!("{}_out", part.name),
            load: if keep { Load::Keep } else { Load::Clear([part.clear; 4]) },
            blend: None,
            write: true,
        };
        self.parts().iter().map(attachment).collect()
    }

    /// WGSL: the structure `Fragment` and `fragment_of`, which fills it.
    pub(crate) fn fragment_wgsl(self, writes_depth: bool) -> String {
        let mut text = String::from("struct Fragment {\n");
        for (location, part) in self.parts().iter().enumerate() {
            text += &format!("    @location({location}) {}: {},\n", part.name, part.wgsl);
        }
        if writes_depth {
            text += "    @builtin(frag_depth) depth: f32,\n";
        }
        text += "}\n";
        let (ids, pack) = match self {
            Self::Bytes64 => {
                (include_str!("wgsl/ids_both.wgsl"), include_str!("wgsl/bytes64.wgsl"))
            }
            Self::Bytes36 => {
                (include_str!("wgsl/ids_packed.wgsl"), include_str!("wgsl/bytes36.wgsl"))
            }
            Self::Bytes24 => {
                (include_str!("wgsl/ids_packed.wgsl"), include_str!("wgsl/bytes24.wgsl"))
            }
            Self::Bytes12 => {
                (include_str!("wgsl/ids_packed.wgsl"), include_str!("wgsl/bytes12.wgsl"))
            }
            Self::Bytes8 => {
                (include_str!("wgsl/ids_packed.wgsl"), include_str!("wgsl/bytes8.wgsl"))
            }
            Self::Bytes4 => {
                (include_str!("wgsl/ids_packed.wgsl"), include_str!("wgsl/bytes4.wgsl"))
            }
            Self::Direct => unreachable!("no fragment is written"),
        };
        [&text, include_str!("wgsl/hemisphere.wgsl"), ids, pack].concat()
    }

    /// WGSL: `ids_at`, which reads a pixel's object and atom from where they were left.
    pub(crate) fn ids_wgsl(self) -> &'static str {
        match self {
            Self::Bytes64 => include_str!("wgsl/ids_at_float.wgsl"),
            Self::Direct => include_str!("wgsl/ids_at_nearest.wgsl"),
            _ => include_str!("wgsl/ids_at_word.wgsl"),
        }
    }

    /// WGSL: `seen_at`, which reads all of a pixel from where it was left.
    pub(crate) fn seen_wgsl(self) -> String {
        let seen = match self {
            Self::Bytes64 => include_str!("wgsl/bytes64_seen.wgsl"),
            Self::Bytes36 => include_str!("wgsl/bytes36_seen.wgsl"),
            Self::Bytes24 => include_str!("wgsl/bytes24_seen.wgsl"),
            Self::Bytes12 => include_str!("wgsl/bytes12_seen.wgsl"),
            Self::Bytes8 => include_str!("wgsl/bytes8_seen.wgsl"),
            Self::Bytes4 | Self::Direct => include_str!("wgsl/bytes4_seen.wgsl"),
        };
        let hemisphere = include_str!("wgsl/hemisphere.wgsl");
        [include_str!("wgsl/seen.wgsl"), hemisphere, self.ids_wgsl(), seen].concat()
    }
}

/// WGSL: `ids_at` as what rasterises leaves it before it is written out.
pub(crate) fn early_ids_wgsl(raster: Raster, output: Output) -> &'static str {
    match raster {
        Raster::Billboards { .. } => output.ids_wgsl(),
        Raster::Compute => include_str!("wgsl/ids_at_nearest.wgsl"),
    }
}
