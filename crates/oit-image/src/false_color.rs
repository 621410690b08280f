//! Counts as colours.

use std::path::Path;

use crate::ImageError;
use crate::error::check_len;
use crate::png_file::write_rgb;

/// Every 17th of the 256 entries of matplotlib's `viridis` colour map (`lib/matplotlib/_cm_listed.py`,
/// by Nathaniel Smith, Stefan van der Walt and Eric Firing, CC0), rounded to 1/255.
const VIRIDIS: [[u8; 3]; 16] = [
    [68, 1, 84],
    [72, 26, 108],
    [71, 47, 125],
    [65, 68, 135],
    [57, 86, 140],
    [49, 104, 142],
    [42, 120, 142],
    [35, 136, 142],
    [31, 152, 139],
    [34, 168, 132],
    [53, 183, 121],
    [84, 197, 104],
    [122, 209, 81],
    [165, 219, 54],
    [210, 226, 27],
    [253, 231, 37],
];

/// The viridis colour at `t`, from dark purple at 0 to yellow at 1, piecewise linear between 16
/// entries of the published map. `t` is clamped to 0..1; NaN counts as 0.
#[must_use]
pub fn viridis(t: f64) -> [u8; 3] {
    let last = VIRIDIS.len() - 1;
    let at = t.clamp(0.0, 1.0) * last as f64;
    // A float to integer cast takes NaN to 0.
    let below = (at as usize).min(last - 1);
    let weight = if at.is_nan() { 0.0 } else { at - below as f64 };
    std::array::from_fn(|channel| {
        let [low, high] = [VIRIDIS[below], VIRIDIS[below + 1]].map(|c| f64::from(c[channel]));
        (low + (high - low) * weight).round() as u8
    })
}

/// The colour of a count: black for 0, else [`viridis`] from 1 to `max`, so that a pixel without
/// fragments stands out from one with few. Counts above `max` have the colour of `max`.
#[must_use]
pub fn false_color(count: u32, max: u32) -> [u8; 3] {
    match count {
        0 => [0; 3],
        _ if max <= 1 => viridis(0.0),
        _ => viridis(f64::from(count - 1) / f64::from(max - 1)),
    }
}

/// Writes one count a pixel (the depth complexity of an image, say) as an 8-bit RGB PNG in
/// [`false_color`], up to the largest count there is.
///
/// # Errors
/// [`ImageError::Size`] if there are not `width * height` counts, [`ImageError::Png`] if there are
/// none, [`ImageError::Io`] if the file cannot be written.
pub fn false_color_png(
    path: &Path,
    width: u32,
    height: u32,
    counts: &[u32],
) -> Result<(), ImageError> {
    check_len("counts", width, height, counts.len())?;
    let max = counts.iter().copied().max().unwrap_or(0);
    let pixels: Vec<_> = counts.iter().map(|&count| false_color(count, max)).collect();
    write_rgb(path, width, height, &pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_meets_its_table_and_is_linear_between() {
        assert_eq!(viridis(0.0), [68, 1, 84]);
        assert_eq!(viridis(1.0), [253, 231, 37]);
        assert_eq!(viridis(0.2), [65, 68, 135]);
        // Half way between the entries 0 and 1: 70, 13.5, 96.
        assert_eq!(viridis(0.5 / 15.0), [70, 14, 96]);
        assert_eq!(viridis(-1.0), viridis(0.0));
        assert_eq!(viridis(2.0), viridis(1.0));
        assert_eq!(viridis(f64::NAN), viridis(0.0));
    }

    /// The interpolated map is within 7/255 of the published one. These entries (8, 60, 128 and 245
    /// of 256) are not in the table.
    #[test]
    fn viridis_is_near_the_published_map_between_its_entries() {
        let published =
            [(8, [71, 13, 96]), (60, [61, 78, 138]), (128, [33, 145, 140]), (245, [229, 228, 25])];
        for (index, color) in published {
            let found = viridis(f64::from(index) / 255.0);
            for (a, b) in found.into_iter().zip(color) {
                assert!(a.abs_diff(b) <= 7, "entry {index}: {found:?}, published {color:?}");
            }
        }
    }

    #[test]
    fn zero_is_black_and_the_largest_count_is_yellow() {
        assert_eq!(false_color(0, 9), [0, 0, 0]);
        assert_eq!(false_color(1, 9), viridis(0.0));
        assert_eq!(false_color(5, 9), viridis(0.5));
        assert_eq!(false_color(9, 9), viridis(1.0));
        assert_eq!(false_color(1, 1), viridis(0.0));
        assert_eq!(false_color(0, 0), [0, 0, 0]);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        false_color_png(&path, 3, 1, &[0, 1, 700]).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!(data, [0, 0, 0, 68, 1, 84, 253, 231, 37]);
        assert!(matches!(
            false_color_png(&path, 2, 1, &[0]),
            Err(ImageError::Size { expected: 2, found: 1, .. })
        ));
    }
}
