//! What was measured on a device: views, and techniques on them.

use std::collections::BTreeMap;

use oit_record::statistics::median;
use oit_record::{Event, Record, Verdict, Verification};

/// An exact picture's largest error, which is rounding: what records call exact is nearer.
pub const EXACT_ERROR: f64 = 1e-5;

/// One view of a scene at one resolution, as a device's count pass found it.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct View {
    /// The scene, with its overridden parameters: `grid{layers=20}`.
    pub scene: String,
    /// The view.
    pub view: String,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Triangles drawn.
    pub triangles: u64,
    /// `histogram[n]` pixels have `n` fragments.
    pub histogram: Vec<u64>,
}

/// A technique on a view, measured.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Measured {
    /// The view's place in [`Evidence::views`].
    pub view: usize,
    /// The technique; where it left something to a tuning, what was run in its place.
    pub technique: String,
    /// The median of the whole frame, in nanoseconds.
    pub total_ns: f64,
    /// Of it, to group pixels and resolve them: the median of the sums. `None` for methods, where a
    /// stage of that name is but a part.
    pub resolve_ns: Option<f64>,
    /// The largest error of a colour channel; 0 where the picture is exact.
    pub max_error: f64,
    /// Root mean square error over all pixels and colour channels; 0 where the picture is exact.
    pub rmse: f64,
    /// Whether it had to be exact, and was.
    pub exact: bool,
    /// What the device's cost model had predicted for that; `None` where it could not.
    pub predicted_resolve_ns: Option<f64>,
    /// Device memory of all its buffers and targets; 0 where it is not known.
    pub memory_bytes: u64,
}

/// All that is known of one device.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Evidence {
    /// The device, as its driver names it.
    pub device: String,
    /// The backend it was reached by.
    pub backend: String,
    /// `discrete-gpu` and so on, as [`oit_record::DeviceInfo::kind`].
    pub kind: String,
    /// The largest buffer that programs may bind, in bytes; 0 where it is not known.
    pub max_buffer_bytes: u64,
    /// The views, one for each run that has it. Each run's come after another's.
    pub views: Vec<View>,
    /// The name of the run of each view.
    pub runs: Vec<String>,
    /// What was measured on them.
    pub cells: Vec<Measured>,
}

/// A scene's name without its overridden parameters: `grid` of `grid{layers=20}`.
#[must_use]
pub fn scene_name(scene: &str) -> &str {
    scene.split('{').next().unwrap_or(scene)
}

impl View {
    /// Pixels of the frame.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        u64::from(self.width_px) * u64::from(self.height_px)
    }

    /// Pixels with fragments.
    #[must_use]
    pub fn covered(&self) -> u64 {
        self.histogram.iter().skip(1).fold(0, |sum, &pixels| sum.saturating_add(pixels))
    }

    /// Fragments of all pixels.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        let depths = (0_u64..).zip(&self.histogram);
        depths.fold(0, |sum, (n, &pixels)| sum.saturating_add(n.saturating_mul(pixels)))
    }

    /// The peak depth complexity.
    #[must_use]
    pub fn peak(&self) -> u32 {
        self.histogram.iter().rposition(|&pixels| pixels > 0).unwrap_or(0) as u32
    }

    /// Fragments of a covered pixel, on average.
    #[must_use]
    pub fn mean_depth(&self) -> f64 {
        self.fragments() as f64 / self.covered().max(1) as f64
    }

    /// Whether it is of the same scene, whatever its parameters.
    #[must_use]
    pub fn same_scene(&self, other: &Self) -> bool {
        scene_name(&self.scene) == scene_name(&other.scene)
    }

    /// Whether it is the very same: scene with parameters, view, resolution, and as many fragments
    /// but for one in a thousand, by which devices differ at the edges of triangles.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        let (own, others) = (self.fragments(), other.fragments());
        (&self.scene, &self.view, self.width_px, self.height_px)
            == (&other.scene, &other.view, other.width_px, other.height_px)
            && self.triangles == other.triangles
            && own.abs_diff(others) <= own.max(others) / 1000
    }
}

impl Measured {
    /// The two errors of a comparison with the oracle, 0 both where it is exact but for rounding.
    #[must_use]
    pub fn errors(result: &Verification) -> (f64, f64) {
        if result.verdict == Verdict::Exact && result.max_error <= EXACT_ERROR {
            return (0.0, 0.0);
        }
        (result.max_error, result.rmse)
    }
}

impl Evidence {
    /// What runs say, one for each device, in the order of their names. Cells that are wrong, and those
    /// of fewer than two samples, say nothing: experiments that take one ask for other things than time.
    /// Frames of camera paths are left out: they are many, and alike.
    #[must_use]
    pub fn of_records(records: &[Record]) -> Vec<Self> {
        let mut devices: BTreeMap<(String, String), Self> = BTreeMap::new();
        for record in records {
            let device = &record.run.device;
            let of_device =
                devices.entry((device.name.clone(), device.backend.clone())).or_default();
            of_device.device.clone_from(&device.name);
            of_device.backend.clone_from(&device.backend);
            of_device.kind.clone_from(&device.kind);
            of_device.max_buffer_bytes = device.max_storage_buffer_bytes;
            of_device.add(record);
        }
        devices.into_values().filter(|evidence| !evidence.cells.is_empty()).collect()
    }

    fn add(&mut self, record: &Record) {
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        let name = record.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for event in &record.events {
            let Event::Counted { group, triangles, histogram, .. } = event else { continue };
            let Some(cell) = record.run.cells.iter().find(|cell| cell.group() == *group) else {
                continue;
            };
            // Where nothing was counted, opaque spheres were drawn: no technique for transparency.
            let uncounted = histogram.is_empty();
            if cell.view.contains('@') || uncounted || places.contains_key(group.as_str()) {
                continue;
            }
            places.insert(group, self.views.len());
            self.runs.push(name.clone());
            self.views.push(View {
                scene: cell.scene.clone(),
                view: cell.view.clone(),
                width_px: cell.width_px,
                height_px: cell.height_px,
                triangles: *triangles,
                histogram: histogram.clone(),
            });
        }
        let mut samples: BTreeMap<usize, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
        let mut results: BTreeMap<usize, &Verification> = BTreeMap::new();
        for event in &record.events {
            match event {
                Event::Verified { cell, result } => {
                    results.insert(*cell, result);
                }
                Event::Sample { cell, stages_ns, total_ns, .. } => {
                    let (totals, resolves) = samples.entry(*cell).or_default();
                    totals.push(*total_ns as f64);
                    if let Some(resolve) = stages_ns.get("resolve") {
                        let group = stages_ns.get("group").unwrap_or(&0);
                        resolves.push(resolve.saturating_add(*group) as f64);
                    }
                }
                _ => {}
            }
        }
        for (place, (totals, resolves)) in samples {
            let Some(cell) = record.run.cells.get(place) else { continue };
            let (Some(result), Some(&view)) =
                (results.get(&place), places.get(cell.group().as_str()))
            else {
                continue;
            };
            let Some(total_ns) = median(&totals).filter(|ns| *ns > 0.0) else { continue };
            if result.verdict == Verdict::Wrong || totals.len() < 2 {
                continue;
            }
            let technique = result.tuned.clone().unwrap_or_else(|| cell.technique.clone());
            let (max_error, rmse) = Measured::errors(result);
            let whole = resolves.len() == totals.len() && technique.split('/').count() >= 5;
            self.cells.push(Measured {
                view,
                technique,
                total_ns,
                resolve_ns: median(&resolves).filter(|_| whole),
                predicted_resolve_ns: result.predicted_ns,
                max_error,
                rmse,
                exact: result.verdict == Verdict::Exact,
                memory_bytes: result.memory_bytes,
            });
        }
    }

    /// The device with its backend, as figures name it: `NVIDIA H200 (vulkan)`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} ({})", self.device, self.backend)
    }

    /// By how much the device's cost model, which knows pixels of one depth at a time, is off where
    /// depths are mixed: the median of measured over predicted, and of how many cells of this layout,
    /// schedule and stage. Also how far these are from that, at the median. `None` where none was both
    /// predicted and measured.
    #[must_use]
    pub fn correction(&self, technique: &str) -> Option<(f64, f64, usize)> {
        let kind = |name: &str| {
            let mut parts = name.split('/');
            let (capture, schedule) = (parts.next(), parts.next());
            Some((capture?.to_owned(), schedule?.to_owned(), parts.nth(1)?.to_owned()))
        };
        let wanted = kind(technique)?;
        let mixed = |cell: &&Measured| {
            let depths = self.view_of(cell).histogram.iter().skip(1);
            depths.filter(|&&pixels| pixels > 0).count() > 1
        };
        let of_kind = |cell: &&Measured| kind(&cell.technique).as_ref() == Some(&wanted);
        let ratio = |cell: &Measured| {
            let (measured, predicted) = (cell.resolve_ns?, cell.predicted_resolve_ns?);
            Some(measured / predicted).filter(|ratio| ratio.is_finite())
        };
        let ratios: Vec<f64> =
            self.cells.iter().filter(mixed).filter(of_kind).filter_map(ratio).collect();
        let by = median(&ratios)?;
        let off: Vec<f64> = ratios.iter().map(|ratio| (by / ratio - 1.0).abs()).collect();
        Some((by, median(&off)?, ratios.len()))
    }

    /// The view of a cell.
    #[must_use]
    pub fn view_of(&self, cell: &Measured) -> &View {
        &self.views[cell.view]
    }

    /// The same without what was measured on some views.
    #[must_use]
    pub fn without(&self, left_out: impl Fn(&View) -> bool) -> Self {
        let mut kept = self.clone();
        kept.cells.retain(|cell| !left_out(&self.views[cell.view]));
        kept
    }

    /// The techniques there are, each once, in order of their names.
    #[must_use]
    pub fn techniques(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.cells.iter().map(|cell| cell.technique.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_is_told_by_its_histogram() {
        let view = View { histogram: vec![5, 1, 0, 3, 0], ..View::default() };
        assert_eq!((view.covered(), view.fragments(), view.peak()), (4, 10, 3));
        assert!((view.mean_depth() - 2.5).abs() < 1e-12);
        let empty = View::default();
        assert_eq!((empty.covered(), empty.fragments(), empty.peak()), (0, 0, 0));
        assert!(empty.mean_depth() == 0.0);
        let grid = |scene: &str| View { scene: scene.into(), ..View::default() };
        assert!(grid("grid{layers=2}").same_scene(&grid("grid")));
        assert!(!grid("planes").same_scene(&grid("planes2")));
        assert!(!grid("grid{layers=2}").same(&grid("grid")));
    }
}
