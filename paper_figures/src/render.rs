//! A canvas as SVG and as PNG, through plotters' backends. Nothing depends on the time or place of
//! drawing.

use plotters::backend::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use plotters_backend::{BackendColor, BackendCoord, BackendStyle, DrawingErrorKind};

use crate::FigureError;
use crate::canvas::{Anchor, Canvas, Colour, FONT, Item, PLOTTERS_SIZE_PER_EM, text_width};
use crate::png_file;

/// Both outputs are drawn on a grid this much finer than the page, so that what an SVG rounds to
/// whole units is rounded to half a pixel.
const SCALE: f64 = 2.0;

fn rgb(colour: Colour) -> RGBColor {
    RGBColor(colour.0, colour.1, colour.2)
}

fn unit(value: f64) -> i32 {
    (value * SCALE).round() as i32
}

fn units((x, y): (f64, f64)) -> (i32, i32) {
    (unit(x), unit(y))
}

fn failed<E: std::fmt::Display>(error: E) -> FigureError {
    FigureError::Draw(error.to_string())
}

/// Draws everything but pictures, which plotters' SVG backend cannot embed.
///
/// `lower_em` moves text down: plotters' backends do not agree on where the middle of a line is.
fn draw<DB: DrawingBackend>(
    canvas: &Canvas,
    backend: &mut DB,
    lower_em: f64,
) -> Result<(), FigureError> {
    let page = (unit(canvas.width_px), unit(canvas.height_px));
    backend.draw_rect((0, 0), page, &RGBColor(255, 255, 255), true).map_err(failed)?;
    for item in &canvas.items {
        match item {
            Item::Line { points, colour, width_px } => {
                let stroke_width = unit(*width_px).max(1) as u32;
                let style = ShapeStyle { color: rgb(*colour).into(), filled: false, stroke_width };
                backend.draw_path(points.iter().map(|&p| units(p)), &style).map_err(failed)?;
            }
            Item::Polygon { points, colour } => {
                let points = points.iter().map(|&p| units(p));
                backend.fill_polygon(points, &rgb(*colour)).map_err(failed)?;
            }
            Item::Rectangle { sides: [left, top, right, bottom], colour } => {
                let (a, b) = (units((*left, *top)), units((*right, *bottom)));
                backend.draw_rect(a, b, &rgb(*colour), true).map_err(failed)?;
            }
            Item::Circle { centre, radius, colour } => {
                let (centre, radius) = (units(*centre), unit(*radius) as u32);
                backend.draw_circle(centre, radius, &rgb(*colour), true).map_err(failed)?;
            }
            Item::Text { text, .. } if text.is_empty() => {}
            Item::Text { at, size_px, colour, anchor, upwards, text } => {
                text_width("", *size_px)?;
                let h_pos = match anchor {
                    Anchor::Start => HPos::Left,
                    Anchor::Middle => HPos::Center,
                    Anchor::End => HPos::Right,
                };
                let size = size_px * SCALE * PLOTTERS_SIZE_PER_EM;
                let mut font = (FONT, size).into_font();
                if *upwards {
                    font = font.transform(FontTransform::Rotate270);
                }
                let colour = rgb(*colour);
                let style = TextStyle::from(font).color(&colour).pos(Pos::new(h_pos, VPos::Center));
                let lower = lower_em * size_px;
                let at = if *upwards { (at.0 + lower, at.1) } else { (at.0, at.1 + lower) };
                backend.draw_text(text, &style, units(at)).map_err(failed)?;
            }
            Item::Picture { .. } => {}
        }
    }
    backend.present().map_err(failed)
}

/// The canvas as SVG. `description` is put into its `desc` element.
///
/// # Errors
/// Where the font is damaged or plotters refuses.
pub(crate) fn svg(canvas: &Canvas, description: &str) -> Result<String, FigureError> {
    let size = (unit(canvas.width_px) as u32, unit(canvas.height_px) as u32);
    let mut text = String::new();
    draw(canvas, &mut SVGBackend::with_string(&mut text, size), 0.1)?;
    // The grid is finer than the page: the view box stays, the natural size is the page's.
    let fine = format!("width=\"{}\" height=\"{}\" viewBox", size.0, size.1);
    let page = format!(
        "width=\"{}\" height=\"{}\" font-family=\"{FONT}\" viewBox",
        canvas.width_px, canvas.height_px
    );
    let text: String = text.lines().map(|line| slim(line) + "\n").collect();
    let text = text.replacen(&fine, &page, 1);
    let (Some(head), Some(end)) = (text.find('>'), text.rfind("</svg>")) else {
        return Err(FigureError::Draw("plotters wrote no SVG element".to_owned()));
    };
    let mut pictures = String::new();
    for item in &canvas.items {
        let Item::Picture { at, width_px, rgb } = item else { continue };
        let height_px = rgb.len() / 3 / width_px.max(&1);
        let png = png_file::encode(rgb.clone(), *width_px as u32, height_px as u32, "")?;
        let (x, y) = units(*at);
        pictures += &format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width_px}\" height=\"{height_px}\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
            base64(&png)
        );
    }
    let description = escape(description);
    let (head, body) = (&text[..=head], &text[head + 1..end]);
    Ok(format!("{head}\n<desc>{description}</desc>{body}{pictures}</svg>\n"))
}

/// A line that plotters wrote, without what an SVG says anyway: that nothing is transparent, the font
/// that the root element names once, and digits of a font size that are but rounding.
///
/// Plotters writes each tag in a line of its own and escapes what is in a text.
fn slim(line: &str) -> String {
    if !line.starts_with('<') {
        return line.to_owned();
    }
    let family = format!(" font-family=\"{FONT}\"");
    let line = line.replace(" opacity=\"1\"", "").replace(&family, "");
    const SIZE: &str = " font-size=\"";
    let Some((before, (size, after))) =
        line.split_once(SIZE).and_then(|(before, rest)| Some((before, rest.split_once('"')?)))
    else {
        return line;
    };
    let Ok(number) = size.parse::<f64>() else { return line };
    format!("{before}{SIZE}{}\"{after}", (number * 1000.0).round() / 1000.0)
}

/// The canvas as PNG with two pixels a unit. `description` is put into a text chunk.
///
/// # Errors
/// Where the font is damaged or plotters or the encoder refuses.
pub(crate) fn png(canvas: &Canvas, description: &str) -> Result<Vec<u8>, FigureError> {
    let (width, height) = (unit(canvas.width_px) as u32, unit(canvas.height_px) as u32);
    let mut pixels = vec![0; width as usize * height as usize * 3];
    let bitmap = BitMapBackend::with_buffer(&mut pixels, (width, height));
    draw(canvas, &mut FewShades(bitmap), 0.24)?;
    for item in &canvas.items {
        let Item::Picture { at, width_px, rgb } = item else { continue };
        let (x, y) = (unit(at.0) as usize, unit(at.1) as usize);
        for (row, line) in rgb.chunks_exact(width_px * 3).enumerate() {
            let start = ((y + row) * width as usize + x) * 3;
            if let Some(place) = pixels.get_mut(start..start + line.len()) {
                place.copy_from_slice(line);
            }
        }
    }
    png_file::encode(pixels, width, height, description)
}

/// How many shades an edge has between what lies below and itself. Few of them look like many, and
/// leave a page with no more colours than a palette holds: its file is then half as long.
const EDGE_SHADES: f64 = 8.0;

/// A bitmap on which edges of text and areas have few shades.
struct FewShades<'a>(BitMapBackend<'a>);

type BitMapError<'a> = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

impl<'a> DrawingBackend for FewShades<'a> {
    type ErrorType = BitMapError<'a>;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawingErrorKind<Self::ErrorType>> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Result<(), DrawingErrorKind<Self::ErrorType>> {
        self.0.present()
    }

    fn draw_pixel(
        &mut self,
        point: BackendCoord,
        mut color: BackendColor,
    ) -> Result<(), DrawingErrorKind<Self::ErrorType>> {
        color.alpha = (color.alpha * EDGE_SHADES).round() / EDGE_SHADES;
        self.0.draw_pixel(point, color)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Self::ErrorType>> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), DrawingErrorKind<Self::ErrorType>> {
        self.0.draw_rect(upper_left, bottom_right, style, fill)
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |index: usize| u32::from(chunk.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            if digit <= chunk.len() {
                text.push(char::from(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{base64, slim};

    #[test]
    fn an_svg_says_nothing_twice() {
        let tag =
            r#"<text x="4" font-family="sans-serif" font-size="26.000000000000004" opacity="1">"#;
        assert_eq!(slim(tag), r#"<text x="4" font-size="26">"#);
        let faint = r##"<rect x="0" opacity="0.5" fill="#FFFFFF"/>"##;
        assert_eq!(slim(faint), faint);
        let written = r#"text of opacity="1""#;
        assert_eq!(slim(written), written);
    }

    #[test]
    fn base64_pads() {
        // RFC 4648, section 10.
        assert_eq!(base64(b""), "");
        assert_eq!(base64(b"f"), "Zg==");
        assert_eq!(base64(b"fo"), "Zm8=");
        assert_eq!(base64(b"foobar"), "Zm9vYmFy");
    }
}
