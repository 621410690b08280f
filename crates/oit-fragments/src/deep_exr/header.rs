//! The start of a file: magic, version field, attributes.

use super::{Channel, DeepExrError, SampleType};

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The format's version, in the lowest byte of the version field.
const VERSION: u32 = 2;
const TILED: u32 = 0x200;
const LONG_NAMES: u32 = 0x400;
const NON_IMAGE: u32 = 0x800;
const MULTI_PART: u32 = 0x1000;

/// How rows are compressed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Compression {
    /// Not at all.
    None,
    /// zlib, each row for itself.
    #[default]
    Zips,
}

impl Compression {
    fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Zips => 2,
        }
    }
}

/// In which order a file has its rows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LineOrder {
    /// From the top.
    Increasing,
    /// From the bottom.
    Decreasing,
    /// In any order.
    Random,
}

/// A rectangle of pixels, its ends included; y points down.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Window {
    /// The top left pixel, x and y.
    pub min: [i32; 2],
    /// The bottom right pixel, x and y.
    pub max: [i32; 2],
}

impl Window {
    /// Columns and rows, where there are both.
    #[must_use]
    pub fn size(&self) -> Option<[u32; 2]> {
        let side = |i: usize| {
            let side = i64::from(self.max[i]) - i64::from(self.min[i]) + 1;
            u32::try_from(side).ok().filter(|&side| side > 0)
        };
        Some([side(0)?, side(1)?])
    }
}

/// What reading needs of a header.
pub(super) struct Header {
    pub(super) channels: Vec<Channel>,
    pub(super) compression: Compression,
    pub(super) line_order: LineOrder,
    pub(super) data_window: Window,
    pub(super) display_window: Window,
    /// What the file says of its depths.
    pub(super) depth: Option<String>,
    /// Bytes from the start of the file to the end of the header.
    pub(super) len: usize,
}

/// Some of the file's bytes, and how many of them have been taken.
struct Bytes<'a> {
    bytes: &'a [u8],
    /// Of the first of `bytes` in the file.
    base: usize,
    taken: usize,
}

impl<'a> Bytes<'a> {
    fn damaged(&self, what: impl Into<String>) -> DeepExrError {
        DeepExrError::Damaged { offset: (self.base + self.taken) as u64, what: what.into() }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.taken..]
    }

    fn slice(&mut self, len: usize, what: &str) -> Result<&'a [u8], DeepExrError> {
        let Some(slice) = self.rest().get(..len) else {
            let left = self.rest().len();
            return Err(self.damaged(format!("{what} of {len} bytes, where {left} are left")));
        };
        self.taken += len;
        Ok(slice)
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], DeepExrError> {
        Ok(*self.slice(N, what)?.first_chunk().expect("a slice of that length"))
    }

    fn i32(&mut self, what: &str) -> Result<i32, DeepExrError> {
        Ok(i32::from_le_bytes(self.array(what)?))
    }

    /// Text up to a zero byte, empty where that comes first.
    fn name(&mut self, max: usize, what: &str) -> Result<&'a str, DeepExrError> {
        let Some(len) = self.rest().iter().take(max + 1).position(|&byte| byte == 0) else {
            return Err(self.damaged(format!("{what} longer than {max} bytes or without an end")));
        };
        let Ok(name) = std::str::from_utf8(&self.rest()[..len]) else {
            return Err(self.damaged(format!("{what} that is no text")));
        };
        self.taken += len + 1;
        Ok(name)
    }
}

/// Reads the start of a file.
pub(super) fn parse(file: &[u8]) -> Result<Header, DeepExrError> {
    let mut bytes = Bytes { bytes: file, base: 0, taken: 0 };
    if !file.starts_with(&MAGIC) {
        return Err(DeepExrError::NotExr { found: file[..file.len().min(4)].to_vec() });
    }
    bytes.taken = 4;
    let field = u32::from_le_bytes(bytes.array("the version field")?);
    let unsupported = |found: String| Err(DeepExrError::Unsupported { found });
    if field & 0xff != VERSION {
        return unsupported(format!("a file of version {}", field & 0xff));
    }
    if field & MULTI_PART != 0 {
        return unsupported("a file of several parts".to_owned());
    }
    if field & !(0xff | TILED | LONG_NAMES | NON_IMAGE) != 0 {
        return unsupported(format!("a file with the version field {field:#x}"));
    }
    if field & NON_IMAGE == 0 {
        let kind = if field & TILED == 0 { "scanline" } else { "tiled" };
        return unsupported(format!("a flat {kind} image"));
    }
    let max_name = if field & LONG_NAMES == 0 { 31 } else { 255 };

    let mut seen = std::collections::BTreeSet::new();
    let mut kind = None;
    let (mut channels, mut compression, mut line_order) = (None, None, None);
    let (mut data_window, mut display_window, mut version) = (None, None, None);
    let (mut chunks, mut depth) = (None, None);
    loop {
        let at = bytes.taken;
        let name = bytes.name(max_name, "an attribute's name")?;
        if name.is_empty() {
            break;
        }
        if !seen.insert(name) {
            bytes.taken = at;
            return Err(bytes.damaged(format!("a second attribute {name}")));
        }
        let type_name = bytes.name(max_name, "an attribute's type")?;
        let Ok(len) = usize::try_from(bytes.i32("an attribute's length")?) else {
            return Err(bytes.damaged(format!("the attribute {name} has a negative length")));
        };
        let base = bytes.taken;
        let value = bytes.slice(len, &format!("the attribute {name}"))?;
        let mut value = Bytes { bytes: value, base, taken: 0 };
        let expected = match name {
            "channels" => "chlist",
            "compression" => "compression",
            "lineOrder" => "lineOrder",
            "dataWindow" | "displayWindow" => "box2i",
            "version" | "chunkCount" => "int",
            "type" => "string",
            super::DEPTH_ATTRIBUTE if type_name == "string" => "string",
            // What other attributes say is of no account here.
            _ => continue,
        };
        if type_name != expected {
            return Err(value.damaged(format!("the attribute {name} is of type {type_name}")));
        }
        match name {
            "channels" => channels = Some(parse_channels(&mut value)?),
            "compression" => compression = Some(value.array::<1>(name)?[0]),
            "lineOrder" => line_order = Some(value.array::<1>(name)?[0]),
            "dataWindow" => data_window = Some(parse_window(&mut value)?),
            "displayWindow" => display_window = Some(parse_window(&mut value)?),
            "version" => version = Some(value.i32(name)?),
            "chunkCount" => chunks = Some(value.i32(name)?),
            "type" => kind = Some(String::from_utf8_lossy(value.slice(len, name)?)),
            _ => depth = Some(String::from_utf8_lossy(value.slice(len, name)?).into_owned()),
        }
        if !value.rest().is_empty() {
            return Err(value.damaged(format!("the attribute {name} is too long")));
        }
    }

    let missing = |name: &str| bytes.damaged(format!("the header ends without {name}"));
    match kind.as_deref() {
        Some("deepscanline") if field & TILED == 0 => {}
        Some("deeptile") => return unsupported("a tiled deep image".to_owned()),
        Some(other) => return unsupported(format!("an image of type {other}")),
        None => return Err(missing("type")),
    }
    match version {
        Some(1) => {}
        Some(other) => return unsupported(format!("deep data of version {other}")),
        None => return Err(missing("version")),
    }
    let compression = match compression.ok_or_else(|| missing("compression"))? {
        0 => Compression::None,
        2 => Compression::Zips,
        other => return unsupported(format!("compression {}", compression_name(other))),
    };
    let line_order = match line_order.ok_or_else(|| missing("lineOrder"))? {
        0 => LineOrder::Increasing,
        1 => LineOrder::Decreasing,
        2 => LineOrder::Random,
        other => return Err(bytes.damaged(format!("there is no line order {other}"))),
    };
    let data_window = data_window.ok_or_else(|| missing("dataWindow"))?;
    let Some([_, height]) = data_window.size() else {
        return Err(bytes.damaged("the data window has no pixels"));
    };
    if chunks.is_some_and(|chunks| i64::from(chunks) != i64::from(height)) {
        return Err(bytes.damaged(format!("chunkCount is not the {height} rows there are")));
    }
    Ok(Header {
        channels: channels.ok_or_else(|| missing("channels"))?,
        compression,
        line_order,
        data_window,
        display_window: display_window.ok_or_else(|| missing("displayWindow"))?,
        depth,
        len: bytes.taken,
    })
}

fn parse_window(value: &mut Bytes) -> Result<Window, DeepExrError> {
    let mut corner = || Ok::<_, DeepExrError>([value.i32("a window")?, value.i32("a window")?]);
    Ok(Window { min: corner()?, max: corner()? })
}

fn parse_channels(value: &mut Bytes) -> Result<Vec<Channel>, DeepExrError> {
    let mut channels: Vec<Channel> = Vec::new();
    loop {
        let name = value.name(255, "a channel's name")?;
        if name.is_empty() {
            return Ok(channels);
        }
        let code = value.i32("a channel's type")?;
        let Some(sample_type) = SampleType::from_code(code as u32) else {
            return Err(value.damaged(format!("channel {name} is of the unknown type {code}")));
        };
        let _perceptually_linear: [u8; 4] = value.array("a channel")?;
        let sampling = [value.i32("a channel's sampling")?, value.i32("a channel's sampling")?];
        if sampling != [1, 1] {
            let what = format!("channel {name} is sampled every {sampling:?} pixels");
            return Err(value.damaged(what));
        }
        // A row has its channels in the order of their names.
        if channels.last().is_some_and(|last| last.name.as_str() >= name) {
            return Err(value.damaged(format!("channel {name} is out of order")));
        }
        channels.push(Channel { name: name.to_owned(), sample_type });
    }
}

fn compression_name(code: u8) -> String {
    let names = ["NONE", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"];
    names.get(usize::from(code)).map_or_else(|| code.to_string(), |&name| name.to_owned())
}

/// The start of a file that is written: these channels as floats, the data window at the origin.
pub(super) fn build(
    channels: &[&str],
    compression: Compression,
    [width, height]: [i32; 2],
    max_samples: i32,
) -> Vec<u8> {
    let mut list = Vec::new();
    for name in channels {
        list.extend(name.as_bytes());
        list.push(0);
        list.extend(2u32.to_le_bytes());
        list.extend([0; 4]);
        list.extend(1u32.to_le_bytes());
        list.extend(1u32.to_le_bytes());
    }
    list.push(0);
    let window: Vec<u8> =
        [0, 0, width - 1, height - 1].into_iter().flat_map(i32::to_le_bytes).collect();

    let mut out = MAGIC.to_vec();
    out.extend((VERSION | NON_IMAGE).to_le_bytes());
    let mut attribute = |name: &str, type_name: &str, value: &[u8]| {
        for text in [name, type_name] {
            out.extend(text.as_bytes());
            out.push(0);
        }
        out.extend((value.len() as u32).to_le_bytes());
        out.extend(value);
    };
    attribute("channels", "chlist", &list);
    attribute("chunkCount", "int", &height.to_le_bytes());
    attribute("compression", "compression", &[compression.code()]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("maxSamplesPerPixel", "int", &max_samples.to_le_bytes());
    attribute("name", "string", b"fragments");
    attribute(super::DEPTH_ATTRIBUTE, "string", super::WINDOW_DEPTH.as_bytes());
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    attribute("type", "string", b"deepscanline");
    attribute("version", "int", &1u32.to_le_bytes());
    out.push(0);
    out
}
