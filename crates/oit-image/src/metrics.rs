//! How far an image is from the reference.

use rayon::prelude::*;

use crate::{Image, ImageError};

/// A pixel is wrong if a colour channel is off by more than this: one step of an 8-bit display.
pub const WRONG_PX_ERROR: f64 = 1.0 / 255.0;

/// The difference between an image and its reference. Colour is compared as it is stored,
/// premultiplied and neither clamped nor rounded; 1 is the full scale. Alpha is counted apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Pixels with a colour channel off by more than [`WRONG_PX_ERROR`], or with any channel, alpha
    /// included, that is not finite.
    pub wrong_px: u64,
    /// Largest absolute error of a colour channel.
    pub max_color_error: f64,
    /// Root of the mean squared error over the colour channels of all pixels.
    pub rmse: f64,
    /// Largest absolute error of alpha.
    pub max_alpha_error: f64,
}

impl Difference {
    /// Peak signal-to-noise ratio for a peak of 1, in decibels: `-20 log10(rmse)`. Infinite for
    /// equal images, minus infinity where a pixel is not finite.
    #[must_use]
    pub fn psnr_db(&self) -> f64 {
        -20.0 * self.rmse.log10()
    }
}

/// Compares an image with its reference, given as `f64` pixels in the same order and form.
///
/// A channel that is NaN or infinite, in the image or in the reference, has an infinite error
/// (even where both are the same infinity), so a broken pixel can never lower an error.
///
/// # Errors
/// [`ImageError::Size`] if the image and the reference do not have the same number of pixels.
pub fn compare(image: &Image, reference: &[[f64; 4]]) -> Result<Difference, ImageError> {
    image.check()?;
    crate::error::check_len("reference", image.width, image.height, reference.len())?;
    // Chunks are added up in order, so that the sum is the same however many threads there are.
    let chunks = image.pixels.par_chunks(PIXELS_AT_ONCE).zip(reference.par_chunks(PIXELS_AT_ONCE));
    let parts: Vec<Sums> = chunks.map(|(pixels, expected)| Sums::of(pixels, expected)).collect();
    let Sums { wrong_px, max_color_error, max_alpha_error, squares } =
        parts.into_iter().fold(Sums::default(), Sums::and);
    // An image without pixels has no error; 0 / 0 would be NaN.
    let channels = (reference.len() * 3).max(1) as f64;
    Ok(Difference { wrong_px, max_color_error, rmse: (squares / channels).sqrt(), max_alpha_error })
}

/// Pixels that one thread compares at a time.
const PIXELS_AT_ONCE: usize = 1 << 14;

/// What some of the pixels come to.
#[derive(Default)]
struct Sums {
    wrong_px: u64,
    max_color_error: f64,
    max_alpha_error: f64,
    squares: f64,
}

impl Sums {
    fn of(pixels: &[[f32; 4]], reference: &[[f64; 4]]) -> Self {
        let mut sums = Self::default();
        for (pixel, expected) in pixels.iter().zip(reference) {
            let error: [f64; 4] = std::array::from_fn(|c| error(f64::from(pixel[c]), expected[c]));
            let [r, g, b, alpha] = error;
            let color = r.max(g).max(b);
            if color > WRONG_PX_ERROR || alpha.is_infinite() {
                sums.wrong_px += 1;
            }
            sums.max_color_error = sums.max_color_error.max(color);
            sums.max_alpha_error = sums.max_alpha_error.max(alpha);
            sums.squares += r * r + g * g + b * b;
        }
        sums
    }

    fn and(self, other: Self) -> Self {
        Self {
            wrong_px: self.wrong_px + other.wrong_px,
            max_color_error: self.max_color_error.max(other.max_color_error),
            max_alpha_error: self.max_alpha_error.max(other.max_alpha_error),
            squares: self.squares + other.squares,
        }
    }
}

/// The absolute error of a channel, infinite where it has none. Never NaN.
fn error(found: f64, expected: f64) -> f64 {
    let error = (found - expected).abs();
    if error.is_finite() { error } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: &[[f32; 4]]) -> Image {
        Image { width: pixels.len() as u32, height: 1, pixels: pixels.to_vec() }
    }

    #[test]
    fn equal_images_have_no_error() {
        let found = compare(&image(&[[0.5, 0.25, 0.0, 1.0]]), &[[0.5, 0.25, 0.0, 1.0]]).unwrap();
        let none =
            Difference { wrong_px: 0, max_color_error: 0.0, rmse: 0.0, max_alpha_error: 0.0 };
        assert_eq!(found, none);
        assert_eq!(found.psnr_db(), f64::INFINITY);
    }

    #[test]
    fn hand_computed_errors() {
        // Colour errors 0.25 and 0.5 in 6 channels: mean square (0.0625 + 0.25) / 6.
        let found = compare(
            &image(&[[0.25, 0.0, 0.0, 1.0], [0.0, 0.0, 0.5, 0.25]]),
            &[[0.5, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]],
        )
        .unwrap();
        assert_eq!(found.wrong_px, 2);
        assert_eq!(found.max_color_error, 0.5);
        assert_eq!(found.max_alpha_error, 0.75);
        assert!((found.rmse - 0.228_217_732).abs() < 1e-9, "{}", found.rmse);
        assert!((found.psnr_db() - 12.833_012_2).abs() < 1e-6, "{}", found.psnr_db());
    }

    #[test]
    fn wrong_begins_above_one_step_of_255_and_leaves_alpha_out() {
        let step = 1.0 / 255.0;
        let reference = [[0.0, step, 0.0, 0.0]];
        assert_eq!(compare(&image(&[[0.0; 4]]), &reference).unwrap().wrong_px, 0);
        let reference = [[0.0, step * 1.0001, 0.0, 0.0]];
        assert_eq!(compare(&image(&[[0.0; 4]]), &reference).unwrap().wrong_px, 1);
        let found = compare(&image(&[[0.0, 0.0, 0.0, 0.5]]), &[[0.0; 4]]).unwrap();
        assert_eq!((found.wrong_px, found.max_alpha_error, found.rmse), (0, 0.5, 0.0));
    }

    #[test]
    fn what_is_not_finite_is_wrong_with_an_infinite_error() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for channel in 0..4 {
                let mut pixel = [0.0; 4];
                pixel[channel] = bad;
                // In the image, in the reference, and in both.
                let broken = pixel.map(f64::from);
                for (found, expected) in [(pixel, [0.0; 4]), ([0.0; 4], broken), (pixel, broken)] {
                    let found = compare(&image(&[found, [0.0; 4]]), &[expected, [0.0; 4]]).unwrap();
                    assert_eq!(found.wrong_px, 1);
                    if channel == 3 {
                        assert_eq!(found.max_alpha_error, f64::INFINITY);
                        assert_eq!(found.max_color_error, 0.0);
                    } else {
                        assert_eq!(found.max_color_error, f64::INFINITY);
                        assert_eq!(found.rmse, f64::INFINITY);
                        assert_eq!(found.psnr_db(), f64::NEG_INFINITY);
                        assert_eq!(found.max_alpha_error, 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn refuses_sizes_that_differ() {
        let found = compare(&image(&[[0.0; 4]; 2]), &[[0.0; 4]; 3]);
        assert!(matches!(found, Err(ImageError::Size { expected: 2, found: 3, .. })));
        let broken = Image { width: 2, height: 2, pixels: vec![[0.0; 4]; 3] };
        let found = compare(&broken, &[[0.0; 4]; 3]);
        assert!(matches!(found, Err(ImageError::Size { expected: 4, found: 3, .. })));
    }

    #[test]
    fn an_image_without_pixels_has_no_error() {
        assert_eq!(compare(&image(&[]), &[]).unwrap().rmse, 0.0);
    }
}
