//! Every cell against the oracle, before it is timed.

use std::cell::OnceCell;
use std::collections::HashMap;

use oit_capture::Accuracy;
use oit_fragments::{Lfb, MultisetDifference, Ties, oracle};
use oit_image::{Difference, Image, compare};
use oit_record::{Stability, Verdict, Verification};
use serde::{Deserialize, Serialize};

use crate::assemble::{array, intervals, rewrites, sort_spec};
use crate::engine::{CellError, Engine, Preparation, Ready};
use crate::method::MethodChoice;
use crate::stability::repeat;
use crate::technique::{IntervalChoice, PoolPolicy, Schedule, Sorted, Technique};

/// How far a colour channel of an exact technique may be from the oracle. Its arithmetic is single
/// precision, the oracle's double; the tolerance is four hundred times finer than an 8-bit step.
pub const EXACT_TOLERANCE: f64 = 1e-5;

/// What of a technique is compared with the oracle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum Check {
    /// Its picture, which must be that of the reference's fragments; and the number of fragments
    /// met, without which a technique is not made ready.
    Picture,
    /// The fragments themselves as well, and whether a second run gives the same bits.
    All,
}

/// Pixels whose picture cannot be told from right or wrong where depth alone is compared.
struct Tied {
    pixels: Vec<bool>,
    count_px: u64,
}

impl Tied {
    fn new(pixels: Vec<bool>) -> Self {
        let count_px = pixels.iter().filter(|tied| **tied).count() as u64;
        Self { pixels, count_px }
    }
}

/// The oracle's picture of the open view, and what has been compared with it.
pub struct Verifier {
    reference: Lfb,
    peak: u32,
    picture: Vec<[f64; 4]>,
    tied: Tied,
    /// Where any fragments share a depth, once a method asked.
    shared: OnceCell<Tied>,
    captures: HashMap<(&'static str, Schedule, IntervalChoice, u64), MultisetDifference>,
    repeats: Option<u32>,
}

impl Verifier {
    /// The oracle for the engine's open view.
    ///
    /// # Errors
    /// Where the reference cannot be captured, or disagrees with the counts made without it.
    pub fn new(engine: &mut dyn Engine) -> Result<Self, CellError> {
        let (reference, counts) = engine.reference()?;
        let differ = reference.counts().zip(&counts).filter(|(a, b)| a != *b).count();
        if differ > 0 {
            return Err(CellError::Failed(format!(
                "the reference capture and the count pass differ on {differ} pixels"
            )));
        }
        Ok(Self {
            peak: reference.histogram().peak(),
            picture: oracle::composite(&reference),
            tied: Tied::new(oracle::depth_tied_pixels(&reference)),
            shared: OnceCell::new(),
            reference,
            captures: HashMap::new(),
            repeats: None,
        })
    }

    /// From here on a frame is repeated so often, and what that told is recorded; `None` for once.
    pub fn repeat(&mut self, repeats: Option<u32>) {
        self.repeats = repeats;
    }

    /// The reference capture.
    #[must_use]
    pub fn reference(&self) -> &Lfb {
        &self.reference
    }

    /// The oracle's picture: premultiplied RGBA.
    #[must_use]
    pub fn picture(&self) -> &[[f64; 4]] {
        &self.picture
    }

    /// Compares the last run of a technique with the oracle, in all that is compared.
    ///
    /// # Errors
    /// Where its picture or its fragments cannot be read.
    pub fn verify(
        &mut self,
        engine: &mut dyn Engine,
        technique: &Technique,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<Verification, CellError> {
        self.verify_by(Check::All, engine, technique, ready, preparation)
    }

    /// Compares the last run of a technique with the oracle. Where a picture cannot decide, because
    /// the pool drops fragments or the technique is not meant to be exact, all is compared. Of a method
    /// only its picture is ever compared, and its second run where all is.
    ///
    /// # Errors
    /// Where its picture or its fragments cannot be read.
    pub fn verify_by(
        &mut self,
        check: Check,
        engine: &mut dyn Engine,
        technique: &Technique,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<Verification, CellError> {
        match technique {
            Technique::Sorted(sorted) => {
                self.verify_sorted(check, engine, sorted, ready, preparation)
            }
            Technique::Method(choice) => {
                self.verify_method(check, engine, choice, ready, preparation)
            }
            Technique::Spheres(_) => Err(CellError::Failed(SPHERES.into())),
        }
    }

    fn verify_sorted(
        &mut self,
        check: Check,
        engine: &mut dyn Engine,
        technique: &Sorted,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<Verification, CellError> {
        let inexact = self.inexact(technique)?;
        // How far off it may be: nothing to speak of, what it says itself, or anything.
        let bound = match &inexact {
            None => Some(EXACT_TOLERANCE),
            Some(inexact) => inexact.bound.map(|bound| bound + EXACT_TOLERANCE),
        };
        let dropping = technique.pool.policy == PoolPolicy::Drop;
        let all_checked = check == Check::All || dropping || inexact.is_some();
        let fragments = if all_checked {
            self.fragments(engine, technique, ready, preparation)?
        } else {
            MultisetDifference::default()
        };
        let image = engine.picture(ready)?;
        // What is left out is data; what is left must still be blended right.
        let of_stored = match bound {
            Some(bound) if dropping && fragments.missing > 0 => {
                let stored = oracle::composite(&engine.captured(ready)?);
                Some(difference(&image, &stored)?)
                    .filter(|own| technique.ties == Ties::Total && !within(bound, own))
            }
            _ => None,
        };
        let repeated = self.repeated(all_checked, engine, ready, &image)?;
        let all = difference(&image, &self.picture)?;
        let depth_only = technique.ties == Ties::Depth;
        let decisive = if depth_only
            && self.tied.count_px > 0
            && bound.is_none_or(|bound| !within(bound, &all))
        {
            difference(&self.without(&self.tied, image), &self.picture)?
        } else {
            all
        };
        let (verdict, note) = if let Some(own) = of_stored {
            let note = format!("its picture is not that of what it stored: {}", off(&own));
            (Verdict::Wrong, Some(note))
        } else if dropping && fragments.extra == 0 && fragments.missing > 0 {
            let (missing, pixels) = (fragments.missing, fragments.pixels);
            let note = format!("the pool has no room for {missing} fragments of {pixels} pixels");
            (Verdict::Approximate, Some(note))
        } else if !fragments.is_none() {
            let pixels = fragments.pixels;
            let note = format!("its fragments differ from the reference's on {pixels} pixels");
            (Verdict::Wrong, Some(note))
        } else if bound.is_some_and(|bound| !within(bound, &decisive)) {
            let note = off(&decisive);
            (Verdict::Wrong, Some(note))
        } else if let Some(inexact) = inexact {
            (Verdict::Approximate, Some(inexact.reason))
        } else {
            let tied = (depth_only && self.tied.count_px > 0).then(|| {
                let tied = self.tied.count_px;
                format!("exact but for {tied} pixels on which unlike fragments share a depth")
            });
            (Verdict::Exact, tied)
        };
        let note = match (note, &preparation.note) {
            (Some(note), Some(told)) => Some(format!("{note}; {told}")),
            (note, told) => note.or_else(|| told.clone()),
        };
        Ok(Verification {
            note,
            fragments_missing: fragments.missing,
            fragments_extra: fragments.extra,
            fragments_compared: all_checked,
            tied_px: if depth_only { self.tied.count_px } else { 0 },
            repeat_differs_px: repeated.differs_px,
            stability: repeated.stability,
            ..verification(verdict, &all, preparation)
        })
    }

    fn verify_method(
        &self,
        check: Check,
        engine: &mut dyn Engine,
        choice: &MethodChoice,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<Verification, CellError> {
        let image = engine.picture(ready)?;
        let repeated = self.repeated(check == Check::All, engine, ready, &image)?;
        let all = difference(&image, &self.picture)?;
        let mut tied_px = 0;
        let (verdict, note) = match choice.accuracy(&self.reference.histogram()) {
            Accuracy::Approximate(reason) => (Verdict::Approximate, Some(reason)),
            Accuracy::Exact if within(EXACT_TOLERANCE, &all) => (Verdict::Exact, None),
            Accuracy::Exact => (Verdict::Wrong, Some(off(&all))),
            Accuracy::ExactWithoutTies => {
                let shared = self
                    .shared
                    .get_or_init(|| Tied::new(oracle::depth_shared_pixels(&self.reference)));
                tied_px = shared.count_px;
                let decisive = difference(&self.without(shared, image), &self.picture)?;
                if within(EXACT_TOLERANCE, &decisive) {
                    let note =
                        format!("exact but for {tied_px} pixels on which fragments share a depth");
                    (Verdict::Exact, (tied_px > 0).then_some(note))
                } else {
                    (Verdict::Wrong, Some(off(&decisive)))
                }
            }
        };
        Ok(Verification {
            note,
            fragments_compared: false,
            tied_px,
            repeat_differs_px: repeated.differs_px,
            stability: repeated.stability,
            ..verification(verdict, &all, preparation)
        })
    }

    /// Runs a frame again where it is compared in all, or where that is asked for.
    fn repeated(
        &self,
        all_checked: bool,
        engine: &mut dyn Engine,
        ready: Ready,
        image: &Image,
    ) -> Result<Repeated, CellError> {
        let Some(repeats) = self.repeats.or(all_checked.then_some(1)) else {
            return Ok(Repeated::default());
        };
        let (differs_px, stability) = repeat(engine, ready, image, repeats)?;
        let stability = self.repeats.is_some().then_some(stability);
        Ok(Repeated { differs_px: Some(differs_px), stability })
    }

    /// How its capture differs from the reference. Techniques with the same capture passes share
    /// the answer: what differs between them comes after the capture, if it writes no fragments.
    fn fragments(
        &mut self,
        engine: &mut dyn Engine,
        technique: &Sorted,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<MultisetDifference, CellError> {
        if rewrites(technique, self.peak)? {
            return Ok(self.reference.multiset_difference(&engine.captured(ready)?));
        }
        // A capture that goes by the schedule's lists is another with other intervals.
        let intervals = Some(&technique.intervals).filter(|_| technique.capture.needs_lists());
        let key = (
            technique.capture.name(),
            technique.schedule,
            intervals.cloned().unwrap_or_default(),
            preparation.pool_final,
        );
        if let Some(known) = self.captures.get(&key) {
            return Ok(*known);
        }
        let difference = self.reference.multiset_difference(&engine.captured(ready)?);
        self.captures.insert(key, difference);
        Ok(difference)
    }

    /// The picture with the oracle's pixels in place of the tied ones.
    fn without(&self, tied: &Tied, mut image: Image) -> Image {
        for ((pixel, right), tied) in image.pixels.iter_mut().zip(&self.picture).zip(&tied.pixels) {
            if *tied {
                *pixel = right.map(|channel| channel as f32);
            }
        }
        image
    }

    /// Why a technique is not meant to be exact on this view, if it is not.
    fn inexact(&self, technique: &Sorted) -> Result<Option<Inexact>, CellError> {
        let mut early: Option<(&'static str, f32)> = None;
        let intervals = intervals(technique, self.peak)?;
        for interval in intervals.iter() {
            let (strategy, _) = sort_spec(technique, array(technique, &intervals, interval))?;
            if !strategy.sorts() && !technique.capture.delivers_sorted() {
                let reason = format!("{} does not sort", strategy.name());
                return Ok(Some(Inexact { reason, bound: None }));
            }
            if let Some(bound) = strategy.error_bound()
                && early.is_none_or(|(_, before)| bound > before)
            {
                early = Some((strategy.name(), bound));
            }
        }
        let max_frags = technique.max_frags.for_peak(self.peak);
        if technique.max_frags.truncates(self.peak) {
            let deep = self.reference.counts().filter(|&count| count > max_frags).count();
            let reason =
                format!("{deep} pixels are deeper than the {max_frags} fragments that it holds");
            return Ok(Some(Inexact { reason, bound: None }));
        }
        Ok(early.map(|(name, bound)| Inexact {
            reason: format!("{name} is off by up to {bound:.3e} by its own definition"),
            bound: Some(f64::from(bound)),
        }))
    }
}

/// Why a technique is not meant to be exact.
struct Inexact {
    reason: String,
    /// How far any channel may be off, where its strategies say.
    bound: Option<f64>,
}

/// What repeating a frame told.
#[derive(Default)]
struct Repeated {
    differs_px: Option<u64>,
    stability: Option<Stability>,
}

/// What is recorded of any technique; of its fragments, as if they were equal and compared.
pub(crate) fn verification(
    verdict: Verdict,
    all: &Difference,
    preparation: &Preparation,
) -> Verification {
    Verification {
        verdict,
        note: None,
        wrong_px: all.wrong_px,
        max_error: finite(all.max_color_error),
        rmse: finite(all.rmse),
        max_alpha_error: finite(all.max_alpha_error),
        fragments_missing: 0,
        fragments_extra: 0,
        fragments_compared: true,
        tied_px: 0,
        max_frags: preparation.max_frags,
        pool_initial: preparation.pool_initial,
        pool_final: preparation.pool_final,
        pool_grown: preparation.pool_grown,
        memory_bytes: preparation.memory.map_or(0, |memory| memory.all_bytes),
        lfb_bytes: preparation.memory.and_then(|memory| memory.lfb_bytes),
        peak_bytes: preparation.memory.map(|memory| memory.peak_bytes),
        repeat_differs_px: None,
        prepare_ms: preparation.prepare_ms,
        tuned: None,
        predicted_ns: None,
        ssim: None,
        flip: None,
        stability: None,
    }
}

fn difference(image: &Image, right: &[[f64; 4]]) -> Result<Difference, CellError> {
    compare(image, right).map_err(|error| CellError::Failed(error.to_string()))
}

/// What [`crate::SphereVerifier`] is for.
const SPHERES: &str = "ways of drawing spheres are compared with an oracle of their own";

/// Whether no channel of a picture is off by more than this. What is no number is off by infinity.
fn within(bound: f64, difference: &Difference) -> bool {
    difference.max_color_error <= bound && difference.max_alpha_error <= bound
}

/// How far a picture is off, in words.
pub(crate) fn off(difference: &Difference) -> String {
    let Difference { wrong_px, max_color_error, max_alpha_error, .. } = difference;
    format!(
        "{wrong_px} wrong pixels, colour off by up to {max_color_error:.3e}, alpha by up to \
         {max_alpha_error:.3e}"
    )
}

/// JSON has no infinity: a picture that is not finite has the largest error there is.
pub(crate) fn finite(error: f64) -> f64 {
    error.min(f64::MAX)
}
