//! Charts what the world costs: CPU time against instances, and work on bricks against bricks that change.

mod chart;
mod field;
mod measure;

use anyhow::{Context as _, Result};
use clap::Parser;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measures brickgi's world and writes CSV and SVG.
#[derive(Parser, Debug)]
#[command(version)]
struct Args {
    /// Folder for the tables and charts
    #[arg(long, default_value = "docs/measurements")]
    out: PathBuf,
    /// Most instances in a world
    #[arg(long, default_value_t = 100_000)]
    instances: usize,
    /// Most bricks that change in a frame, 1 to 4096
    #[arg(long, default_value_t = 4096)]
    bricks: usize,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<()> {
    fs::create_dir_all(&args.out).with_context(|| format!("cannot make {}", args.out.display()))?;
    let write = |name: &str, text: &str| {
        let path = args.out.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    let instances = measure::instances(args.instances)?;
    write("instances.csv", &instances.csv())?;
    write("instances.svg", &chart::draw(&instances)?)?;
    let bricks = measure::bricks(args.bricks)?;
    write("bricks.csv", &bricks.csv())?;
    write("bricks.svg", &chart::draw(&bricks)?)
}
