const NO_PIXEL = 0xffffffffu;

// The pixel that has the place `at`: groups are of 32 pixels each, row by row.
fn entry(at: u32) -> u32 {
    return select(NO_PIXEL, at, at < PIXELS);
}

