//! Technique registry, experiments, runner, verification.
//!
//! The harness knows no technique by name: captures, sorts, schedules and methods are registries, a
//! technique is a point on the axes of the first three, a method or a way of drawing spheres, and a cell is a technique on one
//! view of a scene.

mod advise;
mod array_probe;
mod assemble;
mod bandwidth;
mod conformance;
mod cpu_engine;
mod cuda_stage;
mod engine;
mod experiment;
mod gpu_engine;
mod kept;
mod method;
pub mod provenance;
mod runner;
mod spheres;
mod stability;
mod stored;
mod technique;
mod tune;
mod tuner;
mod tuning;
mod twins;
mod verify;
mod work;
mod worker;

pub use advise::{Description, Planned};
pub use array_probe::probe_arrays;
pub use assemble::{Fragments, IMAGE, assemble};
pub use bandwidth::{BANDWIDTH_BYTES, measure_bandwidth, probe_bandwidth};
pub use conformance::{check_emitted, emitted, kernel_conforms, twin_conforms};
pub use cpu_engine::cpu_info;
pub use cuda_stage::{cuda_segmented_sort, cuda_source, cuda_versions};
pub use engine::{
    CellError, Engine, FrameSize, Memory, Preparation, Ready, SceneView, Source, ViewData,
    ViewError, open_engine,
};
pub use experiment::{
    Experiment, ExperimentError, Overrides, PathProfile, PlannedCell, Profile, ProfileName,
    list_experiments, scene_name,
};
pub use method::{MethodChoice, methods, parse_method};
pub use runner::{Outcome, Progress, RunError, Setup, default_folder, run, samples_by_cell};
pub use spheres::SphereVerifier;
pub use stored::{
    DEEP_EXTENSION, Origin, STORED_VIEW, Stored, StoredError, is_stored, load_stored, stored_entry,
};
pub use technique::{
    ALIASES, DEEPEST, IntervalChoice, MaxFrags, Pool, PoolPolicy, Schedule, Sorted, Stage,
    Technique, TechniqueError, parse_capture, parse_intervals, parse_max_frags, parse_pool,
    parse_schedule, parse_stage, parse_ties,
};
pub use tune::{TuneError, tune};
pub use tuner::Tuner;
pub use tuning::{
    Fastest, FromRun, IntervalCost, PixelCost, TUNING_VERSION, Tuning, TuningError, tuning_path,
};
pub use twins::{Twin, TwinInterval, time_twins};
pub use verify::{Check, EXACT_TOLERANCE, Verifier};
pub use work::pass_work;
pub use worker::{Spent, serve};
