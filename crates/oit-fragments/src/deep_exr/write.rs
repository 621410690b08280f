//! Writing a deep image.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use rayon::prelude::*;

use super::{Compression, DeepExrError, block, header};
use crate::Lfb;
use crate::atomic::write_atomically;

/// In the order in which a row has them.
const CHANNELS: [&str; 5] = ["A", "B", "G", "R", "Z"];

const SAMPLE_BYTES: usize = 4 * CHANNELS.len();

/// The OpenEXR library reads no row of more than 2 GiB.
const MAX_ROW_SAMPLES: usize = i32::MAX as usize / SAMPLE_BYTES;

/// Rows that are packed at a time, for each thread.
const BATCH: usize = 16;

/// Writes a buffer as a deep image, whole or not at all.
///
/// # Errors
/// Where the file is there and `overwrite` is not set ([`std::io::ErrorKind::AlreadyExists`]) or
/// cannot be written, the buffer has no pixels or too many for the format, or a depth is NaN. The
/// file then is as it was.
pub fn write(
    path: &Path,
    lfb: &Lfb,
    compression: Compression,
    overwrite: bool,
) -> Result<(), DeepExrError> {
    write_atomically(path, overwrite, |file| write_to(file, lfb, compression))
        .map_err(|error: DeepExrError| error.of_file(path))
}

/// Writes a buffer as a deep image, from the output's start.
///
/// # Errors
/// As [`write()`].
pub fn write_to(
    mut out: impl Write + Seek,
    lfb: &Lfb,
    compression: Compression,
) -> Result<(), DeepExrError> {
    let (width, height) = (lfb.width(), lfb.height());
    let (Ok(columns), Ok(rows)) = (i32::try_from(width), i32::try_from(height)) else {
        return Err(DeepExrError::Size { width, height });
    };
    if columns == 0 || rows == 0 {
        return Err(DeepExrError::Size { width, height });
    }
    for row in 0..height {
        let first = row as usize * width as usize;
        let samples = lfb.offsets()[first + width as usize] - lfb.offsets()[first];
        if samples > MAX_ROW_SAMPLES {
            return Err(DeepExrError::RowTooLarge { row, samples, max: MAX_ROW_SAMPLES });
        }
    }

    let peak = lfb.counts().max().unwrap_or(0) as i32;
    let header = header::build(&CHANNELS, compression, [columns, rows], peak);
    out.write_all(&header)?;
    // The rows' offsets are known only when they are packed.
    out.write_all(&vec![0; 8 * height as usize])?;
    let mut end = (header.len() + 8 * height as usize) as u64;
    let mut offsets = Vec::with_capacity(8 * height as usize);
    let rows: Vec<u32> = (0..height).collect();
    for batch in rows.chunks(BATCH * rayon::current_num_threads()) {
        let packed: Vec<_> = batch.par_iter().map(|&row| pack_row(lfb, row, compression)).collect();
        for row in packed {
            let row = row?;
            offsets.extend(end.to_le_bytes());
            end += row.len() as u64;
            out.write_all(&row)?;
        }
    }
    out.seek(SeekFrom::Start(header.len() as u64))?;
    out.write_all(&offsets)?;
    out.flush()?;
    Ok(())
}

/// One row as it stands in the file.
fn pack_row(lfb: &Lfb, row: u32, compression: Compression) -> Result<Vec<u8>, DeepExrError> {
    let width = lfb.width() as usize;
    let first = row as usize * width;
    let offsets = &lfb.offsets()[first..=first + width];
    let fragments = &lfb.fragments()[offsets[0]..offsets[width]];

    // The table has running totals, not counts.
    let counts: Vec<u8> =
        offsets[1..].iter().flat_map(|end| ((end - offsets[0]) as u32).to_le_bytes()).collect();
    let mut samples = vec![0; SAMPLE_BYTES * fragments.len()];
    for (i, fragment) in fragments.iter().enumerate() {
        let depth = fragment.depth();
        if depth.is_nan() {
            let x = offsets.partition_point(|&offset| offset <= offsets[0] + i) - 1;
            return Err(DeepExrError::Value {
                x: x as u32,
                y: row,
                sample: offsets[0] + i - offsets[x],
                channel: "Z",
                value: depth,
            });
        }
        let [r, g, b, a] = fragment.rgba8().map(|channel| f64::from(channel) / 255.0);
        let values = [a as f32, (b * a) as f32, (g * a) as f32, (r * a) as f32, depth];
        for (channel, value) in values.into_iter().enumerate() {
            let at = 4 * (channel * fragments.len() + i);
            samples[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
    }

    let unpacked_len = samples.len() as u64;
    let (counts, samples) = match compression {
        Compression::None => (counts, samples),
        Compression::Zips => (block::pack(counts), block::pack(samples)),
    };
    let mut out = Vec::with_capacity(28 + counts.len() + samples.len());
    out.extend(row.to_le_bytes());
    out.extend((counts.len() as u64).to_le_bytes());
    out.extend((samples.len() as u64).to_le_bytes());
    out.extend(unpacked_len.to_le_bytes());
    out.extend(counts);
    out.extend(samples);
    Ok(out)
}
