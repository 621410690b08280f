//! Every cell against the oracle, before it is timed.

use std::collections::HashMap;

use oit_fragments::{Lfb, MultisetDifference, Ties, oracle};
use oit_image::{Difference, Image, compare};
use oit_record::{Verdict, Verification};

use crate::assemble::{array, intervals, sort_spec};
use crate::engine::{CellError, Engine, Preparation, Ready};
use crate::technique::{PoolPolicy, Schedule, Technique};

/// How far a colour channel of an exact technique may be from the oracle. Its arithmetic is single
/// precision, the oracle's double; the tolerance is four hundred times finer than an 8-bit step.
pub const EXACT_TOLERANCE: f64 = 1e-5;

/// The oracle's picture of the open view, and what has been compared with it.
pub struct Verifier {
    reference: Lfb,
    peak: u32,
    picture: Vec<[f64; 4]>,
    tied: Vec<bool>,
    tied_px: u64,
    captures: HashMap<(&'static str, Schedule, u64), MultisetDifference>,
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
        let tied = oracle::depth_tied_pixels(&reference);
        Ok(Self {
            peak: reference.histogram().peak(),
            picture: oracle::composite(&reference),
            tied_px: tied.iter().filter(|tied| **tied).count() as u64,
            tied,
            reference,
            captures: HashMap::new(),
        })
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

    /// Compares the last run of a technique with the oracle.
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
        let fragments = self.fragments(engine, technique, ready, preparation)?;
        let image = engine.picture(ready)?;
        let reason = self.inexact(technique)?;
        let dropping = technique.pool.policy == PoolPolicy::Drop;
        // What is left out is data; what is left must still be blended right.
        let of_stored = if dropping && fragments.missing > 0 && reason.is_none() {
            let stored = oracle::composite(&engine.captured(ready)?);
            Some(difference(&image, &stored)?)
                .filter(|own| technique.ties == Ties::Total && !exact(own))
        } else {
            None
        };
        engine.run(ready)?;
        let again = engine.picture(ready)?;
        let differs =
            image.pixels.iter().zip(&again.pixels).filter(|(a, b)| bits(**a) != bits(**b));
        let repeat_differs_px = differs.count() as u64;
        let all = difference(&image, &self.picture)?;
        let depth_only = technique.ties == Ties::Depth;
        let decisive = if depth_only && self.tied_px > 0 {
            difference(&self.without_tied(image), &self.picture)?
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
        } else if let Some(reason) = reason {
            (Verdict::Approximate, Some(reason))
        } else if !exact(&decisive) {
            let note = off(&decisive);
            (Verdict::Wrong, Some(note))
        } else {
            let tied = (depth_only && self.tied_px > 0).then(|| {
                let tied = self.tied_px;
                format!("exact but for {tied} pixels on which unlike fragments share a depth")
            });
            (Verdict::Exact, tied)
        };
        Ok(Verification {
            verdict,
            note,
            wrong_px: all.wrong_px,
            max_error: finite(all.max_color_error),
            rmse: finite(all.rmse),
            max_alpha_error: finite(all.max_alpha_error),
            fragments_missing: fragments.missing,
            fragments_extra: fragments.extra,
            tied_px: if depth_only { self.tied_px } else { 0 },
            max_frags: preparation.max_frags,
            pool_initial: preparation.pool_initial,
            pool_final: preparation.pool_final,
            pool_grown: preparation.pool_grown,
            memory_bytes: preparation.memory.map_or(0, |memory| memory.all_bytes),
            lfb_bytes: preparation.memory.map(|memory| memory.lfb_bytes),
            peak_bytes: preparation.memory.map(|memory| memory.peak_bytes),
            repeat_differs_px: Some(repeat_differs_px),
            prepare_ms: preparation.prepare_ms,
        })
    }

    /// How its capture differs from the reference. Techniques with the same capture passes share
    /// the answer: what differs between them comes after the capture.
    fn fragments(
        &mut self,
        engine: &mut dyn Engine,
        technique: &Technique,
        ready: Ready,
        preparation: &Preparation,
    ) -> Result<MultisetDifference, CellError> {
        let key = (technique.capture.name(), technique.schedule, preparation.pool_final);
        if let Some(known) = self.captures.get(&key) {
            return Ok(*known);
        }
        let difference = self.reference.multiset_difference(&engine.captured(ready)?);
        self.captures.insert(key, difference);
        Ok(difference)
    }

    fn without_tied(&self, mut image: Image) -> Image {
        for ((pixel, right), tied) in image.pixels.iter_mut().zip(&self.picture).zip(&self.tied) {
            if *tied {
                *pixel = right.map(|channel| channel as f32);
            }
        }
        image
    }

    /// Why a technique is not meant to be exact on this view, if it is not.
    fn inexact(&self, technique: &Technique) -> Result<Option<String>, CellError> {
        let intervals = intervals(technique, self.peak)?;
        for interval in intervals.iter() {
            let (strategy, _) = sort_spec(technique, array(technique, &intervals, interval))?;
            if !strategy.sorts() {
                return Ok(Some(format!("{} does not sort", strategy.name())));
            }
        }
        let max_frags = technique.max_frags.for_peak(self.peak);
        Ok(technique.max_frags.truncates(self.peak).then(|| {
            let deep = self.reference.counts().filter(|&count| count > max_frags).count();
            format!("{deep} pixels are deeper than the {max_frags} fragments that it holds")
        }))
    }
}

fn difference(image: &Image, right: &[[f64; 4]]) -> Result<Difference, CellError> {
    compare(image, right).map_err(|error| CellError::Failed(error.to_string()))
}

/// Whether a picture is as near to the oracle's as one of single precision can be.
fn exact(difference: &Difference) -> bool {
    difference.wrong_px == 0
        && difference.max_color_error <= EXACT_TOLERANCE
        && difference.max_alpha_error <= EXACT_TOLERANCE
}

/// How far a picture is off, in words.
fn off(difference: &Difference) -> String {
    let Difference { wrong_px, max_color_error, max_alpha_error, .. } = difference;
    format!(
        "{wrong_px} wrong pixels, colour off by up to {max_color_error:.3e}, alpha by up to \
         {max_alpha_error:.3e}"
    )
}

/// A pixel bit by bit, for comparing runs: not a number equals itself here.
fn bits(pixel: [f32; 4]) -> [u32; 4] {
    pixel.map(f32::to_bits)
}

/// JSON has no infinity: a picture that is not finite has the largest error there is.
fn finite(error: f64) -> f64 {
    error.min(f64::MAX)
}
