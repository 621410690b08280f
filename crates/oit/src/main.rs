//! `oit`: lists, renders, sweeps and compares techniques for order-independent transparency.

mod command;

use clap::Parser;
use command::Command;

/// Order-independent transparency, measured.
#[derive(Parser)]
#[command(name = "oit", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

fn main() -> miette::Result<()> {
    match Arguments::parse().command {
        Command::List(arguments) => command::list::run(&arguments),
        Command::Devices => command::devices::run(),
        Command::Sweep(arguments) => command::sweep::run(&arguments),
        Command::Compare(arguments) => command::compare::run(&arguments),
        Command::Advise(arguments) => command::advise::run(&arguments),
        Command::Pareto(arguments) => command::pareto::run(&arguments),
        Command::Tune(arguments) => command::tune::run(&arguments),
        Command::Render(arguments) => command::render::run(&arguments),
        Command::Trace(arguments) => command::trace::run(&arguments),
        Command::Plan(arguments) => command::plan::run(&arguments),
        Command::Probe(arguments) => command::probe::run(&arguments),
        Command::Generate(arguments) => command::generate::run(&arguments),
        Command::Worker => command::worker::run(),
    }
}
