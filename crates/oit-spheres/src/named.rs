//! The variations that the thesis times, and those past it that are worth a name.

use crate::{
    Billboard, Cover, Culling, Depth, Detail, Drawing, Order, Output, Projection, Raster, Variation,
};

/// Every row of the thesis's tables, then what goes past it. Rows that several tables share stand
/// once.
pub const VARIATIONS: &[&str] = &[
    // The baseline: Tables 3.2 to 3.5 and 4.1.
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64",
    // Table 3.1, on the scene of a stack.
    "spheres/batches/geometry/per-fragment/flat-depth/discard/bytes64/back-to-front",
    "spheres/batches/geometry/per-fragment/flat-depth/discard/bytes64/front-to-back",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64/back-to-front",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64/front-to-back",
    "spheres/batches/geometry/per-fragment/conservative-depth/discard/bytes64/back-to-front",
    "spheres/batches/geometry/per-fragment/conservative-depth/discard/bytes64/front-to-back",
    // Table 3.2, and the infinite depth of section 3.1.2.
    "spheres/batches/geometry/per-fragment/flat-depth/discard/bytes64",
    "spheres/batches/geometry/per-fragment/conservative-depth/discard/bytes64",
    "spheres/batches/geometry/per-fragment/flat-depth/no-discard/bytes64",
    "spheres/batches/geometry/per-fragment/sphere-depth/no-discard/bytes64",
    "spheres/batches/geometry/per-fragment/sphere-depth/infinite-depth/bytes64",
    // Table 3.3.
    "spheres/batches/geometry/per-vertex/sphere-depth/discard/bytes64",
    "spheres/batches/geometry/per-center/sphere-depth/discard/bytes64",
    // Table 3.4, and normals from depth (section 3.3.2).
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes36",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes24",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes12",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes8",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes4",
    // Table 3.5.
    "spheres/per-object/geometry/per-fragment/sphere-depth/discard/bytes64",
    "spheres/per-mesh/geometry/per-fragment/sphere-depth/discard/bytes64",
    // Table 4.1.
    "spheres/per-mesh/geometry/per-fragment/sphere-depth/discard/bytes4",
    "spheres/per-mesh/geometry/per-center/sphere-depth/discard/bytes64",
    "spheres/batches/geometry/per-center/sphere-depth/discard/bytes4",
    "spheres/per-object/geometry/per-center/sphere-depth/discard/bytes4",
    "spheres/per-mesh/geometry/per-center/sphere-depth/discard/bytes4",
    // Past the thesis: triangles without a geometry shader, and other lists.
    "spheres/index-list/geometry/per-center/sphere-depth/discard/bytes4",
    "spheres/per-object/pulled/per-center/sphere-depth/discard/bytes4",
    "spheres/per-mesh/pulled/per-center/sphere-depth/discard/bytes4",
    "spheres/index-list/pulled/per-center/sphere-depth/discard/bytes4",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4",
    "spheres/per-mesh/pulled/per-center/conservative-depth/discard/bytes4",
    "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4",
    "spheres/batches/mesh-shader/per-center/conservative-depth/discard/bytes4",
    "spheres/compute/bytes64",
    "spheres/compute/bytes4",
    "spheres/compute/direct",
    // Orders (chapter 5).
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/front-to-back",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/back-to-front",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/random",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/outside-in",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/sorted",
    "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4/sorted",
    // Without levels of detail.
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64/full-detail",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/full-detail",
    "spheres/compute/direct/full-detail",
    // Culling (chapter 5).
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64/frustum",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/frustum",
    "spheres/per-mesh/pulled/per-center/conservative-depth/discard/bytes4/frustum",
    "spheres/compute/direct/frustum",
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64/occlusion",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/occlusion",
    "spheres/per-mesh/pulled/per-center/conservative-depth/discard/bytes4/occlusion",
    "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4/occlusion",
    "spheres/batches/mesh-shader/per-center/conservative-depth/discard/bytes4/occlusion",
    "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4/sorted/occlusion",
    "spheres/compute/direct/occlusion",
];

/// Every variation that makes sense: the thesis's "every combination" (chapter 4), and more.
pub fn cross_product() -> impl Iterator<Item = Variation> {
    let mut rasters = vec![Raster::Compute];
    for &drawing in Drawing::ALL {
        for &billboard in Billboard::ALL {
            for &projection in Projection::ALL {
                for &depth in Depth::ALL {
                    for &cover in Cover::ALL {
                        rasters.push(Raster::Billboards {
                            drawing,
                            billboard,
                            projection,
                            depth,
                            cover,
                        });
                    }
                }
            }
        }
    }
    let mut all = Vec::new();
    for raster in rasters {
        for &output in Output::ALL {
            for &order in Order::ALL {
                for &detail in Detail::ALL {
                    for &culling in Culling::ALL {
                        all.push(Variation { raster, output, order, detail, culling });
                    }
                }
            }
        }
    }
    all.into_iter().filter(|variation| variation.fault().is_none() && variation.refuse().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn named_variations_are_variations_and_stand_once() {
        let all: HashSet<Variation> = cross_product().collect();
        let mut seen = HashSet::new();
        for name in VARIATIONS {
            let variation: Variation = name.parse().unwrap_or_else(|error| panic!("{error}"));
            assert!(all.contains(&variation), "{name}");
            assert!(seen.insert(variation), "{name} stands twice");
        }
    }

    #[test]
    fn every_variation_is_read_as_it_is_written() {
        for variation in cross_product() {
            assert_eq!(variation.to_string().parse(), Ok(variation));
        }
    }
}
