//! Ways of drawing spheres, judged by an oracle of their own: they draw opaque pictures, and capture no
//! fragments that others could be compared with.

use std::collections::HashMap;
use std::sync::Arc;

use oit_record::{Verdict, Verification};
use oit_scene::{Camera, Shading, Spheres};
use oit_spheres::{Detail, Expected, Variation, expected};

use crate::engine::{CellError, Engine, FrameSize, Preparation, Ready, Source, ViewData};
use crate::stability::repeat;
use crate::verify::{off, verification};

/// The right pictures of the open view's spheres.
pub struct SphereVerifier {
    spheres: Arc<Spheres>,
    shading: Shading,
    camera: Camera,
    size: FrameSize,
    /// By the level of detail that is drawn; made when first asked for.
    expected: HashMap<Detail, Expected>,
}

impl SphereVerifier {
    /// For a view; `None` where it is not of spheres.
    #[must_use]
    pub fn new(view: &ViewData) -> Option<Self> {
        let Source::Scene(scene) = &view.source else { return None };
        Some(Self {
            spheres: scene.spheres.clone()?,
            shading: scene.shading,
            camera: scene.camera,
            size: view.size,
            expected: HashMap::new(),
        })
    }

    /// The right picture where this level of detail is drawn.
    pub fn expected(&mut self, detail: Detail) -> &Expected {
        let Self { spheres, shading, camera, size, expected: made } = self;
        made.entry(detail).or_insert_with(|| {
            expected(spheres, detail, shading, camera, size.width_px, size.height_px)
        })
    }

    /// Compares the last run of a way of drawing with the oracle, and another run with it, or as many as
    /// are asked for.
    ///
    /// # Errors
    /// Where its picture cannot be read.
    pub fn verify(
        &mut self,
        engine: &mut dyn Engine,
        variation: &Variation,
        ready: Ready,
        preparation: &Preparation,
        repeats: Option<u32>,
    ) -> Result<Verification, CellError> {
        let image = engine.picture(ready)?;
        let found = self.expected(variation.detail).compare(&image.pixels);
        let all = oit_image::Difference {
            wrong_px: found.wrong_px,
            max_color_error: found.max_error,
            rmse: found.rmse,
            max_alpha_error: found.max_alpha_error,
        };
        let (differs_px, stability) = repeat(engine, ready, &image, repeats.unwrap_or(1))?;
        let (verdict, note) = match variation.accuracy() {
            Err(why) => (Verdict::Approximate, Some(why.to_owned())),
            Ok(()) if found.wrong_px > 0 => (Verdict::Wrong, Some(off(&all))),
            Ok(()) => {
                let undecided = found.undecided_px;
                let note = format!("right but for {undecided} pixels at the rims of spheres");
                (Verdict::Exact, (undecided > 0).then_some(note))
            }
        };
        Ok(Verification {
            note,
            fragments_compared: false,
            tied_px: found.undecided_px,
            repeat_differs_px: Some(differs_px),
            stability: repeats.map(|_| stability),
            ..verification(verdict, &all, preparation)
        })
    }
}
