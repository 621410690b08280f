//! `oit compare --trace`: the CPU twins of sorts on captured fragments.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use miette::{Context, IntoDiagnostic, miette};
use oit_lab::{STORED_VIEW, Twin, TwinInterval, is_stored, load_stored, time_twins, twin_conforms};
use oit_record::statistics::{compare, median};
use oit_record::{Subject, SubjectPart};
use oit_sort::SortChoice;

use crate::command::compare::{Arguments, SEED, folder, told, word};
use crate::command::report;

/// Times and counts the twins, prints the page, and leaves it in the run folder with all samples.
pub(super) fn run(arguments: &Arguments, trace: &Path, sorts: &[SortChoice]) -> miette::Result<()> {
    if !is_stored(trace) {
        return Err(miette!(
            "{}: neither a trace (.oitt) nor a deep image (.exr)",
            trace.display()
        ));
    }
    let lfb = load_stored(trace).map_err(report)?.lfb;
    let subject = &sorts[0];
    let parts = subject.parts().iter().map(|part| SubjectPart {
        name: part.strategy.name().to_owned(),
        summary: part.strategy.summary().to_owned(),
        citation: part.strategy.citation().to_owned(),
        store: part.store.name().to_owned(),
        stores: part.strategy.stores().iter().map(|store| store.name().into()).collect(),
        limit: part.limit(),
        conformance: twin_conforms(part.strategy, part.store, lfb.histogram().peak()),
    });
    let parts = parts.collect();
    let found = Subject { sort: subject.to_string(), device: "cpu".into(), parts };
    let folder = folder(arguments, subject, STORED_VIEW);
    let files = ["twins.csv", "compare.md"].map(|name| folder.join(name));
    if let Some(there) = files.iter().find(|path| path.exists()) {
        return Err(miette!("{} is there already: name another folder", there.display()));
    }
    found.write(&folder).map_err(report)?;
    told(&found)?;
    let samples = arguments.samples.unwrap_or(9);
    let intervals = time_twins(&lfb, sorts, arguments.pixels, samples, SEED);
    let page = page(&found, trace, &intervals);
    for (path, text) in files.iter().zip([csv(&intervals), page.clone()]) {
        fs::write(path, text).into_diagnostic().with_context(|| path.display().to_string())?;
    }
    println!("\n{page}\nin {}", folder.display());
    Ok(())
}

/// Every sample.
fn csv(intervals: &[TwinInterval]) -> String {
    let mut text =
        "low,high,pixels,resolved_pixels,fragments,sort,comparisons,sample,ns\n".to_owned();
    for interval in intervals {
        let TwinInterval { low, high, pixels, resolved_pixels, fragments, twins } = interval;
        for Twin { sort, comparisons, samples_ns } in twins {
            let comparisons = comparisons.map(|count| count.to_string()).unwrap_or_default();
            for (sample, ns) in samples_ns.iter().enumerate() {
                let _ = writeln!(
                    text,
                    "{low},{high},{pixels},{resolved_pixels},{fragments},{sort},{comparisons},\
                     {sample},{ns}"
                );
            }
        }
    }
    text
}

fn nanoseconds(twin: &Twin) -> Vec<f64> {
    twin.samples_ns.iter().map(|&ns| ns as f64).collect()
}

fn page(subject: &Subject, trace: &Path, intervals: &[TwinInterval]) -> String {
    let mut text = format!("# {} on {}, by CPU twins\n\n", subject.sort, trace.display());
    for part in &subject.parts {
        let _ = writeln!(text, "{}: {} {}.\n", part.name, part.summary, part.citation);
    }
    text += "Comparisons and nanoseconds are those of a fragment. The time is to take, sort and \
             composite, on one thread of this machine, and says nothing of a GPU. The ratio is the \
             subject's time over the other's, with its 95 % interval: faster where that lies below \
             1, slower above, else same. Comparisons are counted in runs of their own, and include \
             those with padding; moves are not counted.\n";
    for interval in intervals {
        let TwinInterval { low, high, pixels, resolved_pixels, fragments, twins } = interval;
        let _ = write!(
            text,
            "\n## {low} to {high} fragments\n\n{pixels} pixels, {resolved_pixels} of them resolved, \
             {fragments} fragments\n\n\
             | sort | comparisons | ns | subject over it | interval | verdict |\n\
             | --- | --- | --- | --- | --- | --- |\n"
        );
        let own = nanoseconds(&twins[0]);
        for (place, twin) in twins.iter().enumerate() {
            let each = |sum: f64| sum / (*fragments).max(1) as f64;
            let Some(comparisons) = twin.comparisons else {
                let _ = writeln!(text, "| {} | does not hold so many | | | | |", twin.sort);
                continue;
            };
            let theirs = nanoseconds(twin);
            let ns = median(&theirs).map_or("–".into(), |ns| format!("{:.2}", each(ns)));
            let against = compare(&own, &theirs, SEED).filter(|_| place > 0);
            let against = against.map_or("| | ".to_owned(), |(ratio, low, high, verdict)| {
                format!("{ratio:.3} | {low:.3} to {high:.3} | {}", word(verdict))
            });
            let comparisons = each(comparisons as f64);
            let _ = writeln!(text, "| {} | {comparisons:.2} | {ns} | {against} |", twin.sort);
        }
    }
    text
}
