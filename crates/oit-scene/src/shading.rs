/// Two-sided Lambert shading.
///
/// With surface colour `c` (the vertex colour, or the stripe's), unit normal `n` and unit light
/// direction `l`, a fragment's RGB is `c.rgb * (ambient + (1 - ambient) * |n . l|)`. Its alpha is
/// `c.a`: light does not touch it. Every face is lit alike from both sides, since transparent
/// surfaces show both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// Unit vector towards the light, world space.
    pub light: [f32; 3],
    /// From 0 to 1; 1 switches the light off.
    pub ambient: f32,
    /// Bands in a second colour.
    pub stripes: Option<Stripes>,
}

/// Bands that replace the vertex colour where `fract(dot(position, direction) / period) < 0.5`,
/// with `fract(x) = x - floor(x)`. They let the eye follow a transparent surface (LFB chapter,
/// Figure 20.7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stripes {
    /// Unit vector across the bands, world space.
    pub direction: [f32; 3],
    /// World-space distance from one band to the next; above 0.
    pub period: f32,
    /// Colour of the bands, straight alpha.
    pub rgba: [u8; 4],
}
