// The level above left it there.
fn sum_before(right: u32) -> u32 {
    return VALUES[right];
}

