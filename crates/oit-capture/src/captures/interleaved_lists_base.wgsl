@group(0) @binding(4) var<storage, read> bases: array<u32>;

// The slot of a pixel's first fragment; anything for a pixel without fragments.
fn lfb_base(pixel: u32) -> u32 {
    return bases[pixel];
}

