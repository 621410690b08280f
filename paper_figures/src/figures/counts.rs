//! The map of fragment counts beside a record, in `counts/SCENE_VIEW_WIDTHxHEIGHT.png`: 16-bit grey,
//! one value a pixel.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use analysis::{RunInfo, Tables};
use oit_record::Cell;

use crate::FigureError;
use crate::data::{Group, groups};

/// What a view's map of counts says.
pub(super) struct Counts {
    /// Fragments of each pixel, row by row.
    pub(super) pixels: Vec<u16>,
    /// The most.
    pub(super) peak: u16,
    /// Their mean over all pixels.
    pub(super) mean: f64,
    /// Pixels without any.
    pub(super) empty_px: usize,
}

/// Where the counts of a cell's view lie.
fn path(run: &RunInfo, cell: &Cell) -> PathBuf {
    let name = format!("{}_{}_{}x{}", cell.scene, cell.view, cell.width_px, cell.height_px);
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    run.folder.join("counts").join(name + ".png")
}

/// The views that have a map of counts, from the run that speaks for each.
pub(super) fn views(tables: &Tables) -> Vec<Group<'_>> {
    // Asked once a view, not once a cell.
    let mut known: BTreeMap<(usize, String), bool> = BTreeMap::new();
    for cell in &tables.results {
        let exists = || path(&tables.runs[cell.run], &cell.name).exists();
        known.entry((cell.run, cell.name.group())).or_insert_with(exists);
    }
    groups(tables, |cell| known.get(&(cell.run, cell.name.group())).copied().unwrap_or(false))
}

/// Reads the counts of a group; nothing where there is no such file.
///
/// # Errors
/// Where the file is damaged or of another size.
pub(super) fn read(group: &Group) -> Result<Option<Counts>, FigureError> {
    let Some(cell) = group.cells.first() else { return Ok(None) };
    let path = path(group.run, &cell.name);
    if !path.exists() {
        return Ok(None);
    }
    let wrong = |reason: String| FigureError::Sidecar { path: path.clone(), reason };
    let file = File::open(&path).map_err(|error| wrong(error.to_string()))?;
    let decoder = png::Decoder::new(BufReader::new(file));
    let mut reader = decoder.read_info().map_err(|error| wrong(error.to_string()))?;
    let (width, height) = (reader.info().width, reader.info().height);
    if (width, height) != (group.width_px, group.height_px) {
        let (wide, high) = (group.width_px, group.height_px);
        return Err(wrong(format!("{width} x {height} px, the record has {wide} x {high}")));
    }
    if reader.output_color_type() != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(wrong("not 16-bit grey".to_owned()));
    }
    let size = reader.output_buffer_size().ok_or_else(|| wrong("too large".to_owned()))?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|error| wrong(error.to_string()))?;
    let pixels: Vec<u16> =
        bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    let total: u64 = pixels.iter().map(|&count| u64::from(count)).sum();
    Ok(Some(Counts {
        peak: pixels.iter().copied().max().unwrap_or(0),
        mean: total as f64 / pixels.len().max(1) as f64,
        empty_px: pixels.iter().filter(|&&count| count == 0).count(),
        pixels,
    }))
}
