//! `oit generate`: the pages that are made from the registries.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use miette::{IntoDiagnostic, miette};
use oit_capture::CAPTURES;
use oit_lab::{ALIASES, Schedule, methods};
use oit_sort::{AUTO, STRATEGIES};

use crate::command::list::{INTERVALS, size_words};
use crate::command::report;

/// Whether to write or to check.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Change nothing; fail where a page is not up to date.
    #[arg(long)]
    check: bool,
    /// The repository's root.
    #[arg(long, default_value = ".")]
    root: PathBuf,
}

/// Writes or checks `docs/registry.md`.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let path = arguments.root.join("docs/registry.md");
    let page = page(&arguments.root)?;
    if !arguments.check {
        return std::fs::write(&path, page).into_diagnostic();
    }
    if std::fs::read_to_string(&path).into_diagnostic()? == page {
        return Ok(());
    }
    Err(miette!("{} is not up to date: run `oit generate`", path.display()))
}

fn page(root: &Path) -> miette::Result<String> {
    let mut text = String::from(
        "# What there is\n\nMade by `oit generate` from the registries; do not edit.\n\n\
         ## Captures\n\n| capture | what it does | source |\n|---|---|---|\n",
    );
    for capture in CAPTURES {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} |",
            capture.name(),
            capture.summary(),
            capture.citation()
        );
    }
    text += "\n## Schedules\n\n| schedule | what it does |\n|---|---|\n";
    for (_, name, summary) in Schedule::ALL {
        let _ = writeln!(text, "| `{name}` | {summary} |");
    }
    text += "\n## Sorts\n\n| sort | what it does | stores | holds up to | source |\n|---|---|---|---|---|\n";
    for sort in STRATEGIES {
        let stores: Vec<String> = sort
            .stores()
            .iter()
            .map(|&store| match sort.limit_in(store) {
                Some(limit) if sort.limit() != Some(limit) => {
                    format!("{} (up to {limit})", store.name())
                }
                _ => store.name().to_owned(),
            })
            .collect();
        let limit = sort.limit().map_or_else(|| "any".to_owned(), |limit| limit.to_string());
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {limit} | {} |",
            sort.name(),
            sort.summary(),
            stores.join(", "),
            sort.citation()
        );
    }
    let _ = writeln!(
        text,
        "\nJoined by `+`, the first that admits an interval runs it: `A+B` is A where it holds the \
         interval and B above, `A@16+B` is A up to 16. `{AUTO}` is, for each interval, the strategy \
         that was measured to be the fastest on the device (`oit tune`)."
    );
    text += "\n## Intervals of bma\n\n| option | what it does |\n|---|---|\n\
             | | powers of two from 8 up to the peak, as in the papers |\n";
    for (word, summary) in INTERVALS {
        let _ = writeln!(text, "| `{word}` | {summary} |");
    }
    text += "\n## Methods\n\nTechniques that are one whole, without a layered fragment buffer. A name may be \
             followed by a size: `dual_peel/passes4`.\n\n| method | what it does | size | source \
             |\n|---|---|---|---|\n";
    for method in methods() {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} |",
            method.name(),
            method.summary(),
            size_words(method).unwrap_or_default(),
            method.citation()
        );
    }
    text += "\n## The papers' names\n\n| name | technique |\n|---|---|\n";
    for (alias, name) in ALIASES {
        let _ = writeln!(text, "| {alias} | `{name}` |");
    }
    text += "\n## Scenes\n\n| scene | made of | views | what it is |\n|---|---|---|---|\n";
    for scene in oit_scene::list(&root.join("scenes")).map_err(report)? {
        let about = scene.about.trim().replace('\n', " ");
        let made = if scene.spheres { "spheres" } else { "triangles" };
        let _ =
            writeln!(text, "| `{}` | {made} | {} | {about} |", scene.name, scene.views.join(", "));
    }
    text += "\n## Experiments\n\n| experiment | source | what it shows |\n|---|---|---|\n";
    for experiment in oit_lab::list_experiments(&root.join("experiments")).map_err(report)? {
        let about = experiment.about.trim().replace('\n', " ");
        let _ = writeln!(text, "| `{}` | {} | {about} |", experiment.name, experiment.source);
    }
    Ok(text)
}
