//! What a run folder holds: `run.json`, written once when the run starts, and `events.jsonl`, one
//! line an event, appended as it happens.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Bandwidth, DeviceInfo, PassWork, Program};

/// The version of this schema. A record of another version is refused.
pub const SCHEMA_VERSION: u32 = 1;

/// `run.json`: one execution of one experiment on one device, and where it took place.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// [`SCHEMA_VERSION`] of the writer.
    pub schema: u32,
    /// The experiment's name.
    pub experiment: String,
    /// The experiment file, whole, as it was run.
    pub experiment_toml: String,
    /// `quick` or `full`.
    pub profile: String,
    /// The device.
    pub device: DeviceInfo,
    /// The machine around it.
    pub host: Host,
    /// The project's version.
    pub oit_version: String,
    /// The commit the program was built from; `None` outside a git checkout.
    pub git_commit: Option<String>,
    /// Whether tracked files differed from that commit when it was built.
    pub git_dirty: Option<bool>,
    /// The command line.
    pub command: Vec<String>,
    /// The seed of the order in which samples were taken.
    pub seed: u64,
    /// When it was started, UTC, `2026-11-22T09:30:00Z`.
    pub started: String,
    /// The cells, in order; events name a cell by its place here.
    pub cells: Vec<Cell>,
}

/// The machine around a device.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Host {
    /// Operating system and its version, as it calls itself.
    pub os: String,
    /// Processor, as it calls itself.
    pub cpu: String,
    /// Logical processors the program may use.
    pub cpus: u32,
}

/// One technique on one view of one scene at one resolution.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// The technique's coordinate: `capture/schedule/sort/stage/max[/ties]`, say
    /// `linked_list/bma-list/rbs/compute/peak`; or a method's name and size, say `dual_peel/passes4`.
    pub technique: String,
    /// The scene, with its overridden parameters in order: `grid{layers=20}`.
    pub scene: String,
    /// The view.
    pub view: String,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

impl Cell {
    /// What cells compared with each other share: scene, view and resolution.
    #[must_use]
    pub fn group(&self) -> String {
        format!("{}:{}@{}x{}", self.scene, self.view, self.width_px, self.height_px)
    }
}

/// One line of `events.jsonl`.
#[expect(clippy::large_enum_variant, reason = "one is held at a time, and a record has one a cell")]
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// What the device's own count pass found on a view.
    Counted {
        /// [`Cell::group`].
        group: String,
        /// Triangles drawn.
        triangles: u64,
        /// Spheres there are, every object in full detail, where the scene is of spheres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spheres: Option<u64>,
        /// `histogram[n]` pixels have `n` fragments; empty where they were not counted, since every cell
        /// draws opaque spheres.
        histogram: Vec<u64>,
    },
    /// A cell was run once and compared with the oracle, before any timing.
    Verified {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// The comparison.
        result: Verification,
    },
    /// What the driver tells of a cell's resolve programs, once a cell, before it is verified. Older
    /// records have none.
    Programs {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// One an interval, from the shallowest.
        programs: Vec<Program>,
    },
    /// What the device's memory moves, once a run whose experiment asks for work. Older records have
    /// none.
    Bandwidth {
        /// What was measured.
        measured: Bandwidth,
    },
    /// How much work a cell's passes are, once a cell, where the experiment asks for it. Older records
    /// have none.
    Work {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// In the order in which they run; where a pool grew, those of both attempts.
        passes: Vec<PassWork>,
    },
    /// The clocks just before and after a view's samples, where they can be read.
    Clocks {
        /// [`Cell::group`].
        group: String,
        /// `before` or `after`.
        when: String,
        /// Streaming multiprocessors or shader cores, in MHz.
        shader_mhz: Option<u32>,
        /// Memory, in MHz.
        memory_mhz: Option<u32>,
    },
    /// One timing of a cell, by stage.
    Sample {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// Which sample, from 0.
        sample: u32,
        /// Nanoseconds of each stage.
        stages_ns: BTreeMap<String, u64>,
        /// Nanoseconds of the parts of stages that have parts, `resolve[16]` for the pixels of the
        /// interval that ends at 16. They are contained in their stage's. Older records have none.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        parts_ns: BTreeMap<String, u64>,
        /// Nanoseconds from before the first stage to after the last.
        total_ns: u64,
    },
    /// A cell that this device cannot run.
    Skipped {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// What the device lacks.
        reason: String,
    },
    /// A cell that was tried and broke: a crash, a hang, a driver's error.
    Failed {
        /// Its place in [`Run::cells`].
        cell: usize,
        /// What happened.
        reason: String,
    },
    /// The run is complete: every cell has all its samples or a reason.
    Finished {
        /// Wall time of the whole run, resumed parts added up, in seconds.
        wall_s: f64,
    },
}

/// How a cell's picture compares with the oracle.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verification {
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in words, where the verdict is not `exact`; and of the stage `cuda` which memory it reads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Pixels off by more than 1/255 in some channel.
    pub wrong_px: u64,
    /// The largest error of a colour channel (0 to 1).
    pub max_error: f64,
    /// Root mean square error over all pixels and colour channels.
    pub rmse: f64,
    /// The largest error of alpha.
    pub max_alpha_error: f64,
    /// Fragments that the reference capture has and this one lacks, and the other way round.
    pub fragments_missing: u64,
    /// Fragments that this capture has and the reference lacks.
    pub fragments_extra: u64,
    /// Whether the fragments themselves were compared. They are not on most frames of a camera path,
    /// where the picture alone decides, and never of methods, which keep none: missing and extra are 0
    /// there, unseen.
    #[serde(default = "compared", skip_serializing_if = "is_compared")]
    pub fragments_compared: bool,
    /// Pixels that are left out of the verdict. Where only depth is compared: those on which unlike
    /// fragments share a depth. For methods that lose fragments at one depth: those on which any do.
    #[serde(default)]
    pub tied_px: u64,
    /// `max_frags` the program was compiled for (of its deepest interval); 0 for methods, and so are
    /// their pool's.
    pub max_frags: u32,
    /// Room in the pool at first, in slots of a fragment each.
    pub pool_initial: u64,
    /// Room in the pool in the end.
    pub pool_final: u64,
    /// How often the pool was too small, grew to the counted size, and the frame was rendered again.
    pub pool_grown: u32,
    /// Device memory of all the technique's buffers and targets, in bytes; 0 on the CPU backend.
    pub memory_bytes: u64,
    /// Of these the layered fragment buffer that a resolve reads: the pool and its tables. Other
    /// buffers and targets may be given back once it is captured. `None` in older records, on the CPU
    /// backend, and for methods, which have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lfb_bytes: Option<u64>,
    /// The most device memory that was needed at once: where the pool grew, the first pool and the
    /// second together. `None` in older records and on the CPU backend.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_bytes: Option<u64>,
    /// Pixels that differ in any bit between two runs of the same frame. `None` in older records, and
    /// on most frames of a camera path, which are not repeated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeat_differs_px: Option<u64>,
    /// Milliseconds until its pipelines were ready.
    pub prepare_ms: f64,
    /// The coordinate that was run in its place, where the cell's leaves sorts (`auto`) or intervals
    /// (`intervals-optimal`) to what was measured before on the device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tuned: Option<String>,
    /// Nanoseconds to group and resolve the frame by the device's cost model, for techniques with
    /// intervals. `None` where the model lacks something, and in older records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_ns: Option<f64>,
    /// Mean structural similarity to the oracle's picture, over black: 1 for equal pictures. Of
    /// approximate ones, where the experiment asks for it; else `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// Mean of FLIP against the oracle's picture, over black: 0 for equal pictures, 1 at most. Where
    /// `ssim` is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// Whether the picture stays, where the experiment asks for it (`repeats`); else `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stability: Option<Stability>,
}

/// A picture whose largest error is no less than this is lost: half of what a channel can hold. So is one
/// that is not finite.
pub const LOST: f64 = 0.5;

impl Verification {
    /// Whether the picture broke: it is not what it must be, or is lost, or is not the same in every
    /// run. That an approximate one is off, but not lost, is no break.
    #[must_use]
    pub fn breaks(&self) -> bool {
        let varies = self.stability.as_ref().is_some_and(|stability| stability.pictures > 1);
        self.verdict == Verdict::Wrong || varies || self.max_error >= LOST
    }
}

/// Whether a technique's picture stays: over runs of one frame, and on the way to the next.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stability {
    /// Runs of the frame whose pictures were compared bit by bit, the verified one among them.
    pub runs: u32,
    /// How many different pictures these gave: 1 where all are the same.
    pub pictures: u32,
    /// FNV-1a hash, of 64 bits in 16 hexadecimal digits, of the verified picture's bytes: equal for
    /// equal pictures, also of other runs and devices.
    pub hash: String,
    /// How its picture changed from the view before, beside the right one. `None` where the view before
    /// was not of the same sequence: frames of one camera path, or one view of a scene whose triangles
    /// are submitted in another order; or where it had no picture there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
}

/// The change of a technique's picture from one view to the next minus the change of the right one, by
/// pixel and colour channel. A technique whose error stays where it is has none.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// Pixels on which it is more than 1/255 in some channel.
    pub px: u64,
    /// The largest, of a colour channel (0 to 1).
    pub max: f64,
    /// Root mean square over all pixels and colour channels.
    pub rms: f64,
}

/// What a record says that does not say whether fragments were compared: they were.
fn compared() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_compared(compared: &bool) -> bool {
    *compared
}

/// The verdict on a cell.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It must be exact and is: fragments equal as multisets, colour within the tolerances.
    Exact,
    /// It is not meant to be exact: its errors are data.
    Approximate,
    /// It must be exact and is not. Its times are never charted.
    Wrong,
}

impl Event {
    /// The cell it is about, if it is about one.
    #[must_use]
    pub fn cell(&self) -> Option<usize> {
        match self {
            Self::Verified { cell, .. }
            | Self::Programs { cell, .. }
            | Self::Work { cell, .. }
            | Self::Sample { cell, .. }
            | Self::Skipped { cell, .. }
            | Self::Failed { cell, .. } => Some(*cell),
            Self::Counted { .. }
            | Self::Bandwidth { .. }
            | Self::Clocks { .. }
            | Self::Finished { .. } => None,
        }
    }
}
