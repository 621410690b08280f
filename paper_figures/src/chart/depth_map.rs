//! Depth complexity of pixels, in the papers' scales: false colour relative to the array size, or
//! grey.

use oit_image::false_color;

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::canvas::{Anchor, Canvas, Colour, text_width};
use crate::style::{INK, MUTED};

/// One view.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthMap {
    /// Its name.
    pub title: String,
    /// Width in pixels.
    pub width_px: usize,
    /// Fragments of each pixel, row by row.
    pub counts: Vec<u16>,
    /// What counts look like.
    pub scale: MapScale,
}

/// What counts look like.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum MapScale {
    /// False colour, black for none; `max_frags` is the top: the next power of two of the deepest
    /// pixel.
    FalseColour {
        /// The top of the scale.
        max_frags: u32,
    },
    /// From black for none to white for so many and more.
    Grey {
        /// What is white.
        white: u32,
    },
}

impl MapScale {
    fn rgb(self, count: u32) -> [u8; 3] {
        match self {
            Self::FalseColour { max_frags } => false_color(count, max_frags),
            Self::Grey { white } => {
                let white = white.max(1);
                [(f64::from(count.min(white)) / f64::from(white) * 255.0).round() as u8; 3]
            }
        }
    }

    fn top(self) -> u32 {
        match self {
            Self::FalseColour { max_frags } => max_frags,
            Self::Grey { white } => white,
        }
    }
}

/// Views, two a row.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthMaps(pub Vec<DepthMap>);

/// Width of a map on the page; a picture has twice as many pixels.
const MAP_PX: usize = 400;
const GAP_PX: f64 = 24.0;
const TITLE_PX: f64 = 22.0;
const LEGEND_PX: f64 = 40.0;

impl DepthMap {
    fn rows(&self) -> usize {
        self.counts.len() / self.width_px.max(1)
    }

    /// The map's size in picture pixels.
    fn picture(&self) -> (usize, usize) {
        let width = 2 * MAP_PX;
        (width, (width * self.rows()).div_ceil(self.width_px.max(1)))
    }

    fn rgb(&self) -> Vec<u8> {
        let (width, height) = self.picture();
        let mut rgb = Vec::with_capacity(width * height * 3);
        for y in 0..height {
            for x in 0..width {
                // The nearest pixel: a mean would show counts that no pixel has.
                let (row, column) = (y * self.rows() / height, x * self.width_px / width);
                let count = self.counts.get(row * self.width_px + column).copied().unwrap_or(0);
                rgb.extend(self.scale.rgb(u32::from(count)));
            }
        }
        rgb
    }

    fn height_px(&self) -> f64 {
        TITLE_PX + self.picture().1 as f64 / 2.0 + LEGEND_PX
    }
}

impl DepthMaps {
    fn row_height(row: &[DepthMap]) -> f64 {
        row.iter().map(DepthMap::height_px).fold(0.0, f64::max)
    }
}

impl Chart for DepthMaps {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let columns = self.0.len().min(2) as f64;
        let width = columns * MAP_PX as f64 + (columns - 1.0).max(0.0) * GAP_PX;
        Ok((width, self.0.chunks(2).map(Self::row_height).sum()))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let mut y = top;
        for row in self.0.chunks(2) {
            for (column, map) in row.iter().enumerate() {
                let x = left + column as f64 * (MAP_PX as f64 + GAP_PX);
                canvas.text((x, y + 9.0), LABEL_PX, INK, Anchor::Start, &map.title);
                let (width_px, height_px) = map.picture();
                let at = (x, y + TITLE_PX);
                canvas.items.push(crate::canvas::Item::Picture { at, width_px, rgb: map.rgb() });
                legend(canvas, (x, y + TITLE_PX + height_px as f64 / 2.0 + 8.0), map.scale)?;
            }
            y += Self::row_height(row);
        }
        Ok(())
    }
}

fn legend(
    canvas: &mut Canvas,
    (left, top): (f64, f64),
    scale: MapScale,
) -> Result<(), FigureError> {
    let max_frags = scale.top();
    const STEPS: u32 = 64;
    let (width, step) = (220.0, 220.0 / f64::from(STEPS));
    let (start, end) = (left + 28.0, left + 28.0 + width);
    let colour = |count: u32| {
        let [red, green, blue] = scale.rgb(count);
        Colour(red, green, blue)
    };
    canvas.rectangle((left, top), (left + 14.0, top + 10.0), colour(0));
    canvas.text((left + 7.0, top + 19.0), SMALL_PX, INK, Anchor::Middle, "0");
    for index in 0..STEPS {
        let count =
            1 + (u64::from(max_frags.max(1) - 1) * u64::from(index) / u64::from(STEPS - 1)) as u32;
        let x = start + f64::from(index) * step;
        canvas.rectangle((x, top), (x + step, top + 10.0), colour(count));
    }
    // White must not fade into the page.
    let corners = [(start, top), (end, top), (end, top + 10.0), (start, top + 10.0), (start, top)];
    canvas.line(&corners, MUTED, 0.5);
    canvas.text((start, top + 19.0), SMALL_PX, INK, Anchor::Start, "1");
    let half = format!("{}", max_frags / 2);
    canvas.text((start + width / 2.0, top + 19.0), SMALL_PX, INK, Anchor::Middle, &half);
    let more = if matches!(scale, MapScale::Grey { .. }) { " or more" } else { "" };
    let most = format!("{max_frags} fragments{more}");
    // The scale ends where its number ends, and the words go on.
    let number_px = text_width(&max_frags.to_string(), SMALL_PX)?;
    canvas.text((end - number_px, top + 19.0), SMALL_PX, INK, Anchor::Start, &most);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_ends_at_white() {
        let scale = MapScale::Grey { white: 8 };
        assert_eq!([0, 4, 8, 200].map(|count| scale.rgb(count)[0]), [0, 128, 255, 255]);
    }
}
