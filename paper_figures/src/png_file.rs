//! The one place where figures become PNG files: as small as is quick, and the same bytes everywhere.
//!
//! Most charts have at most 256 colours, and a byte or less a pixel then says the same as three. The
//! encoder finds that out, as it finds which row filter is worth its while: none for text and
//! areas, one for pictures.

use oxipng::{
    BitDepth, ColorType, Deflater, FilterStrategy, Options, RawImage, StripChunks, indexset,
};

use crate::FigureError;

/// All that decides what is written, so that a new default of the library changes no file. Nothing in
/// it depends on the time that encoding takes or on the number of processors.
///
/// Libdeflate's level 10 is the first that weighs alternatives; 11 made the recorded figures smaller by
/// 2 % in twice the time. A second filter beyond none and bigrams made them no smaller.
fn options() -> Options {
    Options {
        filters: indexset! { FilterStrategy::NONE, FilterStrategy::Bigrams },
        deflater: Deflater::Libdeflater { compression: 10 },
        fast_evaluation: true,
        interlace: Some(false),
        strip: StripChunks::None,
        bit_depth_reduction: true,
        color_type_reduction: true,
        palette_reduction: true,
        grayscale_reduction: true,
        idat_recoding: true,
        timeout: None,
        ..Options::default()
    }
}

/// Pixels of three bytes, red, green and blue, row by row, as a PNG file of the same colours. A
/// `description` that is not empty is put into a text chunk, uncompressed.
///
/// # Errors
/// Where the pixels do not fill `width` times `height`, or there are none.
pub(crate) fn encode(
    rgb: Vec<u8>,
    width: u32,
    height: u32,
    description: &str,
) -> Result<Vec<u8>, FigureError> {
    let failed = |error: oxipng::PngError| FigureError::Draw(error.to_string());
    if width == 0 || height == 0 {
        return Err(FigureError::Draw("a picture without pixels".to_owned()));
    }
    let colour = ColorType::RGB { transparent_color: None };
    let mut image = RawImage::new(width, height, colour, BitDepth::Eight, rgb).map_err(failed)?;
    if !description.is_empty() {
        // PNG (third edition), 11.3.3.4: keyword, null, uncompressed, method, no language and no
        // translated keyword, each ended by null, text.
        let chunk = [b"Description\0\0\0\0\0", description.as_bytes()].concat();
        image.add_png_chunk(*b"iTXt", chunk);
    }
    image.create_optimized_png(&options()).map_err(failed)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::io::Cursor;

    use super::*;

    /// The pixels of a PNG file as three bytes each, and how the file stores them.
    fn decode(file: &[u8]) -> (Vec<u8>, (u32, u32), (png::ColorType, png::BitDepth), String) {
        let mut decoder = png::Decoder::new(Cursor::new(file));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        pixels.truncate(frame.buffer_size());
        let rgb = match frame.color_type {
            png::ColorType::Rgb => pixels,
            png::ColorType::Grayscale => pixels.into_iter().flat_map(|grey| [grey; 3]).collect(),
            other => panic!("{other:?}"),
        };
        reader.finish().unwrap();
        let info = reader.info();
        let text = info.utf8_text.first().map(|text| text.get_text().unwrap());
        let stored = (info.color_type, info.bit_depth);
        (rgb, (frame.width, frame.height), stored, text.unwrap_or_default())
    }

    fn colours(rgb: &[u8]) -> usize {
        rgb.chunks_exact(3).collect::<BTreeSet<_>>().len()
    }

    /// Pixels of a picture 183 wide and 141 high.
    fn picture(colour: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
        (0..141)
            .flat_map(|y| (0..183).map(move |x| (x, y)))
            .flat_map(|(x, y)| colour(x, y))
            .collect()
    }

    #[track_caller]
    fn comes_back(rgb: &[u8], stored: (png::ColorType, png::BitDepth)) {
        let file = encode(rgb.to_vec(), 183, 141, "20 × 30 px\nsecond line").unwrap();
        let text = "20 × 30 px\nsecond line".to_owned();
        assert!(decode(&file) == (rgb.to_vec(), (183, 141), stored, text), "{:?}", decode(&file).2);
        assert_eq!(encode(rgb.to_vec(), 183, 141, "20 × 30 px\nsecond line").unwrap(), file);
    }

    /// One of so many colours for each pixel, without a pattern that a row filter could take away.
    fn scattered(colours: u32) -> Vec<u8> {
        picture(|x, y| {
            let which = ((x * 7919 + y * 104_729).wrapping_mul(2_654_435_761) >> 16) % colours;
            [(which * 37) as u8, (which * 91) as u8, (which * which) as u8]
        })
    }

    #[test]
    fn few_colours_make_a_palette() {
        for (number, depth) in [(256, 8), (200, 8), (16, 4), (2, 1)] {
            let rgb = scattered(number);
            assert_eq!(colours(&rgb), number as usize);
            comes_back(&rgb, (png::ColorType::Indexed, png::BitDepth::from_u8(depth).unwrap()));
        }
    }

    #[test]
    fn many_colours_stay_true() {
        let rgb = picture(|x, y| [x as u8, y as u8, (x ^ y) as u8]);
        assert_eq!(colours(&rgb), 183 * 141);
        comes_back(&rgb, (png::ColorType::Rgb, png::BitDepth::Eight));
    }

    #[test]
    fn greys_take_a_byte() {
        let rgb = picture(|x, y| [(x + y) as u8; 3]);
        comes_back(&rgb, (png::ColorType::Grayscale, png::BitDepth::Eight));
    }

    #[test]
    fn what_is_no_picture_is_an_error() {
        assert!(encode(vec![0; 11], 2, 2, "").is_err());
        assert!(encode(Vec::new(), 0, 0, "").is_err());
    }

    #[test]
    fn no_description_makes_no_chunk() {
        let file = encode(vec![0; 12], 2, 2, "").unwrap();
        assert!(!file.windows(4).any(|bytes| bytes == b"iTXt"));
    }
}
