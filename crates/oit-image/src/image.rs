//! The float image that a resolve gives.

use crate::ImageError;
use crate::error::check_len;

/// A float RGBA image.
///
/// Colour is premultiplied by alpha and alpha is coverage: a pixel without fragments is
/// `[0, 0, 0, 0]`. Values are display values: no gamma is applied anywhere, as in the papers.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels, row by row, row 0 at the top.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// An image of these pixels.
    ///
    /// # Errors
    /// [`ImageError::Size`] if there are not `width * height` pixels.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Result<Self, ImageError> {
        let image = Self { width, height, pixels };
        image.check()?;
        Ok(image)
    }

    /// Checks that there are `width * height` pixels: the fields are public.
    pub(crate) fn check(&self) -> Result<(), ImageError> {
        check_len("image", self.width, self.height, self.pixels.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_a_wrong_number_of_pixels() {
        assert!(Image::from_pixels(2, 3, vec![[0.0; 4]; 6]).is_ok());
        let error = Image::from_pixels(2, 3, vec![[0.0; 4]; 5]).unwrap_err();
        assert!(matches!(error, ImageError::Size { expected: 6, found: 5, .. }), "{error}");
    }
}
