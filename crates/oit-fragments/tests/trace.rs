//! Traces come back as they were, and anything else is an error.

use std::io::ErrorKind;

use oit_fragments::trace::{
    FragmentOrder, TRACE_EXTENSION, TraceError, TraceInfo, info, info_from, load, load_from, save,
    save_to,
};
use oit_fragments::{Fragment, Lfb};
use proptest::prelude::*;

fn described(lfb: &Lfb) -> TraceInfo {
    TraceInfo {
        scene: "stack".to_owned(),
        view: "front".to_owned(),
        order: FragmentOrder::Submission,
        capture: "cpu".to_owned(),
        device: "a \"quoted\" device".to_owned(),
        oit_version: "0.1.0".to_owned(),
        git_commit: Some("abc".to_owned()),
        created: "2026-01-02T03:04:05Z".to_owned(),
        ..TraceInfo::new(lfb)
    }
}

fn small() -> Lfb {
    let fragment = |i: u8| Fragment::new(f32::from(i) / 16.0, [i, 2 * i, 255 - i, 128]);
    let lists: Vec<Vec<_>> =
        (0..12).map(|pixel| (0..pixel % 4).map(|i| fragment(pixel + i)).collect()).collect();
    Lfb::from_lists(4, 3, &lists)
}

fn bytes(lfb: &Lfb) -> Vec<u8> {
    let mut bytes = Vec::new();
    save_to(&mut bytes, &described(lfb), lfb).unwrap();
    bytes
}

/// Where the header ends, its checksum included.
fn header_end(bytes: &[u8]) -> usize {
    16 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize + 4
}

/// Makes the last four bytes of a range its checksum again: for damage that no checksum shows.
fn reseal(record: &mut [u8]) {
    let (rest, seal) = record.split_last_chunk_mut().unwrap();
    *seal = crc32fast::hash(rest).to_le_bytes();
}

/// The same trace with another header.
fn with_header(trace: &[u8], header: &str) -> Vec<u8> {
    let mut start = trace[..12].to_vec();
    start.extend((header.len() as u32).to_le_bytes());
    start.extend(header.as_bytes());
    start.extend([0; 4]);
    reseal(&mut start);
    start.extend(&trace[header_end(trace)..]);
    start
}

fn fault(bytes: &[u8]) -> String {
    load_from(bytes).expect_err("this is no trace").to_string()
}

#[test]
fn a_file_comes_back_and_is_overwritten_only_when_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a").with_extension(TRACE_EXTENSION);
    let (lfb, other) = (small(), Lfb::from_lists(1, 1, &[vec![]]));
    save(&path, &described(&lfb), &lfb, false).unwrap();
    assert_eq!(load(&path).unwrap(), (described(&lfb), lfb.clone()));
    assert_eq!(info(&path).unwrap(), described(&lfb));

    let error = save(&path, &described(&other), &other, false).unwrap_err();
    assert!(
        matches!(error.fault(), TraceError::Io(io) if io.kind() == ErrorKind::AlreadyExists),
        "{error}"
    );
    assert_eq!(load(&path).unwrap().1, lfb);
    save(&path, &described(&other), &other, true).unwrap();
    assert_eq!(load(&path).unwrap().1, other);

    let missing = load(&folder.path().join("missing.oitt")).unwrap_err().to_string();
    assert!(missing.contains("missing.oitt"), "{missing}");
}

#[test]
fn buffers_without_pixels_or_fragments_come_back() {
    for (width, height) in [(0, 0), (0, 7), (7, 0), (3, 2)] {
        let lfb = Lfb::from_lists(width, height, &vec![vec![]; (width * height) as usize]);
        assert_eq!(load_from(&bytes(&lfb)[..]).unwrap(), (described(&lfb), lfb));
    }
}

#[test]
fn several_chunks_and_batches_come_back() {
    // 70,000 pixels a row: more than a chunk may have; one pixel deeper than a chunk may be.
    let mut lists: Vec<Vec<Fragment>> = (0..70_000u32 * 30)
        .map(|p| vec![Fragment { rgba: p ^ 0xff00, depth_key: p }; usize::from(p % 7 == 0)])
        .collect();
    lists[65_536] = (0..300_000).map(|i| Fragment { rgba: i, depth_key: !i }).collect();
    let lfb = Lfb::from_lists(70_000, 30, &lists);
    let bytes = bytes(&lfb);
    assert!(load_from(&bytes[..]).unwrap().1 == lfb);
    assert!(bytes.len() < lfb.fragments().len() * 5, "{} bytes", bytes.len());

    // Chunks may not trade places: the second is put first.
    let start = header_end(&bytes);
    let length =
        |at: usize| 40 + u64::from_le_bytes(bytes[at + 24..at + 32].try_into().unwrap()) as usize;
    let second = start + length(start);
    let third = second + length(second);
    let swapped =
        [&bytes[..start], &bytes[second..third], &bytes[start..second], &bytes[third..]].concat();
    assert!(fault(&swapped).contains("belongs"), "{}", fault(&swapped));
    // Nor may one be missing.
    let missing = [&bytes[..second], &bytes[third..]].concat();
    assert!(fault(&missing).contains("belongs"), "{}", fault(&missing));
}

#[test]
fn every_damaged_byte_is_an_error() {
    let good = bytes(&small());
    for at in 0..good.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            let error = load_from(&bytes[..]).expect_err("a damaged byte");
            match error {
                TraceError::NotATrace { .. } => assert!(at < 8, "byte {at}"),
                TraceError::Version { .. } => assert!((8..12).contains(&at), "byte {at}"),
                TraceError::Damaged { offset, .. } => {
                    // A wrong length of the header is found by what is then taken for the header.
                    let latest = if (12..16).contains(&at) { 16 } else { at as u64 };
                    assert!(offset <= latest, "byte {at} found at {offset}");
                }
                other => panic!("byte {at}: {other}"),
            }
            let in_header = at < header_end(&good);
            assert_eq!(info_from(&bytes[..]).is_err(), in_header, "byte {at}");
        }
    }
}

#[test]
fn every_truncation_and_any_surplus_is_an_error() {
    let good = bytes(&small());
    for len in 0..good.len() {
        let error = load_from(&good[..len]).expect_err("a truncated trace");
        assert!(matches!(error, TraceError::Damaged { .. }), "{len}: {error}");
    }
    assert!(fault(&[&good[..], b"\0"].concat()).contains("after the end"));
    // A trace that ends before its end record, at a boundary between records.
    assert!(fault(&good[..good.len() - 36]).contains("ends in the end's record"));
}

#[test]
fn another_version_is_refused_by_name() {
    let mut bytes = bytes(&small());
    bytes[8] = 2;
    let end = header_end(&bytes);
    reseal(&mut bytes[..end]);
    assert_eq!(fault(&bytes), "a fragment trace of version 2; this program reads version 1");
    assert!(fault(b"RIFF and something else").contains("not a fragment trace"));
}

#[test]
fn forged_headers_are_refused() {
    let lfb = small();
    let trace = bytes(&lfb);
    let json = serde_json::to_string(&described(&lfb)).unwrap();
    assert_eq!(with_header(&trace, &json), trace);

    let surplus = json.replacen('{', "{\"colour\":1,", 1);
    assert!(fault(&with_header(&trace, &surplus)).contains("colour"));
    let lacking = json.replace("\"peak\":3,", "");
    assert!(fault(&with_header(&trace, &lacking)).contains("peak"));
    for (from, to) in [
        ("\"width_px\":4", "\"width_px\":4294967295"),
        ("\"width_px\":4", "\"width_px\":3"),
        ("\"width_px\":4", "\"width_px\":0"),
        ("\"height_px\":3", "\"height_px\":4294967295"),
        ("\"fragments\":18", "\"fragments\":18446744073709551615"),
        ("\"fragments\":18", "\"fragments\":17"),
        ("\"fragments\":18", "\"fragments\":19"),
        ("\"peak\":3", "\"peak\":2"),
        ("\"peak\":3", "\"peak\":4"),
    ] {
        assert!(json.contains(from), "{from} in {json}");
        let forged = with_header(&trace, &json.replace(from, to));
        assert!(load_from(&forged[..]).is_err(), "{to}");
    }
    // A header's length is checked before it is read.
    let mut long = trace.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(fault(&long).contains("a header of 4294967295 bytes"));
}

#[test]
fn forged_chunks_are_refused_and_nothing_is_allocated_for_them() {
    let lfb = small();
    // The header agrees to anything, so that the chunk's own bounds are tried.
    let json = serde_json::to_string(&described(&lfb))
        .unwrap()
        .replace("\"width_px\":4", "\"width_px\":4294967295")
        .replace("\"fragments\":18", "\"fragments\":18446744073709551615");
    let good = with_header(&bytes(&lfb), &json);
    let at = header_end(&good);
    let forge = |field: usize, value: &[u8]| {
        let mut bytes = good.clone();
        bytes[at + field..][..value.len()].copy_from_slice(value);
        reseal(&mut bytes[at..at + 40]);
        fault(&bytes)
    };
    assert!(forge(4, &1u64.to_le_bytes()).contains("belongs"));
    assert!(forge(12, &0u32.to_le_bytes()).contains("belongs"));
    assert!(forge(12, &u32::MAX.to_le_bytes()).contains("belongs"));
    assert!(forge(16, &u32::MAX.to_le_bytes()).contains("belongs"));
    assert!(forge(16, &100_000u32.to_le_bytes()).contains("bytes for a chunk of"));
    assert!(forge(20, &4u32.to_le_bytes()).contains("unknown form"));
    assert!(forge(24, &u64::MAX.to_le_bytes()).contains("bytes for a chunk of"));
    assert!(forge(24, &300u64.to_le_bytes()).contains("ends in a chunk"));
    // A chunk that promises a pixel more than its payload has, with a header that agrees.
    let mut more =
        with_header(&good, &json.replace(":4294967295", ":13").replace(":3,\"f", ":1,\"f"));
    let at = header_end(&more);
    more[at + 12] = 13;
    reseal(&mut more[at..at + 40]);
    assert!(fault(&more).contains("chunk: the deflated bytes do not give"), "{}", fault(&more));

    // One pixel may have any number of fragments, but not more than its bytes can inflate to.
    let mut one = Vec::new();
    one.extend(1u32.to_le_bytes());
    one.extend(u32::MAX.to_le_bytes());
    assert!(forge(12, &one).contains("bytes for a chunk of"));
}

#[test]
fn what_does_not_belong_together_is_not_saved() {
    let lfb = small();
    let wrong = TraceInfo { peak: 9, ..described(&lfb) };
    let mut out = Vec::new();
    assert_eq!(
        save_to(&mut out, &wrong, &lfb).unwrap_err().to_string(),
        "the header says peak is 9, the buffer has 3"
    );
    let long = TraceInfo { device: "x".repeat(70_000), ..described(&lfb) };
    assert!(matches!(
        save_to(&mut out, &long, &lfb),
        Err(TraceError::HeaderTooLong { max: 65_536, .. })
    ));
    assert!(out.is_empty());
}

prop_compose! {
    fn any_lfb()(width in 0u32..9, height in 0u32..9)(
        lists in prop::collection::vec(
            prop::collection::vec((any::<u32>(), any::<u32>()), 0..6),
            (width * height) as usize,
        ),
        width in Just(width),
        height in Just(height),
    ) -> Lfb {
        let fragment = |(rgba, depth_key)| Fragment { rgba, depth_key };
        let lists: Vec<Vec<_>> =
            lists.into_iter().map(|list| list.into_iter().map(fragment).collect()).collect();
        Lfb::from_lists(width, height, &lists)
    }
}

proptest! {
    #[test]
    fn any_buffer_comes_back(lfb in any_lfb(), text in ".*") {
        let info = TraceInfo { scene: text, ..described(&lfb) };
        let mut bytes = Vec::new();
        save_to(&mut bytes, &info, &lfb).unwrap();
        prop_assert_eq!(info_from(&bytes[..]).unwrap(), info.clone());
        prop_assert_eq!(load_from(&bytes[..]).unwrap(), (info, lfb));
    }

    #[test]
    fn garbage_is_an_error(garbage in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(load_from(&garbage[..]).is_err());
        // And with a good start.
        let good = bytes(&small());
        let start = &good[..header_end(&good)];
        prop_assert!(load_from(&[start, &garbage].concat()[..]).is_err());
        prop_assert!(load_from(&[start, b"CHNK", &garbage].concat()[..]).is_err());
    }
}
