//! Whether a variation's picture is what the oracle expects.

use crate::{Cover, Depth, Output, Raster, Variation};

impl Variation {
    /// Whether its picture is exact: the nearest sphere of every pixel, of the level of detail that
    /// the variation draws, with the colour of its normal to a 255th.
    ///
    /// # Errors
    /// Why it is not.
    pub fn accuracy(&self) -> Result<(), &'static str> {
        if let Raster::Billboards { depth, cover, .. } = self.raster {
            if cover == Cover::Triangle {
                return Err("nothing is discarded, and the triangles about spheres are seen");
            }
            if depth == Depth::Flat {
                return Err(
                    "a sphere has one depth, so that spheres do not cut through each other",
                );
            }
        }
        match self.output {
            Output::Bytes64
            | Output::Bytes36
            | Output::Bytes24
            | Output::Bytes4
            | Output::Direct => Ok(()),
            Output::Bytes12 => Err("normals are two bytes, and positions three 16-bit floats"),
            Output::Bytes8 => Err("normals are differences of neighbouring depths"),
        }
    }
}
