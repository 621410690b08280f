//! The figures and tables there are, one file each.

mod advise_regret;
mod approx_accuracy;
mod approx_errors;
mod bma_figure_3;
mod bma_figure_4;
mod bma_figure_5;
mod bma_figure_6;
mod bma_figure_7;
mod bma_figure_8;
mod bma_figure_9;
mod bma_intervals;
mod bma_overhead;
mod bma_table_1;
mod bma_table_2;
pub(crate) mod bma_views;
mod compare;
mod compare_page;
mod counts;
mod cuda_resolve;
mod flights;
mod images;
mod layout_views;
mod lfb_array;
mod lfb_figure_20_11;
mod lfb_figure_20_12;
mod lfb_figure_20_9;
mod lfb_layouts;
pub(crate) mod lfb_memory;
mod lfb_overflow;
mod lfb_table_20_1;
pub(crate) mod lfb_views;
mod mechanism_occupancy;
mod mechanism_registers;
mod pareto;
mod pareto_all;
mod peel_passes;
mod ratios;
mod rbs_compile;
mod rbs_figure_5;
mod rbs_fragments;
mod rbs_merge;
mod rbs_registers;
mod rbs_table_1;
mod rbs_table_2;
mod rbs_table_3;
pub(crate) mod rbs_views;
mod sort_deep;
mod sort_depths;
mod sort_intervals;
mod spheres_cross;
mod spheres_renders;
mod spheres_scale;
mod spheres_tables;
pub(crate) mod spheres_views;
mod stability;
mod work;

pub use compare::compare;
pub use compare_page::{Page, compare_pages};

use analysis::Tables;

use crate::FigureError;
use crate::output::Output;

/// A figure or table that is drawn from records.
pub trait Figure: Sync {
    /// Its name: the start of the names of its files.
    fn name(&self) -> &'static str;

    /// Which table or figure of which paper it repeats, or what it shows.
    fn source(&self) -> &'static str;

    /// What records must hold for it to be drawn.
    fn needs(&self) -> &'static str;

    /// Draws it: nothing where the records lack what it needs.
    ///
    /// # Errors
    /// Where published numbers, a file beside a record or the font is damaged.
    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError>;
}

/// All figures, in the order of the index.
pub const FIGURES: &[&dyn Figure] = &[
    &rbs_table_1::RbsTable1,
    &rbs_table_2::RbsTable2,
    &rbs_table_3::RbsTable3,
    &rbs_figure_5::RbsFigure5,
    &rbs_fragments::RbsFragments,
    &rbs_merge::RbsMerge,
    &rbs_registers::RbsRegisters,
    &rbs_compile::RbsCompile,
    &cuda_resolve::CudaResolve,
    &bma_table_1::BmaTable1,
    &bma_table_2::BmaTable2,
    &bma_figure_3::BmaFigure3,
    &bma_figure_4::BmaFigure4,
    &bma_figure_5::BmaFigure5,
    &bma_figure_6::BmaFigure6,
    &bma_figure_7::BmaFigure7,
    &bma_figure_8::BmaFigure8,
    &bma_figure_9::BmaFigure9,
    &bma_overhead::BmaOverhead,
    &bma_intervals::BmaIntervals,
    &pareto::Pareto,
    &pareto_all::ParetoAll,
    &advise_regret::AdviseRegret,
    &peel_passes::PeelPasses,
    &approx_accuracy::ApproxAccuracy,
    &approx_errors::ApproxErrors,
    &sort_depths::SortDepths,
    &sort_deep::SortDeep,
    &sort_intervals::SortIntervals,
    &lfb_table_20_1::LfbTable20_1,
    &lfb_figure_20_9::LfbFigure20_9,
    &lfb_figure_20_11::LfbFigure20_11,
    &lfb_figure_20_12::LfbFigure20_12,
    &lfb_layouts::LfbLayouts,
    &lfb_memory::LfbMemory,
    &lfb_array::LfbArray,
    &lfb_overflow::LfbOverflow,
    &mechanism_registers::MechanismRegisters,
    &mechanism_occupancy::MechanismOccupancy,
    &stability::Stability,
    &spheres_tables::SpheresTables,
    &spheres_cross::SpheresCross,
    &spheres_scale::SpheresScale,
    &spheres_renders::SpheresRenders,
    &work::Work,
];
