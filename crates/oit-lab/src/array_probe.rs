//! Runs the array probe of the BMA paper's Figure 3 on a device, by the protocol of experiments:
//! verified, warmed up, sampled in interleaved order, every sample recorded.
//!
//! It is no experiment, since it has no scene and captures nothing; and it needs no worker process,
//! since its programs are a few lines without a loop, of which none can hang.

use std::collections::BTreeMap;
use std::time::Instant;

use oit_bma::{ArrayProbe, ProbeAccess, ProbePlace};
use oit_gpu::{Device, GpuError, PlanId};
use oit_record::statistics::SplitMix64;
use oit_record::{Cell, Event, RunWriter, Verdict, Verification};
use serde::Deserialize;

use crate::assemble::IMAGE;
use crate::experiment::ProfileName;
use crate::provenance;
use crate::runner::{Outcome, Progress, RunError, Setup, run_of};
use crate::worker::{ms, until_warm};

/// The scene and the view that cells of a probe name.
const NONE: &str = "none";

/// How it is run, kept whole in every record.
const SETTINGS: &str = include_str!("array_probe.toml");

/// What is said of it in prose is left out here.
#[derive(Deserialize)]
struct Settings {
    seed: u64,
    profile: BTreeMap<String, Profile>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Profile {
    resolution: [u32; 2],
    repeats: u32,
    step: Step,
    samples: u32,
    warmup_ms: u64,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    touched: u32,
    unset: u32,
}

impl Settings {
    fn read() -> Self {
        toml::from_str(SETTINGS).expect("it is part of the program, and a test reads it")
    }

    fn profile(&self, name: ProfileName) -> Profile {
        self.profile[name.name()]
    }
}

impl Profile {
    /// Every probe of this profile.
    fn probes(&self) -> Vec<ArrayProbe> {
        let mut probes = Vec::new();
        for access in ProbeAccess::ALL {
            let step = match access {
                ProbeAccess::Touched => self.step.touched,
                ProbeAccess::Unset => self.step.unset,
            };
            for place in ProbePlace::ALL {
                let steps = (1..=place.most_entries()).filter(|n| *n == 1 || n % step == 0);
                probes.extend(steps.map(|size| ArrayProbe { access, place, size }));
            }
        }
        probes
    }

    fn cell(&self, probe: &ArrayProbe) -> Cell {
        let [width_px, height_px] = self.resolution;
        let (scene, view) = (NONE.to_owned(), NONE.to_owned());
        Cell { technique: probe.to_string(), scene, view, width_px, height_px }
    }
}

/// Runs the probe and records it in the run folder of `setup`, whose scenes and worker are not used.
///
/// # Errors
/// Where the device does not start, or the record cannot be written; what was recorded before stays.
pub fn probe_arrays(
    setup: &Setup,
    progress: &mut dyn FnMut(Progress),
) -> Result<Outcome, RunError> {
    let settings = Settings::read();
    let profile = settings.profile(setup.profile);
    let probes = profile.probes();
    let cells: Vec<Cell> = probes.iter().map(|probe| profile.cell(probe)).collect();
    let started = Instant::now();
    let failed = |what: String| RunError::Device { device: setup.device.clone(), what };
    if setup.device == "cpu" {
        return Err(failed("the array probe is of a GPU's memory, and this is none".into()));
    }
    let device =
        oit_gpu::open(&setup.device, &setup.cache).map_err(|error| failed(error.to_string()))?;
    let run = run_of(setup, device.info(), "array-probe", SETTINGS, settings.seed, cells);
    let writer = RunWriter::create(&setup.out, &run)?;
    progress(Progress::Started {
        cells: probes.len(),
        groups: 1,
        steps: (1 + u64::from(profile.samples)) * probes.len() as u64,
        done: 0,
        device: Box::new(device.info().clone()),
    });
    let cells = run.cells;
    let mut session =
        Session { device, profile, cells, writer, progress, outcome: Outcome::default() };
    let mut ready = Vec::new();
    for (cell, probe) in probes.iter().enumerate() {
        match session.prepare(cell, probe) {
            Ok(Some(plan)) => ready.push((cell, plan)),
            Ok(None) => {}
            Err(Stop::Cell(error)) => session.end(cell, &error)?,
            Err(Stop::Run(error)) => return Err(error),
        }
    }
    session.sample(ready, settings.seed)?;
    let mut outcome = session.outcome;
    outcome.wall_s = started.elapsed().as_secs_f64();
    session.writer.append(&Event::Finished { wall_s: outcome.wall_s })?;
    (session.progress)(Progress::Finished(outcome));
    Ok(outcome)
}

/// What ends: a cell, or all of the run.
enum Stop {
    Cell(GpuError),
    Run(RunError),
}

impl From<GpuError> for Stop {
    fn from(error: GpuError) -> Self {
        Self::Cell(error)
    }
}

struct Session<'a> {
    device: Box<dyn Device>,
    profile: Profile,
    cells: Vec<Cell>,
    writer: RunWriter,
    progress: &'a mut dyn FnMut(Progress),
    outcome: Outcome,
}

impl Session<'_> {
    /// Makes a probe ready, runs it twice and records how its pictures compare with what a processor
    /// computes. Nothing where they are wrong.
    fn prepare(&mut self, cell: usize, probe: &ArrayProbe) -> Result<Option<PlanId>, Stop> {
        let [width_px, height_px] = self.profile.resolution;
        let plan = probe.plan(width_px, height_px, self.profile.repeats);
        let started = Instant::now();
        let id = self.device.prepare(&plan)?;
        let prepare_ms = ms(started);
        let verifying = Instant::now();
        self.device.poison(id)?;
        self.device.run(id)?;
        let first = self.device.read(id, IMAGE)?;
        self.device.run(id)?;
        let again = self.device.read(id, IMAGE)?;
        let memory_bytes = self.device.memory_bytes(id)?;
        let result = Verification {
            max_frags: probe.size,
            memory_bytes,
            prepare_ms,
            ..verify(probe, &first, &again)
        };
        self.outcome.spent.prepare_ms += prepare_ms;
        self.outcome.spent.verify_ms += ms(verifying);
        let verdict = result.verdict;
        match verdict {
            Verdict::Exact => self.outcome.exact += 1,
            Verdict::Approximate => self.outcome.approximate += 1,
            Verdict::Wrong => self.outcome.wrong += 1,
        }
        let event = Event::Verified { cell, result: result.clone() };
        self.writer.append(&event).map_err(|error| Stop::Run(error.into()))?;
        let name = self.name(cell);
        (self.progress)(Progress::Verified(name, Box::new(result)));
        let wrong = verdict == Verdict::Wrong;
        let steps = 1 + if wrong { u64::from(self.profile.samples) } else { 0 };
        (self.progress)(Progress::Steps(steps));
        Ok((!wrong).then_some(id))
    }

    /// Warms up, and takes all samples: in each round one of each cell, in an order shuffled from the
    /// seed.
    fn sample(&mut self, mut ready: Vec<(usize, PlanId)>, seed: u64) -> Result<(), RunError> {
        let Some(&(first, _)) = ready.first() else { return Ok(()) };
        let started = Instant::now();
        let warmed = until_warm(self.profile.warmup_ms, || {
            let mut round_ns = 0;
            for &(_, plan) in &ready {
                round_ns += self.device.run(plan)?.total_ns;
            }
            Ok::<u64, GpuError>(round_ns)
        });
        // Which cell broke, if one did, shows when it is sampled.
        drop(warmed);
        self.clocks(first, "before")?;
        for sample in 0..self.profile.samples {
            let mut order = ready.clone();
            SplitMix64(seed ^ (u64::from(sample) << 32)).shuffle(&mut order);
            for (cell, plan) in order {
                match self.device.run(plan) {
                    Ok(timing) => {
                        let stages = timing.stages.into_iter();
                        let stages_ns = stages.map(|(stage, ns)| (stage.to_owned(), ns)).collect();
                        let total_ns = timing.total_ns;
                        self.writer.append(&Event::Sample {
                            cell,
                            sample,
                            stages_ns,
                            parts_ns: BTreeMap::new(),
                            total_ns,
                        })?;
                        (self.progress)(Progress::Steps(1));
                    }
                    Err(error) => {
                        self.end(cell, &error)?;
                        ready.retain(|(known, _)| *known != cell);
                    }
                }
            }
        }
        self.outcome.spent.render_ms += ms(started);
        self.clocks(first, "after")
    }

    /// Ends a cell with a reason.
    fn end(&mut self, cell: usize, error: &GpuError) -> Result<(), RunError> {
        let reason = error.to_string();
        let event = match error {
            GpuError::Unsupported(reason) => {
                self.outcome.skipped += 1;
                Event::Skipped { cell, reason: reason.clone() }
            }
            _ => {
                self.outcome.failed += 1;
                Event::Failed { cell, reason: reason.clone() }
            }
        };
        self.writer.append(&event)?;
        let name = self.name(cell);
        (self.progress)(Progress::Dropped(name, reason));
        Ok(())
    }

    fn clocks(&mut self, cell: usize, when: &str) -> Result<(), RunError> {
        if !self.device.info().name.contains("NVIDIA") {
            return Ok(());
        }
        let provenance::Clocks { shader_mhz, memory_mhz } = provenance::clocks();
        let (group, when) = (self.cells[cell].group(), when.to_owned());
        Ok(self.writer.append(&Event::Clocks { group, when, shader_mhz, memory_mhz })?)
    }

    fn name(&self, cell: usize) -> String {
        format!("{} {}", self.cells[cell].technique, self.cells[cell].group())
    }
}

/// Compares a probe's picture with what a processor computes, bit by bit, and with that of another
/// run.
fn verify(probe: &ArrayProbe, picture: &[u8], again: &[u8]) -> Verification {
    let pixels = |bytes: &[u8]| -> Vec<[f32; 4]> { bytemuck::pod_collect_to_vec(bytes) };
    let (picture, again) = (pixels(picture), pixels(again));
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    let differ = picture.iter().zip(&again).filter(|(a, b)| bits(a) != bits(b)).count();
    let is_wrong = |(pixel, found): (u32, &[f32; 4])| {
        probe.expected(pixel).is_some_and(|expected| bits(&expected) != bits(found))
    };
    let wrong_px = (0..).zip(&picture).filter(|&pair| is_wrong(pair)).count() as u64;
    let (verdict, note) = match probe.access {
        ProbeAccess::Unset => {
            let note =
                "an array that is not written may hold anything: its picture is not compared";
            (Verdict::Approximate, Some(note.to_owned()))
        }
        ProbeAccess::Touched if wrong_px > 0 => {
            (Verdict::Wrong, Some(format!("{wrong_px} pixels are not what a processor computes")))
        }
        ProbeAccess::Touched => (Verdict::Exact, None),
    };
    Verification {
        verdict,
        note,
        wrong_px,
        max_error: 0.0,
        rmse: 0.0,
        max_alpha_error: 0.0,
        fragments_missing: 0,
        fragments_extra: 0,
        tied_px: 0,
        max_frags: 0,
        pool_initial: 0,
        pool_final: 0,
        pool_grown: 0,
        memory_bytes: 0,
        lfb_bytes: None,
        peak_bytes: None,
        repeat_differs_px: Some(differ as u64),
        prepare_ms: 0.0,
        fragments_compared: false,
        tuned: None,
        predicted_ns: None,
        ssim: None,
        flip: None,
        stability: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(profile: ProfileName, access: ProbeAccess, place: ProbePlace) -> Vec<u32> {
        let probes = Settings::read().profile(profile).probes().into_iter();
        probes.filter(|p| (p.access, p.place) == (access, place)).map(|p| p.size).collect()
    }

    #[test]
    fn the_full_profile_goes_in_steps_of_one_entry() {
        let full = |access, place| sizes(ProfileName::Full, access, place);
        let touched = ProbeAccess::Touched;
        assert_eq!(full(touched, ProbePlace::LocalFragment), (1..=256).collect::<Vec<_>>());
        assert_eq!(full(touched, ProbePlace::WorkgroupCompute), (1..=32).collect::<Vec<_>>());
        let unset = full(ProbeAccess::Unset, ProbePlace::WorkgroupCompute);
        assert_eq!(unset, [1, 8, 16, 24, 32]);
        let quick = sizes(ProfileName::Quick, touched, ProbePlace::LocalCompute);
        assert_eq!((quick[..3].to_vec(), quick.len()), (vec![1, 16, 32], 17));
    }

    #[test]
    fn a_wrong_pixel_is_found() {
        let probe =
            ArrayProbe { access: ProbeAccess::Touched, place: ProbePlace::LocalCompute, size: 5 };
        let right: Vec<[f32; 4]> = (0..6).filter_map(|pixel| probe.expected(pixel)).collect();
        let mut off = right.clone();
        off[4][2] += 1.0;
        let (right, off) = (bytemuck::cast_slice(&right), bytemuck::cast_slice(&off));
        assert_eq!(verify(&probe, right, right).verdict, Verdict::Exact);
        let wrong = verify(&probe, off, right);
        assert_eq!((wrong.verdict, wrong.wrong_px), (Verdict::Wrong, 1));
        assert_eq!(wrong.repeat_differs_px, Some(1));
        let unset = ArrayProbe { access: ProbeAccess::Unset, ..probe };
        assert_eq!(verify(&unset, off, off).verdict, Verdict::Approximate);
    }
}
