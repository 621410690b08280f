//! Pictures in rows, each under its title.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::canvas::{Anchor, Canvas, Colour, Item, text_width};
use crate::style::{INK, MUTED};

/// One picture.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Picture {
    /// What is above it.
    pub title: String,
    /// Its width in its own pixels.
    pub width: usize,
    /// Three bytes a pixel, row by row.
    pub rgb: Vec<u8>,
}

/// Pictures side by side.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct PictureRow {
    /// The heading.
    pub title: String,
    /// The pictures, left to right.
    pub pictures: Vec<Picture>,
}

/// Rows of pictures, and a scale of colours below them.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Pictures {
    /// The rows.
    pub rows: Vec<PictureRow>,
    /// The scale: colours from left to right, and what its ends mean.
    pub scale: (Vec<Colour>, [String; 2]),
}

/// Width of a picture on the page; a PNG has twice as many pixels.
const PICTURE_PX: usize = 320;
const GAP_PX: f64 = 16.0;
const HEADING_PX: f64 = 24.0;
const TITLE_PX: f64 = 18.0;
const BELOW_PX: f64 = 14.0;
const SCALE_PX: f64 = 34.0;

impl Picture {
    fn rows(&self) -> usize {
        self.rgb.len() / 3 / self.width.max(1)
    }

    /// As large as it is drawn: by whole rows and columns, without any pixel mixed with another.
    fn scaled(&self) -> (usize, usize, Vec<u8>) {
        let width = 2 * PICTURE_PX;
        let height = (width * self.rows()).div_ceil(self.width.max(1));
        let mut rgb = Vec::with_capacity(width * height * 3);
        for y in 0..height {
            for x in 0..width {
                let (row, column) = (y * self.rows() / height, x * self.width / width);
                let start = 3 * (row * self.width + column);
                rgb.extend(self.rgb.get(start..start + 3).unwrap_or(&[0; 3]));
            }
        }
        (width, height, rgb)
    }

    fn height_px(&self) -> f64 {
        let height = (2 * PICTURE_PX * self.rows()).div_ceil(self.width.max(1));
        TITLE_PX + height as f64 / 2.0
    }
}

impl PictureRow {
    fn height_px(&self) -> f64 {
        let pictures = self.pictures.iter().map(Picture::height_px).fold(0.0, f64::max);
        HEADING_PX + pictures + BELOW_PX
    }
}

impl Chart for Pictures {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let most = self.rows.iter().map(|row| row.pictures.len()).max().unwrap_or(0) as f64;
        let width = most * PICTURE_PX as f64 + (most - 1.0).max(0.0) * GAP_PX;
        let rows: f64 = self.rows.iter().map(PictureRow::height_px).sum();
        Ok((width, rows + SCALE_PX))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let mut y = top;
        for row in &self.rows {
            canvas.text((left, y + 9.0), LABEL_PX, INK, Anchor::Start, &row.title);
            for (column, picture) in row.pictures.iter().enumerate() {
                let x = left + column as f64 * (PICTURE_PX as f64 + GAP_PX);
                let title = (x, y + HEADING_PX + 7.0);
                canvas.text(title, SMALL_PX, MUTED, Anchor::Start, &picture.title);
                let (width_px, height_px, rgb) = picture.scaled();
                let (from, to) = ((x, y + HEADING_PX + TITLE_PX), height_px as f64 / 2.0);
                canvas.items.push(Item::Picture { at: from, width_px, rgb });
                // What is white must not fade into the page.
                let (right, bottom) = (x + PICTURE_PX as f64, from.1 + to);
                let corners = [from, (right, from.1), (right, bottom), (x, bottom), from];
                canvas.line(&corners, MUTED, 0.5);
            }
            y += row.height_px();
        }
        let (colours, [first, last]) = &self.scale;
        let mut x = left;
        canvas.text((x, y + 9.0), SMALL_PX, INK, Anchor::Start, first);
        x += text_width(first, SMALL_PX)? + 8.0;
        let step = 160.0 / colours.len().max(1) as f64;
        for colour in colours {
            canvas.rectangle((x, y + 3.0), (x + step, y + 15.0), *colour);
            x += step;
        }
        canvas.text((x + 8.0, y + 9.0), SMALL_PX, INK, Anchor::Start, last);
        Ok(())
    }
}
