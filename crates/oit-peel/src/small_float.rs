//! Floats of eleven and ten bits.

/// A colour as R11G11B10F keeps it: five bits of exponent, six or five of mantissa, no sign, rounded
/// to the nearest (a device may also round towards zero). Alpha is 1, as a shader reads it.
pub(crate) fn r11g11b10([r, g, b, _]: [f32; 4]) -> [f32; 4] {
    [small(r, 6), small(g, 6), small(b, 5), 1.0]
}

/// A float with this many bits of mantissa and the exponents of a half float.
fn small(value: f32, mantissa_bits: u32) -> f32 {
    if value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    let bits = value.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    // Below 2^-14 steps are equal.
    let step = 2.0_f32.powi(exponent.max(-14) - mantissa_bits as i32);
    let largest = (2.0 - 2.0_f32.powi(-(mantissa_bits as i32))) * 32_768.0;
    ((value / step).round_ties_even() * step).min(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_and_their_neighbours() {
        // Above 32 a step of six bits is a half, of five bits 1.
        assert_eq!(r11g11b10([32.5, 32.25, 32.25, 0.3]), [32.5, 32.0, 32.0, 1.0]);
        assert_eq!(
            r11g11b10([1.0, 1.0 + 1.0 / 64.0, 1.0 + 1.0 / 32.0, 0.0])[..3],
            [1.0, 1.015_625, 1.031_25]
        );
        assert_eq!(r11g11b10([0.0, -1.0, 1e9, 0.0])[..3], [0.0, 0.0, 64_512.0]);
    }
}
