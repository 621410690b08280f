//! Deep images come back as they were, and damaged ones are errors.

use std::io::{Cursor, ErrorKind};

use oit_fragments::deep_exr::{
    Compression, DeepExrError, DeepInfo, LineOrder, SampleType, WINDOW_DEPTH, Window, read,
    read_from, write, write_to,
};
use oit_fragments::{Fragment, Lfb};
use proptest::prelude::*;

const COMPRESSIONS: [Compression; 2] = [Compression::None, Compression::Zips];

fn bytes(lfb: &Lfb, compression: Compression) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write_to(&mut out, lfb, compression).unwrap();
    out.into_inner()
}

/// What comes back of a buffer: all, but for the colour of what cannot be seen.
fn without_hidden_colour(lfb: &Lfb) -> Lfb {
    let seen = |&f: &Fragment| if f.rgba8()[3] == 0 { Fragment { rgba: 0, ..f } } else { f };
    let fragments = lfb.fragments().iter().map(seen).collect();
    Lfb::new(lfb.width(), lfb.height(), lfb.offsets().to_vec(), fragments).unwrap()
}

fn small() -> Lfb {
    let fragment = |i: u8| Fragment::new(f32::from(i) / 16.0, [i, 2 * i, 255 - i, 127 + i]);
    let lists: Vec<Vec<_>> =
        (0..12).map(|pixel| (0..pixel % 4).map(|i| fragment(pixel + i)).collect()).collect();
    Lfb::from_lists(4, 3, &lists)
}

/// Where the table of offsets of a file written here begins: after the last attribute.
fn table_of(file: &[u8]) -> usize {
    let last = b"version\0int\0";
    let at = file.windows(last.len()).position(|window| window == last).expect("a version");
    at + last.len() + 4 + 4 + 1
}

fn fault(file: &[u8]) -> String {
    read_from(file).expect_err("this cannot be read").to_string()
}

/// One sample of one pixel, by channel: name, type's code, bytes.
type Sample<'a> = (&'a str, u32, &'a [u8]);

/// A file of one uncompressed pixel with one sample, put together by hand; channels in this order.
fn one_pixel(window: [i32; 4], line_order: u8, sample: &[Sample]) -> Vec<u8> {
    let mut file = b"\x76\x2f\x31\x01\x02\x08\0\0".to_vec();
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    let mut channels = Vec::new();
    for (name, code, _) in sample {
        channels.extend([name.as_bytes(), b"\0", &code.to_le_bytes(), &[0; 4]].concat());
        channels.extend([1, 0, 0, 0, 1, 0, 0, 0]);
    }
    channels.push(0);
    let window: Vec<u8> = window.into_iter().flat_map(i32::to_le_bytes).collect();
    attribute("type", "string", b"deepscanline");
    attribute("note", "something else", b"skipped");
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("displayWindow", "box2i", &[0; 16]);
    attribute("dataWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[line_order]);
    attribute("version", "int", &[1, 0, 0, 0]);
    file.push(0);
    let row = file.len() as u64 + 8;
    file.extend(row.to_le_bytes());
    file.extend(&window[4..8]);
    let samples: Vec<u8> = sample.iter().flat_map(|(.., bytes)| bytes.iter().copied()).collect();
    for len in [4, samples.len() as u64, samples.len() as u64] {
        file.extend(len.to_le_bytes());
    }
    file.extend(1u32.to_le_bytes());
    file.extend(samples);
    file
}

fn only(file: &[u8]) -> (DeepInfo, Fragment) {
    let (info, lfb) = read_from(file).unwrap();
    assert_eq!((lfb.width(), lfb.height(), lfb.fragments().len()), (1, 1, 1));
    (info, lfb.fragments()[0])
}

#[test]
fn a_file_comes_back_and_is_overwritten_only_when_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for compression in COMPRESSIONS {
        write(&path, &small(), compression, true).unwrap();
        let (info, lfb) = read(&path).unwrap();
        assert_eq!(lfb, small());
        assert_eq!(info.compression, compression);
        assert_eq!(info.line_order, LineOrder::Increasing);
        assert_eq!(info.data_window, Window { min: [0, 0], max: [3, 2] });
        assert_eq!(info.display_window, info.data_window);
        assert_eq!(info.depth.as_deref(), Some(WINDOW_DEPTH));
        assert!(info.skipped.is_empty() && info.missing.is_empty() && !info.has_backs());
        assert!(info.largest_error < 1e-7);
        let error = write(&path, &small(), compression, false).unwrap_err();
        assert!(
            matches!(error.fault(), DeepExrError::Io(io) if io.kind() == ErrorKind::AlreadyExists),
            "{error}"
        );
    }
    let missing = read(&folder.path().join("missing.exr")).unwrap_err().to_string();
    assert!(missing.contains("missing.exr"), "{missing}");
}

#[test]
fn zips_is_smaller() {
    let f = Fragment::new(0.5, [10, 20, 30, 40]);
    let lfb = Lfb::from_lists(64, 64, &vec![vec![f; 8]; 64 * 64]);
    assert_eq!(read_from(&bytes(&lfb, Compression::Zips)).unwrap().1, lfb);
    assert!(bytes(&lfb, Compression::Zips).len() * 10 < bytes(&lfb, Compression::None).len());
}

#[test]
fn channels_of_any_type_are_read_and_others_skipped() {
    let half = |value: f32| half::f16::from_f32(value).to_le_bytes();
    let file = one_pixel(
        [-7, -5, -7, -5],
        1,
        &[
            ("A", 1, &half(0.5)),
            ("B", 0, &0u32.to_le_bytes()),
            ("G", 2, &0.25f32.to_le_bytes()),
            ("Layer.R", 2, &f32::NAN.to_le_bytes()),
            ("R", 1, &half(0.5)),
            ("Z", 0, &70_000u32.to_le_bytes()),
            ("ZBack", 2, &9f32.to_le_bytes()),
        ],
    );
    let (info, fragment) = only(&file);
    assert_eq!(fragment, Fragment::new(70_000.0, [255, 128, 0, 128]));
    assert_eq!(info.data_window, Window { min: [-7, -5], max: [-7, -5] });
    assert_eq!(info.display_window, Window { min: [0, 0], max: [0, 0] });
    assert_eq!(info.line_order, LineOrder::Decreasing);
    assert_eq!(info.skipped, ["Layer.R", "ZBack"]);
    assert_eq!(info.channels[0].sample_type, SampleType::Half);
    assert!(info.has_backs() && info.missing.is_empty() && info.depth.is_none());
    assert!(info.largest_error > 0.001 && info.largest_error < 0.004);
}

#[test]
fn without_alpha_a_sample_is_opaque_and_without_colour_black() {
    let z = (-2.5f32).to_le_bytes();
    let (info, fragment) =
        only(&one_pixel([0; 4], 0, &[("G", 2, &0.2f32.to_le_bytes()), ("Z", 2, &z)]));
    assert_eq!(fragment, Fragment::new(-2.5, [0, 51, 0, 255]));
    assert_eq!(info.missing, ["R", "B", "A"]);
    let error = read_from(&one_pixel([0; 4], 0, &[("R", 2, &z)])).unwrap_err();
    assert_eq!(error.to_string(), "no channel Z, only [\"R\"]");
}

#[test]
fn values_that_no_fragment_has_are_named() {
    let (one, nan, inf) = (1f32.to_le_bytes(), f32::NAN.to_le_bytes(), f32::INFINITY.to_le_bytes());
    let of = |g: &[u8], z: &[u8]| one_pixel([0; 4], 0, &[("G", 2, g), ("Z", 2, z)]);
    assert_eq!(fault(&of(&one, &nan)), "pixel (0, 0), sample 0: Z is NaN");
    assert_eq!(fault(&of(&nan, &one)), "pixel (0, 0), sample 0: G is NaN");
    assert_eq!(fault(&of(&inf, &one)), "pixel (0, 0), sample 0: G is inf");
    assert_eq!(only(&of(&one, &inf)).1.depth(), f32::INFINITY);

    // Nor are they written: a key that stands for NaN.
    let nan = Fragment { rgba: 0, depth_key: u32::MAX };
    let near = Fragment::new(0.0, [0; 4]);
    let lfb = Lfb::from_lists(2, 2, &[vec![], vec![near], vec![near], vec![near, near, nan]]);
    let error = write_to(Cursor::new(Vec::new()), &lfb, Compression::None).unwrap_err();
    assert_eq!(error.to_string(), "pixel (1, 1), sample 2: Z is NaN");
    for (width, height) in [(0, 0), (5, 0), (0, 5)] {
        let error = write_to(
            Cursor::new(Vec::new()),
            &Lfb::from_lists(width, height, &[]),
            Compression::None,
        );
        assert!(matches!(error, Err(DeepExrError::Size { .. })));
    }
    // In a file, a pixel is named after empty ones too.
    let mut file = bytes(&Lfb::from_lists(2, 1, &[vec![], vec![near, near]]), Compression::None);
    let end = file.len();
    file[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(fault(&file), "pixel (1, 0), sample 1: Z is NaN");
}

#[test]
fn other_kinds_of_file_are_refused_by_name() {
    let good = bytes(&small(), Compression::None);
    let with = |from: &[u8], to: &[u8]| {
        let at = good.windows(from.len()).position(|window| window == from).expect("it is there");
        let mut file = good.clone();
        file[at..at + to.len()].copy_from_slice(to);
        fault(&file)
    };
    let of_field = |field: u32| with(&[2, 8, 0, 0], &field.to_le_bytes());
    assert!(of_field(0x1802).starts_with("a file of several parts"));
    assert!(of_field(0x0002).starts_with("a flat scanline image"));
    assert!(of_field(0x0202).starts_with("a flat tiled image"));
    assert!(of_field(0x0803).starts_with("a file of version 3"));
    assert!(of_field(0x8802).starts_with("a file with the version field 0x8802"));
    let compression = b"compression\0compression\0\x01\0\0\0";
    let compressed = |code: u8| with(compression, &[&compression[..], &[code]].concat());
    assert!(compressed(1).starts_with("compression RLE"));
    assert!(compressed(3).starts_with("compression ZIP:"));
    assert!(compressed(8).starts_with("compression DWAA"));
    assert!(compressed(200).starts_with("compression 200"));
    assert!(
        with(b"\x0c\0\0\0deepscanline", b"\x0c\0\0\0scanlineimag").contains("type scanlineimag")
    );
    assert!(
        with(b"version\0int\0\x04\0\0\0", b"version\0int\0\x04\0\0\0\x02").contains("version 2")
    );
    assert!(with(b"type\0string", b"typo\0string").contains("without type"));
    assert!(fault(b"\x89PNG\r\n").starts_with("not an OpenEXR file"));
    assert!(fault(b"").starts_with("not an OpenEXR file"));

    let at = good.windows(12).position(|window| window == b"deepscanline").unwrap();
    let tiled = [&good[..at - 4], &8u32.to_le_bytes(), b"deeptile", &good[at + 12..]].concat();
    assert!(fault(&tiled).starts_with("a tiled deep image"));
}

#[test]
fn forged_lengths_are_refused_and_nothing_is_allocated_for_them() {
    for compression in COMPRESSIONS {
        let good = bytes(&small(), compression);
        let window = good.windows(10).position(|window| window == b"dataWindow").unwrap() + 21;
        let forge = |at: usize, value: &[u8]| {
            let mut file = good.clone();
            file[at..at + value.len()].copy_from_slice(value);
            fault(&file)
        };
        let table = table_of(&good);
        let row = u64::from_le_bytes(good[table..table + 8].try_into().unwrap()) as usize;
        assert_eq!(row, table + 24);

        let max = i32::MAX.to_le_bytes();
        assert!(forge(window + 8, &max).contains("bytes for"), "wide");
        assert!(forge(window + 8, &(-1i32).to_le_bytes()).contains("no pixels"));
        assert!(forge(window, &i32::MIN.to_le_bytes()).contains("bytes for"), "wider");
        assert!(forge(window + 12, &max).contains("chunkCount"), "high");
        assert!(forge(table, &u64::MAX.to_le_bytes()).contains("said to be at"));
        assert!(forge(table, &0u64.to_le_bytes()).contains("said to be at"));
        assert!(forge(table, &good[table + 8..table + 16]).contains("where row 0 belongs"));
        assert!(forge(row, &7u32.to_le_bytes()).contains("where row 0 belongs"));
        for length in [4, 12, 20] {
            let error = forge(row + length, &u64::MAX.to_le_bytes());
            assert!(error.contains("bytes"), "{error}");
        }
        assert!(forge(row + 20, &1_000_000u64.to_le_bytes()).contains("of samples"));
    }

    // A row inside another's samples.
    let near = Fragment::new(0.0, [0; 4]);
    let good = bytes(&Lfb::from_lists(1, 2, &[vec![near; 9], vec![]]), Compression::None);
    let second = good.len() - 32;
    let mut file = good.clone();
    file.copy_within(second.., second - 40);
    let entry = good.windows(8).position(|entry| entry == (second as u64).to_le_bytes()).unwrap();
    file[entry..entry + 8].copy_from_slice(&(second as u64 - 40).to_le_bytes());
    assert!(fault(&file).contains("overlaps row 0"), "{}", fault(&file));

    // Running totals that fall, and that are not what the samples are.
    let good = bytes(&Lfb::from_lists(2, 1, &[vec![near], vec![near]]), Compression::None);
    let counts = good.len() - 8 - 40;
    assert_eq!(good[counts..counts + 8], [1, 0, 0, 0, 2, 0, 0, 0]);
    for (counted, what) in [
        ([3, 0, 0, 0, 2, 0, 0, 0], "falls to 2 at pixel 1"),
        ([0, 0, 0, 128, 2, 0, 0, 0], "falls to -2147483648 at pixel 0"),
        ([1, 0, 0, 0, 255, 255, 255, 127], "2147483647 samples are"),
    ] {
        let mut file = good.clone();
        file[counts..counts + 8].copy_from_slice(&counted);
        assert!(fault(&file).contains(what), "{}", fault(&file));
    }
}

#[test]
fn rows_may_lie_anywhere() {
    let good = bytes(&small(), Compression::None);
    let first = table_of(&good) + 24;
    let entry = |row: usize| first - 24 + 8 * row;
    let at = |row: usize| u64::from_le_bytes(good[entry(row)..][..8].try_into().unwrap()) as usize;
    assert_eq!(at(0), first);
    // The last row first.
    let (second, third) = (at(1), at(2));
    let mut file = [&good[..first], &good[third..], &good[first..third]].concat();
    let shift = good.len() - third;
    for (row, place) in [first + shift, second + shift, first].into_iter().enumerate() {
        file[entry(row)..][..8].copy_from_slice(&(place as u64).to_le_bytes());
    }
    assert_eq!(read_from(&file).unwrap().1, small());
}

#[test]
fn truncation_is_always_an_error() {
    for compression in COMPRESSIONS {
        let good = bytes(&small(), compression);
        for len in 0..good.len() {
            assert!(read_from(&good[..len]).is_err(), "{len} of {}", good.len());
        }
    }
}

#[test]
fn no_damaged_byte_panics() {
    // There are no checksums but zlib's: a damaged sample may be another sample.
    for compression in COMPRESSIONS {
        let good = bytes(&small(), compression);
        for at in 0..good.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut file = good.clone();
                file[at] ^= flip;
                if let Ok((_, lfb)) = read_from(&file) {
                    assert_eq!(lfb.pixels(), 12, "byte {at}");
                    assert!(lfb.fragments().len() <= file.len());
                }
            }
        }
    }
}

prop_compose! {
    fn any_lfb()(width in 1u32..9, height in 1u32..9)(
        lists in prop::collection::vec(
            prop::collection::vec((any::<[u8; 4]>(), -1e30f32..1e30), 0..6),
            (width * height) as usize,
        ),
        width in Just(width),
        height in Just(height),
    ) -> Lfb {
        let fragment = |(rgba, depth)| Fragment::new(depth, rgba);
        let lists: Vec<Vec<_>> =
            lists.into_iter().map(|list| list.into_iter().map(fragment).collect()).collect();
        Lfb::from_lists(width, height, &lists)
    }
}

proptest! {
    #[test]
    fn any_buffer_comes_back(lfb in any_lfb()) {
        for compression in COMPRESSIONS {
            let (_, back) = read_from(&bytes(&lfb, compression)).unwrap();
            prop_assert_eq!(back, without_hidden_colour(&lfb));
        }
    }

    #[test]
    fn garbage_never_panics(
        garbage in prop::collection::vec(any::<u8>(), 0..300),
        at in any::<prop::sample::Index>(),
    ) {
        prop_assert!(read_from(&garbage).is_err());
        prop_assert!(read_from(&[&b"\x76\x2f\x31\x01\x02\x08\0\0"[..], &garbage].concat()).is_err());
        for compression in COMPRESSIONS {
            // In the middle of a good file.
            let mut file = bytes(&small(), compression);
            let at = at.index(file.len());
            let end = file.len().min(at + garbage.len());
            file[at..end].copy_from_slice(&garbage[..end - at]);
            let _ = read_from(&file);
        }
    }
}
