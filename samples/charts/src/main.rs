//! Charts what the world costs: CPU time against instances, work on bricks against bricks that change, direct light
//! against lights; how fast light settles; and how images follow the camera.

mod chart;
mod cuts;
mod field;
mod hall;
mod measure;
mod moves;
mod radiosity;

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
    /// Only these tables: instances, bricks, lights, radiosity, cuts, moves
    #[arg(long, value_delimiter = ',', default_values = ["instances", "bricks", "lights", "radiosity", "cuts", "moves"])]
    only: Vec<String>,
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
    let both = |name: &str, table: &measure::Table| {
        write(&format!("{name}.csv"), &table.csv())?;
        write(&format!("{name}.svg"), &chart::draw(table)?)
    };
    let is_wanted = |name: &str| args.only.iter().any(|only| only == name);
    if is_wanted("instances") {
        both("instances", &measure::instances(args.instances)?)?;
    }
    if is_wanted("bricks") {
        both("bricks", &measure::bricks(args.bricks)?)?;
    }
    if is_wanted("lights") {
        let [cost, error] = hall::lights()?;
        both("lights_cost", &cost)?;
        both("lights_error", &error)?;
    }
    if is_wanted("radiosity") {
        let [by_rays, by_time] = radiosity::error()?;
        both("radiosity_rays", &by_rays)?;
        both("radiosity_time", &by_time)?;
    }
    if is_wanted("cuts") {
        both("cuts", &cuts::error()?)?;
    }
    if is_wanted("moves") {
        let [turn, flight] = moves::error()?;
        both("turn", &turn)?;
        both("flight", &flight)?;
    }
    Ok(())
}
