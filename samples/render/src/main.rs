//! Renders a scene with brickgi beside the truth.

mod args;
mod compare;
mod measure;
mod path;
mod report;
mod tonemap;

use anyhow::{Context as _, Result, bail};
use args::Args;
use brickgi::DebugView;
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Image, Reference, Scene};
use clap::Parser;
use path::Stage;
use report::Report;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    match render(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Fails for a bad image too, after everything was written: the files then show what is wrong.
fn render(args: &Args) -> Result<()> {
    let path = args.scene_path().context("the default scene is missing; give a scene")?;
    let mut scene = Scene::load(&path)?;
    scene.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let camera = scene.camera(args.camera.as_deref())?.clone();
    let stage = args.path.as_deref().map(|file| Stage::load(file, &mut scene, camera)).transpose()?;
    let settings = args.settings();
    let mut host = Host::new(HostOptions {
        camera: args.camera.clone(),
        size: args.size,
        settings: settings.clone(),
        frames_in_flight: args.frames_in_flight,
        validation: args.validate,
        shadow_maps: args.shadow_maps,
        motion: args.motion,
        ..HostOptions::new(scene)
    })?;
    let out = output_folder(args, &host);
    if let Some(stage) = stage {
        create(&out)?;
        return path::run(&mut host, stage, args, &out);
    }
    let timing = measure::run(&mut host, args.frames)?;
    host.context_mut().take_warnings().iter().for_each(|text| eprintln!("warning: {text}"));
    let camera = host.camera().name.clone();
    let indirect = host.read_indirect()?;
    let reference = Reference::beside(host.scene(), &camera)?.filter(|r| r.size() == host.size());
    create(&out)?;
    write_images(&mut host, &indirect, reference.as_ref(), &out)?;

    if args.debug_views {
        write_debug_views(&mut host, &out)?;
    }
    let messages = host.validation_messages();
    let mut report = Report {
        scene: host.scene().name.clone(),
        camera,
        size: host.size(),
        frames: args.frames,
        device: host.device_name().to_owned(),
        wall_seconds: timing.wall_seconds,
        timing,
        world: host.stats().into(),
        rel_mse: None,
        nrmse: None,
        bias: None,
        mean: mean_over_surfaces(&indirect, &host.read_depth()?),
        max_abs: None,
        reference_noise: None,
        validation_messages: args.validate.then_some(messages.len()),
        settings: (&settings).into(),
    };
    if let Some(score) = reference.as_ref().and_then(|r| r.score(&indirect)) {
        report.set_score(&score);
    }
    write_json(&report, &out.join("stats.json"))?;
    println!("{report}\n  files {}", out.display());
    judge(&indirect, reference.as_ref(), &messages)
}

fn output_folder(args: &Args, host: &Host) -> PathBuf {
    let path = args.path.as_deref().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
    let what = path.unwrap_or_else(|| host.camera().name.clone());
    args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}_{what}", host.scene().name)))
}

fn create(out: &Path) -> Result<()> {
    std::fs::create_dir_all(out).with_context(|| format!("cannot create {}", out.display()))
}

fn write_images(host: &mut Host, indirect: &Image, reference: Option<&Reference>, out: &Path) -> Result<()> {
    let (albedo, emission, direct) = (host.read_albedo()?, host.read_emission()?, host.direct()?);
    let lit = shade(&albedo, &emission, &[indirect, &direct]);
    let exposure = tonemap::exposure(&lit);
    let save = |name: &str, image: &image::RgbImage| {
        image.save(out.join(name)).with_context(|| format!("cannot write {}", out.join(name).display()))
    };
    save("lit.png", &tonemap::develop(&lit, exposure))?;
    save("direct.png", &tonemap::develop(&shade(&albedo, &emission, &[&direct]), exposure))?;
    save("indirect.png", &tonemap::develop(indirect, tonemap::exposure(indirect)))?;
    if let Some(reference) = reference {
        save("compare.png", &compare::panels(indirect, reference))?;
    }
    Ok(indirect.write_exr(&out.join("indirect.exr"))?)
}

/// What each debug view shows in a frame of its own, as a picture and as numbers.
fn write_debug_views(host: &mut Host, out: &Path) -> Result<()> {
    for view in DebugView::ALL {
        host.show(Some(view));
        host.frame()?;
        let shown = host.read_indirect()?;
        let picture = match view {
            DebugView::Radiance | DebugView::Irradiance | DebugView::ProbeRadiance => {
                tonemap::develop(&shown, tonemap::exposure(&shown))
            }
            _ => tonemap::plain(&shown),
        };
        let file = out.join(format!("debug_{}.png", format!("{view:?}").to_lowercase()));
        picture.save(&file).with_context(|| format!("cannot write {}", file.display()))?;
        shown.write_exr(&file.with_extension("exr"))?;
    }
    host.show(None);
    Ok(())
}

/// What the camera sees by all light: radiance.
fn lit(host: &mut Host, indirect: &Image) -> Result<Image> {
    let (albedo, emission, direct) = (host.read_albedo()?, host.read_emission()?, host.direct()?);
    Ok(shade(&albedo, &emission, &[indirect, &direct]))
}

/// albedo / pi * (sum of the irradiances) + emission.
fn shade(albedo: &Image, emission: &Image, irradiances: &[&Image]) -> Image {
    let pixel = |i: usize| {
        std::array::from_fn(|c| {
            let irradiance: f32 = irradiances.iter().map(|image| image.pixels[i][c]).sum();
            albedo.pixels[i][c] / std::f32::consts::PI * irradiance + emission.pixels[i][c]
        })
    };
    Image { width: albedo.width, height: albedo.height, pixels: (0..albedo.pixels.len()).map(pixel).collect() }
}

fn mean_over_surfaces(image: &Image, depth: &Image<f32>) -> f64 {
    let seen = image.pixels.iter().zip(&depth.pixels).filter(|(_, depth)| **depth > 0.0);
    let (sum, count) = seen.fold((0.0, 0u64), |(sum, count), (p, _)| (sum + luminance(*p), count + 1));
    sum / count.max(1) as f64
}

fn write_json(report: &Report, path: &Path) -> Result<()> {
    let text = serde_json::to_string_pretty(report)?;
    std::fs::write(path, text + "\n").with_context(|| format!("cannot write {}", path.display()))
}

/// A good image is finite, not black where the truth is not, and made without a validation message.
fn judge(indirect: &Image, reference: Option<&Reference>, messages: &[String]) -> Result<()> {
    if !indirect.is_finite() {
        bail!("the image holds values that are not numbers");
    }
    let black = |image: &Image| image.pixels.iter().flatten().all(|v| *v == 0.0);
    if black(indirect) && !reference.is_some_and(|r| black(&r.indirect())) {
        bail!("the image is black");
    }
    if let Some(first) = messages.first() {
        bail!("{} validation messages, the first: {first}", messages.len());
    }
    Ok(())
}
