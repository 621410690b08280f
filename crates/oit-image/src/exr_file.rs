//! Flat OpenEXR files: the float image and the depth complexity it was resolved from.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::meta::MetaData;
use exr::meta::header::LayerAttributes;
use exr::prelude::{
    Compression, LineOrder, ReadChannels, ReadLayers, SmallVec, Vec2, WritableImage,
};

use crate::atomic::write_atomically;
use crate::error::check_len;
use crate::{Image, ImageError};

/// Name of the `u32` channel that holds how many fragments each pixel had.
pub const DEPTH_COMPLEXITY_CHANNEL: &str = "depth_complexity";

/// Most pixels that [`read_exr`] reads (8192 x 8192). A header is a few bytes and can claim any
/// size, so the size is checked before memory is asked for.
pub const MAX_EXR_PX: usize = 1 << 26;

/// The colour channels, in the order of [`Image::pixels`].
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// Writes an image as OpenEXR: `f32` channels `R`, `G`, `B` (premultiplied) and `A`, and, where
/// given, the fragments of each pixel as the `u32` channel [`DEPTH_COMPLEXITY_CHANNEL`].
///
/// Lossless (ZIP, 16 scan lines a block); the same pixels give the same bytes.
///
/// # Errors
/// [`ImageError::Size`] if the counts or the pixels are not `width * height`,
/// [`ImageError::Exr`] if the image has no pixels, [`ImageError::Io`] if it cannot be written.
pub fn write_exr(
    path: &Path,
    image: &Image,
    depth_complexity: Option<&[u32]>,
) -> Result<(), ImageError> {
    image.check()?;
    let mut channels = SmallVec::new();
    for (index, name) in RGBA.into_iter().enumerate() {
        let samples = image.pixels.iter().map(|pixel| pixel[index]).collect();
        channels.push(AnyChannel::new(name, FlatSamples::F32(samples)));
    }
    if let Some(counts) = depth_complexity {
        check_len("depth complexity", image.width, image.height, counts.len())?;
        let samples = FlatSamples::U32(counts.to_vec());
        channels.push(AnyChannel::new(DEPTH_COMPLEXITY_CHANNEL, samples));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        // Blocks are compressed in parallel: without an order the bytes would vary.
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        Vec2(image.width as usize, image.height as usize),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|source| ImageError::Exr { path: path.to_owned(), source })?;
    write_atomically(path, bytes.get_ref())
}

/// Reads what [`write_exr`] wrote: the image and, if the file has it, the depth complexity.
///
/// # Errors
/// [`ImageError::Io`] if the file cannot be read, [`ImageError::Exr`] if it is no valid EXR,
/// [`ImageError::NotOurs`] if it has more than [`MAX_EXR_PX`] pixels, several layers, subsampled
/// channels, no `f32` RGBA, or a depth complexity that is not `u32`.
pub fn read_exr(path: &Path) -> Result<(Image, Option<Vec<u32>>), ImageError> {
    let invalid = |source| ImageError::Exr { path: path.to_owned(), source };
    let not_ours = |reason: String| ImageError::NotOurs { path: path.to_owned(), reason };
    let bytes =
        std::fs::read(path).map_err(|source| ImageError::Io { path: path.to_owned(), source })?;

    let meta = MetaData::read_from_buffered(Cursor::new(&bytes), true).map_err(invalid)?;
    let [header] = meta.headers.as_slice() else {
        return Err(not_ours(format!("{} layers instead of one", meta.headers.len())));
    };
    let Vec2(width, height) = header.layer_size;
    if width.checked_mul(height).is_none_or(|px| px > MAX_EXR_PX) {
        return Err(not_ours(format!("{width} x {height} pixels, at most {MAX_EXR_PX} are read")));
    }
    if let Some(channel) = header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        return Err(not_ours(format!("channel {} is subsampled", channel.name)));
    }

    let file = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .pedantic()
        .from_buffered(Cursor::new(&bytes))
        .map_err(invalid)?;
    let channel = |name: &str| {
        let mut list = file.layer_data.channel_data.list.iter();
        list.find(|channel| channel.name.eq(name)).map(|channel| &channel.sample_data)
    };

    let mut pixels = vec![[0.0; 4]; width * height];
    for (index, name) in RGBA.into_iter().enumerate() {
        let Some(FlatSamples::F32(samples)) = channel(name) else {
            return Err(not_ours(format!("no f32 channel {name}")));
        };
        for (pixel, &sample) in pixels.iter_mut().zip(samples) {
            pixel[index] = sample;
        }
    }
    let depth_complexity = match channel(DEPTH_COMPLEXITY_CHANNEL) {
        None => None,
        Some(FlatSamples::U32(counts)) => Some(counts.clone()),
        Some(_) => return Err(not_ours(format!("{DEPTH_COMPLEXITY_CHANNEL} is not u32"))),
    };
    // Both are below MAX_EXR_PX, or the other one is 0 and the library has refused it.
    let side = |px: usize| u32::try_from(px).map_err(|_| not_ours(format!("{px} pixels a side")));
    let image = Image { width: side(width)?, height: side(height)?, pixels };
    Ok((image, depth_complexity))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (Image, Vec<u32>) {
        // Several 16-line blocks, and values that 16-bit floats could not hold.
        let (width, height) = (7_u8, 40_u8);
        let pixels = (0..u16::from(width) * u16::from(height))
            .map(|i| [0.1 * f32::from(i), -1.0, f32::MIN_POSITIVE, 1.0 / 3.0])
            .collect();
        let counts = (0..280).map(|i| i * 65_537).collect();
        (Image { width: width.into(), height: height.into(), pixels }, counts)
    }

    #[test]
    fn gives_back_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, counts) = example();
        write_exr(&path, &image, Some(&counts)).unwrap();
        assert_eq!(read_exr(&path).unwrap(), (image.clone(), Some(counts)));
        write_exr(&path, &image, None).unwrap();
        assert_eq!(read_exr(&path).unwrap(), (image, None));
    }

    #[test]
    fn keeps_not_a_number_and_infinity() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let pixels = vec![[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0]];
        write_exr(&path, &Image { width: 1, height: 1, pixels }, None).unwrap();
        let [r, g, b, a] = read_exr(&path).unwrap().0.pixels[0];
        assert!(r.is_nan());
        assert_eq!([g, b, a], [f32::INFINITY, f32::NEG_INFINITY, 1.0]);
    }

    #[test]
    fn the_same_image_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let (image, counts) = example();
        let bytes = ["a.exr", "b.exr"].map(|name| {
            let path = folder.path().join(name);
            write_exr(&path, &image, Some(&counts)).unwrap();
            std::fs::read(path).unwrap()
        });
        assert!(bytes[0] == bytes[1]);
    }

    #[test]
    fn refuses_wrong_sizes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, counts) = example();
        let short = write_exr(&path, &image, Some(&counts[1..]));
        assert!(matches!(short, Err(ImageError::Size { expected: 280, found: 279, .. })));
        let empty = Image { width: 0, height: 0, pixels: Vec::new() };
        assert!(matches!(write_exr(&path, &empty, None), Err(ImageError::Exr { .. })));
        assert!(!path.exists());
    }

    #[test]
    fn a_truncated_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, counts) = example();
        write_exr(&path, &image, Some(&counts)).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for len in (0..bytes.len()).step_by(31) {
            std::fs::write(&path, &bytes[..len]).unwrap();
            assert!(read_exr(&path).is_err(), "cut to {len} of {} bytes", bytes.len());
        }
    }

    #[test]
    fn an_enormous_size_is_refused_before_memory_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (image, _) = example();
        write_exr(&path, &image, None).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let mut replace = |old: &[u8], new: &[u8]| {
            let at: Vec<_> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(old)).collect();
            for &at in &at {
                bytes[at..at + new.len()].copy_from_slice(new);
            }
            at.len()
        };
        // Windows are stored as x min, y min, x max, y max: 6 and 39 are the last column and row.
        let window = |x: i32, y: i32| [0, 0, x, y].map(i32::to_le_bytes).concat();
        assert_eq!(replace(&window(6, 39), &window(99_999, 99_999)), 2, "display and data window");
        // One block holds 16 rows.
        let blocks = |n: i32| [&b"chunkCount\0int\0\x04\0\0\0"[..], &n.to_le_bytes()].concat();
        assert_eq!(replace(&blocks(3), &blocks(6_250)), 1);
        std::fs::write(&path, &bytes).unwrap();
        let error = read_exr(&path).unwrap_err();
        assert!(error.to_string().contains("100000 x 100000"), "{error}");
    }
}
