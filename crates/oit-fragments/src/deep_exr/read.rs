//! Reading a deep image.

use std::path::Path;

use rayon::prelude::*;

use super::header::{self, Header};
use super::{Channel, Compression, DeepExrError, LineOrder, Window, block};
use crate::deflate::may_hold;
use crate::{Fragment, Lfb};

/// What stands before a row: y, and the lengths of the table, of the samples, and of the samples
/// unpacked.
const ROW_RECORD: usize = 28;

/// Rows that are unpacked at a time, for each thread.
const BATCH: usize = 16;

/// What a deep image was, and what became of it.
#[derive(Clone, PartialEq, Debug)]
pub struct DeepInfo {
    /// The pixels there are: the buffer's.
    pub data_window: Window,
    /// The pixels the picture is meant to have. The buffer does not follow it.
    pub display_window: Window,
    /// How the rows were compressed.
    pub compression: Compression,
    /// The order in which the file has its rows. The buffer's are from the top in any case.
    pub line_order: LineOrder,
    /// The file's channels, in order of their names.
    pub channels: Vec<Channel>,
    /// The channels that were not read. With `ZBack` among them, samples had a back that is lost.
    pub skipped: Vec<String>,
    /// The channels of R, G, B and A that the file lacks: colour was taken to be 0, alpha 1.
    pub missing: Vec<String>,
    /// What the file says `Z` is, if it was written here ([`super::WINDOW_DEPTH`]).
    pub depth: Option<String>,
    /// The largest difference between a value of A, or of R, G and B (times alpha, as the file has
    /// them), and that of the fragment made from it. At most 0.004 from rounding (of both); more where alpha
    /// or a colour does not lie between 0 and 1.
    pub largest_error: f64,
}

impl DeepInfo {
    /// Whether samples filled ranges of depths, of which the buffer has the fronts.
    #[must_use]
    pub fn has_backs(&self) -> bool {
        self.skipped.iter().any(|name| name == "ZBack")
    }
}

/// Reads a deep image from a file.
///
/// # Errors
/// Where the file cannot be read, is of another kind, is damaged, or has a sample that no fragment
/// can have.
pub fn read(path: &Path) -> Result<(DeepInfo, Lfb), DeepExrError> {
    let read = || read_from(&std::fs::read(path)?);
    read().map_err(|error| error.of_file(path))
}

/// Reads a deep image from a file's bytes.
///
/// # Errors
/// As [`read()`].
pub fn read_from(file: &[u8]) -> Result<(DeepInfo, Lfb), DeepExrError> {
    let header = header::parse(file)?;
    let layout = Layout::new(&header.channels)?;
    let [width, height] = header.data_window.size().expect("checked with the header");
    let rows = find_rows(file, &header, width, height)?;

    // What the header says is not reserved: this grows with the rows that have been unpacked.
    let mut offsets = vec![0];
    let mut fragments = Vec::new();
    let mut largest_error = 0f64;
    for batch in rows.chunks(BATCH * rayon::current_num_threads()) {
        let unpacked: Vec<_> =
            batch.par_iter().map(|row| row.unpack(file, &layout, width as usize)).collect();
        for row in unpacked {
            let row = row?;
            let first = fragments.len();
            offsets.extend(row.ends.iter().map(|end| first + end));
            fragments.extend_from_slice(&row.fragments);
            largest_error = largest_error.max(row.largest_error);
        }
    }
    let lfb = Lfb::new(width, height, offsets, fragments).expect("each row's ends rise");
    let info = DeepInfo {
        data_window: header.data_window,
        display_window: header.display_window,
        compression: header.compression,
        line_order: header.line_order,
        skipped: layout.skipped,
        missing: layout.missing,
        channels: header.channels,
        depth: header.depth,
        largest_error,
    };
    Ok((info, lfb))
}

/// Where a row's samples are, for each channel that is read.
struct Layout {
    /// Red, green, blue and alpha: the bytes of one sample of all channels before it, and itself.
    colour: [Option<(usize, Channel)>; 4],
    depth: (usize, Channel),
    /// Bytes of one sample of all channels.
    sample_bytes: usize,
    skipped: Vec<String>,
    missing: Vec<String>,
}

const COLOUR: [&str; 4] = ["R", "G", "B", "A"];

impl Layout {
    fn new(channels: &[Channel]) -> Result<Self, DeepExrError> {
        let mut sample_bytes = 0;
        let mut skipped = Vec::new();
        let (mut colour, mut depth) = ([const { None }; 4], None);
        for channel in channels {
            let place = Some((sample_bytes, channel.clone()));
            sample_bytes += channel.sample_type.bytes();
            match COLOUR.iter().position(|&name| name == channel.name) {
                Some(i) => colour[i] = place,
                None if channel.name == "Z" => depth = place,
                None => skipped.push(channel.name.clone()),
            }
        }
        let Some(depth) = depth else {
            let found = channels.iter().map(|channel| channel.name.clone()).collect();
            return Err(DeepExrError::NoDepth { found });
        };
        let missing = COLOUR.iter().zip(&colour).filter(|(_, place)| place.is_none());
        let missing = missing.map(|(&name, _)| name.to_owned()).collect();
        Ok(Self { colour, depth, sample_bytes, skipped, missing })
    }
}

/// Where a row is in the file. Its lengths have been found possible.
struct Row {
    /// From the top.
    y: u32,
    /// The row's own start.
    offset: usize,
    counts_len: usize,
    samples_len: usize,
    /// Bytes of the samples unpacked.
    unpacked_len: usize,
    compression: Compression,
}

struct Unpacked {
    /// Of each pixel's fragments among the row's.
    ends: Vec<usize>,
    fragments: Vec<Fragment>,
    largest_error: f64,
}

/// Finds the rows by the table of offsets, and checks all lengths before anything is allocated.
fn find_rows(
    file: &[u8],
    header: &Header,
    width: u32,
    height: u32,
) -> Result<Vec<Row>, DeepExrError> {
    let damaged =
        |offset: usize, what: String| DeepExrError::Damaged { offset: offset as u64, what };
    let rest = &file[header.len..];
    let Some(table) = rest.as_chunks::<8>().0.get(..height as usize) else {
        let what = format!("a table of {height} rows, where {} bytes are left", rest.len());
        return Err(damaged(header.len, what));
    };
    let start = header.len + 8 * table.len();
    let counts_len = 4 * u64::from(width);
    let mut rows = Vec::with_capacity(table.len());
    for (y, &entry) in (0..height).zip(table) {
        let entry_at = header.len + 8 * y as usize;
        let offset = u64::from_le_bytes(entry);
        let row = usize::try_from(offset).ok().filter(|&offset| offset >= start);
        let Some((offset, record)) =
            row.and_then(|offset| Some((offset, file.get(offset..)?.first_chunk::<ROW_RECORD>()?)))
        else {
            return Err(damaged(entry_at, format!("row {y} is said to be at byte {offset}")));
        };
        let length = |at: usize| u64::from_le_bytes(*record[at..].first_chunk().expect("in it"));
        let found = i32::from_le_bytes(*record.first_chunk().expect("in it"));
        if i64::from(found) != i64::from(header.data_window.min[1]) + i64::from(y) {
            return Err(damaged(offset, format!("y is {found}, where row {y} belongs")));
        }
        let (counts, samples, unpacked) = (length(4), length(12), length(20));
        let left = (file.len() - offset - ROW_RECORD) as u64;
        if counts.checked_add(samples).is_none_or(|len| len > left) {
            let what = format!("row {y} has {counts} and {samples} bytes, {left} are left");
            return Err(damaged(offset, what));
        }
        let possible = |packed: u64, len: u64| match header.compression {
            Compression::None => packed == len,
            Compression::Zips => packed <= len && may_hold(packed, len),
        };
        if !possible(counts, counts_len) || !possible(samples, unpacked) {
            let what = format!(
                "row {y} has {counts} bytes for {counts_len} of counts and {samples} for {unpacked} of samples"
            );
            return Err(damaged(offset, what));
        }
        rows.push(Row {
            y,
            offset,
            counts_len: counts as usize,
            samples_len: samples as usize,
            unpacked_len: unpacked as usize,
            compression: header.compression,
        });
    }

    // Rows that share bytes would let a small file unpack to any size.
    let mut ends: Vec<_> = rows.iter().map(|row| (row.offset, row.end(), row.y)).collect();
    ends.sort_unstable();
    if let Some(pair) = ends.windows(2).find(|pair| pair[0].1 > pair[1].0) {
        let what = format!("row {} overlaps row {}", pair[1].2, pair[0].2);
        return Err(damaged(pair[1].0, what));
    }
    Ok(rows)
}

impl Row {
    fn end(&self) -> usize {
        self.offset + ROW_RECORD + self.counts_len + self.samples_len
    }

    fn unpack(&self, file: &[u8], layout: &Layout, width: usize) -> Result<Unpacked, DeepExrError> {
        let damaged = |what: String| DeepExrError::Damaged {
            offset: self.offset as u64,
            what: format!("row {}: {what}", self.y),
        };
        let (counts, samples) =
            file[self.offset + ROW_RECORD..self.end()].split_at(self.counts_len);

        let counts = self.unpack_block(counts, 4 * width).map_err(damaged)?;
        let mut ends = Vec::with_capacity(width);
        let mut last = 0;
        for (x, &end) in counts.as_chunks().0.iter().enumerate() {
            let end = i32::from_le_bytes(end);
            if end < last {
                return Err(damaged(format!("the running total falls to {end} at pixel {x}")));
            }
            last = end;
            ends.push(end as usize);
        }
        let total = last as usize;
        let expected = total as u64 * layout.sample_bytes as u64;
        if expected != self.unpacked_len as u64 {
            return Err(damaged(format!(
                "{total} samples are {expected} bytes, not {}",
                self.unpacked_len
            )));
        }

        let samples = self.unpack_block(samples, self.unpacked_len).map_err(damaged)?;
        let read = |(before, channel): &(usize, Channel), i: usize| {
            channel.sample_type.sample(&samples[before * total..], i)
        };
        let mut fragments = Vec::with_capacity(total);
        let mut largest_error = 0f64;
        for i in 0..total {
            let bad = |channel, value| {
                let x = ends.partition_point(|&end| end <= i);
                let sample = if x == 0 { i } else { i - ends[x - 1] };
                Err(DeepExrError::Value { x: x as u32, y: self.y, sample, channel, value })
            };
            let depth = read(&layout.depth, i);
            if depth.is_nan() {
                return bad("Z", depth);
            }
            let mut colour = [0.0, 0.0, 0.0, 1.0];
            for (channel, place) in layout.colour.iter().enumerate() {
                let Some(place) = place else { continue };
                colour[channel] = read(place, i);
                if !colour[channel].is_finite() {
                    return bad(COLOUR[channel], colour[channel]);
                }
            }
            let (rgba, error) = quantise(colour);
            largest_error = largest_error.max(error);
            fragments.push(Fragment::new(depth, rgba));
        }
        Ok(Unpacked { ends, fragments, largest_error })
    }

    fn unpack_block(&self, packed: &[u8], len: usize) -> Result<Vec<u8>, String> {
        match self.compression {
            Compression::None => Ok(packed.to_vec()),
            Compression::Zips => block::unpack(packed, len),
        }
    }
}

/// The 8-bit colour, not premultiplied, of a premultiplied one, and the largest difference between
/// the two as premultiplied values.
fn quantise(premultiplied: [f32; 4]) -> ([u8; 4], f64) {
    let [r, g, b, a] = premultiplied.map(f64::from);
    let round = |value: f64| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    // Light without cover has no colour that could be seen.
    let colour = |channel: f64| if a > 0.0 { round(channel / a) } else { 0 };
    let rgba = [colour(r), colour(g), colour(b), round(a)];
    let alpha = f64::from(rgba[3]) / 255.0;
    let error = |channel: f64, made: u8| (channel - f64::from(made) / 255.0 * alpha).abs();
    let largest = error(r, rgba[0]).max(error(g, rgba[1])).max(error(b, rgba[2]));
    (rgba, largest.max((a - alpha).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_colour_comes_back_but_at_alpha_0() {
        for a in 0..=255u8 {
            for c in 0..=255u8 {
                let (alpha, channel) = (f64::from(a) / 255.0, f64::from(c) / 255.0);
                let (rgba, error) = quantise([(channel * alpha) as f32, 0.0, 0.0, alpha as f32]);
                assert_eq!(rgba, [if a == 0 { 0 } else { c }, 0, 0, a]);
                assert!(error < 1e-7, "{c} {a}: {error}");
            }
        }
    }

    #[test]
    fn what_eight_bits_cannot_hold_is_said() {
        let (rgba, error) = quantise([0.25, 0.0, 0.0, 0.0]);
        assert_eq!((rgba, error), ([0, 0, 0, 0], 0.25));
        let (rgba, error) = quantise([3.0, 0.0, -1.0, 1.0]);
        assert_eq!((rgba, error), ([255, 0, 0, 255], 2.0));
        let (rgba, error) = quantise([0.0, 0.0, 0.0, 1.5]);
        assert_eq!((rgba, error), ([0, 0, 0, 255], 0.5));
        // Half a step, from rounding alpha alone: the colour is white.
        let (_, error) = quantise([0.5, 0.5, 0.5, 0.5]);
        assert!(error > 0.0019 && error < 0.002, "{error}");
    }
}
