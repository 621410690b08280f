//! Pictures that are kept beside a record, small enough for a repository: the picture of a cell as a
//! whole, a detail of it pixel by pixel, and its errors.

use std::path::{Path, PathBuf};

use oit_image::{DETAIL_PX, Image, ImageError, Window, write_png, write_png16_gray};
use oit_record::Cell;

/// The most bytes of a file.
const MOST_BYTES: u64 = 100_000;

/// The largest error that a map holds, in 255ths.
const LARGEST: u32 = 65535;

/// Behind what is not opaque.
const WHITE: [f32; 3] = [1.0; 3];

/// Where the pictures of a cell lie in a run folder, without the endings `.picture.png`,
/// `.detail.png` and `.error.png`.
pub(crate) fn stem(folder: &Path, cell: &Cell) -> PathBuf {
    let Cell { technique, scene, view, width_px, height_px } = cell;
    let name = format!("{scene}_{view}_{width_px}x{height_px}_{technique}");
    let safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    folder.join("images").join(name.replace(|c: char| !safe(c), "_"))
}

/// Writes three files:
///
/// - `.picture.png`: the picture over white. Each of its pixels is the mean of a square block of the
///   frame's, of the least size with which the file is below [`MOST_BYTES`].
/// - `.detail.png`: the window of [`DETAIL_PX`] with the most fragments, or the middle where none are
///   counted, pixel by pixel.
/// - `.error.png`: the largest error of a colour channel against `right` in 255ths, 16-bit grey, the
///   largest of each block.
///
/// `right` is the right picture and `counts` are the fragments of each pixel.
///
/// # Errors
/// Where a file cannot be written, or the pictures are not of one size.
pub(crate) fn keep(
    stem: &Path,
    image: &Image,
    right: &[[f64; 4]],
    counts: &[u32],
) -> Result<(), ImageError> {
    let path = |ending: &str| beside(stem, ending);
    let picture = path(".picture.png");
    smallest_blocks(image, &picture, |side| write_png(&picture, &mean(image, side), WHITE))?;
    let error = path(".error.png");
    let errors = errors(image, right);
    smallest_blocks(image, &error, |side| {
        let (width, height, largest) = blocks(image, side, |block| {
            block.map(|pixel| errors.get(pixel).copied().unwrap_or(0)).max().unwrap_or(0)
        });
        write_png16_gray(&error, width, height, &largest)
    })?;
    let window = if counts.iter().any(|&count| count > 0) {
        Window::densest(counts, image.width, DETAIL_PX.0, DETAIL_PX.1)
    } else {
        Window::middle(image.width, image.height, DETAIL_PX.0, DETAIL_PX.1)
    };
    write_png(&path(".detail.png"), &cut(image, window), WHITE)
}

/// Writes two files: `.picture.png`, as [`keep`] does, and `.right.png`, the right picture, likewise.
///
/// # Errors
/// Where a file cannot be written, or the pictures are not of one size.
pub(crate) fn keep_break(stem: &Path, image: &Image, right: &[[f64; 4]]) -> Result<(), ImageError> {
    let right = right.iter().map(|pixel| pixel.map(|channel| channel as f32)).collect();
    let right = Image { pixels: right, ..*image };
    for (image, ending) in [(image, ".picture.png"), (&right, ".right.png")] {
        let path = beside(stem, ending);
        smallest_blocks(image, &path, |side| write_png(&path, &mean(image, side), WHITE))?;
    }
    Ok(())
}

/// A file of a cell, whose folder is made.
fn beside(stem: &Path, ending: &str) -> PathBuf {
    if let Some(folder) = stem.parent() {
        // Where this fails, so does the write, and says why.
        let _ = std::fs::create_dir_all(folder);
    }
    let mut name = stem.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

/// Writes with blocks of 1, 2, 3 and so on pixels a side until the file is small enough.
fn smallest_blocks(
    image: &Image,
    path: &Path,
    write: impl Fn(u32) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    for side in 1..=image.width.max(image.height).max(1) {
        write(side)?;
        if std::fs::metadata(path).is_ok_and(|file| file.len() <= MOST_BYTES) {
            break;
        }
    }
    Ok(())
}

/// One value for each block of `side` x `side` pixels, from the places of its pixels; with how many
/// there are in a row, and rows. Blocks at the right and lower edge may be smaller.
fn blocks<T>(
    image: &Image,
    side: u32,
    value: impl Fn(&mut dyn Iterator<Item = usize>) -> T,
) -> (u32, u32, Vec<T>) {
    let (width, height) = (image.width.div_ceil(side), image.height.div_ceil(side));
    let mut values = Vec::with_capacity(width as usize * height as usize);
    for top in 0..height {
        for left in 0..width {
            let rows = top * side..((top + 1) * side).min(image.height);
            let columns = left * side..((left + 1) * side).min(image.width);
            let mut places = rows.flat_map(|y| {
                columns.clone().map(move |x| y as usize * image.width as usize + x as usize)
            });
            values.push(value(&mut places));
        }
    }
    (width, height, values)
}

fn mean(image: &Image, side: u32) -> Image {
    let (width, height, pixels) = blocks(image, side, |block| {
        let (mut sum, mut count) = ([0.0; 4], 0.0);
        for place in block {
            let pixel = image.pixels[place];
            sum = std::array::from_fn(|channel| sum[channel] + pixel[channel]);
            count += 1.0;
        }
        sum.map(|channel| channel / count)
    });
    Image { width, height, pixels }
}

fn cut(image: &Image, window: Window) -> Image {
    let Window { x, y, width, height } = window;
    let rows = (y..y + height).map(|row| row as usize * image.width as usize + x as usize);
    let pixels = rows.flat_map(|start| image.pixels[start..start + width as usize].iter().copied());
    Image { width, height, pixels: pixels.collect() }
}

/// The largest error of each pixel's colour in 255ths; what is not finite has the largest there is.
fn errors(image: &Image, right: &[[f64; 4]]) -> Vec<u32> {
    let error = |(pixel, right): (&[f32; 4], &[f64; 4])| {
        let channel = |c: usize| (f64::from(pixel[c]) - right[c]).abs();
        // `max` passes over what is not a number.
        let largest = (0..3).map(channel).filter(|e| e.is_finite()).fold(0.0, f64::max);
        let broken = (0..3).any(|c| !channel(c).is_finite());
        if broken { LARGEST } else { (largest * 255.0).round().min(f64::from(LARGEST)) as u32 }
    };
    image.pixels.iter().zip(right).map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(width: u32, height: u32) -> Image {
        let pixel = |i: u32| {
            let channel =
                |c: u32| (i.wrapping_mul(2_654_435_761).rotate_left(c * 9) >> 24) as f32 / 255.0;
            [channel(0), channel(1), channel(2), 1.0]
        };
        Image { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    #[test]
    fn what_is_kept_is_small() {
        let folder = tempfile::tempdir().unwrap();
        let image = noise(700, 300);
        let right: Vec<[f64; 4]> =
            image.pixels.iter().map(|p| p.map(|c| 1.0 - f64::from(c))).collect();
        let counts = vec![1; 700 * 300];
        let stem = folder.path().join("images").join("a_b");
        keep(&stem, &image, &right, &counts).unwrap();
        for ending in ["picture", "detail", "error"] {
            let file = folder.path().join("images").join(format!("a_b.{ending}.png"));
            let bytes = std::fs::metadata(&file).unwrap().len();
            // Noise does not compress: a detail of it is as large as its pixels.
            let most = if ending == "detail" { 3 * 240 * 150 + 2000 } else { MOST_BYTES };
            assert!(bytes > 100 && bytes <= most, "{ending}: {bytes}");
        }
    }

    #[test]
    fn of_a_break_the_right_picture_is_kept_too() {
        let folder = tempfile::tempdir().unwrap();
        let stem = folder.path().join("images").join("a_b");
        let pixels = vec![[1.0, 0.0, 0.0, 1.0], [f32::NAN, 0.0, 0.0, 1.0]];
        let image = Image { width: 2, height: 1, pixels };
        keep_break(&stem, &image, &[[0.0, 1.0, 0.0, 1.0], [0.0; 4]]).unwrap();
        let read = |ending: &str| {
            let file = folder.path().join("images").join(format!("a_b.{ending}.png"));
            std::fs::read(file).unwrap()
        };
        // The same pixels by hand: red and the colour of what is not finite, green and white.
        let by_hand = |name: &str, pixels: Vec<[f32; 4]>| {
            let path = folder.path().join(name);
            write_png(&path, &Image { width: 2, height: 1, pixels }, WHITE).unwrap();
            std::fs::read(path).unwrap()
        };
        let [red, green, magenta] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]]
            .map(|[r, g, b]: [f32; 3]| [r, g, b, 1.0]);
        assert_eq!(read("picture"), by_hand("picture", vec![red, magenta]));
        assert_eq!(read("right"), by_hand("right", vec![green, [0.0; 4]]));
        assert_eq!(std::fs::read_dir(folder.path().join("images")).unwrap().count(), 2);
    }

    #[test]
    fn blocks_are_means_and_largest_errors() {
        let pixels = vec![[0.0; 4], [1.0; 4], [0.5; 4], [0.5; 4], [0.25; 4], [0.75; 4]];
        let image = Image { width: 3, height: 2, pixels };
        let small = mean(&image, 2);
        assert_eq!((small.width, small.height), (2, 1));
        assert_eq!(small.pixels, [[(0.0 + 1.0 + 0.5 + 0.25) / 4.0; 4], [(0.5 + 0.75) / 2.0; 4]]);
        let right = vec![[0.0; 4]; 6];
        assert_eq!(errors(&image, &right), [0, 255, 128, 128, 64, 191]);
        let broken = Image { width: 1, height: 1, pixels: vec![[0.0, f32::NAN, 0.5, 1.0]] };
        assert_eq!(errors(&broken, &[[0.0; 4]]), [LARGEST]);
        let infinite = Image { width: 1, height: 1, pixels: vec![[0.0, 0.5, f32::INFINITY, 1.0]] };
        assert_eq!(errors(&infinite, &[[0.0; 4]]), [LARGEST]);
        let window = Window { x: 1, y: 0, width: 2, height: 2 };
        assert_eq!(cut(&image, window).pixels, [[1.0; 4], [0.5; 4], [0.25; 4], [0.75; 4]]);
    }
}
