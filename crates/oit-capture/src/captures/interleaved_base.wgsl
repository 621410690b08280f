@group(0) @binding(4) var<storage, read> rows: array<u32>;

// The slot of a pixel's first fragment.
fn lfb_base(pixel: u32) -> u32 {
    return 32u * rows[pixel / 32u] + pixel % 32u;
}

