//! Reading captures back: what a device leaves, what a pool that is too small leaves, and damage.

use std::collections::HashMap;

use oit_capture::{
    Array3d, Array3dNearest, CAPTURES, Capture, CaptureError, Demand, FAULTY, Interleaved,
    InterleavedLists, LfbReader, Linearized, LinearizedNearest, LinkedList, LinkedListSorted,
    LinkedPages, Lists, Usage, WIDE, capture,
};
use oit_fragments::{DepthHistogram, Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Contents, GpuError};
use oit_scene::SplitMix64;
use proptest::prelude::*;

/// What a device leaves: buffers by name.
#[derive(Clone, Debug)]
struct Memory {
    width_px: u32,
    height_px: u32,
    pool_slots: u64,
    buffers: HashMap<String, Vec<u8>>,
}

impl Memory {
    fn with<R>(&self, read: impl FnOnce(&mut LfbReader) -> R) -> R {
        read(&mut LfbReader {
            width_px: self.width_px,
            height_px: self.height_px,
            pool_slots: self.pool_slots,
            read: &mut |name| {
                let missing = || GpuError::Device(format!("no buffer {name}"));
                self.buffers.get(name).cloned().ok_or_else(missing)
            },
        })
    }

    fn unpack(&self, capture: &dyn Capture) -> Result<Lfb, CaptureError> {
        self.with(|read| capture.unpack(read))
    }

    fn set(&mut self, buffer: &str, word: usize, value: u32) {
        let bytes = self.buffers.get_mut(buffer).expect("a buffer of the capture");
        bytes[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
    }
}

fn bytes(words: impl IntoIterator<Item = u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// What a device leaves of these fragments in a pool that holds them.
fn memory(capture: &dyn Capture, lfb: &Lfb) -> Memory {
    memory_of(capture.upload(lfb), lfb)
}

fn memory_of(uploaded: Vec<Buffer>, lfb: &Lfb) -> Memory {
    let mut buffers = HashMap::new();
    for buffer in uploaded {
        let Contents::Data(bytes) = buffer.contents else { panic!("{} holds data", buffer.name) };
        buffers.insert(buffer.name, bytes.to_vec());
    }
    let pool_slots = (buffers["fragments"].len() / 8) as u64;
    Memory { width_px: lfb.width(), height_px: lfb.height(), pool_slots, buffers }
}

/// The same in a smaller pool, of a capture that fills its pool from the start.
fn cut(mut memory: Memory, pool_slots: u64) -> Memory {
    memory.pool_slots = pool_slots;
    memory.buffers.get_mut("fragments").expect("a pool").resize(8 * pool_slots as usize, 0xcd);
    memory
}

fn random_lfb(seed: u64, width: u32, height: u32) -> Lfb {
    let mut random = SplitMix64::new(seed);
    let lists: Vec<Vec<_>> = (0..width * height)
        .map(|_| {
            let fragments = random.below(5);
            (0..fragments)
                .map(|_| Fragment::new(random.unit(), (random.next_u64() as u32).to_le_bytes()))
                .collect()
        })
        .collect();
    Lfb::from_lists(width, height, &lists)
}

#[test]
fn what_a_device_leaves_is_read_in_the_order_of_the_twin() {
    for capture in CAPTURES {
        for (seed, (width, height)) in [(1, 1), (7, 5), (16, 16), (3, 40)].into_iter().enumerate() {
            let submitted = random_lfb(seed as u64, width, height);
            let memory = memory(*capture, &submitted);
            let mut expected = submitted.clone();
            capture.order(&mut expected);
            assert_eq!(memory.unpack(*capture).expect("undamaged"), expected, "{}", capture.name());
            let usage = memory.with(|read| capture.usage(read)).expect("undamaged");
            assert_eq!(usage.fragments, submitted.fragments().len() as u64, "{}", capture.name());
            let counts: Vec<u32> = submitted.counts().collect();
            let histogram = &submitted.histogram();
            let demand = Demand { counts: &counts, histogram, lists: None };
            let (slots, used) = (capture.slots(&demand), usage.slots);
            if capture.needs_lists() {
                assert!(used <= slots, "{}: {used} of {slots}", capture.name());
            } else {
                // Some ask for a little more than the fragments take if none are in each other's way.
                assert!(used <= slots && slots - used <= used / 32, "{}", capture.name());
            }
        }
    }
}

#[test]
fn lists_that_are_none_are_refused() {
    let f = Fragment::new(0.5, [1, 2, 3, 4]);
    let lfb = Lfb::from_lists(2, 2, &[vec![f, f], vec![], vec![f], vec![f]]);
    let good = memory(&LinkedList::EACH, &lfb);
    let damaged = |buffer, word, value| {
        let mut memory = good.clone();
        memory.set(buffer, word, value);
        memory.unpack(&LinkedList::EACH)
    };
    let structure = |result: Result<Lfb, CaptureError>, part: &str| match result {
        Err(CaptureError::Damaged(LfbError::Structure { pixel: 0, what })) => {
            assert!(what.contains(part), "{what}");
        }
        other => panic!("{other:?}"),
    };
    assert!(good.unpack(&LinkedList::EACH).is_ok());
    // Pixel 0 has the nodes 0 and 3, and its head is node 3.
    structure(damaged("nexts", 0, 4), "linked twice");
    structure(damaged("nexts", 3, 4), "linked twice");
    structure(damaged("nexts", 0, 6), "node 5 of a pool in which 4 are used");
    structure(damaged("heads", 0, 0xcdcd_cdcd), "of a pool in which 4 are used");
    assert!(matches!(damaged("heads", 0, 0), Err(CaptureError::Lost { node: 0 })));
    assert!(matches!(damaged("node_count", 0, 3), Err(CaptureError::Damaged(_))));
    let mut short = good.clone();
    short.buffers.insert("heads".into(), vec![0; 15]);
    assert!(matches!(
        short.unpack(&LinkedList::EACH),
        Err(CaptureError::Short { buffer: "heads", bytes: 15, expected: 16 })
    ));
}

#[test]
fn sorted_lists_that_are_none_are_refused() {
    let [near, far] = [0.25, 0.5].map(|depth| Fragment::new(depth, [1, 2, 3, 4]));
    let lfb = Lfb::from_lists(2, 2, &[vec![far, near], vec![], vec![far], vec![near]]);
    let capture = &LinkedListSorted::PATIENT;
    let good = memory(capture, &lfb);
    assert_eq!(good.unpack(capture).expect("undamaged").pixel(0), [near, far]);
    let structure = |memory: &Memory, part: &str| match memory.unpack(capture) {
        Err(CaptureError::Damaged(LfbError::Structure { what, .. })) => {
            assert!(what.contains(part), "{what}");
        }
        other => panic!("{other:?}"),
    };
    let damaged = |buffer, word, value| {
        let mut memory = good.clone();
        memory.set(buffer, word, value);
        memory
    };
    // Pixel 0 has the nodes 3 and then 0; the pixels' links come after those of four nodes.
    structure(&damaged("links", 0, 4), "linked twice");
    structure(&damaged("links", 2 * 4, 9), "node 8 of a pool in which 4 are used");
    structure(&damaged("lost", 0, 1), "0 nodes are empty and 1 fragments were lost");
    structure(&damaged("fragments", 2 * 3 + 1, !0), "fragment 1 is nearer");
    assert!(matches!(damaged("links", 2 * 4, 0).unpack(capture), Err(CaptureError::Lost { .. })));
    // A node of pixel 2 that found no place: in no list, and said to be lost.
    let mut lost = good.clone();
    for (buffer, word) in [("links", 2 * 6), ("fragments", 2), ("fragments", 3)] {
        lost.set(buffer, word, 0);
    }
    structure(&lost, "1 nodes are empty and 0 fragments were lost");
    lost.set("lost", 0, 1);
    let left = lost.unpack(capture).expect("told");
    assert_eq!((left.pixel(0).len(), left.pixel(2).len(), left.pixel(3).len()), (2, 0, 1));
    // Whatever its size, the pool is said to be too small.
    for pool in [4, 400] {
        lost.pool_slots = pool;
        let usage = lost.with(|read| capture.usage(read)).expect("reads");
        assert_eq!(usage, Usage { fragments: 4, slots: pool + 1 });
    }
}

#[test]
fn fragments_of_128_bits_are_read_as_those_of_64() {
    for capture in WIDE {
        let name = capture.name();
        for (seed, (width, height)) in [(1, 1), (7, 5), (3, 40)].into_iter().enumerate() {
            let submitted = random_lfb(seed as u64, width, height);
            let mut memory = memory(*capture, &submitted);
            memory.pool_slots /= 2;
            let mut expected = submitted.clone();
            capture.order(&mut expected);
            assert_eq!(memory.unpack(*capture).expect("undamaged"), expected, "{name}");
            let fragments = submitted.fragments().len() as u64;
            let usage = memory.with(|read| capture.usage(read)).expect("undamaged");
            assert_eq!(usage, Usage { fragments, slots: fragments }, "{name}");
            if fragments == 0 {
                continue;
            }
            for word in 0..3 {
                let mut damaged = memory.clone();
                damaged.set("fragments", word, 0x3c00_3c01);
                match damaged.unpack(*capture) {
                    Err(CaptureError::Damaged(LfbError::Structure { what, .. })) => {
                        assert!(what.contains("node 0 holds no colour"), "{what}");
                    }
                    other => panic!("{name}: {other:?}"),
                }
            }
        }
    }
}

/// What a resolve that does not sort relies on.
#[test]
fn captures_that_deliver_sorted_fragments_do() {
    let sorted: Vec<_> = CAPTURES.iter().filter(|capture| capture.delivers_sorted()).collect();
    assert_eq!(sorted.len(), 3);
    for capture in CAPTURES {
        let read = memory(*capture, &random_lfb(5, 9, 9)).unpack(*capture).expect("undamaged");
        let in_order =
            (0..read.pixels()).all(|pixel| read.pixel(pixel).is_sorted_by_key(|f| f.key()));
        assert_eq!(in_order, capture.delivers_sorted(), "{}", capture.name());
    }
}

#[test]
fn pages_that_are_none_are_refused() {
    let f = Fragment::new(0.5, [1, 2, 3, 4]);
    let lfb = Lfb::from_lists(2, 2, &[vec![f; 6], vec![], vec![f; 4], vec![f]]);
    let pages = LinkedPages::new(4);
    let good = memory(&pages, &lfb);
    let damaged = |buffer, word, value| {
        let mut memory = good.clone();
        memory.set(buffer, word, value);
        memory.unpack(&pages)
    };
    let structure = |result: Result<Lfb, CaptureError>, part: &str| match result {
        Err(CaptureError::Damaged(LfbError::Structure { what, .. })) => {
            assert!(what.contains(part), "{what}");
        }
        other => panic!("{other:?}"),
    };
    // Pixel 0 has the pages 0 and 3, and its head is page 3.
    structure(damaged("nexts", 0, 4), "page 3 is linked twice");
    structure(damaged("heads", 0, 9), "page 8 of a pool in which 4 are used");
    structure(damaged("heads", 0, 0x8000_0004), "of a pool in which 4 are used");
    structure(damaged("dropped", 1, 3), "fragments without a page, and 4 of 4 pages were used");
    assert!(matches!(damaged("heads", 3, 0), Err(CaptureError::Lost { node: 2 })));
    assert!(matches!(damaged("page_count", 0, 3), Err(CaptureError::Damaged(_))));
    // Slots asked for in vain fill no page further.
    assert_eq!(damaged("fills", 1, u32::MAX).expect("full"), good.unpack(&pages).expect("good"));
    // What found no page is counted with what did.
    let mut full = good.clone();
    full.set("page_count", 0, 5);
    full.set("dropped", 2, 5);
    let usage = full.with(|read| pages.usage(read)).expect("reads");
    assert_eq!(usage, Usage { fragments: 16, slots: 24 });
}

#[test]
fn slots_out_of_order_are_refused() {
    let [near, far] = [0.25, 0.5].map(|depth| Fragment::new(depth, [1, 2, 3, 4]));
    let lfb = Lfb::from_lists(2, 2, &[vec![far, near], vec![near], vec![], vec![]]);
    // Slots of pixel 0, words of which the second is the depth.
    let [array, runs]: [(&dyn Capture, usize); 2] = [(&Array3dNearest, 4), (&LinearizedNearest, 1)];
    for (capture, stride) in [array, runs] {
        let good = memory(capture, &lfb);
        assert_eq!(good.unpack(capture).expect("undamaged").pixel(0), [near, far]);
        for (change, part) in [
            ([(2 * stride, 0), (2 * stride + 1, 0)], "slot 1 is empty"),
            ([(1, !far.depth_key - 1), (0, 0)], "slot 1 is nearer"),
        ] {
            let mut memory = good.clone();
            for (word, value) in change {
                memory.set("fragments", word, value);
            }
            match memory.unpack(capture) {
                Err(CaptureError::Damaged(LfbError::Structure { pixel: 0, what })) => {
                    assert!(what.contains(part), "{what}");
                }
                other => panic!("{}: {other:?}", capture.name()),
            }
        }
    }
    let damaged = |word, value| {
        let mut memory = memory(&LinearizedNearest, &lfb);
        memory.set("offsets", word, value);
        memory.unpack(&LinearizedNearest)
    };
    assert!(matches!(
        damaged(2, 1),
        Err(CaptureError::Damaged(LfbError::OffsetsFall { pixel: 1 }))
    ));
    let structure = |pixel, result| match result {
        Err(CaptureError::Damaged(LfbError::Structure { pixel: at, .. })) => assert_eq!(at, pixel),
        other => panic!("{other:?}"),
    };
    structure(2, damaged(3, 4));
    structure(0, damaged(0, 1));
}

#[test]
fn offsets_that_are_none_are_refused() {
    let f = Fragment::new(0.5, [1, 2, 3, 4]);
    let lfb = Lfb::from_lists(2, 2, &[vec![f, f], vec![], vec![f], vec![f]]);
    // Also where the fault lies beyond the pool.
    for pool in [2, 4, 9] {
        let good = cut(memory(&Linearized::BLOCKS, &lfb), pool);
        let damaged = |buffer, word, value| {
            let mut memory = good.clone();
            memory.set(buffer, word, value);
            memory.unpack(&Linearized::BLOCKS)
        };
        assert!(good.unpack(&Linearized::BLOCKS).is_ok());
        assert!(matches!(
            damaged("offsets", 1, 1),
            Err(CaptureError::Damaged(LfbError::OffsetsFall { pixel: 1 }))
        ));
        for (buffer, word, value) in [("offsets", 3, 5), ("offsets", 3, u32::MAX), ("total", 0, 5)]
        {
            assert!(
                matches!(
                    damaged(buffer, word, value),
                    Err(CaptureError::Damaged(LfbError::Structure { pixel: 3, .. })
                        | CaptureError::Short { buffer: "fragments", .. })
                ),
                "{buffer} {word} {value}"
            );
        }
    }
}

#[test]
fn an_array_keeps_the_layers_that_fit() {
    for (width, height) in [(1, 1), (3, 1), (7, 5)] {
        let lfb = random_lfb(3, width, height);
        let good = memory(&Array3d, &lfb);
        // A layer has four slots at least.
        let layer = lfb.pixels().max(4);
        for pool in 2..good.pool_slots {
            let part = cut(good.clone(), pool).unpack(&Array3d).expect("undamaged");
            for pixel in 0..lfb.pixels() {
                let held = lfb.pixel(pixel).len().min(pool as usize / layer);
                assert_eq!(part.pixel(pixel), &lfb.pixel(pixel)[..held], "{width} {pool} {pixel}");
            }
        }
    }
}

#[test]
fn groups_that_are_none_are_refused() {
    let f = Fragment::new(0.5, [1, 2, 3, 4]);
    let lists: Vec<_> = (0..80).map(|pixel| vec![f; [2, 0, 1, 1, 3][pixel % 5]]).collect();
    let lfb = Lfb::from_lists(40, 2, &lists);
    let rows: (&dyn Capture, _) = (&Interleaved, [("rows", 1, 4), ("rows", 2, 5), ("rows", 0, 1)]);
    // Pixel 4 has 3 fragments and the base 3 or 4: that of pixel 5, another row, no group at all.
    let bases: (&dyn Capture, _) =
        (&InterleavedLists, [("bases", 4, 4), ("bases", 4, 40), ("bases", 4, 96 * 3)]);
    for (capture, places) in [rows, bases] {
        // Also where the fault lies beyond the pool.
        for pool in [2, 40, 1000] {
            let good = cut(memory(capture, &lfb), pool);
            assert!(good.unpack(capture).is_ok(), "{}", capture.name());
            let others = [
                ("total", 0, 111),
                ("row_total", 0, 10),
                ("row_total", 0, 8),
                ("counts", 1, 1),
                ("counts", 4, 2),
            ];
            for (buffer, word, value) in places.into_iter().chain(others) {
                let mut memory = good.clone();
                memory.set(buffer, word, value);
                let refused = memory.unpack(capture);
                let name = capture.name();
                assert!(
                    matches!(refused, Err(CaptureError::Damaged(LfbError::Structure { .. }))),
                    "{name}: {buffer} {word} {value}: {refused:?}"
                );
            }
        }
    }
}

/// The worst order of a list: its deepest pixels each in a group of their own.
#[test]
fn demand_in_lists_holds_for_the_worst_order() {
    let counts: Vec<u32> = (0..200).map(|pixel| [0, 1, 9, 30, 2][pixel % 5]).collect();
    let histogram = &DepthHistogram::from_counts(counts.iter().copied());
    let lists = Lists { firsts: vec![0, 200], uppers: vec![4, 16] };
    let demand = Demand { counts: &counts, histogram, lists: Some(&lists) };
    // 80 pixels with 1 or 2 in three groups, 80 with 9 or 30 (more than the last bound) in three.
    assert_eq!(InterleavedLists.slots(&demand), 32 * (3 * 2 + 3 * 30));
    let lists = Lists { firsts: vec![0], uppers: vec![4] };
    let demand = Demand { lists: Some(&lists), ..demand };
    assert_eq!(InterleavedLists.slots(&demand), 32 * (5 * 30));
    // Groups by pixel: each has a pixel of 30; the last has eight pixels only.
    assert_eq!(Interleaved.slots(&demand), 32 * 7 * 30);
}

#[test]
fn buffers_are_laid_out_by_lists() {
    let submitted = random_lfb(3, 31, 17);
    let lists = Lists { firsts: vec![0, 527], uppers: vec![1, 3] };
    for capture in CAPTURES {
        let memory = memory_of(capture.upload_in_lists(&submitted, &lists), &submitted);
        let mut expected = submitted.clone();
        capture.order(&mut expected);
        assert_eq!(memory.unpack(*capture).expect("undamaged"), expected, "{}", capture.name());
    }
    let memory = memory_of(InterleavedLists.upload_in_lists(&submitted, &lists), &submitted);
    let bases = |pixel: usize| {
        let bytes = &memory.buffers["bases"][4 * pixel..4 * pixel + 4];
        u32::from_le_bytes(bytes.try_into().expect("four bytes"))
    };
    // The first list is of pixels with one fragment: a row for each 32.
    let shallow = (0..submitted.pixels()).filter(|&pixel| submitted.pixel(pixel).len() == 1);
    for (place, pixel) in shallow.enumerate() {
        assert_eq!(bases(pixel) as usize, place);
    }
}

#[test]
fn a_buffer_that_cannot_be_read_is_an_error() {
    for capture in CAPTURES {
        let good = memory(*capture, &random_lfb(1, 4, 4));
        let mut needed = 0;
        for name in good.buffers.keys() {
            let mut memory = good.clone();
            memory.buffers.remove(name);
            match memory.unpack(*capture) {
                Err(CaptureError::Read(_)) => needed += 1,
                // The counts for a schedule, say: no reader needs them.
                other => {
                    assert_eq!(other.expect("not needed"), good.unpack(*capture).expect("good"));
                }
            }
        }
        assert!(needed >= 2, "{}", capture.name());
    }
}

#[test]
fn totals_that_a_capture_has_no_bits_for_are_refused() {
    let refuses = |capture: &dyn Capture, counts: &[u32]| {
        let histogram = &DepthHistogram::from_counts(counts.iter().copied());
        capture.refuses(&Demand { counts, histogram, lists: None })
    };
    // 64 pixels of 2^24 fragments are 2^30.
    let full = vec![1 << 24; 64];
    let mut below = full.clone();
    below[63] -= 1;
    let reason = refuses(&Linearized::LOOK_BACK, &full).expect("too many");
    assert!(reason.contains("1073741824 fragments"), "{reason}");
    assert_eq!(refuses(&Linearized::LOOK_BACK, &below), None);
    assert_eq!(refuses(&Linearized::BLOCKS, &full), None);
    assert!(refuses(&Linearized::BLOCKS, &vec![1 << 24; 256]).is_some());
    for capture in [&Interleaved as &dyn Capture, &InterleavedLists] {
        // A row of a group is 32 slots, and so are 32 pixels.
        assert_eq!(refuses(capture, &full), None);
        let reason = refuses(capture, &vec![1 << 24; 256]).expect("too many");
        assert!(reason.contains("4294967296 slots"), "{reason}");
    }
    for capture in [&Linearized::BLEND as &dyn Capture, &LinkedList::BLEND] {
        assert_eq!(refuses(capture, &[1 << 24]), None);
        assert!(refuses(capture, &[(1 << 24) + 1]).is_some());
    }
    assert_eq!(refuses(&LinkedList::EACH, &[(1 << 24) + 1]), None);
    assert_eq!(refuses(&LinkedListSorted::PATIENT, &[16_383]), None);
    assert!(refuses(&LinkedListSorted::PATIENT, &[16_384]).is_some());
    for capture in CAPTURES {
        assert_eq!(refuses(*capture, &[0, 1, 500, 7]), None, "{}", capture.name());
    }
}

#[test]
fn names_are_found_and_an_unknown_one_lists_what_there_is() {
    for registered in CAPTURES.iter().chain(WIDE).chain(FAULTY) {
        let name = registered.name();
        assert_eq!(capture(name).expect("registered").name(), name);
        assert_eq!(
            CAPTURES.iter().chain(WIDE).chain(FAULTY).filter(|other| other.name() == name).count(),
            1,
            "{name}"
        );
    }
    let message = capture("linkedlist").err().expect("unknown").to_string();
    assert!(message.contains("linkedlist") && message.contains("linked_list"), "{message}");
}

proptest! {
    #[test]
    fn random_bytes_never_panic(
        width_px in 0u32..4,
        height_px in 0u32..4,
        pool_slots in 0u64..20,
        small in any::<bool>(),
        noise in prop::collection::vec(any::<u32>(), 0..60),
    ) {
        let words = noise.iter().map(|&word| if small { word % 24 } else { word });
        let words = bytes(words);
        let names = [
            "heads", "nexts", "fragments", "node_count", "offsets", "total", "counts", "page_count",
            "fills", "dropped", "rows", "row_total", "bases", "links", "lost",
        ];
        let names = names.into_iter().enumerate();
        let part = |i: usize| words[(i * words.len() / 30) & !3..].to_vec();
        let buffers = names.map(|(i, name)| (name.to_owned(), part(i))).collect();
        let memory = Memory { width_px, height_px, pool_slots, buffers };
        for capture in CAPTURES {
            if let Ok(lfb) = memory.unpack(*capture) {
                prop_assert!(lfb.fragments().len() as u64 <= pool_slots.max(2));
            }
        }
    }

    #[test]
    fn one_changed_word_is_refused_or_loses_nothing(
        seed: u64,
        buffer in any::<prop::sample::Index>(),
        word in any::<prop::sample::Index>(),
        value in 0u32..200,
    ) {
        for capture in CAPTURES {
            let lfb = random_lfb(seed, 5, 5);
            let mut memory = memory(*capture, &lfb);
            let mut names: Vec<_> = memory.buffers.keys().cloned().collect();
            names.sort_unstable();
            let name = &names[buffer.index(names.len())];
            let words = memory.buffers[name].len() / 4;
            memory.set(name, word.index(words), value);
            let Ok(read) = memory.unpack(*capture) else { continue };
            let usage = memory.with(|read| capture.usage(read)).expect("what was unpacked");
            if usage.slots <= memory.pool_slots {
                prop_assert_eq!(read.fragments().len() as u64, usage.fragments);
            }
            // The others hold the number of their fragments twice.
            if !["array3d", "array3d_nearest", "linked_pages4", "linked_pages6"].contains(&capture.name()) {
                prop_assert_eq!(read.fragments().len(), lfb.fragments().len());
            }
        }
    }
}
