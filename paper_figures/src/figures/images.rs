//! The pictures that are kept beside a record, in `images/`: `.picture.png` and `.detail.png`, 8-bit RGB,
//! and `.error.png`, 16-bit grey in 255ths.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use analysis::RunInfo;
use oit_image::false_color;
use oit_record::Cell;

use crate::FigureError;
use crate::canvas::Colour;
use crate::chart::Picture;

/// The pictures of one cell.
pub(super) struct Images {
    /// The picture as a whole, scaled down.
    pub(super) picture: Rgb,
    /// A detail of it, pixel by pixel.
    pub(super) detail: Rgb,
    /// The largest errors of blocks of pixels, in 255ths.
    pub(super) error: Errors,
}

/// An RGB picture.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Rgb {
    /// Pixels a row.
    pub(super) width: usize,
    /// Three bytes a pixel, row by row.
    pub(super) bytes: Vec<u8>,
}

/// A map of errors.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Errors {
    /// Values a row.
    pub(super) width: usize,
    /// 255ths, row by row.
    pub(super) values: Vec<u16>,
}

/// The error, in 255ths, from which a map has its brightest colour.
const BRIGHTEST: u16 = 32;

impl Rgb {
    /// Whether all of it is of one colour: there is nothing to be seen.
    pub(super) fn is_blank(&self) -> bool {
        let mut pixels = self.bytes.chunks_exact(3);
        let first = pixels.next();
        pixels.all(|pixel| Some(pixel) == first)
    }

    /// The picture for a chart.
    pub(super) fn titled(self, title: &str) -> Picture {
        Picture { title: title.to_owned(), width: self.width, rgb: self.bytes }
    }
}

impl Errors {
    /// The map for a chart, in the colours of [`error_scale`].
    pub(super) fn map(self, title: &str) -> Picture {
        let colour = |error: u16| false_color(u32::from(error.min(BRIGHTEST)), BRIGHTEST.into());
        let rgb = self.values.into_iter().flat_map(colour).collect();
        Picture { title: title.to_owned(), width: self.width, rgb }
    }
}

/// The colours of maps of errors, and what their ends mean.
pub(super) fn error_scale() -> (Vec<Colour>, [String; 2]) {
    let colours = (0..BRIGHTEST).map(|step| {
        let [red, green, blue] = false_color(u32::from(step) + 1, BRIGHTEST.into());
        Colour(red, green, blue)
    });
    let ends = [
        "Errors: black none, then 1/255".to_owned(),
        format!("{BRIGHTEST}/255 and more, of a colour channel"),
    ];
    (colours.collect(), ends)
}

/// The least side of square blocks that a frame so wide was divided into.
pub(super) fn block_px(frame_width: u32, width: usize) -> u32 {
    let width = u32::try_from(width).unwrap_or(u32::MAX).max(1);
    (1..=frame_width).find(|&side| frame_width.div_ceil(side) <= width).unwrap_or(1)
}

/// The picture of a cell that broke, and the right one.
pub(super) struct BreakImages {
    /// The picture as a whole, scaled down where it is large.
    pub(super) picture: Rgb,
    /// The right picture, likewise.
    pub(super) right: Rgb,
}

/// Where a picture of a cell lies, if it was kept.
fn path_of(run: &RunInfo, cell: &Cell, ending: &str) -> PathBuf {
    let Cell { technique, scene, view, width_px, height_px } = cell;
    let name = format!("{scene}_{view}_{width_px}x{height_px}_{technique}");
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    run.folder.join("images").join(format!("{name}.{ending}.png"))
}

/// Whether pictures of a cell were kept.
pub(super) fn are_kept(run: &RunInfo, cell: &Cell) -> bool {
    path_of(run, cell, "picture").exists()
}

/// An RGB picture of a cell.
fn rgb_of(run: &RunInfo, cell: &Cell, ending: &str) -> Result<Rgb, FigureError> {
    let path = path_of(run, cell, ending);
    let (width, bytes) = decode(path, (png::ColorType::Rgb, png::BitDepth::Eight))?;
    Ok(Rgb { width, bytes })
}

/// The picture of a cell that broke, beside the right one, if they were kept.
///
/// # Errors
/// Where a file is missing beside the other, or damaged.
pub(super) fn read_break(run: &RunInfo, cell: &Cell) -> Result<Option<BreakImages>, FigureError> {
    if !path_of(run, cell, "right").exists() {
        return Ok(None);
    }
    let [picture, right] = [rgb_of(run, cell, "picture")?, rgb_of(run, cell, "right")?];
    Ok(Some(BreakImages { picture, right }))
}

/// The pictures of a cell, if they were kept.
///
/// # Errors
/// Where a file is missing beside the others, or damaged.
pub(super) fn read(run: &RunInfo, cell: &Cell) -> Result<Option<Images>, FigureError> {
    if !path_of(run, cell, "picture").exists() {
        return Ok(None);
    }
    let rgb = |ending: &str| rgb_of(run, cell, ending);
    let grey = (png::ColorType::Grayscale, png::BitDepth::Sixteen);
    let (width, bytes) = decode(path_of(run, cell, "error"), grey)?;
    let values = bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    let error = Errors { width, values };
    Ok(Some(Images { picture: rgb("picture")?, detail: rgb("detail")?, error }))
}

/// The width and bytes of a PNG file of this kind.
fn decode(
    path: PathBuf,
    kind: (png::ColorType, png::BitDepth),
) -> Result<(usize, Vec<u8>), FigureError> {
    let wrong = |reason: String| FigureError::Sidecar { path: path.clone(), reason };
    let file = File::open(&path).map_err(|error| wrong(error.to_string()))?;
    let decoder = png::Decoder::new(BufReader::new(file));
    let mut reader = decoder.read_info().map_err(|error| wrong(error.to_string()))?;
    if reader.output_color_type() != kind {
        return Err(wrong(format!("not {:?} with {:?} bits", kind.0, kind.1)));
    }
    let size = reader.output_buffer_size().ok_or_else(|| wrong("too large".to_owned()))?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|error| wrong(error.to_string()))?;
    Ok((reader.info().width as usize, bytes))
}
