//! Whether a technique's picture stays: over runs of one frame, and from one view to the next.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

use oit_image::Image;
use oit_record::{Change, Stability};
use oit_scene::{SHUFFLE, split_frame_view};

use crate::engine::{CellError, Engine, FrameSize, Ready};
use crate::experiment::Overrides;
use crate::technique::Technique;
use crate::verify::finite;

/// Runs a frame again, so many times. Returns the pixels that differ from `image`, which is of its last
/// run, in any bit of any run; and how many pictures there were.
///
/// # Errors
/// Where the device fails.
pub(crate) fn repeat(
    engine: &mut dyn Engine,
    ready: Ready,
    image: &Image,
    repeats: u32,
) -> Result<(u64, Stability), CellError> {
    let mut differs = vec![false; image.pixels.len()];
    let first = hash(image);
    let mut hashes = BTreeSet::from([first]);
    for _ in 0..repeats {
        engine.run(ready)?;
        let again = engine.picture(ready)?;
        hashes.insert(hash(&again));
        for ((a, b), differs) in image.pixels.iter().zip(&again.pixels).zip(&mut differs) {
            *differs |= bits(*a) != bits(*b);
        }
    }
    let stability = Stability {
        runs: 1 + repeats,
        pictures: hashes.len() as u32,
        hash: format!("{first:016x}"),
        change: None,
    };
    Ok((differs.iter().filter(|differs| **differs).count() as u64, stability))
}

/// A pixel bit by bit, for comparing runs: not a number equals itself here.
fn bits(pixel: [f32; 4]) -> [u32; 4] {
    pixel.map(f32::to_bits)
}

/// FNV-1a of 64 bits over the bytes of all pixels, little endian.
fn hash(image: &Image) -> u64 {
    let bytes = image.pixels.iter().flatten().flat_map(|channel| channel.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// What the views of one sequence share: the scene's file, its parameters but for the order of its
/// triangles, the view or the camera path, and the size.
pub(crate) type Sequence = (PathBuf, String, String, FrameSize);

/// The sequence that a view is of. `key` is the scene's file and its parameters in TOML.
pub(crate) fn sequence(key: &(PathBuf, String), view: &str, size: FrameSize) -> Sequence {
    // Parameters that are none were refused when the scene was loaded.
    let mut overrides: Overrides = toml::from_str(&key.1).unwrap_or_default();
    overrides.remove(SHUFFLE);
    let path = split_frame_view(view).map_or(view, |(path, _)| path);
    let overrides = toml::to_string(&overrides).unwrap_or_default();
    (key.0.clone(), overrides, path.to_owned(), size)
}

/// The errors of techniques' pictures on the view that is open and on the one before it.
#[derive(Default)]
pub(crate) struct Changes {
    sequence: Option<Sequence>,
    before: HashMap<String, Vec<[f64; 3]>>,
    now: HashMap<String, Vec<[f64; 3]>>,
}

impl Changes {
    /// A view is opened.
    pub(crate) fn open(&mut self, sequence: Sequence) {
        self.before = std::mem::take(&mut self.now);
        if self.sequence.as_ref() != Some(&sequence) {
            self.before.clear();
            self.sequence = Some(sequence);
        }
    }

    /// Takes note of a picture of the open view, and says how it changed beside the right one.
    ///
    /// The technique's change minus the oracle's is the change of the technique's error, so that errors
    /// are all that is kept.
    pub(crate) fn next(
        &mut self,
        technique: &Technique,
        image: &Image,
        right: &[[f64; 4]],
    ) -> Option<Change> {
        let error = |(pixel, right): (&[f32; 4], &[f64; 4])| {
            std::array::from_fn(|channel| f64::from(pixel[channel]) - right[channel])
        };
        let errors: Vec<[f64; 3]> = image.pixels.iter().zip(right).map(error).collect();
        let change = self.before.get(&technique.to_string()).map(|before| change(before, &errors));
        self.now.insert(technique.to_string(), errors);
        change
    }
}

fn change(before: &[[f64; 3]], now: &[[f64; 3]]) -> Change {
    let (mut px, mut max, mut squares) = (0, 0.0_f64, 0.0);
    for (before, now) in before.iter().zip(now) {
        // What is not a number changes by infinity: comparisons would pass over it.
        let channel = |c: usize| match (now[c] - before[c]).abs() {
            change if change.is_nan() => f64::INFINITY,
            change => change,
        };
        let changes = [0, 1, 2].map(channel);
        let largest = changes.into_iter().fold(0.0, f64::max);
        px += u64::from(largest > 1.0 / 255.0);
        max = max.max(largest);
        squares += changes.iter().map(|change| change * change).sum::<f64>();
    }
    let rms = (squares / (3 * now.len()).max(1) as f64).sqrt();
    Change { px, max: finite(max), rms: finite(rms) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: FrameSize = FrameSize { width_px: 2, height_px: 1 };

    fn image(pixels: [f32; 2]) -> Image {
        Image { width: 2, height: 1, pixels: pixels.map(|grey| [grey, grey, grey, 1.0]).to_vec() }
    }

    fn right(pixels: [f64; 2]) -> Vec<[f64; 4]> {
        pixels.map(|grey| [grey, grey, grey, 1.0]).to_vec()
    }

    #[test]
    fn hashes_are_fnv_1a() {
        let none = Image { width: 0, height: 0, pixels: Vec::new() };
        assert_eq!(hash(&none), 0xcbf2_9ce4_8422_2325);
        // The bytes "foobarfoobarfoob", of which the reference implementation gives this.
        let pixels = vec![*b"foob", *b"arfo", *b"obar", *b"foob"].into_iter();
        let pixel: Vec<f32> = pixels.map(f32::from_le_bytes).collect();
        let words = Image { width: 1, height: 1, pixels: vec![pixel.try_into().unwrap()] };
        let bytes = b"foobarfoobarfoob".iter();
        let by_hand = bytes.fold(14_695_981_039_346_656_037_u128, |hash, byte| {
            ((hash ^ u128::from(*byte)) * 1_099_511_628_211) % (1 << 64)
        });
        assert_eq!(u128::from(hash(&words)), by_hand);
        assert_ne!(hash(&image([0.0, 1.0])), hash(&image([-0.0, 1.0])));
        assert_ne!(hash(&image([0.0, 1.0])), hash(&image([1.0, 0.0])));
    }

    #[test]
    fn an_error_that_stays_is_no_change() {
        let technique: Technique = "weighted".parse().unwrap();
        let key = (PathBuf::from("a.toml"), String::new());
        let mut changes = Changes::default();
        changes.open(sequence(&key, "path@0", SIZE));
        assert_eq!(changes.next(&technique, &image([0.5, 0.5]), &right([0.25, 0.5])), None);
        changes.open(sequence(&key, "path@1", SIZE));
        let still = changes.next(&technique, &image([1.0, 0.75]), &right([0.75, 0.75]));
        assert_eq!(still, Some(Change { px: 0, max: 0.0, rms: 0.0 }));
        changes.open(sequence(&key, "path@2", SIZE));
        let moved = changes.next(&technique, &image([1.0, 0.75]), &right([0.75, 0.25])).unwrap();
        assert_eq!((moved.px, moved.max), (1, 0.5));
        assert!((moved.rms - 0.5_f64.powi(2).mul_add(0.5, 0.0).sqrt()).abs() < 1e-12);
        // Another technique has no view before.
        let other: Technique = "stochastic".parse().unwrap();
        assert_eq!(changes.next(&other, &image([1.0, 0.75]), &right([0.75, 0.25])), None);
        changes.open(sequence(&key, "path@3", SIZE));
        let broken = changes.next(&technique, &image([f32::NAN, 0.75]), &right([0.75, 0.25]));
        assert_eq!(broken, Some(Change { px: 1, max: f64::MAX, rms: f64::MAX }));
        changes.open(sequence(&key, "other@4", SIZE));
        assert_eq!(changes.next(&technique, &image([1.0, 0.5]), &right([0.75, 0.25])), None);
    }

    #[test]
    fn a_sequence_is_a_path_or_a_view_in_any_order() {
        let key = |overrides: &str| (PathBuf::from("a.toml"), overrides.to_owned());
        let plain = sequence(&key("count = 3\n"), "front", SIZE);
        assert_eq!(sequence(&key("count = 3\nshuffle = 7\n"), "front", SIZE), plain);
        assert_ne!(sequence(&key("count = 4\n"), "front", SIZE), plain);
        assert_ne!(sequence(&key("count = 3\n"), "back", SIZE), plain);
        let path = |view| sequence(&key(""), view, SIZE);
        assert_eq!(path("fly@3"), path("fly@4"));
        assert_ne!(path("fly@3"), path("by@3"));
    }
}
