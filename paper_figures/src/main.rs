//! `paper-figures`: draws the figures, lists them, prints verdicts, compares a sort with the others.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use paper_figures::figures::{FIGURES, compare, compare_pages};
use paper_figures::{FigureError, claims, generate, read, write_all};

/// Figures and tables of the papers, drawn from records.
#[derive(Parser)]
#[command(version, about, args_conflicts_with_subcommands = true, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    draw: Option<Draw>,
}

#[derive(Args)]
struct Draw {
    /// Run folders, or folders of run folders.
    #[arg(long, required = true, value_name = "DIR", num_args = 1..)]
    records: Vec<PathBuf>,
    /// Where to write the figures.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Draw only figures or files whose name starts so.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

#[derive(Subcommand)]
enum Command {
    /// List the figures, and what records each needs.
    List,
    /// Print whether the papers' claims hold.
    Verdicts {
        /// Run folders, or folders of run folders.
        #[arg(long, required = true, value_name = "DIR", num_args = 1..)]
        records: Vec<PathBuf>,
    },
    /// Write and print the page of one sort against the others: one for each run that has it.
    Compare {
        /// A run folder, or a folder of run folders.
        run: PathBuf,
        /// The sort.
        #[arg(long)]
        sort: String,
        /// Where to write the page and its chart.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

fn draw(arguments: &Draw) -> Result<(), FigureError> {
    let tables = read(&arguments.records)?;
    let drawn = generate(&tables, &arguments.out, arguments.only.as_deref())?;
    for drawn in drawn {
        match drawn.files.len() {
            0 => println!("{}: not drawn, needs {}", drawn.figure.name(), drawn.figure.needs()),
            1 => println!("{}: 1 figure", drawn.figure.name()),
            count => println!("{}: {count} figures", drawn.figure.name()),
        }
    }
    println!("in {}", arguments.out.display());
    Ok(())
}

fn compare_sort(run: &Path, sort: &str, out: &Path) -> Result<(), FigureError> {
    let tables = read(&[run.to_owned()])?;
    for page in compare_pages(&tables, sort)? {
        println!("{}", page.markdown);
        page.write(out)?;
        println!("{}", out.join(format!("{}.md", page.output.name)).display());
    }
    let charts = write_all(&compare(&tables, sort)?, out)?;
    println!("{} charts of whole scenes in {}", charts.len(), out.display());
    Ok(())
}

fn run(arguments: &Arguments) -> Result<(), FigureError> {
    match (&arguments.command, &arguments.draw) {
        (Some(Command::List), _) => {
            for figure in FIGURES {
                let (name, source, needs) = (figure.name(), figure.source(), figure.needs());
                println!("{name:16}{source}\n{:16}needs {needs}", "");
            }
            Ok(())
        }
        (Some(Command::Verdicts { records }), _) => {
            print!("{}", claims::printed(&claims::verdicts(&read(records)?)?));
            Ok(())
        }
        (Some(Command::Compare { run, sort, out }), _) => compare_sort(run, sort, out),
        (None, Some(arguments)) => draw(arguments),
        (None, None) => Ok(()),
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("paper-figures: {error}");
            ExitCode::FAILURE
        }
    }
}
