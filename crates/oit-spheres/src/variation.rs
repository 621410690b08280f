//! A way of drawing spheres: a point on every axis, and its name.

use std::fmt;
use std::str::FromStr;

use oit_scene::Problem;

/// What stands before every variation's name.
pub const PREFIX: &str = "spheres/";

/// A way of drawing spheres. Its name is `spheres/`, then [`Drawing`], [`Billboard`],
/// [`Projection`], [`Depth`], [`Cover`] and [`Output`], then what is not the default of [`Order`],
/// [`Detail`] and [`Culling`]: `spheres/per-object/pulled/per-center/sphere-depth/discard/bytes4`.
/// The compute rasteriser has no billboard: `spheres/compute/bytes4`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Variation {
    /// Who rasterises.
    pub raster: Raster,
    /// What is written for each fragment.
    pub output: Output,
    /// In which order objects are submitted.
    pub order: Order,
    /// Which level of detail is drawn.
    pub detail: Detail,
    /// What is left out before drawing.
    pub culling: Culling,
}

/// Who rasterises.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Raster {
    /// The GPU's raster units: billboards.
    Billboards {
        /// How draws are submitted.
        drawing: Drawing,
        /// Where a sphere's triangles are made.
        billboard: Billboard,
        /// Where positions are projected.
        projection: Projection,
        /// A fragment's depth.
        depth: Depth,
        /// What becomes of fragments outside the sphere.
        cover: Cover,
    },
    /// A compute shader, which keeps the nearest of a pixel by a 64-bit atomic minimum.
    Compute,
}

/// The word for [`Raster::Compute`].
const COMPUTE: &str = "compute";

/// An axis whose values are words.
macro_rules! axis {
    ($(#[$about:meta])* $name:ident, $what:literal, { $($(#[$each:meta])* $value:ident = $word:literal,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum $name {
            $($(#[$each])* $value,)*
        }

        impl $name {
            /// Every value, in the order they are listed.
            pub const ALL: &[Self] = &[$(Self::$value),*];

            /// The word for it in names.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $word,)*
                }
            }

            fn parse(word: &str) -> Result<Self, VariationError> {
                let known = Self::ALL.iter().find(|value| value.name() == word);
                known.copied().ok_or_else(|| {
                    Problem::unknown($what, word, Self::ALL.iter().map(|value| value.name())).into()
                })
            }
        }
    };
}

axis!(
    /// How draws are submitted.
    Drawing, "way of submitting draws", {
    /// Batches of an object's atoms: tessellated patches of up to 4,160 (the thesis's baseline, section
    /// 3.4.1), or a mesh shader's workgroups of 64.
    Batches = "batches",
    /// One indirect draw for each object (section 3.4.2).
    PerObject = "per-object",
    /// One indirect draw for each level of each kind, its objects as instances (section 3.4.3).
    PerMesh = "per-mesh",
    /// One draw over a list of atoms that a compute shader writes.
    IndexList = "index-list",
});

axis!(
    /// Where a sphere's triangles are made.
    Billboard, "billboard", {
    /// A geometry shader, one triangle for each sphere (the thesis's).
    Geometry = "geometry",
    /// The vertex shader, from the vertex's number.
    Pulled = "pulled",
    /// A mesh shader.
    MeshShader = "mesh-shader",
});

axis!(
    /// Where positions are projected into clip space (section 3.2, Table 3.3).
    Projection, "projection", {
    /// For each fragment.
    PerFragment = "per-fragment",
    /// For each corner of a billboard.
    PerVertex = "per-vertex",
    /// For each sphere's centre; its corners are offset from there.
    PerCenter = "per-center",
});

axis!(
    /// A fragment's depth (section 3.1.2, Tables 3.1 and 3.2).
    Depth, "depth", {
    /// The impostor's own.
    Flat = "flat-depth",
    /// The sphere's at that fragment.
    Sphere = "sphere-depth",
    /// The same, where the shader says that it lies behind the impostor's.
    Conservative = "conservative-depth",
});

axis!(
    /// What becomes of fragments outside the sphere (section 3.1.2, Table 3.2).
    Cover, "cover", {
    /// They are discarded.
    Discard = "discard",
    /// They stay: triangles are seen.
    Triangle = "no-discard",
    /// Their depth is set to the far plane.
    Infinite = "infinite-depth",
});

axis!(
    /// What is written for each fragment (section 3.3, Table 3.4). Where atom and instance share 32 bits,
    /// each has 16 if that is enough, else one takes bits from the other, and else all spheres are
    /// numbered through: ids are never wrong, as the thesis's are beyond 65,536.
    Output, "output", {
    /// Atom, instance, position and normal, each four 32-bit floats.
    Bytes64 = "bytes64",
    /// Atom and instance in 16 bits each; position and normal as before.
    Bytes36 = "bytes36",
    /// Atom and instance in 16 bits each, three floats of position, two of normal.
    Bytes24 = "bytes24",
    /// Atom and instance in 16 bits each, three 16-bit floats of position, two bytes of normal.
    Bytes12 = "bytes12",
    /// Atom and instance in 16 bits each, and depth once more, since a plan does not read its depth
    /// target; position rebuilt from depth, and normal from its differences (section 3.3.2).
    Bytes8 = "bytes8",
    /// Atom and instance in 16 bits each; they name the sphere, which is met once more.
    Bytes4 = "bytes4",
    /// Nothing: the picture is made in compute of what the compute rasteriser kept.
    Direct = "direct",
});

axis!(
    /// In which order objects are submitted (section 3.1.1 and chapter 5).
    Order, "order", {
    /// As the scene has them.
    AsIs = "as-is",
    /// The nearest to the camera first.
    FrontToBack = "front-to-back",
    /// The farthest first.
    BackToFront = "back-to-front",
    /// At random, from a fixed seed.
    Random = "random",
    /// The farthest from the middle of the scene first: for any camera outside (section 5.3).
    OutsideIn = "outside-in",
    /// Nearest first, sorted on the GPU in every frame.
    Sorted = "sorted",
});

axis!(
    /// Which level of detail is drawn.
    Detail, "level of detail", {
    /// The one that fits the object's distance.
    ByDistance = "by-distance",
    /// The finest.
    Full = "full-detail",
});

axis!(
    /// What is left out before drawing (chapter 5).
    Culling, "culling", {
    /// Nothing.
    None = "no-culling",
    /// Objects outside the view's frustum.
    Frustum = "frustum",
    /// These, and objects behind a pyramid of depths: what was seen is drawn first, then what the
    /// pyramid does not hide.
    Occlusion = "occlusion",
});

/// What is wrong with a variation's name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum VariationError {
    /// A word that is none of an axis.
    #[error("{0}")]
    Unknown(Problem),
    /// Too few words, or too many.
    #[error(
        "`{0}` is not `spheres/DRAWING/BILLBOARD/PROJECTION/DEPTH/COVER/OUTPUT` or `spheres/compute/OUTPUT`, then order, detail, culling where they are not the default"
    )]
    Shape(String),
    /// Words that do not go together.
    #[error("`{name}`: {why}")]
    Together {
        /// The name.
        name: String,
        /// Why.
        why: &'static str,
    },
}

impl From<Problem> for VariationError {
    fn from(problem: Problem) -> Self {
        Self::Unknown(problem)
    }
}

impl Variation {
    /// Why it makes no sense, if it does not.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        match self.raster {
            Raster::Billboards {
                drawing: Drawing::Batches, billboard: Billboard::Pulled, ..
            } => {
                Some("a batch is tessellated and needs the geometry shader, or is a mesh shader's")
            }
            Raster::Billboards { drawing, billboard: Billboard::MeshShader, .. }
                if drawing != Drawing::Batches =>
            {
                Some("a mesh shader draws batches")
            }
            Raster::Billboards { depth: Depth::Flat, cover: Cover::Infinite, .. } => {
                Some("an infinite depth is a depth that the shader writes")
            }
            Raster::Billboards { .. } if self.output == Output::Direct => {
                Some("a billboard's fragments are written somewhere")
            }
            _ => None,
        }
    }
}

impl fmt::Display for Variation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(PREFIX)?;
        match self.raster {
            Raster::Compute => f.write_str(COMPUTE)?,
            Raster::Billboards { drawing, billboard, projection, depth, cover } => write!(
                f,
                "{}/{}/{}/{}/{}",
                drawing.name(),
                billboard.name(),
                projection.name(),
                depth.name(),
                cover.name()
            )?,
        }
        write!(f, "/{}", self.output.name())?;
        if self.order != Order::AsIs {
            write!(f, "/{}", self.order.name())?;
        }
        if self.detail != Detail::ByDistance {
            write!(f, "/{}", self.detail.name())?;
        }
        if self.culling != Culling::None {
            write!(f, "/{}", self.culling.name())?;
        }
        Ok(())
    }
}

impl FromStr for Variation {
    type Err = VariationError;

    fn from_str(name: &str) -> Result<Self, VariationError> {
        let shape = || VariationError::Shape(name.to_owned());
        let mut words = name.strip_prefix(PREFIX).ok_or_else(shape)?.split('/');
        let mut next = || words.next().ok_or_else(shape);
        let first = next()?;
        let raster = if first == COMPUTE {
            Raster::Compute
        } else {
            Raster::Billboards {
                drawing: Drawing::parse(first)?,
                billboard: Billboard::parse(next()?)?,
                projection: Projection::parse(next()?)?,
                depth: Depth::parse(next()?)?,
                cover: Cover::parse(next()?)?,
            }
        };
        let mut variation = Self {
            raster,
            output: Output::parse(next()?)?,
            order: Order::AsIs,
            detail: Detail::ByDistance,
            culling: Culling::None,
        };
        for word in words {
            if let Ok(order) = Order::parse(word) {
                variation.order = order;
            } else if let Ok(detail) = Detail::parse(word) {
                variation.detail = detail;
            } else {
                variation.culling = Culling::parse(word)?;
            }
        }
        if let Some(why) = variation.fault() {
            return Err(VariationError::Together { name: name.to_owned(), why });
        }
        // One name a variation: no default spelt out, nothing twice, nothing out of order.
        if variation.to_string() == name { Ok(variation) } else { Err(shape()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for name in [
            "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64",
            "spheres/per-object/pulled/per-center/conservative-depth/no-discard/bytes4/sorted/full-detail/occlusion",
            "spheres/compute/bytes12/random/frustum",
        ] {
            assert_eq!(name.parse::<Variation>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn mistakes_are_named() {
        let error = |name: &str| name.parse::<Variation>().unwrap_err().to_string();
        let error_of = error("spheres/per-objcet/pulled/per-center/flat-depth/discard/bytes4");
        assert!(
            error_of.contains("`per-objcet`") && error_of.contains("`per-object`"),
            "{error_of}"
        );
        assert!(error("spheres/compute").contains("is not"));
        assert!(error("spheres/compute/bytes4/as-is").contains("is not"));
        let together = error("spheres/batches/pulled/per-center/flat-depth/discard/bytes4");
        assert!(together.contains("geometry shader"), "{together}");
    }
}
