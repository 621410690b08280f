//! A drawing as a list of shapes: charts add to it, [`crate::render`] turns it into SVG and PNG.
//!
//! Coordinates are in pixels of the SVG at its natural size, from the top left. The PNG has twice
//! as many.

use std::sync::OnceLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use crate::FigureError;

/// The name under which the vendored font is known to plotters. An SVG names it too, so a reader
/// shows it in their own sans-serif.
pub(crate) const FONT: &str = "sans-serif";

/// Roboto Regular, Apache-2.0: `fonts/LICENSE-Roboto-Apache-2.0.txt`.
static ROBOTO: &[u8] = include_bytes!("../fonts/Roboto-Regular.ttf");

/// Plotters' font size is this much larger than the em.
pub(crate) const PLOTTERS_SIZE_PER_EM: f64 = 1.24;

/// Red, green and blue.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// Mixed with white: 0 is the colour itself, 1 is white.
    #[must_use]
    pub fn tint(self, white: f64) -> Self {
        let mix = |c: u8| (f64::from(c) + (255.0 - f64::from(c)) * white).round() as u8;
        Self(mix(self.0), mix(self.1), mix(self.2))
    }
}

/// Which part of a text lies at its x.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Anchor {
    /// Its start.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// One shape.
#[derive(Clone, PartialEq, Debug)]
pub enum Item {
    /// A line through points.
    Line {
        /// The points.
        points: Vec<(f64, f64)>,
        /// Its colour.
        colour: Colour,
        /// Its width.
        width_px: f64,
    },
    /// A filled polygon.
    Polygon {
        /// The corners.
        points: Vec<(f64, f64)>,
        /// Its colour.
        colour: Colour,
    },
    /// A filled rectangle.
    Rectangle {
        /// Left, top, right, bottom.
        sides: [f64; 4],
        /// Its colour.
        colour: Colour,
    },
    /// A filled circle.
    Circle {
        /// The middle.
        centre: (f64, f64),
        /// The radius.
        radius: f64,
        /// Its colour.
        colour: Colour,
    },
    /// A line of text.
    Text {
        /// Where the anchor lies; y is the middle of the line.
        at: (f64, f64),
        /// Height of the em.
        size_px: f64,
        /// Its colour.
        colour: Colour,
        /// Its anchor.
        anchor: Anchor,
        /// Turned by a quarter, reading upwards.
        upwards: bool,
        /// The text.
        text: String,
    },
    /// A picture, drawn with square pixels.
    Picture {
        /// Its top left corner.
        at: (f64, f64),
        /// Its width in its own pixels; two of them make one of the drawing's.
        width_px: usize,
        /// Three bytes a pixel, row by row.
        rgb: Vec<u8>,
    },
}

/// A list of shapes on a white page.
#[derive(Clone, PartialEq, Debug)]
pub struct Canvas {
    /// Width of the page.
    pub width_px: f64,
    /// Height of the page.
    pub height_px: f64,
    /// The shapes, later ones above earlier ones.
    pub items: Vec<Item>,
}

/// Registers the vendored font, once.
fn register() -> Result<(), FigureError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let done = || register_font(FONT, FontStyle::Normal, ROBOTO).is_ok();
    if *REGISTERED.get_or_init(done) { Ok(()) } else { Err(FigureError::Font) }
}

/// The width of a text in the vendored font.
///
/// # Errors
/// Where the vendored font is damaged.
pub(crate) fn text_width(text: &str, size_px: f64) -> Result<f64, FigureError> {
    register()?;
    // Measured large and scaled down: plotters rounds to whole pixels.
    let scale = 8.0;
    let size = size_px * PLOTTERS_SIZE_PER_EM * scale;
    let font = FontDesc::new(FontFamily::SansSerif, size, FontStyle::Normal);
    let (width, _) = font.box_size(text).map_err(|_| FigureError::Font)?;
    Ok(f64::from(width) / scale)
}

/// The width of the widest of some texts.
///
/// # Errors
/// Where the vendored font is damaged.
pub(crate) fn widest<'a>(
    texts: impl IntoIterator<Item = &'a str>,
    size_px: f64,
) -> Result<f64, FigureError> {
    texts.into_iter().try_fold(0.0, |widest, text| Ok(text_width(text, size_px)?.max(widest)))
}

/// As much of a text as fits, ending in an ellipsis where something was cut.
///
/// # Errors
/// Where the vendored font is damaged.
pub(crate) fn fitted(text: &str, size_px: f64, width_px: f64) -> Result<String, FigureError> {
    if text_width(text, size_px)? <= width_px {
        return Ok(text.to_owned());
    }
    let mut kept: Vec<char> = text.chars().collect();
    while kept.pop().is_some() {
        let cut = kept.iter().collect::<String>() + "…";
        if text_width(&cut, size_px)? <= width_px {
            return Ok(cut);
        }
    }
    Ok(String::new())
}

/// A text broken into lines at spaces. A word wider than the line has a line of its own.
///
/// # Errors
/// Where the vendored font is damaged.
pub(crate) fn wrapped(text: &str, size_px: f64, width_px: f64) -> Result<Vec<String>, FigureError> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(line)) if text_width(&longer, size_px)? <= width_px => {
                *line = longer;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    Ok(lines)
}

impl Canvas {
    /// An empty page.
    #[must_use]
    pub fn new(width_px: f64, height_px: f64) -> Self {
        Self { width_px, height_px, items: Vec::new() }
    }

    /// Adds a line through points.
    pub fn line(&mut self, points: &[(f64, f64)], colour: Colour, width_px: f64) {
        self.items.push(Item::Line { points: points.to_vec(), colour, width_px });
    }

    /// Adds a filled polygon.
    pub fn polygon(&mut self, points: &[(f64, f64)], colour: Colour) {
        self.items.push(Item::Polygon { points: points.to_vec(), colour });
    }

    /// Adds a filled rectangle between two opposite corners.
    pub fn rectangle(&mut self, a: (f64, f64), b: (f64, f64), colour: Colour) {
        let sides = [a.0.min(b.0), a.1.min(b.1), a.0.max(b.0), a.1.max(b.1)];
        self.items.push(Item::Rectangle { sides, colour });
    }

    /// Adds a filled circle.
    pub fn circle(&mut self, centre: (f64, f64), radius: f64, colour: Colour) {
        self.items.push(Item::Circle { centre, radius, colour });
    }

    /// Adds a line of text whose vertical middle lies at `at.1`.
    pub fn text(
        &mut self,
        at: (f64, f64),
        size_px: f64,
        colour: Colour,
        anchor: Anchor,
        text: &str,
    ) {
        let text = text.to_owned();
        self.items.push(Item::Text { at, size_px, colour, anchor, upwards: false, text });
    }

    /// Adds a line of text that reads upwards, its middle at `at`.
    pub fn text_upwards(&mut self, at: (f64, f64), size_px: f64, colour: Colour, text: &str) {
        let (anchor, text) = (Anchor::Middle, text.to_owned());
        self.items.push(Item::Text { at, size_px, colour, anchor, upwards: true, text });
    }

    /// The boxes of all texts: left, top, right, bottom, and the text. For tests of overlap.
    ///
    /// # Errors
    /// Where the vendored font is damaged.
    pub fn text_boxes(&self) -> Result<Vec<([f64; 4], &str)>, FigureError> {
        let mut boxes = Vec::new();
        for item in &self.items {
            let Item::Text { at: (x, y), size_px, anchor, upwards, text, .. } = item else {
                continue;
            };
            let (width, half) = (text_width(text, *size_px)?, size_px / 2.0);
            let left = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => width / 2.0,
                Anchor::End => width,
            };
            let sides = if *upwards {
                [x - half, y - width / 2.0, x + half, y + width / 2.0]
            } else {
                [x - left, y - half, x - left + width, y + half]
            };
            boxes.push((sides, text.as_str()));
        }
        Ok(boxes)
    }
}
