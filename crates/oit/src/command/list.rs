//! `oit list`.

use std::path::PathBuf;

use clap::ValueEnum;
use oit_capture::{CAPTURES, Method};
use oit_lab::{ALIASES, Schedule, methods};
use oit_scene::Asset;
use oit_sort::{AUTO, STRATEGIES};

use crate::command::report;

/// What is listed.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// One list; all if none is named.
    what: Option<What>,
    /// The folder of scene files.
    #[arg(long, default_value = "scenes")]
    scenes: PathBuf,
    /// The folder of experiment files.
    #[arg(long, default_value = "experiments")]
    experiments: PathBuf,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
enum What {
    Techniques,
    Sorts,
    Captures,
    Schedules,
    Methods,
    Scenes,
    Experiments,
}

/// What the sort `auto` is.
pub(crate) const AUTO_SUMMARY: &str = "auto: for each interval the strategy that was measured to be \
                                       the fastest on the device (`oit tune`)";

/// What a coordinate may say of intervals.
pub(crate) const INTERVALS: [(&str, &str); 2] = [
    ("intervalsA-B-C", "bma with these upper bounds, and one more where they end below the peak"),
    (
        "intervals-optimal",
        "bma with the bounds that cost least on the view, by costs measured on the device (`oit tune`)",
    ),
];

/// What a method has a number of, if it has: `kN, 1 to 256, 8 if not given`.
pub(crate) fn size_words(method: &dyn Method) -> Option<String> {
    let size = method.size()?;
    let (first, last) = (size.range.start(), size.range.end());
    let default = match size.default {
        Some(n) => format!("{n} if not given"),
        None => "as many as the view needs if not given".to_owned(),
    };
    Some(format!("{}N, {first} to {last}, {default}", size.word))
}

/// Prints the lists.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let all = What::value_variants();
    let wanted = arguments.what.as_ref().map_or(all, std::slice::from_ref);
    for (place, what) in wanted.iter().enumerate() {
        if wanted.len() > 1 {
            let gap = if place > 0 { "\n" } else { "" };
            println!("{gap}{what:?}:");
        }
        print(*what, arguments)?;
    }
    Ok(())
}

fn row(name: &str, text: &str) {
    println!("  {name:<18} {text}");
}

fn print(what: What, arguments: &Arguments) -> miette::Result<()> {
    match what {
        What::Techniques => {
            println!(
                "  a technique is capture/schedule/sort/stage/max[/ties-depth][/poolN[-drop]]\
                 [/intervalsA-B-C], where"
            );
            let join = |names: Vec<&str>| names.join(" | ");
            row("capture", &join(CAPTURES.iter().map(|capture| capture.name()).collect()));
            row(
                "schedule",
                "base | base-stencil, bma-stencil, bma-stencil-count (fragment) | bma-list (compute)",
            );
            row("sort", &join(STRATEGIES.iter().map(|sort| sort.name()).collect()));
            row("", "A+B: A where it holds the interval, B above; A@N+B: A up to N");
            row("", "A-STORE: in another store than its first");
            row("", AUTO_SUMMARY);
            row("stage", "fragment | compute | cuda (schedule base alone)");
            row("max", "peak (the next power of two above the peak) | maxN");
            row("ties-depth", "compare depth alone, as the papers do");
            row(
                "poolN",
                "start with a pool of N % of what is needed: it grows, and both attempts are timed",
            );
            row("poolN-drop", "the same, but it does not grow: what has no room is left out");
            for (word, text) in INTERVALS {
                row(word, text);
            }
            for (alias, name) in ALIASES {
                row(alias, name);
            }
            println!("  or a method, METHOD or METHOD/SIZE, which has no such parts:");
            row("METHOD", &join(methods().map(Method::name).collect()));
        }
        What::Sorts => {
            for sort in STRATEGIES {
                let stores: Vec<String> = sort
                    .stores()
                    .iter()
                    .map(|&store| match sort.limit_in(store) {
                        Some(limit) => format!("{}, up to {limit}", store.name()),
                        None => store.name().to_owned(),
                    })
                    .collect();
                row(sort.name(), &format!("{} [{}]", sort.summary(), stores.join("; ")));
                row("", sort.citation());
            }
            row(AUTO, AUTO_SUMMARY);
        }
        What::Captures => {
            for capture in CAPTURES {
                row(capture.name(), capture.summary());
                row("", capture.citation());
            }
        }
        What::Schedules => {
            for (_, name, summary) in Schedule::ALL {
                row(name, summary);
            }
        }
        What::Methods => {
            for method in methods() {
                row(method.name(), method.summary());
                if let Some(size) = size_words(method) {
                    row("", &format!("/{size}"));
                }
                row("", method.citation());
            }
        }
        What::Scenes => {
            for scene in oit_scene::list(&arguments.scenes).map_err(report)? {
                let about =
                    scene.about.split(". ").next().unwrap_or_default().trim_end_matches('.');
                row(&scene.name, &about.replace('\n', " "));
                let made = if scene.spheres { "spheres; " } else { "" };
                row("", &format!("{made}views: {}", scene.views.join(", ")));
                if let Asset::Missing(path) = scene.asset {
                    row("", &format!("{} is missing: run `just assets`", path.display()));
                }
            }
        }
        What::Experiments => {
            for experiment in oit_lab::list_experiments(&arguments.experiments).map_err(report)? {
                row(&experiment.name, experiment.about.lines().next().unwrap_or_default());
                row("", &experiment.source);
            }
        }
    }
    Ok(())
}
