//! Float images, EXR and PNG files, and error metrics.
//!
//! - [`Image`]: what a resolve gives, premultiplied RGBA in `f32`.
//! - [`write_exr`] and [`read_exr`]: the float image itself, with its depth complexity.
//! - [`write_png`], [`write_png16_gray`], [`false_color_png`]: images to look at. The same pixels
//!   give the same bytes: no time, name or machine is written into a file.
//! - [`Window`]: the part of a picture that is looked at closely.
//! - [`compare`]: the error of an image against an `f64` reference.
//! - [`perceptual`](fn@perceptual): how much two pictures look alike.
//!
//! Every file is written beside its target and then renamed, so a reader sees the old file or the
//! whole new one.

mod atomic;
mod error;
mod exr_file;
mod false_color;
mod image;
mod metrics;
mod perceptual;
mod png_file;
mod window;

pub use error::ImageError;
pub use exr_file::{DEPTH_COMPLEXITY_CHANNEL, MAX_EXR_PX, read_exr, write_exr};
pub use false_color::{false_color, false_color_png, viridis};
pub use image::Image;
pub use metrics::{Difference, WRONG_PX_ERROR, compare};
pub use perceptual::{Perceptual, perceptual};
pub use png_file::{NON_FINITE_COLOR, write_png, write_png16_gray};
pub use window::{DETAIL_PX, Window};
