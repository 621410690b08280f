//! What an eye makes of an error: structural similarity and FLIP, of the picture as it is shown.

use image_compare::{Algorithm, rgb_similarity_structure};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool};

use crate::png_file::display_color;
use crate::{Image, ImageError};

/// How much two pictures look alike, over black, in 8 bits a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perceptual {
    /// Mean structural similarity in windows of 8 by 8 pixels (Wang et al. 2004; the least of the
    /// three channels): 1 for equal pictures, less for others.
    pub ssim: f64,
    /// Mean of NVIDIA's FLIP (Andersson et al. 2020) at 67 pixels a degree: 0 for equal pictures, 1 at
    /// most.
    pub flip: f64,
}

/// Compares how a picture and its reference look. Pixels that are not finite are magenta.
///
/// # Errors
/// [`ImageError::Size`] if they do not have the same number of pixels.
///
/// # Panics
/// Where a picture has more pixels than memory.
pub fn perceptual(image: &Image, reference: &[[f64; 4]]) -> Result<Perceptual, ImageError> {
    image.check()?;
    crate::error::check_len("reference", image.width, image.height, reference.len())?;
    if reference.is_empty() {
        return Ok(Perceptual { ssim: 1.0, flip: 0.0 });
    }
    let shown = |pixel: [f32; 4]| display_color(pixel, [0.0; 3]);
    let own: Vec<u8> = image.pixels.iter().flat_map(|&pixel| shown(pixel)).collect();
    let narrow = |pixel: &[f64; 4]| pixel.map(|channel| channel as f32);
    let right: Vec<u8> = reference.iter().flat_map(|pixel| shown(narrow(pixel))).collect();
    let (width, height) = (image.width, image.height);
    let flip_image = |bytes: &[u8]| FlipImageRgb8::with_data(width, height, bytes);
    let map = nv_flip::flip(flip_image(&right), flip_image(&own), DEFAULT_PIXELS_PER_DEGREE);
    let flip = f64::from(FlipPool::from_image(&map).mean());
    let rgb = |bytes| image::RgbImage::from_raw(width, height, bytes).expect("its own size");
    let similarity = rgb_similarity_structure(&Algorithm::MSSIMSimple, &rgb(right), &rgb(own))
        .expect("pictures of one size");
    Ok(Perceptual { ssim: similarity.score, flip })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkers(width: u32, height: u32, dark: f32, bright: f32) -> Image {
        let pixel = |i: u32| {
            let on = (i % width / 4 + i / width / 4).is_multiple_of(2);
            let value = if on { bright } else { dark };
            [value, value, value, 1.0]
        };
        Image { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    fn wide(image: &Image) -> Vec<[f64; 4]> {
        image.pixels.iter().map(|pixel| pixel.map(f64::from)).collect()
    }

    #[test]
    fn equal_pictures_look_alike_and_worse_ones_look_worse() {
        let right = checkers(64, 32, 0.2, 0.8);
        let same = perceptual(&right, &wide(&right)).unwrap();
        assert!((same.ssim - 1.0).abs() < 1e-6 && same.flip == 0.0, "{same:?}");
        let near = perceptual(&checkers(64, 32, 0.25, 0.75), &wide(&right)).unwrap();
        let far = perceptual(&checkers(64, 32, 0.45, 0.55), &wide(&right)).unwrap();
        assert!(same.ssim > near.ssim && near.ssim > far.ssim, "{near:?} {far:?}");
        assert!(0.0 < near.flip && near.flip < far.flip, "{near:?} {far:?}");
    }

    #[test]
    fn sizes_must_agree_and_broken_pixels_are_seen() {
        let right = checkers(16, 16, 0.2, 0.8);
        assert!(perceptual(&right, &[[0.0; 4]; 3]).is_err());
        let mut broken = right.clone();
        broken.pixels[0] = [f32::NAN; 4];
        assert!(perceptual(&broken, &wide(&right)).unwrap().flip > 0.0);
        let none = Image { width: 0, height: 0, pixels: Vec::new() };
        assert_eq!(perceptual(&none, &[]).unwrap(), Perceptual { ssim: 1.0, flip: 0.0 });
    }
}
