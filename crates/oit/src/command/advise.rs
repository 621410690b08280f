//! `oit advise`: the cheapest technique that a view needs, by what was measured on a device.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use miette::miette;
use oit_advise::{
    Advice, Basis, Bounds, Choice, ErrorBasis, Estimate, Evidence, Metric, Part, Reason, Regret,
    Trial, View, advise, regret, trials,
};
use oit_fragments::DepthHistogram;
use oit_lab::{
    Description, Engine, Planned, Source, Technique, Tuner, Verifier, ViewData, open_engine,
    scene_name, tuning_path,
};
use oit_record::statistics::{median, quantile};
use oit_record::{Record, Verdict};

use crate::command::render::{overrides, size};
use crate::command::{TUNING, cache_folder, device_id, report, usable_devices};

/// Of what, and within which bounds.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A scene file.
    #[arg(required_unless_present = "regret")]
    scene: Option<PathBuf>,
    /// One of the scene's views; the first if none is named.
    #[arg(long)]
    view: Option<String>,
    /// Width and height in pixels.
    #[arg(long, default_value = "1920x1080")]
    size: String,
    /// A scene parameter, `name=value`; may be given several times.
    #[arg(long = "set")]
    set: Vec<String>,
    /// The largest error allowed, from 0 to 1; also as a fraction, `2/255`. 0 asks for techniques that
    /// are exact by what they are.
    #[arg(long, default_value = "0", value_name = "E")]
    max_error: String,
    /// How errors are measured: `max`, the largest of a colour channel over the frame, or `rmse`, the
    /// root mean square over all pixels and colour channels.
    #[arg(long, value_parser = ["max", "rmse"], default_value = "max")]
    metric: String,
    /// The most device memory: bytes, or with a unit, `512MiB`, `2GB`.
    #[arg(long, value_name = "M")]
    max_memory: Option<String>,
    /// The device that is asked about: one with records, by its name or a part of it
    /// (`h200`, `nvidia-h200-vulkan`), or one that is here (`vulkan:0`). If none is named, the best one
    /// here where it has records, else the first GPU that has.
    #[arg(long)]
    device: Option<String>,
    /// The device here that counts fragments, and renders for `--check`.
    #[arg(long, default_value = "auto")]
    on: String,
    /// Folders of recorded runs.
    #[arg(long, default_value = "experiments/recorded", num_args = 1..)]
    records: Vec<PathBuf>,
    /// The folder of tuning files.
    #[arg(long, default_value = TUNING)]
    tuning: PathBuf,
    /// Leave out all that was measured on this scene, whatever its view and parameters: predict as if
    /// it were new.
    #[arg(long)]
    hold_out: bool,
    /// Render with the technique advised, and report its true error, time and memory.
    #[arg(long)]
    check: bool,
    /// Samples of the check.
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    samples: u32,
    /// How many of the next best are shown.
    #[arg(long, default_value_t = 5)]
    others: usize,
    /// Show why each technique is ruled out, not the reasons alone.
    #[arg(long)]
    all: bool,
    /// Put the advice to the test instead: on every recorded view of the device, without what was
    /// measured on its scene.
    #[arg(long, conflicts_with_all = ["scene", "check"])]
    regret: bool,
}

/// The bounds of a test of the advice: exact, an 8-bit step, and what an eye may see.
const BOUNDS: [f64; 4] = [0.0, 1.0 / 255.0, 0.02, 0.1];

/// An error from 0 to 1: a number or a fraction.
fn error_bound(text: &str) -> miette::Result<f64> {
    let value = match text.split_once('/') {
        Some((above, below)) => above
            .trim()
            .parse::<f64>()
            .and_then(|above| below.trim().parse::<f64>().map(|below| above / below)),
        None => text.trim().parse(),
    };
    match value {
        Ok(error) if (0.0..=1.0).contains(&error) => Ok(error),
        _ => Err(miette!("{text:?} is no error: write a number from 0 to 1, as 0.02 or 2/255")),
    }
}

/// Bytes, with a unit or without.
fn memory_bound(text: &str) -> miette::Result<u64> {
    const UNITS: [(&str, f64); 9] = [
        ("kib", 1024.0),
        ("mib", 1_048_576.0),
        ("gib", 1_073_741_824.0),
        ("tib", 1_099_511_627_776.0),
        ("kb", 1e3),
        ("mb", 1e6),
        ("gb", 1e9),
        ("tb", 1e12),
        ("b", 1.0),
    ];
    let lower = text.trim().to_ascii_lowercase();
    let unit = UNITS.iter().find(|(unit, _)| lower.ends_with(unit));
    let (number, by) = match unit {
        Some((unit, by)) => (lower[..lower.len() - unit.len()].trim_end(), *by),
        None => (lower.as_str(), 1.0),
    };
    let digits = number.starts_with(|c: char| c.is_ascii_digit());
    match number.parse::<f64>() {
        Ok(number) if digits && number * by >= 1.0 && number * by <= 2f64.powi(60) => {
            Ok((number * by) as u64)
        }
        _ => Err(miette!("{text:?} is no amount of memory: write bytes, or 512MiB, 1.5GiB, 2GB")),
    }
}

/// What is recorded in some folders, by device.
fn evidence(folders: &[PathBuf]) -> miette::Result<Vec<Evidence>> {
    let mut records = Vec::new();
    for folder in folders {
        records.extend(Record::read_all(folder).map_err(report)?);
    }
    let devices = Evidence::of_records(&records);
    if devices.is_empty() {
        let folders: Vec<String> =
            folders.iter().map(|folder| folder.display().to_string()).collect();
        return Err(miette!("{} hold no times: measure some (oit sweep)", folders.join(", ")));
    }
    Ok(devices)
}

/// Lower-case letters and digits with single hyphens between.
fn slug(text: &str) -> String {
    let text = text.to_ascii_lowercase();
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

/// The evidence of the device asked about.
fn of_device(devices: Vec<Evidence>, asked: Option<&str>) -> miette::Result<Evidence> {
    let names: Vec<String> = devices.iter().map(Evidence::name).collect();
    let here = usable_devices();
    let recorded = |name: &str, backend: &str| {
        devices.iter().position(|of| (of.device.as_str(), of.backend.as_str()) == (name, backend))
    };
    let none = |what: String| miette!("{what}; there are records of {}", names.join(", "));
    let place = match asked {
        None => {
            let best = here.first().and_then(|best| recorded(&best.name, &best.backend));
            let is_gpu = |of: &Evidence| of.kind.ends_with("-gpu");
            let first = devices
                .iter()
                .position(|of| is_gpu(of) && of.backend == "vulkan")
                .or_else(|| devices.iter().position(is_gpu));
            let only = (devices.len() == 1).then_some(0);
            best.or(first).or(only).ok_or_else(|| none("no GPU has records: name a device".into()))
        }
        Some(asked) => match here.iter().find(|device| device.id == asked) {
            Some(device) => recorded(&device.name, &device.backend).ok_or_else(|| {
                none(format!("{asked}, {} ({}), has no records", device.name, device.backend))
            }),
            None => {
                let wanted = slug(asked);
                let meant: Vec<usize> = (0..names.len())
                    .filter(|&place| !wanted.is_empty() && slug(&names[place]).contains(&wanted))
                    .collect();
                // A GPU that was reached by two backends is meant by the first choice of them.
                let one_gpu =
                    meant.iter().all(|&place| devices[place].device == devices[meant[0]].device);
                let whole = meant.iter().find(|&&place| {
                    slug(&names[place]) == wanted || one_gpu && devices[place].backend == "vulkan"
                });
                match (whole, meant.as_slice()) {
                    (Some(&place), _) | (None, &[place]) => Ok(place),
                    (None, []) => Err(none(format!("no device is called {asked:?}"))),
                    (None, _) => Err(none(format!("{asked:?} may mean several devices"))),
                }
            }
        },
    }?;
    devices.into_iter().nth(place).ok_or_else(|| miette!("no device"))
}

/// A scene's view, opened and counted on a device here.
struct Opened {
    engine: Box<dyn Engine>,
    data: ViewData,
    view: View,
    histogram: DepthHistogram,
    counts: Vec<u32>,
}

fn open(arguments: &Arguments, path: &Path) -> miette::Result<Opened> {
    let size = size(&arguments.size)?;
    let set = overrides(&arguments.set)?;
    let scene = oit_scene::load(path, &set).map_err(report)?;
    let name = arguments.view.clone().unwrap_or_else(|| scene.views[0].name.clone());
    let data = ViewData::new(&scene, &name, size).map_err(report)?;
    let mut engine = open_engine(&device_id(&arguments.on)?, &cache_folder()).map_err(report)?;
    let histogram = engine.open_view(data.clone()).map_err(report)?;
    let (_, counts) = engine.reference().map_err(report)?;
    let view = View {
        scene: scene_name(&scene.name, &set),
        view: name,
        width_px: size.width_px,
        height_px: size.height_px,
        triangles: data.triangles(),
        histogram: histogram.pixels.clone(),
    };
    Ok(Opened { engine, data, view, histogram, counts })
}

impl Opened {
    fn planned(&self) -> miette::Result<Planned<'_>> {
        let Source::Scene(scene) = &self.data.source else {
            return Err(miette!("stored fragments are drawn by no technique"));
        };
        Ok(Planned {
            geometry: &scene.geometry,
            size: self.data.size,
            counts: &self.counts,
            histogram: &self.histogram,
        })
    }
}

/// Advises, or puts the advice to the test.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let bounds = Bounds {
        max_error: error_bound(&arguments.max_error)?,
        metric: if arguments.metric == "rmse" { Metric::Rmse } else { Metric::Max },
        max_memory_bytes: arguments.max_memory.as_deref().map(memory_bound).transpose()?,
    };
    let all = of_device(evidence(&arguments.records)?, arguments.device.as_deref())?;
    let Some(path) = arguments.scene.as_ref().filter(|_| !arguments.regret) else {
        print!("{}", tested(&all));
        return Ok(());
    };
    let mut opened = open(arguments, path)?;
    let evidence =
        if arguments.hold_out { all.without(|other| other.same_scene(&opened.view)) } else { all };
    let tuning = tuning_path(&arguments.tuning, &evidence.device, &evidence.backend);
    let tuner = match Tuner::load(&tuning) {
        Ok(tuner) => tuner,
        Err(_) if !tuning.exists() => Tuner::none("it has no tuning file"),
        Err(error) => return Err(report(error)),
    };
    let planned = opened.planned()?;
    let candidates = planned.candidates(&evidence, &tuner);
    let advice = advise(&opened.view, &evidence, &candidates, &bounds);
    print!("{}", head(&opened.view, &evidence, &bounds));
    let Some(best) = advice.choices.first() else {
        if advice.ruled_out.is_empty() {
            return Err(miette!("no technique was measured on another scene"));
        }
        print!("{}", ruled_out(&advice, true));
        return Err(miette!("nothing that was measured is known to meet these bounds"));
    };
    let technique: Technique = best.technique.parse().map_err(report)?;
    let description = planned.describe(&technique).map_err(report)?;
    print!("{}", chosen(best, &technique, &description));
    print!("{}", others(&advice, arguments.others));
    print!("{}", ruled_out(&advice, arguments.all));
    if arguments.check {
        check(&mut opened, arguments, best, &technique, &bounds, &evidence)?;
    }
    Ok(())
}

/// A time as it is said.
pub(super) fn milliseconds(ns: f64) -> String {
    format!("{:.3} ms", ns / 1e6)
}

/// Bytes as they are said.
pub(super) fn bytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / 1_048_576.0)
}

/// An error as it is said, from 1/1000 on also in 8-bit steps.
pub(super) fn error_text(error: f64) -> String {
    match error {
        0.0 => "exact".to_owned(),
        error if error < 1e-3 => format!("{error:.1e}"),
        error => format!("{error:.4} ({:.1}/255)", error * 255.0),
    }
}

fn metric_text(metric: Metric) -> &'static str {
    match metric {
        Metric::Max => "the largest of a colour channel",
        Metric::Rmse => "root mean square",
    }
}

fn head(view: &View, evidence: &Evidence, bounds: &Bounds) -> String {
    let View { scene, view: name, width_px, height_px, triangles, .. } = view;
    let asked = match bounds.max_error {
        0.0 => "exact".to_owned(),
        error => format!("error up to {}, {}", error_text(error), metric_text(bounds.metric)),
    };
    let memory = bounds
        .max_memory_bytes
        .map_or(String::new(), |most| format!("; memory up to {}", bytes(most)));
    format!(
        "{scene}:{name} at {width_px}x{height_px}: {triangles} triangles, {} fragments, {:.1} on a \
         covered pixel, {} on the deepest\nFor {}; {asked}{memory}\n\n",
        view.fragments(),
        view.mean_depth(),
        view.peak(),
        evidence.name()
    )
}

fn part(part: &Part) -> String {
    let off = match part.off {
        Some(0.0) => String::new(),
        Some(off) => format!("; such are off by {:.0} % on scenes not shown", 100.0 * off),
        None => "; how far such are off nothing tells".into(),
    };
    format!("    {:<28} {:>11}  from {}{off}\n", part.what, milliseconds(part.ns), part.from)
}

fn time_text(choice: &Choice) -> String {
    match &choice.time.basis {
        Basis::Measured { run } => {
            format!("{}, measured on this view in {run}\n", milliseconds(choice.time.ns))
        }
        Basis::Fitted(parts) => {
            let parts: String = parts.iter().map(part).collect();
            format!("{}, predicted\n{parts}", milliseconds(choice.time.ns))
        }
    }
}

fn estimate(estimate: &Estimate) -> String {
    let error = error_text(estimate.error);
    match estimate.basis {
        ErrorBasis::Measured { .. } => format!("{error}, measured on this view"),
        ErrorBasis::Exact => "exact, by what the technique is".into(),
        ErrorBasis::ExactElsewhere => "exact on every other view measured that is as deep".into(),
        ErrorBasis::Guaranteed => format!("at most {error}, by what the technique is"),
        ErrorBasis::Worst { views, scenes } => {
            format!("{error}, the worst of {views} views of {scenes} other scenes")
        }
    }
}

fn chosen(choice: &Choice, technique: &Technique, description: &Description) -> String {
    let mut text = format!("{}\n", choice.technique);
    match technique {
        Technique::Sorted(sorted) => {
            let capture = sorted.capture;
            let _ = writeln!(text, "  layout     {}: {}", capture.name(), capture.summary());
            let (schedule, stage) = (sorted.schedule_name(), sorted.stage.name());
            let _ = writeln!(text, "  schedule   {schedule}, in the {stage} stage");
        }
        Technique::Method(method) => {
            let (name, summary) = (method.method.name(), method.method.summary());
            let _ = writeln!(text, "  method     {name}: {summary}");
            if let (Some(n), Some(size)) = (method.size, method.method.size()) {
                let _ = writeln!(text, "  size       {} {n}", size.word);
            }
        }
        // It draws nothing transparent, and is refused before it can be chosen.
        Technique::Spheres(_) => {}
    }
    for (place, (interval, sort, pixels)) in description.intervals.iter().enumerate() {
        let head = if place == 0 { "intervals" } else { "" };
        let range = format!("{} to {}", interval.low, interval.high);
        let _ = writeln!(text, "  {head:<10} {range:<12} {sort:<18} {pixels:>9} pixels");
    }
    let passes: Vec<String> =
        description.passes.iter().map(|(stage, count)| format!("{stage} {count}")).collect();
    let _ = writeln!(text, "  passes     {}", passes.join(", "));
    if let Some(slots) = description.pool_slots {
        let _ = writeln!(text, "  pool       {slots} slots, all that is needed here");
    }
    if let Some(memory) = choice.memory_bytes {
        let _ = writeln!(text, "  memory     {}", bytes(memory));
    }
    let _ = writeln!(text, "  error      {}", estimate(&choice.error));
    let _ = write!(text, "  time       {}", time_text(choice));
    text
}

fn others(advice: &Advice, most: usize) -> String {
    let next: Vec<&Choice> = advice.choices.iter().skip(1).take(most).collect();
    if next.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    let measured = |choice: &&Choice| matches!(choice.time.basis, Basis::Measured { .. });
    if let Some(best) =
        advice.choices.iter().find(measured).filter(|best| **best != advice.choices[0])
    {
        let ms = milliseconds(best.time.ns);
        let _ = writeln!(
            text,
            "\nThe fastest of those measured on this view: {ms}, {}",
            best.technique
        );
    }
    let _ = writeln!(text, "\nNext, of {} that meet the bounds:", advice.choices.len());
    for choice in next {
        let basis = match choice.time.basis {
            Basis::Measured { .. } => "measured",
            Basis::Fitted(_) => "predicted",
        };
        let memory = choice.memory_bytes.map_or("–".into(), bytes);
        let _ = writeln!(
            text,
            "  {:>11} {basis:<9} {memory:>11}  {}  {}",
            milliseconds(choice.time.ns),
            error_text(choice.error.error),
            choice.technique
        );
    }
    text
}

/// A reason, and in short.
fn reason(reason: &Reason) -> (&'static str, String) {
    match reason {
        Reason::Refused(why) => ("cannot draw it", why.clone()),
        Reason::Error(error) => ("its error is above the bound", estimate(error)),
        Reason::UnknownError(why) => ("its error here is not known", why.clone()),
        Reason::Memory(needed) => ("it takes more memory", bytes(*needed)),
        Reason::UnknownMemory => ("its memory is not known", String::new()),
        Reason::UnknownTime(why) => ("its time here is not known", why.clone()),
    }
}

fn ruled_out(advice: &Advice, all: bool) -> String {
    let mut by_reason: Vec<(&str, Vec<(&str, String)>)> = Vec::new();
    for (technique, why) in &advice.ruled_out {
        let (head, why) = reason(why);
        match by_reason.iter_mut().find(|(known, _)| *known == head) {
            Some((_, list)) => list.push((technique, why)),
            None => by_reason.push((head, vec![(technique, why)])),
        }
    }
    if by_reason.is_empty() {
        return String::new();
    }
    let mut text = "\nRuled out:\n".to_owned();
    for (head, list) in by_reason {
        let _ = writeln!(text, "  {:>4}  {head}", list.len());
        let shown = if all { list.len() } else { 2 };
        for (technique, why) in list.iter().take(shown) {
            let _ = writeln!(text, "          {technique}: {why}");
        }
        if list.len() > shown {
            let _ = writeln!(text, "          and so on (--all shows each)");
        }
    }
    text
}

/// Renders with the choice, and compares what was said with what it is.
fn check(
    opened: &mut Opened,
    arguments: &Arguments,
    choice: &Choice,
    technique: &Technique,
    bounds: &Bounds,
    evidence: &Evidence,
) -> miette::Result<()> {
    let engine = &mut *opened.engine;
    let mut verifier = Verifier::new(engine).map_err(report)?;
    let (ready, preparation) = engine.prepare(technique).map_err(report)?;
    let result = verifier.verify(engine, technique, ready, &preparation).map_err(report)?;
    let info = engine.info().clone();
    // A few frames first, for caches and clocks.
    for _ in 0..3 {
        engine.run(ready).map_err(report)?;
    }
    let mut times = Vec::new();
    for _ in 0..arguments.samples {
        times.push(engine.run(ready).map_err(report)?.total_ns as f64);
    }
    times.sort_by(f64::total_cmp);
    let at = |share| quantile(&times, share).unwrap_or_default();
    let (max_error, rmse) = oit_advise::Measured::errors(&result);
    let error = if bounds.metric == Metric::Rmse { rmse } else { max_error };
    let verdict = match result.verdict {
        Verdict::Exact => "exact",
        Verdict::Approximate => "approximate",
        Verdict::Wrong => "wrong",
    };
    println!("\nChecked on {} ({}): {verdict}", info.name, info.backend);
    println!(
        "  error      {}, root mean square {}; said: {}",
        error_text(max_error),
        error_text(rmse),
        error_text(choice.error.error)
    );
    println!(
        "  time       {}, quartiles {} and {}, of {} samples; said: {}",
        milliseconds(at(0.5)),
        milliseconds(at(0.25)),
        milliseconds(at(0.75)),
        times.len(),
        milliseconds(choice.time.ns)
    );
    if (&info.name, &info.backend) != (&evidence.device, &evidence.backend) {
        println!("             that was of {}: the two are no comparison", evidence.name());
    }
    let said = choice.memory_bytes.map_or("nothing".into(), bytes);
    println!("  memory     {}; said: {said}", bytes(result.memory_bytes));
    let too_much = bounds.max_memory_bytes.is_some_and(|most| result.memory_bytes > most);
    let exact = result.verdict == Verdict::Exact;
    let off = error > bounds.max_error || bounds.max_error == 0.0 && !exact;
    if result.verdict == Verdict::Wrong || off || too_much {
        let note = result.note.map_or(String::new(), |note| format!(": {note}"));
        return Err(miette!("it does not keep within the bounds{note}"));
    }
    println!("  It keeps within the bounds.");
    Ok(())
}

/// The advice put to the test on every recorded view of a device.
fn tested(evidence: &Evidence) -> String {
    let all = trials(evidence, &BOUNDS);
    let mut text = format!(
        "{}: on every recorded view, chosen without what was measured on its scene, among what was \
         measured in its run.\nTime over that of the fastest that meets the bound; below, how far a \
         technique picked at random is.\n\n  {:<12} {:>6} {:>7} {:>8} {:>8} {:>8} {:>10} {:>9} {:>8} \
         {:>8}\n",
        evidence.name(),
        "error up to",
        "views",
        "scenes",
        "average",
        "median",
        "worst",
        "within 5 %",
        "no choice",
        "broken",
        "random"
    );
    for bound in BOUNDS {
        let of = all.iter().filter(|trial| trial.max_error == bound);
        let Some(Regret {
            trials, without, broken, scenes, mean, median, worst, near, any, ..
        }) = regret(of)
        else {
            continue;
        };
        let name = if bound == 0.0 { "exact".to_owned() } else { format!("{bound:.4}") };
        let _ = writeln!(
            text,
            "  {name:<12} {trials:>6} {scenes:>7} {mean:>8.3} {median:>8.3} {worst:>8.3} {near:>10} \
             {without:>9} {broken:>8} {any:>8.3}"
        );
    }
    let mut worst: Vec<&Trial> = all.iter().filter(|trial| trial.regret().is_some()).collect();
    let key = |trial: &Trial| trial.regret().unwrap_or(0.0);
    worst.sort_by(|a, b| key(b).total_cmp(&key(a)).then(a.view.cmp(&b.view)));
    let ratios: Vec<f64> = worst
        .iter()
        .filter_map(|trial| trial.choice.as_ref())
        .map(|tried| tried.predicted_ns / tried.ns)
        .collect();
    if let Some(ratio) = median(&ratios) {
        let _ = writeln!(
            text,
            "\nPredicted over measured time of what was chosen: {ratio:.2} at the median"
        );
    }
    let _ = writeln!(text, "\nThe most regretted:");
    worst.dedup_by_key(|trial| trial.view);
    for trial in worst.iter().take(8) {
        let (Some(ratio), Some(tried)) = (trial.regret(), &trial.choice) else { continue };
        let View { scene, view, .. } = &evidence.views[trial.view];
        let _ = writeln!(
            text,
            "  {ratio:.3}  {scene}:{view}, error up to {}\n         {} {} for {} {}",
            trial.max_error,
            tried.technique,
            milliseconds(tried.ns),
            trial.best,
            milliseconds(trial.best_ns)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_read() {
        for (text, expected) in [("0", 0.0), ("0.02", 0.02), ("2/255", 2.0 / 255.0), ("1", 1.0)] {
            assert_eq!(error_bound(text).unwrap(), expected, "{text}");
        }
        for bad in ["", "x", "-0.1", "1.5", "1/0", "nan", "inf", "1/", "0/0"] {
            assert!(error_bound(bad).is_err(), "{bad}");
        }
        for (text, expected) in
            [("1000", 1000), ("512MiB", 512 << 20), ("1.5 GiB", 3 << 29), ("2gb", 2_000_000_000)]
        {
            assert_eq!(memory_bound(text).unwrap(), expected, "{text}");
        }
        for bad in ["", "MiB", "-1", "0", "nan", "inf", "1e300", "5 XiB", "-5GB", "infGB"] {
            assert!(memory_bound(bad).is_err(), "{bad}");
        }
    }
}
