//! Figures and tables of the papers, drawn from records.
//!
//! A figure is a function of records and published numbers: the same records give the same bytes,
//! whenever and wherever it is drawn. [`figures::FIGURES`] lists them; [`claims`] judges the papers'
//! sentences by the same records.

mod axis;
mod canvas;
mod chart;
pub mod claims;
mod data;
mod error;
pub mod figures;
mod generate;
mod mechanism;
mod output;
mod png_file;
pub mod published;
mod render;
mod series;
mod style;
mod technique_names;

pub use canvas::Canvas;
pub use error::FigureError;
pub use generate::{Drawn, generate, read, write_all};
pub use output::Output;
