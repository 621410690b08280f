//! PNG files: the image over a background, and counts.

use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::check_len;
use crate::{Image, ImageError};

/// What [`write_png`] draws for a pixel with a NaN or infinite channel: magenta, so that a broken
/// pixel is seen and not taken for black.
pub const NON_FINITE_COLOR: [u8; 3] = [255, 0, 255];

/// Writes an image over a background as 8-bit RGB PNG.
///
/// Each channel is `color + (1 - alpha) * background`, clamped to 0..1 and rounded to 1/255.
/// Values are display values: no gamma is applied and none is stored in the file. A pixel that is
/// not finite becomes [`NON_FINITE_COLOR`].
///
/// # Errors
/// [`ImageError::Size`] if there are not `width * height` pixels, [`ImageError::Png`] if there are
/// none, [`ImageError::Io`] if the file cannot be written.
pub fn write_png(path: &Path, image: &Image, background: [f32; 3]) -> Result<(), ImageError> {
    image.check()?;
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|&p| display_color(p, background)).collect();
    write(path, image.width, image.height, png::ColorType::Rgb, png::BitDepth::Eight, &bytes)
}

/// Writes one count a pixel as 16-bit grey PNG, the value being the count.
///
/// # Errors
/// [`ImageError::Size`] if there are not `width * height` counts, [`ImageError::CountTooLarge`] if
/// one is over 65535, [`ImageError::Png`] if there are none, [`ImageError::Io`] if the file cannot
/// be written.
pub fn write_png16_gray(
    path: &Path,
    width: u32,
    height: u32,
    counts: &[u32],
) -> Result<(), ImageError> {
    check_len("counts", width, height, counts.len())?;
    let mut bytes = Vec::with_capacity(counts.len() * 2);
    for (pixel, &count) in counts.iter().enumerate() {
        let value = u16::try_from(count).map_err(|_| ImageError::CountTooLarge { pixel, count })?;
        bytes.extend(value.to_be_bytes());
    }
    write(path, width, height, png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes)
}

/// Writes RGB pixels as 8-bit PNG.
pub(crate) fn write_rgb(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[[u8; 3]],
) -> Result<(), ImageError> {
    write(path, width, height, png::ColorType::Rgb, png::BitDepth::Eight, pixels.as_flattened())
}

/// The 8-bit colour of a premultiplied pixel over a background.
pub(crate) fn display_color(pixel: [f32; 4], background: [f32; 3]) -> [u8; 3] {
    if pixel.iter().any(|channel| !channel.is_finite()) {
        return NON_FINITE_COLOR;
    }
    let [r, g, b, alpha] = pixel;
    let mut color = [r, g, b];
    for (channel, behind) in color.iter_mut().zip(background) {
        *channel += (1.0 - alpha) * behind;
    }
    color.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Encodes with settings spelled out, so that a new default of the library changes no file, and
/// with no chunk beyond header, data and end.
fn write(
    path: &Path,
    width: u32,
    height: u32,
    color: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Result<(), ImageError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    let encoded = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(data)?;
        writer.finish()
    });
    encoded.map_err(|source| ImageError::Png { path: path.to_owned(), source })?;
    write_atomically(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path) -> (png::ColorType, png::BitDepth, Vec<u8>) {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        (info.color_type, info.bit_depth, data)
    }

    #[test]
    fn composites_over_the_background() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let pixels = vec![
            [0.0, 0.0, 0.0, 0.0],           // nothing: the background, 0.2 0.4 1.0
            [0.25, 0.0, 0.5, 0.5],          // 0.25 + 0.1, 0.2, 0.5 + 0.5
            [1.0, 2.0, -1.0, 1.0],          // opaque, clamped
            [0.0, 0.0, 0.0, f32::NAN],      // not finite
            [f32::INFINITY, 0.0, 0.0, 1.0], // not finite
            [0.501 / 255.0, 0.0, 0.0, 1.0], // rounds up to 1
        ];
        let image = Image { width: 3, height: 2, pixels };
        write_png(&path, &image, [0.2, 0.4, 1.0]).unwrap();
        let (color, depth, data) = read(&path);
        assert_eq!((color, depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        let expected = [
            [51, 102, 255],
            [89, 51, 255],
            [255, 255, 0],
            NON_FINITE_COLOR,
            NON_FINITE_COLOR,
            [1, 0, 0],
        ];
        assert_eq!(data, expected.as_flattened());
    }

    #[test]
    fn gray_values_are_the_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png16_gray(&path, 2, 1, &[258, 65_535]).unwrap();
        let (color, depth, data) = read(&path);
        assert_eq!((color, depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
        assert_eq!(data, [1, 2, 255, 255]);
    }

    #[test]
    fn refuses_what_it_cannot_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let large = write_png16_gray(&path, 2, 1, &[0, 65_536]);
        assert!(matches!(large, Err(ImageError::CountTooLarge { pixel: 1, count: 65_536 })));
        let short = write_png16_gray(&path, 2, 2, &[0; 3]);
        assert!(matches!(short, Err(ImageError::Size { expected: 4, found: 3, .. })));
        let image = Image { width: 2, height: 2, pixels: vec![[0.0; 4]; 5] };
        let long = write_png(&path, &image, [0.0; 3]);
        assert!(matches!(long, Err(ImageError::Size { expected: 4, found: 5, .. })));
        let empty = write_png16_gray(&path, 0, 0, &[]);
        assert!(matches!(empty, Err(ImageError::Png { .. })));
        assert!(!path.exists());
    }

    #[test]
    fn holds_header_data_and_end_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let counts: Vec<u32> = (0..4096).collect();
        write_png16_gray(&path, 64, 64, &counts).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let mut names = Vec::new();
        let mut rest = &bytes[8..];
        // A chunk is its length, its name, its data and a checksum.
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            names.push(String::from_utf8(after[..4].to_vec()).unwrap());
            rest = &after[4 + u32::from_be_bytes(*length) as usize + 4..];
        }
        names.dedup();
        assert_eq!(names, ["IHDR", "IDAT", "IEND"]);

        let again = folder.path().join("b.png");
        write_png16_gray(&again, 64, 64, &counts).unwrap();
        assert!(bytes == std::fs::read(again).unwrap());
    }
}
