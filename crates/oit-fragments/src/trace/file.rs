//! The file around the chunks: start, records, end.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Write};
use std::path::Path;

use rayon::prelude::*;

use super::chunk::{self, Form, MAX_FRAGMENTS, MAX_PIXELS};
use super::{TRACE_VERSION, TraceError, TraceInfo};
use crate::atomic::write_atomically;
use crate::deflate::may_hold;
use crate::{Fragment, Lfb};

/// As PNG's: neither text nor UTF-8, and a transfer that changes line ends damages it.
const MAGIC: [u8; 8] = *b"\x89OITT\r\n\x1a";

/// Longest header. Ours have a few hundred bytes.
const MAX_HEADER: usize = 1 << 16;

const CHUNK_TAG: [u8; 4] = *b"CHNK";
const END_TAG: [u8; 4] = *b"END.";
const CHUNK_RECORD: usize = 40;
const END_RECORD: usize = 36;

/// Chunks that are packed or unpacked at a time, for each thread.
const BATCH: usize = 8;

/// Writes a trace to a file, whole or not at all.
///
/// # Errors
/// Where the file is there and `overwrite` is not set ([`ErrorKind::AlreadyExists`]), cannot be
/// written, or the sizes in `info` are not those of the buffer. The file then is as it was.
pub fn save(path: &Path, info: &TraceInfo, lfb: &Lfb, overwrite: bool) -> Result<(), TraceError> {
    write_atomically(path, overwrite, |file| save_to(file, info, lfb))
        .map_err(|error: TraceError| error.of_file(path))
}

/// Reads a trace from a file and checks all of it.
///
/// # Errors
/// Where the file cannot be read, is no trace, is of another version, or is damaged anywhere.
pub fn load(path: &Path) -> Result<(TraceInfo, Lfb), TraceError> {
    let load = || load_from(BufReader::with_capacity(1 << 20, File::open(path)?));
    load().map_err(|error| error.of_file(path))
}

/// Reads and checks the header of a trace alone.
///
/// # Errors
/// Where the file cannot be read, or its start is not that of an undamaged trace.
pub fn info(path: &Path) -> Result<TraceInfo, TraceError> {
    let info = || info_from(BufReader::new(File::open(path)?));
    info().map_err(|error| error.of_file(path))
}

/// Writes a trace; several small writes a chunk.
///
/// # Errors
/// As [`save`].
pub fn save_to(mut out: impl Write, info: &TraceInfo, lfb: &Lfb) -> Result<(), TraceError> {
    info.check(lfb)?;
    for (pixel, ends) in lfb.offsets().windows(2).enumerate() {
        let fragments = ends[1] - ends[0];
        if u32::try_from(fragments).is_err() {
            return Err(TraceError::PixelTooDeep { pixel, fragments });
        }
    }

    let header = serde_json::to_vec(info).expect("a header of texts and numbers");
    if header.len() > MAX_HEADER {
        return Err(TraceError::HeaderTooLong { bytes: header.len(), max: MAX_HEADER });
    }
    let mut start = MAGIC.to_vec();
    start.extend(TRACE_VERSION.to_le_bytes());
    start.extend((header.len() as u32).to_le_bytes());
    start.extend(header);
    seal(&mut start);
    out.write_all(&start)?;
    let mut length = start.len() as u64;

    let ranges = chunk::ranges(lfb);
    let mut checksums = crc32fast::Hasher::new();
    for batch in ranges.chunks(BATCH * rayon::current_num_threads()) {
        let packed: Vec<_> =
            batch.par_iter().map(|range| chunk::pack(lfb, range.clone())).collect();
        for (range, packed) in batch.iter().zip(packed) {
            let fragments = lfb.offsets()[range.end] - lfb.offsets()[range.start];
            let payload_checksum = crc32fast::hash(&packed.payload);
            checksums.update(&payload_checksum.to_le_bytes());
            let mut record = CHUNK_TAG.to_vec();
            record.extend((range.start as u64).to_le_bytes());
            record.extend((range.len() as u32).to_le_bytes());
            record.extend((fragments as u32).to_le_bytes());
            record.extend(packed.form.bits().to_le_bytes());
            record.extend((packed.payload.len() as u64).to_le_bytes());
            record.extend(payload_checksum.to_le_bytes());
            seal(&mut record);
            out.write_all(&record)?;
            out.write_all(&packed.payload)?;
            length += (record.len() + packed.payload.len()) as u64;
        }
    }

    let mut end = END_TAG.to_vec();
    end.extend((ranges.len() as u64).to_le_bytes());
    end.extend((lfb.fragments().len() as u64).to_le_bytes());
    end.extend(length.to_le_bytes());
    end.extend(checksums.finalize().to_le_bytes());
    seal(&mut end);
    out.write_all(&end)?;
    Ok(())
}

/// Reads and checks the header of a trace alone.
///
/// # Errors
/// As [`info`].
pub fn info_from(input: impl Read) -> Result<TraceInfo, TraceError> {
    Source { input, offset: 0 }.start()
}

/// Reads a trace to the end of the input and checks all of it.
///
/// # Errors
/// As [`load`].
pub fn load_from(input: impl Read) -> Result<(TraceInfo, Lfb), TraceError> {
    let mut source = Source { input, offset: 0 };
    let info = source.start()?;
    let pixels = u64::from(info.width_px) * u64::from(info.height_px);

    // What the header says is not reserved: everything grows with what has really been read.
    let mut offsets = vec![0];
    let mut fragments: Vec<Fragment> = Vec::new();
    let mut peak = 0;
    let (mut chunks, mut pixels_read, mut fragments_read) = (0u64, 0u64, 0u64);
    let mut checksums = crc32fast::Hasher::new();
    let mut batch = Vec::new();
    while pixels_read < pixels {
        let chunk = source.chunk(pixels_read, pixels, info.fragments - fragments_read)?;
        chunks += 1;
        pixels_read += chunk.pixels as u64;
        fragments_read += chunk.fragments as u64;
        checksums.update(&chunk.checksum.to_le_bytes());
        batch.push(chunk);
        if batch.len() < BATCH * rayon::current_num_threads() && pixels_read < pixels {
            continue;
        }
        let unpacked: Vec<_> =
            std::mem::take(&mut batch).into_par_iter().map(Chunk::unpack).collect();
        for unpacked in unpacked {
            let (counts, own) = unpacked?;
            let mut end = fragments.len();
            offsets.extend(counts.iter().map(|&count| {
                end += count as usize;
                end
            }));
            peak = counts.into_iter().fold(peak, u32::max);
            fragments.extend_from_slice(&own);
        }
    }
    source.end(chunks, fragments_read, checksums.finalize())?;
    if (fragments_read, peak) != (info.fragments, info.peak) {
        return Err(TraceError::Damaged {
            offset: 0,
            what: format!(
                "the header says {} fragments and a peak of {}, there are {fragments_read} and {peak}",
                info.fragments, info.peak
            ),
        });
    }
    let lfb = Lfb::new(info.width_px, info.height_px, offsets, fragments)
        .expect("offsets are sums of counts");
    Ok((info, lfb))
}

/// Ends a record with its checksum.
fn seal(record: &mut Vec<u8>) {
    record.extend(crc32fast::hash(record).to_le_bytes());
}

/// Whether a record ends with its checksum.
fn is_sealed(record: &[u8]) -> bool {
    record
        .split_last_chunk()
        .is_some_and(|(rest, seal)| *seal == crc32fast::hash(rest).to_le_bytes())
}

/// Takes integers from the front of a record of a fixed size.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().expect("a record has all its fields");
        self.0 = rest;
        *first
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }
}

/// A chunk as it was read: its payload has the right checksum.
struct Chunk {
    offset: u64,
    form: Form,
    pixels: usize,
    fragments: usize,
    payload: Vec<u8>,
    checksum: u32,
}

impl Chunk {
    fn unpack(self) -> Result<(Vec<u32>, Vec<Fragment>), TraceError> {
        chunk::unpack(self.form, &self.payload, self.pixels, self.fragments).map_err(|what| {
            TraceError::Damaged { offset: self.offset, what: format!("chunk: {what}") }
        })
    }
}

/// The input, and how much of it has been read.
struct Source<R> {
    input: R,
    offset: u64,
}

impl<R: Read> Source<R> {
    /// Reads so many bytes; no more is allocated than twice what is there.
    fn bytes(&mut self, len: u64, what: &str) -> Result<Vec<u8>, TraceError> {
        let mut bytes = Vec::new();
        let read = self.input.by_ref().take(len).read_to_end(&mut bytes)? as u64;
        if read < len {
            let what = format!("the file ends in {what}, after {read} of {len} bytes");
            return Err(TraceError::Damaged { offset: self.offset, what });
        }
        self.offset += len;
        Ok(bytes)
    }

    fn start(&mut self) -> Result<TraceInfo, TraceError> {
        let damaged = |what: String| TraceError::Damaged { offset: 0, what };
        let mut start = self.bytes(16, "the start")?;
        let mut fields = Fields(&start);
        let (magic, version, len) = (fields.take(), fields.u32(), fields.u32());
        if magic != MAGIC {
            return Err(TraceError::NotATrace { found: magic });
        }
        if version != TRACE_VERSION {
            return Err(TraceError::Version { found: version });
        }
        if len as usize > MAX_HEADER {
            return Err(damaged(format!("a header of {len} bytes, more than {MAX_HEADER}")));
        }
        start.extend(self.bytes(u64::from(len) + 4, "the header")?);
        if !is_sealed(&start) {
            return Err(damaged("the header's checksum is wrong".to_owned()));
        }
        serde_json::from_slice(&start[16..start.len() - 4])
            .map_err(|error| damaged(format!("the header: {error}")))
    }

    /// Reads the chunk that begins at this pixel of so many, and has at most so many fragments.
    fn chunk(&mut self, first: u64, pixels: u64, most: u64) -> Result<Chunk, TraceError> {
        let offset = self.offset;
        let damaged = |what: String| Err(TraceError::Damaged { offset, what });
        let record = self.bytes(CHUNK_RECORD as u64, "a chunk's record")?;
        let mut fields = Fields(&record);
        if fields.take() != CHUNK_TAG || !is_sealed(&record) {
            return damaged(format!("no undamaged record of the chunk of pixel {first}"));
        }
        let found = fields.u64();
        let (own_pixels, own_fragments, form) = (fields.u32(), fields.u32(), fields.u32());
        let (len, checksum) = (fields.u64(), fields.u32());
        let Some(form) = Form::from_bits(form) else {
            return damaged(format!("unknown form {form}"));
        };
        let too_large = own_pixels as usize > MAX_PIXELS
            || (own_pixels > 1 && own_fragments as usize > MAX_FRAGMENTS);
        if found != first || own_pixels == 0 || u64::from(own_pixels) > pixels - first || too_large
        {
            return damaged(format!(
                "{own_pixels} pixels from pixel {found} with {own_fragments} fragments, where the chunk of pixel {first} of {pixels} belongs"
            ));
        }
        if u64::from(own_fragments) > most {
            return damaged("more fragments than the header says".to_owned());
        }
        let planes = chunk::planes_len(own_pixels.into(), own_fragments.into());
        if len > chunk::max_packed_len(planes) || !may_hold(len, planes) {
            return damaged(format!("{len} bytes for a chunk of {planes}"));
        }
        let payload = self.bytes(len, "a chunk")?;
        if crc32fast::hash(&payload) != checksum {
            return Err(TraceError::Damaged {
                offset: offset + CHUNK_RECORD as u64,
                what: format!("the checksum of the chunk of pixel {first} is wrong"),
            });
        }
        Ok(Chunk {
            offset,
            form,
            pixels: own_pixels as usize,
            fragments: own_fragments as usize,
            payload,
            checksum,
        })
    }

    fn end(&mut self, chunks: u64, fragments: u64, checksums: u32) -> Result<(), TraceError> {
        let offset = self.offset;
        let damaged =
            |offset, what: &str| Err(TraceError::Damaged { offset, what: what.to_owned() });
        let record = self.bytes(END_RECORD as u64, "the end's record")?;
        let mut fields = Fields(&record);
        if fields.take() != END_TAG || !is_sealed(&record) {
            return damaged(offset, "no undamaged record of the end");
        }
        let found = (fields.u64(), fields.u64(), fields.u64(), fields.u32());
        if found != (chunks, fragments, offset, checksums) {
            return damaged(offset, "the end's record does not fit what came before");
        }
        let mut more = [0];
        loop {
            match self.input.read(&mut more) {
                Ok(0) => return Ok(()),
                Ok(_) => return damaged(self.offset, "there are bytes after the end"),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}
